"""Recordings of real sensors, one file format a module, all read into the same data type."""

from probreg.recordings._recording import UNKNOWN, Recording
from probreg.recordings._setup import Setup

__all__ = ["UNKNOWN", "Recording", "Setup"]
