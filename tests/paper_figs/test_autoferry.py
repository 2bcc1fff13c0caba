"""The study of real recordings, and its figure; skipped where the recordings are not."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from experiments.__main__ import app
from experiments.results import load_result
from experiments.study import load_study
from tests.paper_figs.small import draw, draw_all, missing, run_small

STUDIES, FIGURES = ["autoferry"], ["autoferry_bias"]
FILES = ["autoferry_bias", "autoferry_table"]


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    if load_study("autoferry").missing():
        if "PROBREG_REQUIRE_DATA" in os.environ:
            pytest.fail("PROBREG_DATA must name the folder that contains autoferry/")
        pytest.skip("PROBREG_DATA names no folder that contains autoferry/")
    return run_small(STUDIES, tmp_path_factory.mktemp("results"))


@pytest.fixture(scope="module")
def drawn(results, tmp_path_factory):
    return draw_all(FIGURES, results, tmp_path_factory.mktemp("out"))


def test_the_figure_is_drawn_and_the_table_holds_the_saved_numbers(drawn, results):
    assert missing(FILES, drawn) == []
    data, _ = load_result("autoferry", "quick", results)
    rows = list(csv.reader((drawn[0] / "autoferry_table.csv").read_text().splitlines()))
    at = next(k for k, row in enumerate(rows) if row[0].startswith("radar.range"))
    saved = float(data["posterior"].sel(bias="radar.range", number="mean")[0, 0])
    assert float(rows[at + 1][1].split(" ± ")[0]) == pytest.approx(saved, abs=0.006)


def test_radar_range_is_that_computed_from_gnss(results):
    data, _ = load_result("autoferry", "quick", results)
    for bias in ("radar.range", "lidar.range", "radar.azimuth", "lidar.azimuth"):
        one = data.sel(bias=bias).isel(replicate=0)
        median, error = one["direct"].values.T
        assert (np.abs(one["posterior"].values[:, 0] - median) < 2.0 * error).all(), bias
        assert (one["score"].sel(correction="own") < one["score"].sel(correction="none")).any()


def test_errors_of_the_vessels_themselves_are_allowed_for(results):
    data, _ = load_result("autoferry", "quick", results)
    one = data.isel(replicate=0)
    biases = one["polar"].values
    own = one["own"].sel(number="sd").values
    alone = one["posterior"].sel(bias=biases, number="sd").values
    assert (own > 2.0 * alone).all()
    # two vessels only: their mean, by GNSS alone, lies within what is claimed
    median = one["direct"].sel(bias=biases, moment="median").values
    assert (np.abs(one["own"].sel(number="mean").values - median) < 3.0 * own).all()


def test_without_the_recordings_it_is_left_out_and_says_why(monkeypatch, tmp_path):
    monkeypatch.setenv("PROBREG_DATA", str(tmp_path))
    assert "Get it from its publishers" in load_study("autoferry").missing()
    done = CliRunner().invoke(app, ["run", "autoferry", "--results", str(tmp_path / "r")])
    assert done.exit_code == 1
    assert "autoferry cannot run" in done.output
    assert not (tmp_path / "r").exists()
    monkeypatch.delenv("PROBREG_DATA")
    assert load_study("autoferry").missing()


def test_a_figure_asked_for_by_name_names_the_missing_result(tmp_path):
    done = draw("autoferry_bias", "--results", tmp_path, "--out", Path(tmp_path / "out"))
    assert done.returncode == 1
    assert "python -m experiments run autoferry" in done.stderr
