"""What must hold of every kind of sensor: facts that raise AssertionError where they do not.

What a report is of is written down here by hand (`PHYSICS`); all else is compared with it, by
finite differences and simulation.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import stats

from probreg.errors import InvalidInputError
from probreg.recordings import setup_file
from probreg.sensors import counter_clockwise, known_kinds, turned
from probreg.sensors.geometry import wrap_angle

SIGMAS = {"m": 20.0, "deg": 0.1}  # in the units of the file
DRAWS = 40_000
FALSE_ALARM = 1e-4  # of all simulated comparisons of one sensor together
CURVED = 2e-3  # what second order adds to a covariance at these accuracies and ranges


def declared(kind, from_north=True, name="s"):
    """What a setup file says of a sensor of a kind."""
    owner = known_kinds()[kind]
    table = {"name": name, "kind": kind}
    table |= {key: SIGMAS[key.rsplit("_", 1)[1]] for key in owner.kind.sigmas}
    if owner.kind.coordinates:
        table["position_m"] = [300.0, -200.0, 50.0][: owner.kind.coordinates]
    if owner.azimuth_column is not None:
        table["from_north"] = from_north
    return table


def made(kind, from_north=True, high=False):
    """A sensor as a setup file makes it; with a 3-D radar beside it in `high` frames."""
    others = [declared("radar3d", name="other")] if high else []
    return setup_file.parse({"sensor": [declared(kind, from_north), *others]}).sensors[0]


SENSORS = [
    made(kind, from_north, high)
    for kind, owner in known_kinds().items()
    for from_north in ([False, True] if owner.azimuth_column is not None else [False])
    for high in ([False, True] if owner.kind.per_axis else [False])
]
IDS = [f"{s.kind.name}-{s.dim}-{'north' if s.from_north else 'axis'}" for s in SENSORS]


def scene(sensor, n=40):
    """Targets all around (n, d), and a platform's positions (n, d)."""
    rng = np.random.default_rng(11)
    side = np.where(rng.random((n, sensor.dim)) < 0.5, -1.0, 1.0)
    return side * rng.uniform(4e3, 2e4, (n, sensor.dim)), rng.uniform(-1e3, 1e3, (n, sensor.dim))


def azimuth(sensor, line):
    x, y = line[:, 0], line[:, 1]
    return np.arctan2(x, y) if sensor.from_north else np.arctan2(y, x)


PHYSICS = {
    "range": lambda s, line: np.sqrt((line**2).sum(axis=1)),
    "azimuth": azimuth,
    "bearing": azimuth,
    "elevation": lambda s, line: np.arcsin(line[:, 2] / np.sqrt((line**2).sum(axis=1))),
    "x": lambda s, line: line[:, 0],
    "y": lambda s, line: line[:, 1],
    "z": lambda s, line: line[:, 2],
    "height": lambda s, line: line[:, 2],
}


def difference(sensor, one, two):
    """One less another array of reports (n, q), angles within half a turn."""
    away = one - two
    angles = np.array(sensor.bias_units) == "rad"
    away[:, angles] = wrap_angle(away[:, angles])
    return away


def describes_itself(sensor):
    q = len(sensor.bias_names)
    assert len(sensor.bias_units) == len(sensor.kind.columns[:q]) == q
    assert set(sensor.bias_units) <= {"m", "rad"}
    for numbers in (sensor.bias_sd, sensor.sigmas):
        assert np.shape(numbers) == (q,)
        assert (np.asarray(numbers) > 0.0).all()
    assert not sensor.cartesian or sensor.gives_position
    assert (sensor.position is not None) == (sensor.kind.coordinates > 0)
    assert all(sensor.kind.sigma_key(j) in sensor.kind.sigmas for j in range(q))


def reports_by_the_physics(sensor):
    x, own = scene(sensor)
    line = x - own - (0.0 if sensor.position is None else np.array(sensor.position))
    wanted = np.column_stack([PHYSICS[name](sensor, line) for name in sensor.bias_names])
    np.testing.assert_allclose(difference(sensor, sensor.to_report(x, own), wanted), 0.0, atol=1e-9)
    still = sensor.to_report(x), sensor.to_report(x, np.zeros_like(x))
    np.testing.assert_array_equal(*still)


def is_placed_where_it_says(sensor):
    x, own = scene(sensor)
    where = sensor.to_cartesian(sensor.to_report(x, own), own, unbiased=False)
    wanted = x if sensor.gives_position else np.full(x.shape, np.nan)
    np.testing.assert_allclose(where, wanted, rtol=1e-9)
    # without a place to linearise at: where the report is, or nothing
    z = sensor.to_report(x, own)
    seen = sensor.observe(z, None, own)
    if sensor.gives_position:
        np.testing.assert_allclose(seen.e, sensor.to_cartesian(z, own), rtol=1e-12)
    else:
        assert not any(part.any() for part in seen)


def has_equations_that_hold(sensor):
    """At the truth e = G x, on a moving platform as well."""
    x, own = scene(sensor)
    seen = sensor.observe(sensor.to_report(x, own), x, own)
    q, left = len(sensor.bias_names), seen.e - np.einsum("nij,nj->ni", seen.G, x)
    sd = np.sqrt(np.einsum("nii->ni", seen.C))
    assert (np.abs(left) <= 0.01 * sd).all()
    for part in seen:  # equations that there are not
        assert not part[:, q:].any()
    assert (sd[:, :q] > 0.0).all()


def has_the_derivatives_it_says(sensor):
    """By the target (G), and by a bias that adds to the report (D): central differences."""
    x, own = scene(sensor)
    z = sensor.to_report(x, own)
    seen = sensor.observe(z, x, own)
    for j, step in enumerate(np.eye(sensor.dim)):
        ends = (sensor.observe(sensor.to_report(x + s * step, own), x, own).e for s in (1, -1))
        _agrees(seen.G[..., j], _slope(ends, 1.0), np.abs(seen.G).max())
    for k, unit in enumerate(sensor.bias_units):
        h = 1e-1 if unit == "m" else 1e-5
        bias = h * np.eye(len(sensor.bias_names))[k]
        ends = (sensor.observe(z + s * bias, x, own).e for s in (1, -1))
        _agrees(seen.D[..., k], _slope(ends, h), np.abs(seen.D[..., k]).max())


def _slope(ends, step):
    ahead, behind = ends
    return (ahead - behind) / (2.0 * step)


def _agrees(found, wanted, size):
    assert size > 0.0
    np.testing.assert_allclose(found, wanted, atol=1e-5 * size)


def has_the_noise_it_says(sensor):
    """Means and covariance of the equations, and spreads of reports, by simulation."""
    x, own = (part[:1] for part in scene(sensor))
    many = np.repeat(x, DRAWS, axis=0), np.repeat(own, DRAWS, axis=0)
    z = sensor.to_report(*many)
    noise = sensor.sample_noise(np.random.default_rng(5), DRAWS, many[0] - many[1])
    assert noise.shape == z.shape
    q = len(sensor.bias_names)
    C = sensor.observe(z[:1], x, own).C[0, :q, :q]
    e = sensor.observe(z + noise, *many).e[:, :q]
    truth = sensor.observe(z[:1], x, own).G[0, :q] @ x[0]
    variance = np.diag(C)
    count = q + q * q + q
    limit = stats.norm.isf(0.5 * FALSE_ALARM / count)
    assert (np.abs(e.mean(axis=0) - truth) <= limit * np.sqrt(variance / DRAWS)).all()
    size = np.sqrt(np.outer(variance, variance))
    error = np.sqrt((size**2 + C**2) / DRAWS)
    assert (np.abs(np.cov(e.T).reshape(q, q) - C) <= limit * error + CURVED * size).all()
    ratio = noise.std(axis=0) / sensor.report_sd(z)[0]
    assert (np.abs(ratio - 1.0) <= limit * np.sqrt(0.5 / DRAWS) + CURVED).all()


def counts_azimuth_as_it_says(sensor):
    column = sensor.azimuth_column
    x, own = scene(sensor)
    z, turn = sensor.to_report(x, own), np.full(len(x), 0.1)
    if column is None:
        np.testing.assert_array_equal(turned(sensor, z, turn), z)
        assert "rad" not in sensor.bias_units
        return
    assert sensor.bias_units[column] == "rad"
    change = turned(sensor, z, turn) - z
    wanted = np.broadcast_to(0.1 * (np.arange(z.shape[1]) == column), z.shape)
    np.testing.assert_allclose(change, wanted, atol=1e-9)
    line = x - own - (0.0 if sensor.position is None else np.array(sensor.position))
    wanted = np.arctan2(line[:, 1], line[:, 0])
    away = wrap_angle(counter_clockwise(sensor, z[:, column]) - wanted)
    np.testing.assert_allclose(away, 0.0, atol=1e-9)
    # the other convention is the same sensor, whose azimuth bias has the other sign
    twin = dataclasses.replace(sensor, from_north=not sensor.from_north)
    one, two = sensor.observe(z, x, own), twin.observe(twin.to_report(x, own), x, own)
    for name in ("e", "G", "C"):
        size = np.abs(getattr(one, name)).max()
        np.testing.assert_allclose(getattr(one, name), getattr(two, name), atol=1e-9 * size)
    sign = np.where(np.arange(z.shape[1]) == column, -1.0, 1.0)
    np.testing.assert_allclose(one.D, sign * two.D, atol=1e-9 * np.abs(one.D).max())


def refuses_what_cannot_be_meant(sensor):
    x, own = scene(sensor)
    z = sensor.to_report(x, own)
    np.testing.assert_array_equal(sensor.check(z), z)
    broken = z.copy()
    broken[7, 0] = np.nan  # the height of a position may be missing
    bad = [z[0], np.column_stack([z, z[:, :1]]), z[..., None], broken]
    angles = np.array(sensor.bias_units) == "rad"
    if angles.any():
        bad.append(np.where(angles, np.rad2deg(z), z))
    for reports in bad:
        with pytest.raises(InvalidInputError, match=repr(sensor.name)):
            sensor.check(reports)


FACTS = [
    describes_itself,
    reports_by_the_physics,
    is_placed_where_it_says,
    has_equations_that_hold,
    has_the_derivatives_it_says,
    has_the_noise_it_says,
    counts_azimuth_as_it_says,
    refuses_what_cannot_be_meant,
]
