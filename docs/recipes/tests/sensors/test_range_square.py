"""The term against its physics, by finite differences."""

from __future__ import annotations

import pytest

from probreg.sensors.terms import known_terms
from tests.conformance.test_terms import SENSORS, disagreement


def reported(sensor, c, x, v, z):
    z = z.copy()
    z[:, 0] += c * z[:, 0] ** 2 / 1e10
    return z


@pytest.mark.parametrize("sensor", SENSORS[:2], ids=lambda s: s.name)
def test_the_column_is_the_derivative_of_the_report(sensor):
    term = known_terms(sensor)["range_square"]
    assert disagreement(term, reported) < 1e-4
    assert disagreement(term, lambda s, c, x, v, z: reported(s, -c, x, v, z)) > 1.0
