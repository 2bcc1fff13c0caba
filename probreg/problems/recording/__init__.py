"""Asynchronous recordings: the tracks of their targets, and the unknowns of their sensors."""

from probreg.problems.recording.recording_problem import RecordingProblem, recording_problem

__all__ = ["RecordingProblem", "recording_problem"]
