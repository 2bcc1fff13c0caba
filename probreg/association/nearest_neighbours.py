"""Which report of one sensor belongs to which of another: global nearest neighbour."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.optimize import linear_sum_assignment

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray, IntArray
from probreg.validation import finite_array, positive_number

Objective = Literal["cost", "cardinality"]


def nearest_neighbours(
    first: FloatArray, second: FloatArray, gate: float, objective: Objective = "cost"
) -> IntArray:
    """Pair positions one to one by global nearest neighbour within a gate.

    Parameters
    ----------
    first, second : ndarray, shape (n1, d), (n2, d)
        Positions in one frame, metres. No row is allowed on either side.
    gate : float
        Largest distance of a pair, metres.
    objective : {"cost", "cardinality"}
        "cost" minimises the sum of d^2 - gate^2 over all partial pairings: a pair is worth
        making if it is inside the gate. "cardinality" makes as many pairs inside the gate as
        possible and among those minimises the sum of d^2.

    Returns
    -------
    ndarray of int, shape (k, 2)
        Row numbers in `first` and `second`, in order of the first.

    Raises
    ------
    InvalidInputError
        A gate that is not positive, non-finite positions, unknown objective.
    """
    gate = positive_number("gate", gate)
    first = finite_array("first positions", first, (None, None))
    second = finite_array("second positions", second, (None, first.shape[1]))
    d2 = squared_distances(first, second)
    return assign(d2, gate, objective)


def assign(d2: FloatArray, gate: float, objective: Objective = "cost") -> IntArray:
    """Pair rows and columns of a matrix of squared distances; see `nearest_neighbours`."""
    inside = d2 < gate**2
    if objective == "cost":
        # zero stands for leaving both alone, so the best full assignment of the clipped
        # matrix is the best partial one of the original
        cost = np.minimum(d2 - gate**2, 0.0)
    elif objective == "cardinality":
        # no saving of distance may outweigh a pair
        cost = np.where(inside, d2, gate**2 * (min(d2.shape, default=0) + 1.0))
    else:
        raise InvalidInputError(f"objective is {objective!r}; take 'cost' or 'cardinality'.")
    rows, columns = linear_sum_assignment(cost)
    keep = inside[rows, columns]
    return np.stack([rows[keep], columns[keep]], axis=1)


def squared_distances(first: FloatArray, second: FloatArray) -> FloatArray:
    """Squared distances, shape (n1, n2)."""
    gaps = first[:, None, :] - second[None, :, :]
    return np.einsum("ijk,ijk->ij", gaps, gaps)


def wrong_pairs(pairs: IntArray, first_target: IntArray, second_target: IntArray) -> FloatArray:
    """Say which pairs join reports of different targets, shape (k,), as booleans.

    Parameters
    ----------
    pairs : ndarray of int, shape (k, 2)
    first_target, second_target : ndarray of int
        True target number of each report; negative for false alarms, which match nothing.
    """
    a, b = first_target[pairs[:, 0]], second_target[pairs[:, 1]]
    return (a != b) | (a < 0)
