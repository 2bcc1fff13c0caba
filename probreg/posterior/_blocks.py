"""Rows cut into blocks, so that many thetas can meet many rows in memory."""

from __future__ import annotations

import numpy as np

from probreg.problems.linear import WhitenedRows
from probreg.typing import IntArray

_CHUNK = 4_000_000  # numbers held at once
_WORTH_SORTING = 100_000  # numbers above which blocks of rows of one size pay


def row_blocks(rows: WhitenedRows, thetas: int) -> list[WhitenedRows]:
    """Parts of the rows whose residuals at so many thetas fit into memory together."""
    n, width = len(rows.size), int(rows.size.max())
    length = max(1, _CHUNK // max(1, thetas * width))
    edges = np.arange(0, n, length)
    if thetas * n * width > _WORTH_SORTING:
        # where rows of one size lie together, laws compute one normaliser for each size
        changes = np.flatnonzero(np.diff(rows.size)) + 1
        edges = np.union1d(edges, changes) if len(changes) <= width else edges
    if len(edges) == 1:
        return [rows]
    return [rows.part(slice(a, b)) for a, b in zip(edges, [*edges[1:], n], strict=True)]


def sizes(rows: WhitenedRows) -> IntArray | int:
    """Sizes of rows, one number where they are all the same: laws then compute one normaliser."""
    size = rows.size
    return int(size[0]) if size.min() == size.max() else size
