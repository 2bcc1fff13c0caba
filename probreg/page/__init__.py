"""What an engineer sees of a registration: a page, tables of numbers, the corrected recording."""

from probreg.page._changes import changes, changes_text, in_si, write_changes
from probreg.page._days_page import fill_days
from probreg.page._folder import own_folder, result_folder
from probreg.page._outputs import check_writable, write_summary
from probreg.page._provenance import Provenance, checksum
from probreg.page._watch_page import alarm_text, when, write_watch
from probreg.page._words import biases_text, matters
from probreg.page._write import fill, write, write_report

__all__ = [
    "Provenance",
    "alarm_text",
    "biases_text",
    "changes",
    "changes_text",
    "check_writable",
    "checksum",
    "fill",
    "fill_days",
    "in_si",
    "matters",
    "own_folder",
    "result_folder",
    "when",
    "write",
    "write_changes",
    "write_report",
    "write_summary",
    "write_watch",
]
