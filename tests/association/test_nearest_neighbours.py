from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from probreg import SensorReports
from probreg.association import assign, nearest_neighbours, squared_distances, wrong_pairs
from probreg.errors import InvalidInputError
from probreg.sensors import Tracker2D
from probreg.sensors.reports import pair_up


def every_pairing(n1, n2):
    """All partial pairings of n1 rows and n2 columns, as lists of pairs."""
    columns = [*range(n2), *([None] * n1)]
    seen = set()
    for order in permutations(columns, n1):
        pairs = tuple((i, j) for i, j in enumerate(order) if j is not None)
        if pairs not in seen:
            seen.add(pairs)
            yield pairs


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 3), st.integers(0, 3), st.integers(0, 10_000))
def test_both_objectives_against_brute_force(n1, n2, seed):
    rng = np.random.default_rng(seed)
    first, second = rng.uniform(0, 3, (n1, 2)), rng.uniform(0, 3, (n2, 2))
    gate = 1.2
    d2 = squared_distances(first, second)
    allowed = [p for p in every_pairing(n1, n2) if all(d2[i, j] < gate**2 for i, j in p)]

    def saving(pairs):
        return sum(d2[i, j] - gate**2 for i, j in pairs)

    got = [tuple(map(int, pair)) for pair in nearest_neighbours(first, second, gate)]
    assert saving(got) == pytest.approx(min(map(saving, allowed)))

    most = max(map(len, allowed))
    cheapest = min(sum(d2[i, j] for i, j in p) for p in allowed if len(p) == most)
    got = [tuple(map(int, p)) for p in nearest_neighbours(first, second, gate, "cardinality")]
    assert len(got) == most
    assert sum(d2[i, j] for i, j in got) == pytest.approx(cheapest, abs=1e-12)
    assert all(d2[i, j] < gate**2 for i, j in got)


def test_the_objectives_differ_where_a_pair_is_dear():
    # 0-0 is nearly free; two dear pairs save less than it does
    d2 = np.array([[0.01, 3.9], [3.9, 100.0]])
    np.testing.assert_array_equal(assign(d2, 2.0, "cost"), [[0, 0]])
    np.testing.assert_array_equal(assign(d2, 2.0, "cardinality"), [[0, 1], [1, 0]])


def test_bad_input():
    x = np.zeros((2, 2))
    with pytest.raises(InvalidInputError, match="gate is 0"):
        nearest_neighbours(x, x, 0.0)
    with pytest.raises(InvalidInputError, match=r"second positions\[1, 0\] is nan"):
        nearest_neighbours(x, np.array([[0.0, 0.0], [np.nan, 0.0]]), 1.0)
    with pytest.raises(InvalidInputError, match="second positions has shape"):
        nearest_neighbours(x, np.zeros((2, 3)), 1.0)
    with pytest.raises(InvalidInputError, match="'cost' or 'cardinality'"):
        nearest_neighbours(x, x, 1.0, "speed")


def test_wrong_pairs_are_scored_against_truth():
    pairs = np.array([[0, 0], [1, 2], [2, 1], [3, 3]])
    wrong = wrong_pairs(pairs, np.array([7, 8, 9, -1]), np.array([7, 9, 5, -1]))
    np.testing.assert_array_equal(wrong, [False, True, False, True])


def test_paired_reports_are_the_chosen_rows():
    rng = np.random.default_rng(0)
    sensors = Tracker2D((0.0, 0.0), 10.0, "a"), Tracker2D((1e3, 0.0), 10.0, "b")
    first, second = (
        SensorReports(s, s.to_report(rng.uniform(5e3, 9e3, (n, 2))))
        for s, n in zip(sensors, (3, 4), strict=True)
    )
    pairs = np.array([[2, 0], [0, 3]])
    paired = pair_up(first, second, pairs)
    np.testing.assert_array_equal(paired.values[0], first.values[[2, 0]])
    np.testing.assert_array_equal(paired.values[1], second.values[[0, 3]])
    with pytest.raises(InvalidInputError, match="reports of sensor 'a'"):
        SensorReports(sensors[0], np.array([[1.0, np.nan]]))
