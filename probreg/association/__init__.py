"""Whose report is it? Pairs of one frame, missing identities, and tracks of identities."""

from probreg.association._identify import associate
from probreg.association._intervals import comparison_window, usual_intervals
from probreg.association.nearest_neighbours import (
    Objective,
    assign,
    nearest_neighbours,
    squared_distances,
    wrong_pairs,
)
from probreg.association.segments import segments

__all__ = [
    "Objective",
    "assign",
    "associate",
    "comparison_window",
    "nearest_neighbours",
    "segments",
    "squared_distances",
    "usual_intervals",
    "wrong_pairs",
]
