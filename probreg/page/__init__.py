"""What an engineer sees of a registration: a page, tables of numbers, the corrected recording."""

from probreg.page._folder import result_folder
from probreg.page._outputs import check_writable, write_summary
from probreg.page._provenance import Provenance, checksum
from probreg.page._words import biases_text, matters
from probreg.page._write import fill, write, write_report

__all__ = [
    "Provenance",
    "biases_text",
    "check_writable",
    "checksum",
    "fill",
    "matters",
    "result_folder",
    "write",
    "write_report",
    "write_summary",
]
