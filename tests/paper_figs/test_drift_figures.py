"""Figures of drifting biases, drawn from saved results; a module of its own for another worker."""

from __future__ import annotations

import pytest

from paper_figs.__main__ import figures
from tests.paper_figs.small import draw_all, missing, run_small

STUDIES = ["mh", "mh_sensitivity", "mh_radar", "drift_methods", "drift_calibration"]
MH = [*(f"mh_fig{k}" for k in range(1, 9)), "mh_table", "mh_sensitivity", "mh_gamma", "mh_lowpass"]
MH += ["mh_radar", "drift_methods", "drift_trace", "drift_calibration"]
FILES = [*MH, "mh_radar_table", "drift_methods_table", "drift_calibration_table"]


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    results = run_small(STUDIES, tmp_path_factory.mktemp("results"))
    return draw_all(MH, results, tmp_path_factory.mktemp("out"))


def test_all_figures_of_drift_are_there():
    assert set(MH) <= set(figures())


def test_every_figure_is_drawn_as_vector_and_picture(drawn):
    assert missing(FILES, drawn) == []
