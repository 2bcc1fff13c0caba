"""What an engineer sees of a registration: a page, tables of numbers, the corrected recording."""

from probreg.report._corrected import Source, read_source, write_changed
from probreg.report._folder import result_folder
from probreg.report._outputs import read_biases, write_summary
from probreg.report._provenance import Provenance, checksum
from probreg.report._words import biases_text, matters
from probreg.report._write import fill, write, write_report

__all__ = [
    "Provenance",
    "Source",
    "biases_text",
    "checksum",
    "fill",
    "matters",
    "read_biases",
    "read_source",
    "result_folder",
    "write",
    "write_changed",
    "write_report",
    "write_summary",
]
