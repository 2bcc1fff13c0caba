"""Biases that drift in setups, and taken out of recordings and put back."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.recordings import BiasPaths, bias_model, correct, restore, setup_file
from tests.registration.conftest import fly, sensors_2d, vector

TEXT = """
[[sensor]]
name = "west"
kind = "radar2d"
position_m = [0, 0]
sigma_range_m = 50.0
sigma_azimuth_deg = 0.1
drift = {azimuth_deg = "walk", range_m = "steps"}
drift_sd = {azimuth_deg = 0.3}
prior_sd = {range_m = 80.0}

[[sensor]]
name = "east"
kind = "radar2d"
position_m = [40000, 0]
sigma_range_m = 50.0
sigma_azimuth_deg = 0.1
"""


def read(tmp_path, text=TEXT):
    path = tmp_path / "sensors.toml"
    path.write_text(text)
    return setup_file.read(path)


def test_a_setup_file_says_what_drifts_and_how_far(tmp_path):
    setup = read(tmp_path)
    assert setup.drift == {"west.azimuth": "walk", "west.range": "steps"}
    model = bias_model(setup)
    names = [model.names[k] for k in model.drifts]
    assert names == ["west.range", "west.azimuth"]
    (steps, far), (walk, turn) = model.drifts.values()
    assert (steps.name, walk.name) == ("steps", "walk")
    # a tenth of the prior standard deviation unless it is given
    assert far == pytest.approx(8.0)
    assert turn == pytest.approx(np.deg2rad(0.3))


def test_a_setup_that_is_written_says_the_same_again(tmp_path):
    setup = read(tmp_path)
    setup_file.write(tmp_path / "again.toml", setup)
    again = setup_file.read(tmp_path / "again.toml")
    assert again.drift == setup.drift
    assert again.drift_sd == pytest.approx(setup.drift_sd)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"walk"', '"wander"', r"azimuth_deg is 'wander'; it can be ou, steps, walk"),
        ('"walk"', "3", r"azimuth_deg is 3; it can be ou, steps, walk"),
        ("azimuth_deg = \"walk\"", "elevation_deg = \"walk\"", "unknown key 'elevation_deg'"),
        ("{azimuth_deg = 0.3}", "{azimuth_deg = -0.3}", "azimuth_deg in drift_sd"),
        ('drift = {azimuth_deg = "walk", range_m = "steps"}', "", "drift_sd names west.azimuth"),
        ('drift = {azimuth_deg = "walk", range_m = "steps"}', 'drift = "walk"', "a table such as"),
    ],
)  # fmt: skip
def test_a_setup_that_cannot_be_meant_is_refused(tmp_path, old, new, said):
    assert old in TEXT
    with pytest.raises(InvalidInputError, match=said):
        read(tmp_path, TEXT.replace(old, new))


def test_a_drift_of_a_bias_that_is_not_estimated_is_refused():
    made = fly(sensors_2d(), {"a.range": 30.0})
    with pytest.raises(InvalidInputError, match=r"drift of \['a.azimuth'\]"):
        bias_model(dataclasses.replace(made.setup, drift={"a.azimuth": "walk"}))
    with pytest.raises(InvalidInputError, match="drift of a.range is 'wander'"):
        dataclasses.replace(made.setup, drift={"a.range": "wander"})


THETA = {"a.range": 100.0, "a.azimuth": 0.01, "b.range_gain": 2e-3, "b.time": 0.4}


def paths_of(made, names, slope):
    """Biases that move: the true ones at time zero, then more by a slope of their size an hour."""
    base = vector(made, names)
    time = np.array([-10.0, 7.0, 25.0, 60.0])
    moved = (time / 60.0)[:, None] ** 2 * slope * base
    return BiasPaths(time, base + moved)


def test_a_path_of_constants_is_the_constants():
    made = fly(sensors_2d(), THETA)
    names = bias_model(made.setup).names
    held = correct(made.recording, made.setup, paths_of(made, names, 0.0))
    constant = correct(made.recording, made.setup, vector(made, names))
    np.testing.assert_allclose(held.values, constant.values, rtol=1e-14)
    np.testing.assert_array_equal(held.time, constant.time)


@pytest.mark.parametrize("slope", [0.3, 3.0])
def test_what_is_restored_is_what_was_corrected(slope):
    made = fly(sensors_2d(), THETA)
    recording = made.recording
    paths = paths_of(made, bias_model(made.setup).names, slope)
    marked = dataclasses.replace(recording, target=np.arange(len(recording)))
    back = restore(correct(marked, made.setup, paths), made.setup, paths)
    order = np.argsort(back.target)
    np.testing.assert_allclose(back.values[order], recording.values, rtol=1e-12)
    np.testing.assert_allclose(back.time[order], recording.time, atol=1e-9)


def test_every_report_has_the_bias_of_its_stamp_and_ends_are_held():
    made = fly(sensors_2d(), {"a.range": 30.0}, noise=0.0)
    time = np.array([10.0, 20.0])
    paths = BiasPaths(time, np.array([[100.0], [200.0]]))
    changed = correct(made.recording, made.setup, paths)
    own = made.recording.sensor == 0
    taken = (made.recording.values - changed.values)[own, 0]
    wanted = np.interp(made.recording.time[own], time, [100.0, 200.0])
    np.testing.assert_allclose(taken, wanted, rtol=1e-9)
    assert {100.0, 200.0} <= set(np.round(taken, 6))


def test_paths_that_cannot_be_are_refused():
    with pytest.raises(InvalidInputError, match="increase"):
        BiasPaths(np.array([1.0, 1.0]), np.zeros((2, 1)))
    with pytest.raises(InvalidInputError, match="values of bias paths"):
        BiasPaths(np.array([1.0, 2.0]), np.zeros((3, 1)))
    made = fly(sensors_2d(), {"a.range": 30.0})
    with pytest.raises(InvalidInputError, match="values of bias paths"):
        correct(made.recording, made.setup, BiasPaths(np.array([1.0]), np.zeros((1, 4))))
