"""What is seen and what is unknown: rows whose residuals a noise law judges."""

from probreg.problems.bearings import BearingProblem
from probreg.problems.contrast import ReportProblem
from probreg.problems.drifting import as_rows, as_trajectory
from probreg.problems.linear import LinearProblem, Problem, Whitened, WhitenedRows
from probreg.problems.observability import (
    Observability,
    observability_of,
    observability_of_information,
)
from probreg.problems.recording import RecordingProblem, recording_problem

__all__ = [
    "BearingProblem",
    "LinearProblem",
    "Observability",
    "Problem",
    "RecordingProblem",
    "ReportProblem",
    "Whitened",
    "WhitenedRows",
    "as_rows",
    "as_trajectory",
    "observability_of",
    "observability_of_information",
    "recording_problem",
]
