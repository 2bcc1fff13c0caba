"""The RALAD paper at full size: its numbers, an independent implementation's, and the bound.

Run by `make test-slow`. Means are compared with those of an independent implementation of
the same scene (100 runs a side, so a difference has sqrt(2) times our standard error), at 4
standard errors; 24 comparisons a table, false alarm rate 0.15 %.
"""

from __future__ import annotations

import io

import numpy as np
import pytest
from rich.console import Console

from experiments.results import load_result
from experiments.runner import run_study
from experiments.study import configurations, load_study
from probreg.diagnostics import bias, rmse

pytestmark = pytest.mark.slow

UNITS = np.array([1.0, 1e3, 1e3] * 2)
# metres and milliradians, rounded as given: range, azimuth, elevation of i, then of j
INDEPENDENT = {
    ("RLS", "true"): (-77.6, -8.66, -3.01, -116.8, 8.62, -20.4),
    ("Huber", "true"): (13.3, -8.68, 7.75, -26.8, 8.72, -9.70),
    ("RALAD", "true"): (15.1, -8.69, 8.44, -24.8, 8.73, -8.99),
    ("RALAD", "smooth"): (17.7, -8.70, 8.70, -22.2, 8.73, -8.75),
}
ROUNDING = {"RLS": (0.05, 0.005, 0.005, 0.05, 0.005, 0.05)}
DEFAULT_ROUNDING = (0.05, 0.005, 0.005, 0.05, 0.005, 0.005)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    for name in ("ralad", "ralad_beyond"):
        study = load_study(name)
        for label, config in configurations(study, "paper", []):
            run_study(study, label, config, folder, 0, Console(file=io.StringIO()))
    return folder


def estimates(results, study, case, estimator, reading):
    data, _ = load_result(study, f"paper,case={case}", results)
    theta = data["theta"].sel(estimator=estimator, reading=reading).values
    return UNITS * theta, UNITS * data["truth"].values


def distance(results, estimator, reading, row):
    """Differences of means in standard errors, less the rounding of the reference."""
    theta, _ = estimates(results, "ralad", 1, estimator, reading)
    measured = bias(theta, 0.0)
    slack = np.array(ROUNDING.get(estimator, DEFAULT_ROUNDING))
    gap = np.maximum(np.abs(measured.value - row) - slack, 0.0)
    return gap / (np.sqrt(2.0) * measured.standard_error)


@pytest.mark.parametrize("key", INDEPENDENT, ids=str)
def test_means_of_case_1_are_those_of_an_independent_implementation(results, key):
    assert (distance(results, *key, INDEPENDENT[key]) < 4.0).all()


@pytest.mark.parametrize("estimator", ["RLS", "Huber", "RALAD"])
def test_the_wrong_reading_fails_that_comparison(results, estimator):
    # negative control: B and R at the raw reports
    assert distance(results, estimator, "measured", INDEPENDENT[estimator, "true"]).max() > 4.0


@pytest.mark.parametrize("case", [1, 2])
def test_ralad_beats_huber_beats_rls_in_range_and_elevation(results, case):
    errors = {}
    for name in ("RALAD", "Huber", "RLS"):
        theta, truth = estimates(results, "ralad", case, name, "true")
        errors[name] = rmse(theta, truth).value
    for k in (0, 2, 3, 5):
        assert errors["RALAD"][k] < errors["Huber"][k] < errors["RLS"][k]


@pytest.mark.parametrize(("reading", "expected"), [("true", -10.0), ("smooth", -7.5)])
def test_ralad_range_errors_of_case_2(results, reading, expected):
    theta, truth = estimates(results, "ralad", 2, "RALAD", reading)
    measured = bias(theta, truth)
    assert np.mean(measured.value[[0, 3]]) == pytest.approx(expected, abs=0.8)


def test_errors_in_variables_bias_ralad_outwards(results):
    # +20 m in case 1, +53 m in case 2 with B and R at the raw reports
    for case, expected in ((1, 20.0), (2, 53.0)):
        theta, truth = estimates(results, "ralad", case, "RALAD", "measured")
        assert np.mean(bias(theta, truth).value[[0, 3]]) == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize(("reading", "student"), [("true", 1.9), ("smooth", 0.76)])
def test_heavy_tailed_laws_come_near_the_bound(results, reading, student):
    theta, truth = estimates(results, "ralad_beyond", 1, "Student-t, recursive", reading)
    got = np.sqrt(np.mean(rmse(theta, truth).value[[0, 3]] ** 2))
    assert got == pytest.approx(student, rel=0.15)
    theta, truth = estimates(results, "ralad_beyond", 1, "contaminated, batch", "smooth")
    assert np.sqrt(np.mean(rmse(theta, truth).value[[0, 3]] ** 2)) < 0.62


def test_bound_of_the_clean_scene(results):
    data, _ = load_result("ralad_beyond", "paper,case=0", results)
    sd = UNITS * data["bound_sd"].mean("replicate").values
    np.testing.assert_allclose(sd, [0.458, 0.059, 0.116] * 2, rtol=0.05)


def test_the_relinearised_form_is_calibrated_on_clean_data(results):
    # exact binomial limits of 90 % intervals over 100 runs, 6 parameters, 1e-4 each: 78..98
    data, _ = load_result("ralad_beyond", "paper,case=0", results)
    clean = data.sel(estimator="least squares, clean rows only")
    z = (clean["theta"] - data["truth"]) / clean["claimed_sd"]
    covered = (abs(z) < 1.6449).sum("replicate")
    good = covered.sel(reading="relinearised").values
    assert ((good >= 78) & (good <= 98)).all()
    assert (np.abs(z.sel(reading="relinearised").mean("replicate")) < 0.4).all()
    # negative control: one-shot conversion, four bounds off in range
    for reading in ("true", "measured"):
        assert (covered.sel(reading=reading).values[[0, 3]] < 78).all()


@pytest.mark.parametrize(("case", "above", "below"), [(1, 0.38, 0.165), (2, 0.50, 0.165)])
def test_condition_numbers_show_little(results, case, above, below):
    # the reference counted an unstated track: its share must lie between the two kinds
    data, _ = load_result("ralad", f"paper,case={case}", results)
    ratio = data["log_condition_ratio"]
    lone, paired = (ratio.sel(track=f"{k} parallel track").values for k in ("without", "with"))
    assert (lone > 0.01).mean() - 0.01 < above < (paired > 0.01).mean() + 0.01
    assert (paired < -0.01).mean() - 0.01 < below < (lone < -0.01).mean() + 0.01
    shift = UNITS * np.abs(data["theta_single_shift"].values)
    assert shift.max() < 0.02  # metres and milliradians; the bound is 0.46 m
