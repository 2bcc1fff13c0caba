"""Recordings of real sensors: every file format is read into the same data type.

`read` chooses the format; formats are modules of `probreg.recordings.formats`.
"""

from probreg.recordings._bias_model import BiasModel, bias_model
from probreg.recordings._changed import write_changed
from probreg.recordings._correction import correct, corrected_values, restore
from probreg.recordings._observing import TARGET_HEIGHT_M, observing_axes, places, turns
from probreg.recordings._reading import Reading
from probreg.recordings._recording import UNKNOWN, Recording
from probreg.recordings._setup import Setup
from probreg.recordings.bias_paths import Biases, BiasPaths
from probreg.recordings.biases_file import read_biases
from probreg.recordings.formats import read

__all__ = [
    "TARGET_HEIGHT_M",
    "UNKNOWN",
    "BiasModel",
    "BiasPaths",
    "Biases",
    "Reading",
    "Recording",
    "Setup",
    "bias_model",
    "correct",
    "corrected_values",
    "observing_axes",
    "places",
    "read",
    "read_biases",
    "restore",
    "turns",
    "write_changed",
]
