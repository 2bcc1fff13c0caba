"""Asynchronous recordings: rows of a target's reports, its path eliminated."""

from probreg.problems.recording._rows import RowPlan, plan_rows
from probreg.problems.recording.recording_problem import RecordingProblem

__all__ = ["RecordingProblem", "RowPlan", "plan_rows"]
