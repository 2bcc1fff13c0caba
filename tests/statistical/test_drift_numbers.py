"""Drift studies at their full size: exact answers, agreement, calibration, order of methods.

`make test-slow`.
"""

from __future__ import annotations

import dataclasses
import io

import numpy as np
import pytest
from rich.console import Console

from experiments.drift_scene import joint_model
from experiments.results import load_result
from experiments.runner import run_study
from experiments.study import load_study
from probreg.diagnostics import Ranks

pytestmark = pytest.mark.slow
BIAS = slice(4, 6)
CURES = ("Gibbs, Student-t", "Gibbs, contaminated", "NUTS, Student-t")


def run(name, folder, **changes):
    study = load_study(name)
    config = dataclasses.replace(study.profiles["paper"], **changes)
    run_study(study, "run", config, folder, 0, Console(file=io.StringIO()))
    return load_result(name, "run", folder)[0]


@pytest.fixture(scope="module", params=["Gaussian", "Student-t"])
def methods(request, tmp_path_factory):
    data = run("drift_methods", tmp_path_factory.mktemp("methods"), noise=request.param)
    return request.param, data.stack(case=("replicate", "run"), create_index=False)


def squares(data, name):
    """Mean squared error of each run."""
    return data["square"].sel(estimator=name).mean("time").values


def paired(one, two):
    """Difference of mean squared errors in standard errors, run by run."""
    gap = one - two
    return gap.mean() / (gap.std(ddof=1) / np.sqrt(gap.size))


def test_under_gaussian_noise_filter_and_smoother_are_exact(methods):
    # mean squared error against the covariance's trace, coverage against .9; limit 4 errors
    noise, data = methods
    if noise != "Gaussian":
        pytest.skip("exact under Gaussian noise")
    model = joint_model(data.sizes["time"])
    for name, covariance in (
        ("Kalman filter", model.filtered.covariance),
        ("RTS smoother", model.smooth().covariance),
    ):
        expected = np.einsum("taa->t", covariance[:, BIAS, BIAS]).mean()
        own = squares(data, name)
        assert abs(own.mean() - expected) < 4.0 * own.std() / np.sqrt(own.size)
        held = data["held"].sel(estimator=name).mean("time").values
        assert abs(held.mean() - 0.9) < 4.0 * held.std() / np.sqrt(held.size)


def test_samplers_of_whole_paths_have_the_same_errors_and_cover(methods):
    # a mean of few draws adds its own Monte-Carlo error, so five per cent are allowed
    _, data = methods
    gibbs = squares(data, "Gibbs")
    for name in ("MH in blocks", "NUTS"):
        other = squares(data, name)
        assert abs(other.mean() / gibbs.mean() - 1.0) < 0.05
        held = data["held"].sel(estimator=name).mean("time").values
        # few draws make an interval's ends uncertain: a little too short on average
        assert 0.86 < held.mean() < 0.93
    held = data["held"].sel(estimator="Gibbs").mean("time").values
    assert abs(held.mean() - 0.9) < 4.0 * held.std() / np.sqrt(held.size)


def test_under_student_noise_the_right_law_wins(methods):
    # paired, 4 standard errors: each better than its Gaussian counterpart
    noise, data = methods
    if noise != "Student-t":
        pytest.skip("under Gaussian noise nothing is to be won")
    for better, worse in (
        ("particle filter", "Kalman filter"),
        ("sequential MH", "Kalman filter"),
        ("Gibbs", "RTS smoother"),
    ):
        assert paired(squares(data, worse), squares(data, better)) > 4.0


def test_samplers_of_paths_are_calibrated(tmp_path):
    data = run("drift_calibration", tmp_path)
    data = data.stack(case=("replicate", "run"), create_index=False)
    found = []
    for sampler in (str(s) for s in data["sampler"].values):
        values = data["ranks"].sel(sampler=sampler).transpose("case", "quantity").values
        values = values[(values >= 0).any(axis=1)]
        values = values[:, (values >= 0).all(axis=0)]
        ranks = Ranks(values, 49, tuple(str(k) for k in range(values.shape[1])))
        found.extend(ranks.p_values)
        # negative control: a tenth of the truths moved to the top
        broken = values.copy()
        broken[::10] = 49
        if len(values) == 500:
            assert Ranks(broken, 49, ranks.names).p_values.max() < 1e-3
    assert min(found) > 1e-3 / len(found)


@pytest.mark.parametrize("drifting", [True, False])
def test_under_outliers_posteriors_beat_least_squares_by_far(drifting, tmp_path):
    # ten runs; what is said of the figure: order of magnitude of the errors, and who covers
    data = run("mh_radar", tmp_path, drifting=drifting, replicates=10)
    error = np.sqrt(data["square"].mean(["replicate"]))
    held = data["held"].mean(["replicate", "parameter"])
    for name in CURES:
        for parameter in data["parameter"].values:
            chosen = error.sel(parameter=parameter)
            assert float(chosen.sel(estimator=name)) < 0.2 * float(chosen.sel(estimator="RLS"))
            assert float(chosen.sel(estimator=name)) < float(chosen.sel(estimator="Huber"))
        assert float(held.sel(estimator=name)) > 0.75
    for name in ("RLS", "MH tracker, Student-t, gamma 10"):
        assert float(held.sel(estimator=name)) < 0.65
