"""Tracks and reports as files: those of the registration, and near the simulated truth."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from probreg.page import write
from probreg.registration import LAWS, register
from probreg.scenarios.traffic import TrafficScene, simulate


class Written(NamedTuple):
    """A registration, the truth, and the two tables as files have them."""

    found: Any
    truth: Any
    tracks: pd.DataFrame
    reports: pd.DataFrame
    folder: Path


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    scene = TrafficScene(4_000, wrong_share=0.1, outlier_share=0.05)
    recording, setup, truth = simulate(scene, np.random.default_rng(7))
    found = register(recording, setup, rng=np.random.default_rng(8), laws=LAWS[1:2])
    folder = tmp_path_factory.mktemp("tables") / "result"
    write(found, folder)
    tables = (pd.read_parquet(folder / f"{name}.parquet") for name in ("tracks", "reports"))
    return Written(found, truth, *tables, folder)


def test_files_hold_what_the_registration_gives(written):
    pd.testing.assert_frame_equal(written.tracks, written.found.tracks())
    pd.testing.assert_frame_equal(written.reports, written.found.reports())
    recording = written.found.recording
    names = np.array([sensor.name for sensor in recording.sensors])
    for table in (written.tracks, written.reports):
        # every report once, under its own sensor; no clock is in question here
        assert sorted(table.report) == list(range(len(recording)))
        assert (table.sensor == names[recording.sensor[table.report]]).all()
        np.testing.assert_array_equal(table.time, recording.time[table.report])
    assert written.tracks.groupby("track").time.is_monotonic_increasing.all()


def inside(written, stretched=1.0):
    """Whether the claimed 90 % ellipse of each state holds the true position."""
    tracks, truth = written.tracks, written.truth
    labels = written.found.recording.labels
    right = tracks.used & (tracks.target == np.array(labels)[truth.target[tracks.report]])
    own = tracks[right]
    error = own[["x", "y"]].to_numpy() - truth.positions[own.report]
    C = own[["cov_xx", "cov_xy", "cov_xy", "cov_yy"]].to_numpy().reshape(-1, 2, 2)
    square = np.einsum("ni,nij,nj->n", error, np.linalg.inv(C), error) / stretched
    return square < stats.chi2.ppf(0.9, 2)


def test_claimed_ellipses_hold_the_true_positions(written):
    held = inside(written)
    assert len(held) > 3_000
    # neighbouring states share their errors: some 80 aircraft, a standard error of about 2 %
    assert 0.85 < held.mean() < 0.95
    # control: ellipses a fifth too small or too large in standard deviation are found out
    assert inside(written, 0.8**2).mean() < 0.85
    assert inside(written, 1.25**2).mean() > 0.95


def test_velocities_and_earth_columns(written):
    tracks = written.tracks
    assert not {"latitude_deg", "longitude_deg", "height_m", "z"} & set(tracks.columns)
    # oracle: a chord between neighbouring states a few seconds apart
    step = tracks.groupby("track")[["time", "x", "y"]].diff()
    good = (step.time > 2.0) & (step.time < 5.0)
    chord = step.x[good] / step.time[good]
    mean = 0.5 * (tracks.vx + tracks.vx.shift())[good]
    assert np.abs(chord - mean).median() < 1.0
    assert (tracks.sd_vx > 0.0).all()


def test_probabilities_of_reports_know_the_truth(written):
    reports, truth = written.reports, written.truth
    wrong, outlier = truth.wrong[reports.report], truth.outlier[reports.report]
    known = np.array(written.found.recording.labels)[truth.target[reports.report]]
    assert reports.wrong[~wrong & ~outlier].mean() < 0.01
    # under a wrong identity: refused, or given to the target that it is of
    lost = (reports.wrong > 0.5) | reports.moved
    assert lost[wrong].mean() > 0.95
    assert (reports.target == known)[reports.moved].mean() > 0.95
    # ten times the noise is at times no more than the usual
    assert reports.outlier[outlier & ~wrong].mean() > 0.6
    assert reports.outlier[~outlier & ~wrong].mean() < 0.03


def test_residuals_of_reports_are_those_of_the_truth_within_their_sd(written):
    reports, truth, recording = written.reports, written.truth, written.found.recording
    good = ~(truth.wrong | truth.outlier)[reports.report]
    for k, sensor in enumerate(recording.sensors):
        own = reports[good & (reports.sensor == sensor.name)]
        assert not own["range"].isna().any()
        assert (own["range"] / own["range_sd"]).std() == pytest.approx(1.0, abs=0.1)
        # oracle: what noise and bias added, known in the simulation; the path's error is left
        noise = recording.values[own.report, :2] - sensor.to_report(truth.positions[own.report])
        noise[:, 0] -= truth.bias[f"radar{k + 1}.range"]
        assert np.corrcoef(noise[:, 0], own["range"])[0, 1] > 0.7
        assert (own["range"] - noise[:, 0]).std() < own["range_sd"].median()


def test_programs_read_the_noise_of_each_sensor(written):
    found, truth = written.found, written.truth
    content = json.loads((written.folder / "biases.json").read_text())["noise"]
    assert content["law"] == "Contaminated"
    assert content["acceleration_m_s2"] == pytest.approx(np.sqrt(found.fit.point.q))
    for k, one in enumerate(content["sensors"]):
        own = found.recording.sensor == k
        assert one["sensor"] == f"radar{k + 1}"
        # about 1 300 reports each: three standard errors of a share of 5 %, and what is not seen
        assert one["parameters"]["rate"] == pytest.approx(truth.outlier[own].mean(), abs=0.02)
        assert one["parameters"]["core_scale"] == pytest.approx(1.0, abs=0.08)
        assert one["wrong_identities"] == pytest.approx(truth.wrong[own].mean(), abs=0.01)
