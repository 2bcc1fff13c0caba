"""Whose report is it? Pairs of one frame, identities where a recording has none, and doubts."""

from probreg.association._doubt import OFF_PATH, TOO_FAST, doubt_identities, doubts
from probreg.association._identify import associate
from probreg.association.nearest_neighbours import (
    Objective,
    assign,
    nearest_neighbours,
    squared_distances,
    wrong_pairs,
)
from probreg.association.segments import segments

__all__ = [
    "OFF_PATH",
    "TOO_FAST",
    "Objective",
    "assign",
    "associate",
    "doubt_identities",
    "doubts",
    "nearest_neighbours",
    "segments",
    "squared_distances",
    "wrong_pairs",
]
