"""Recordings of real sensors, one file format a module, all read into the same data type."""

from probreg.recordings._bias_model import BiasModel, bias_model
from probreg.recordings._correction import correct, corrected_values, restore
from probreg.recordings._observing import places, turns
from probreg.recordings._recording import UNKNOWN, Recording
from probreg.recordings._setup import Setup

__all__ = [
    "UNKNOWN",
    "BiasModel",
    "Recording",
    "Setup",
    "bias_model",
    "correct",
    "corrected_values",
    "places",
    "restore",
    "turns",
]
