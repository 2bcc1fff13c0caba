"""Size of a step at the moment of its alarm, against least squares of steps at known moments."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from probreg.prior import GaussianPrior
from probreg.watch import WatchSettings, _filters
from probreg.watch._advance import step_size
from probreg.watch._changes import Found

WINDOW, REPORTS, SIGMA, STEP = 3, 500, 0.05, 0.7
SETTINGS = WatchSettings(slice_s=10.0, lag_s=20.0, window=WINDOW, delay_s=0.0, drift=False)


def said(knot, share, values):
    """J and eta of reports at shares of the slice before a knot."""
    H = np.zeros((len(share), WINDOW))
    H[:, knot], H[:, knot - 1] = share, 1.0 - share
    return H.T @ H / SIGMA**2, H.T @ values / SIGMA**2


def measured(moment, ago, rng):
    """Size and sd by the rule; sds of the newest knot after and before the step."""
    prior = GaussianPrior.from_sd(np.ones(1))
    variance = _filters.levels(SETTINGS, np.ones(1))
    filters = _filters.first_filters(prior, np.zeros(1), SETTINGS)
    J, eta = np.zeros((WINDOW, WINDOW)), np.zeros(WINDOW)
    for k in range(60 + ago):
        filters = _filters.next_knot(filters, variance)
        share = (np.arange(REPORTS) + 0.5) / REPORTS
        past = k - 59  # slices since that of the step
        truth = STEP * ((share > moment) if past == 0 else float(past > 0))
        values = truth + SIGMA * rng.standard_normal(REPORTS)
        if past < 0:
            filters = _filters.with_reports(filters, *said(WINDOW - 1, share, values))
            before = _filters.belief(filters, J, eta, 1).variance[0, 0]
        else:
            own = said(WINDOW - 1 - (ago - past), share, values)
            J, eta = J + own[0], eta + own[1]
    filters = _filters.widened(filters, WINDOW - 1 - ago, np.array([2.25]))
    after = _filters.belief(filters, J, eta, 1).variance[0, 0]
    refined = SimpleNamespace(information=(J, eta))
    size, sd = step_size(filters, refined, Found(59, 0, np.nan, np.nan), ago)
    return size, sd, np.sqrt(after + before)


@pytest.mark.parametrize("ago", [0, 1])
def test_a_step_at_any_moment_of_its_slice_is_as_far_off_as_is_said(ago):
    rng = np.random.default_rng(ago)
    # of a step near the end of its slice the next one raises the alarm
    moments = (np.arange(100) + 0.5) / (100 if ago else 125)
    size, sd, old = np.array([measured(u, ago, rng) for u in moments]).T
    expected = STEP * (0.5 * (1.0 - moments**2) + ago) / (1.0 / 3.0 + ago)
    np.testing.assert_allclose(size, expected, atol=5.0 * SIGMA / np.sqrt(REPORTS / 4))
    assert 0.5 < np.sqrt(np.mean(((size - STEP) / sd) ** 2)) < 1.3
    # the control: beliefs after and before the step know nothing of its moment
    assert np.sqrt(np.mean(((size - STEP) / old) ** 2)) > 5.0


def test_a_step_from_before_the_window_is_as_its_odds_have_it():
    filters = _filters.first_filters(GaussianPrior.from_sd(np.ones(1)), np.zeros(1), SETTINGS)
    refined = SimpleNamespace(information=(np.eye(WINDOW), np.zeros(WINDOW)))
    assert step_size(filters, refined, Found(0, 0, 0.3, 0.1), WINDOW) == (0.3, 0.1)
