"""Figures of calibration, coverage and posteriors, drawn from saved results.

A module of its own, so that two workers share the drawing of all figures.
"""

from __future__ import annotations

import pytest

from paper_figs.__main__ import figures
from tests.paper_figs.small import draw_all, missing, run_small

STUDIES = ["calibration", "calibration_nuts", "calibration_position", "calibration_reports"]
STUDIES += ["coverage_by_gamma", "coverage_methods", "posterior_ralad"]
BAYES = ["calibration_sbc", "calibration_reports", "calibration_position", "coverage_by_gamma"]
BAYES += ["posterior_ralad", "coverage_methods"]
FILES = [f"calibration_{kind}_pair_{d}d" for kind in ("sbc", "ranks") for d in (2, 3)] + BAYES[1:]
FILES += ["calibration_table", "calibration_reports_table", "calibration_position_table"]


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    results = run_small(STUDIES, tmp_path_factory.mktemp("results"))
    return draw_all(BAYES, results, tmp_path_factory.mktemp("out"))


def test_all_figures_of_the_samplers_are_there():
    assert set(BAYES) <= set(figures())


def test_every_figure_is_drawn_as_vector_and_picture(drawn):
    assert missing(FILES, drawn) == []
    assert not list(drawn[0].glob("*.tmp"))
