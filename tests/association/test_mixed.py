"""Identities in three dimensions: slant ranges, a 3-D radar and a reference, heights or none."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg import PositionSensor, Radar2D, Radar3D
from probreg.association import associate
from probreg.recordings import UNKNOWN, Recording, Setup, observing_axes
from probreg.sensors import known_kinds
from probreg.sensors.frame import LocalFrame
from tests.association.test_identities import purity

ORIGIN = (50.0, 8.0, 0.0)
PLACES = {"a": [0.0, 0.0, 100.0], "b": [60e3, 10e3, 200.0], "c": [20e3, -50e3, 50.0]}
SCANS_S = (4.0, 5.0, 6.0, 5.0)
TARGETS, SECONDS = 40, 200.0
PRESSURE_M = 150.0  # what all barometric heights are off
RADARS, GNSS, BARO = (0, 1, 2), 3, 4


def fly(rng, carriers):
    """Level aircraft; plots of the radars in `carriers` come with a barometric height."""
    a, b = (Radar2D(tuple(PLACES[n]), 50.0, 2e-3, n, from_north=True) for n in "ab")
    c = Radar3D(tuple(PLACES["c"]), 50.0, 2e-3, 3e-3, "c", from_north=True)
    gnss = PositionSensor(tuple(map(tuple, np.diag([400.0, 400.0, 900.0]).tolist())), "gnss")
    sensors = (a, b, c, gnss, known_kinds()["barometer"](10.0, "baro"))
    frame = LocalFrame(*ORIGIN)
    geodetic = {n: tuple(frame.to_geodetic(np.array([p]))[0].tolist()) for n, p in PLACES.items()}
    setup = Setup(sensors, {"a": ("range",)}, origin=ORIGIN, places=geodetic)
    axes = observing_axes(setup)
    start = rng.uniform([-80e3, -80e3, 3e3], [120e3, 80e3, 12e3], (TARGETS, 3))
    velocity = rng.uniform([-200.0, -200.0, 0.0], [200.0, 200.0, 0.0], (TARGETS, 3))
    parts = []
    for k, scan in enumerate(SCANS_S):
        for target in range(TARGETS):
            time = rng.uniform(0.0, scan) + np.arange(0.0, SECONDS - scan, scan)
            where = start[target] + time[:, None] * velocity[target]
            noise = rng.standard_normal((len(time), len(sensors[k].sigmas))) * sensors[k].sigmas
            values = axes[k].observe(where).value + noise
            heights = axes[BARO].observe(where).value + PRESSURE_M
            for t, value, height in zip(time, values, heights, strict=True):
                parts.append((t, 0, k, target, value))
                if sensors[k].name in carriers:
                    parts.append((t, 1, BARO, target, height))
    parts.sort(key=lambda part: part[:2])
    values = np.full((len(parts), 3), np.nan)
    for i, part in enumerate(parts):
        values[i, : len(part[4])] = part[4]
    time, came, sensor, target = (np.array(column) for column in list(zip(*parts, strict=True))[:4])
    beside = np.arange(len(parts)) - came
    labels = tuple(str(k) for k in range(TARGETS))
    return Recording(sensors, sensor, time, values, target, labels, beside=beside), setup


@pytest.mark.parametrize("carriers", ["", "a", "ab"])
def test_slant_ranges_find_their_targets(carriers):
    rng = np.random.default_rng(5)
    recording, setup = fly(rng, carriers)
    truth = recording.target
    blind = np.where(recording.sensor == GNSS, truth, UNKNOWN)
    found = associate(dataclasses.replace(recording, target=blind), setup).target
    for k in np.unique(recording.sensor):
        own = recording.sensor == k
        known = own & (found != UNKNOWN)
        assert known.sum() > 0.93 * own.sum()
        assert (found[known] == truth[known]).mean() > 0.99
    blind = np.full(len(truth), UNKNOWN)
    found = associate(dataclasses.replace(recording, target=blind), setup).target
    assert (found != UNKNOWN).mean() > 0.98
    assert purity(found, truth) > 0.99
    assert len(np.unique(found[found != UNKNOWN])) < 1.1 * TARGETS
    np.testing.assert_array_equal(found, found[recording.beside])
