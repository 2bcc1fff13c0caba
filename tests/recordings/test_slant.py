"""Plots on the round earth: found where earth-centred geometry has the target."""

from __future__ import annotations

import numpy as np

from probreg.recordings._slant import site, target_places
from probreg.sensors.frame import LocalFrame


def test_a_target_is_found_again_by_slant_range_azimuth_and_height():
    radar = LocalFrame(52.0, 9.0, 240.0)
    rng = np.random.default_rng(1)
    places = np.column_stack(
        [rng.uniform(50.5, 53.5, 200), rng.uniform(6.5, 11.5, 200), rng.uniform(500, 12e3, 200)]
    )
    local = radar.from_geodetic(places)
    slant = np.linalg.norm(local, axis=1)
    azimuth = np.arctan2(local[:, 0], local[:, 1])
    found = target_places(radar, slant, azimuth, places[:, 2])
    error = radar.from_geodetic(found) - local
    assert np.abs(error).max() < 0.01
    # a target higher than its distance cannot be
    none = target_places(radar, np.array([5e3]), np.zeros(1), np.array([9e3]))
    assert np.isnan(none).all()


def test_a_site_is_at_its_height_over_its_place_in_the_frame():
    frame = LocalFrame(50.0, 8.0, 100.0)
    true = np.array([50.7, 9.1, 321.0])
    found = site(frame, frame.from_geodetic(true)[:2], 321.0)
    np.testing.assert_allclose(
        [found.latitude_deg, found.longitude_deg, found.height_m], true, atol=1e-6
    )
