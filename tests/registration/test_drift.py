"""Biases that drift, as a user registers them."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray

from probreg.errors import InvalidInputError
from probreg.noise import Contaminated
from probreg.page import biases_text, write
from probreg.recordings import bias_model, read_biases
from probreg.registration import LawChoice, register
from tests.statistical.traffic_runs import draw, drifted, step_path, walk_path

LAW = (LawChoice.usual(Contaminated()),)
NAME, OTHER = "radar1.azimuth", "radar2.range"


@pytest.fixture(scope="module")
def made():
    """Seven minutes: an azimuth that steps by 0.2 degrees, a range that walks."""
    drawn = draw(3, reports=9_000, wrong_share=0.1)
    end = drawn.recording.time[-1]
    at, step = step_path(3, np.deg2rad(0.2), end)
    walk = walk_path(3, 20.0, end)
    drawn = drifted(drifted(drawn, NAME, step), OTHER, walk)
    setup = replace(drawn.setup, drift={NAME: "steps", OTHER: "walk"}, limits={OTHER: 500.0})
    found = register(drawn.recording, setup, rng=np.random.default_rng(1), laws=LAW)
    return found, drawn, at, step, walk


def test_paths_follow_the_truth_within_their_bands(made):
    """A step between two knots costs most."""
    found, drawn, _, step, walk = made
    time = np.arange(20.0, drawn.recording.time[-1] - 20.0, 7.0)
    for name, path, sd in ((NAME, step, np.deg2rad(0.03)), (OTHER, walk, 15.0)):
        truth = drawn.truth.bias[name] + path(time)
        draws = found.path_draws(name, time)
        error = draws.mean(axis=0) - truth
        assert np.sqrt(np.mean(error**2)) < sd
        low, high = np.quantile(draws, [0.05, 0.95], axis=0)
        assert ((low <= truth) & (truth <= high)).mean() > 0.7
        # what a constant would be off by
        assert truth.std() > 2.0 * np.sqrt(np.mean(error**2))


def test_averages_stand_where_constants_stood(made):
    found, drawn, _, step, _ = made
    time = np.linspace(*drawn.recording.time[[0, -1]], 4_001)
    truth = {name: bias for name, bias in drawn.truth.bias.items() if name not in (NAME, OTHER)}
    truth[NAME] = drawn.truth.bias[NAME] + step(time).mean()
    for name, bias in truth.items():
        k = found.names.index(name)
        assert abs(found.mean[k] - bias) < 4.5 * found.sd[k]
    assert found.drifting == (NAME, OTHER)
    assert found.bias_draws.shape == (2_000, 6)
    paths = found.draws.paths
    weights = found.fit.knots.average[found.names.index(OTHER), found.fit.knots.places(3 - 1)]
    own = paths.flat[..., 1] @ weights
    np.testing.assert_allclose(own, found.bias_draws[:, found.names.index(OTHER)], rtol=1e-9)


def test_the_step_is_named_where_it_was(made):
    found, _, at, _, _ = made
    (change,) = found.changes
    assert change.name == NAME
    assert abs(change.time - at) < 3.0 * change.time_sd < 45.0
    assert np.rad2deg(change.size) == pytest.approx(0.2, abs=0.02)
    assert found.draws.paths.constant[0] < 1e-3


def test_correction_takes_the_path_and_restoring_puts_it_back(made):
    found, drawn, _, step, _ = made
    marked = replace(drawn.recording, target=np.arange(len(drawn.recording)))
    corrected = found.correct(marked)
    own = np.flatnonzero(drawn.recording.sensor == 0)
    taken = (drawn.recording.values - corrected.values)[own, 1]
    truth = drawn.truth.bias[NAME] + step(drawn.recording.time[own])
    assert np.sqrt(np.mean((taken - truth) ** 2)) < np.deg2rad(0.02)
    back = found.restore(corrected)
    np.testing.assert_allclose(back.values, drawn.recording.values, rtol=1e-12)


def test_everything_downstream_takes_what_drifts(made):
    found, drawn, *_ = made
    tracks = found.tracks()
    own = drawn.truth.target[tracks["report"]] == found.problem.owner[tracks["track"]]
    away = tracks[["x", "y"]].to_numpy() - drawn.truth.positions[tracks["report"], :2]
    share = (np.hypot(*away.T) ** 2 / (tracks["cov_xx"] + tracks["cov_yy"]))[own].median()
    assert 0.3 < share < 1.0  # 0.5 to 0.7 of a chi-square of one to two degrees of freedom
    assert found.held_out.verdict == "better"
    assert (found.determined.share > 0.9).all()
    assert (found.cluster_ratio < 1.8).all()
    assert not found.missing
    verdict = found.verdicts[0]
    path = found.path_draws(OTHER)
    assert verdict.probability == pytest.approx((np.abs(path) > 500.0).mean(axis=0).max())


def test_files_hold_the_paths_and_are_read_back(made, tmp_path):
    found, *_ = made
    write(found, tmp_path / "out")
    table = pd.read_csv(tmp_path / "out" / "biases.csv")
    assert list(table["name"][table["time"].isna()]) == list(found.names)
    own = table[(table["name"] == NAME) & table["time"].notna()]
    knots = found.fit.knots.time
    np.testing.assert_allclose(own["time"], knots)
    degrees = np.rad2deg(np.quantile(found.path_draws(NAME), 0.95, axis=0))
    np.testing.assert_allclose(own["high_90"], degrees, rtol=1e-9)
    again = read_biases(tmp_path / "out" / "biases.json", bias_model(found.setup).names)
    np.testing.assert_allclose(again.values, found.over_time.values, rtol=1e-12)
    content = json.loads((tmp_path / "out" / "biases.json").read_text())
    assert [one["drift"] for one in content["paths"]] == ["steps", "walk"]
    assert content["changes"][0]["name"] == NAME
    posterior = xarray.open_dataset(tmp_path / "out" / "posterior.nc", group="posterior")
    np.testing.assert_allclose(posterior["time"], knots)
    np.testing.assert_array_equal(
        posterior[f"{OTHER}.path"].values, found.draws.paths.values[..., 1]
    )
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Biases over time" in page
    assert "azimuth moves between" in page
    assert "it drifts" in biases_text(found)


def test_paths_are_asked_for_by_names_that_are_there(made):
    found, *_ = made
    with pytest.raises(InvalidInputError, match="no bias 'x'"):
        found.path_draws("x")
    with pytest.raises(InvalidInputError, match="does not drift; say at which times"):
        found.path_draws("radar3.range")
    held = found.path_draws("radar3.range", np.array([1.0, 2.0]))
    np.testing.assert_array_equal(held[:, 0], held[:, 1])
    assert len(found.paths(np.array([30.0, 60.0]))) == 4


def test_what_does_not_move_is_as_well_known_as_a_constant():
    drawn = draw(5, reports=6_000)
    constant = register(drawn.recording, drawn.setup, rng=np.random.default_rng(1), laws=LAW)
    setup = replace(drawn.setup, drift={NAME: "walk"})
    moving = register(drawn.recording, setup, rng=np.random.default_rng(1), laws=LAW)
    k = constant.names.index(NAME)
    assert moving.draws.paths.constant[0] > 0.5
    assert abs(moving.mean[k] - constant.mean[k]) < 0.5 * constant.sd[k]
    assert 0.9 < moving.sd[k] / constant.sd[k] < 1.5
    assert constant.drifting == ()
    assert constant.changes == ()
    assert len(constant.paths()) == 0
