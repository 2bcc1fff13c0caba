"""The figure of moving biases on recordings; a module of its own for another worker."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from experiments.results import load_result
from tests.paper_figs.small import draw_all, missing, run_small

STUDIES = ["recording_drift"]
FIGURES = ["recording_drift"]
FILES = ["recording_drift", "recording_drift_bands", "recording_drift_table"]


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return run_small(STUDIES, tmp_path_factory.mktemp("results"))


@pytest.fixture(scope="module")
def drawn(results, tmp_path_factory):
    return draw_all(FIGURES, results, tmp_path_factory.mktemp("out"))


def test_the_figures_are_drawn_and_the_table_holds_the_saved_numbers(drawn, results):
    assert missing(FILES, drawn) == []
    rows = list(csv.reader((drawn[0] / "recording_drift_table.csv").read_text().splitlines()))
    at = next(k for k, row in enumerate(rows) if row[0] == "step")
    found = next(row for row in rows[at:] if row[0].strip() == "exact filter")
    data, _ = load_result("recording_drift", "quick,truth=step", results)
    one = data.sel(estimator="exact filter")
    off = one["bias"].sel(bound="mean") - one["truth"]
    saved = 1e3 * float(np.sqrt((off**2).mean()))
    assert float(found[1].split(" ± ")[0]) == pytest.approx(saved, abs=0.051)
    low, high = (one["bias"].sel(bound=bound) for bound in ("low", "high"))
    share = float(((low <= one["truth"]) & (one["truth"] <= high)).mean())
    assert float(found[2].split(" ± ")[0]) == pytest.approx(share, abs=0.0006)


def test_what_sees_all_slices_errs_less_than_what_sees_the_past(results):
    data, _ = load_result("recording_drift", "quick,truth=walk", results)
    off = data["bias"].sel(bound="mean") - data["truth"]
    error = np.sqrt((off**2).mean(("replicate", "time")))
    assert error.sel(estimator="exact smoother") < error.sel(estimator="exact filter")
    # exact draws of one and the same posterior
    wide = data["bias"].sel(bound="high") - data["bias"].sel(bound="low")
    ratio = (wide.sel(estimator="Gibbs") / wide.sel(estimator="exact smoother")).mean()
    assert float(ratio) == pytest.approx(1.0, abs=0.05)
