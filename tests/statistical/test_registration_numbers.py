"""What `register` promises, counted over recordings of simulated traffic.

Every judgement is one false alarm in a thousand or rarer if the claim holds exactly, unless a
line says otherwise. About forty minutes on one core; recordings are shared between tests.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import stats
from sklearn.metrics import roc_auc_score

from probreg.diagnostics import Coverage
from probreg.diagnostics.coverage import binomial_limits
from probreg.page import matters
from probreg.posterior.tracks import Point, solve
from probreg.problems.recording.track_reports import PathPoints
from probreg.registration import LAWS
from probreg.samplers.tracks import check_mode
from probreg.scenarios import _flights
from tests.statistical.traffic_runs import (
    DIRTY,
    SCENES,
    Numbers,
    Run,
    bound,
    delayed,
    draw,
    in_pairs,
    merged,
    numbers,
    rms,
    run,
    seen,
)

pytestmark = pytest.mark.slow
RARE = 1e-3
AT_BOUND, CHECKED = 20, 10
DELAY_M = 30.0


@cache
def beside_the_bound(scene: str, laws=LAWS, count: int = AT_BOUND):
    """Ratios of sd, and errors of `register` and of the oracle in the oracle's sd."""
    ratio, own, known = [], [], []
    for seed in range(count):
        one = run(draw([5, seed, 5_000], **SCENES[scene]), seed, laws)
        oracle = bound(one)
        sd = np.sqrt(np.diag(oracle.covariance))
        ratio.append(one.found.sd / sd)
        own.append((one.found.mean - one.bias) / sd)
        known.append((oracle.theta - one.bias) / sd)
    return np.array(ratio), np.array(own), np.array(known)


@pytest.mark.parametrize("scene", SCENES)
def test_biases_are_at_the_bound(scene):
    ratio, own, known = beside_the_bound(scene)
    assert 0.97 < ratio.mean() < 1.02
    # the oracle sees the same noise: their ratio is free of most of its chance
    assert 0.95 < rms(own) / rms(known) < 1.05
    # 120 errors, those of one recording correlated: as 60
    low, high = stats.chi2(60).ppf([0.5 * RARE, 1.0 - 0.5 * RARE]) / 60
    assert low < rms(own) ** 2 < high


def test_gaussian_noise_alone_is_not_at_the_bound():
    """The control of the test above: outliers are refused whole, which costs 4 %."""
    ratio, *_ = beside_the_bound("outliers", LAWS[:1], 6)
    assert ratio.mean() > 1.02


def coverage_of(every: list[Numbers]) -> Coverage:
    held = np.array([one.held for one in every])
    return Coverage(int(held.sum()), held.size, 0.9)


@pytest.mark.parametrize(
    ("reports", "count", "width"), [(500, 200, 0.8), (5_000, 200, 0.8), (50_000, 40, 0.6)]
)
def test_intervals_cover(reports, count, width):
    # pooled over six biases as if they were independent: one false alarm in a hundred
    every = [seen("dirty", seed, reports) for seed in range(count)]
    assert coverage_of(every).honest(0.01)
    # control: intervals a fifth too narrow are seen, of 40 recordings only two fifths
    narrow = np.abs([one.z for one in every]) < width * stats.norm.isf(0.05)
    assert not Coverage(int(narrow.sum()), narrow.size, 0.9).honest(0.01)


@cache
def mode_beside_chains(laws=LAWS, count: int = CHECKED, sweeps: int = 400):
    """Ratio of sd, and shift, of the mode and long chains."""
    checks = []
    for seed in range(count):
        found = run(draw([5, seed, 5_000], **DIRTY), seed, laws).found
        checks.append(check_mode(found.fit, np.random.default_rng(seed), sweeps))
    return np.array([c.sd_ratio for c in checks]), np.array([c.shift for c in checks])


def test_the_mode_agrees_with_chains():
    ratio, shift = mode_beside_chains()
    assert abs(ratio.mean() - 1.0) < 0.02
    # chains of 400 sweeps leave about .01 of either
    assert np.abs(ratio.mean(axis=1) - 1.0).max() < 0.03
    assert rms(shift) < 0.05


def test_under_student_t_chains_do_not_agree():
    """The control: weights differ from draw to draw, and the mode does not know."""
    ratio, _ = mode_beside_chains(LAWS[2:], 2, 100)
    assert ratio.mean() < 0.95


def turning(seed, monkeypatch, laws=LAWS) -> Numbers:
    """Every second leg is a turn at up to 4 m/s2; the setup says 1."""
    monkeypatch.setattr(_flights, "TURN_M_S2", 4.0)
    return numbers(run(draw([6, seed], **DIRTY), seed, laws))


def a_third_turning(seed, monkeypatch) -> Numbers:
    """Thirteen aircraft of forty turn at up to 4 m/s2, the others fly straight."""
    rng = np.random.default_rng([8, seed])
    sd = {"range": 100.0, "azimuth": 3e-3}
    biases = {f"radar{k}.{t}": sd[t] * rng.standard_normal() for k in (1, 2, 3) for t in sd}
    parts = []
    for turn, aircraft in ((4.0, 13), (0.0, 27)):
        monkeypatch.setattr(_flights, "TURN_M_S2", turn)
        size = {"reports": 5_000 * aircraft // 40, "aircraft": aircraft, "biases": biases}
        parts.append(draw([9, aircraft, seed], **size, **DIRTY))
    return numbers(run(merged(parts), seed))


def at_least(every: list[Numbers], share: float) -> bool:
    """Whether intervals hold as often as a coverage of `share` allows."""
    found = coverage_of(every)
    return found.value >= binomial_limits(found.trials, share, 2.0 * RARE)[0]


@pytest.mark.parametrize("flights", [turning, a_third_turning])
def test_targets_that_turn_make_nothing_dishonest(flights, monkeypatch):
    every = [flights(seed, monkeypatch) for seed in range(40)]
    assert at_least(every, 0.88)
    assert np.mean([one.refused for one in every]) < 0.002


@pytest.mark.parametrize("factor", [1.0 / 3.0, 3.0])
def test_an_acceleration_that_the_setup_has_wrong_costs_nothing(factor):
    ratio = []
    for seed in range(10):
        one = run(draw([5, seed, 5_000], **DIRTY), seed, acceleration_m_s2=factor)
        ratio.append(one.found.sd / np.sqrt(np.diag(bound(one).covariance)))
    assert np.mean(ratio) < 1.02


@cache
def delays(asked: bool, count: int) -> tuple[list[Run], np.ndarray]:
    """Transponders that answer late or early: a constant of 30 m of range each."""
    runs = []
    for seed in range(count):
        drawn = delayed(draw([10, seed], outlier_share=0.05), DELAY_M, [11, seed])
        runs.append(run(drawn, seed, target_terms={"range": 20.0} if asked else {}))
    return runs, np.array([one.z for one in runs])


def alarmed(one: Run) -> bool:
    """Whether a reader is stopped: a warning, a missing term, or correlated errors."""
    ratio = one.found.cluster_ratio
    return bool(matters(one.found) or one.found.missing or np.nanmax(ratio) > 1.8)


def knowing_delays(one: Run) -> np.ndarray:
    """Errors in standard deviations of one who knows paths, outliers and the delays' spread."""
    model = replace(one.found.fit.model, reports=one.found.problem.reports)
    truth = one.drawn.truth
    at = PathPoints(truth.time, truth.positions[:, :2], np.zeros((len(truth.time), 2)))
    tangent = model.reports.linearise(one.bias, at)
    weights = np.where(truth.outlier, 0.01, 1.0)[tangent.rows]
    nothing, spread = np.zeros(len(model.laws)), np.array([DELAY_M])
    density = one.found.fit.point.density
    known = solve(model, Point(tangent, weights, 1.0, model.laws, nothing, spread, density))
    return np.asarray((known.theta - one.bias) / np.sqrt(np.diag(known.covariance)))


def test_delays_of_targets_are_taken_up_by_their_terms():
    runs, z = delays(True, 40)
    # all ranges of a recording err together: 40 recordings alone say little, an oracle's more
    known = np.array([knowing_delays(one) for one in runs])
    assert 0.85 < rms(z) / rms(known) < 1.15
    # ranges count once, azimuths three times a recording
    low, high = stats.chi2(160).ppf([0.5 * RARE, 1.0 - 0.5 * RARE]) / 160
    once = np.column_stack([z[:, ::2].mean(axis=1), z[:, 1::2]])
    assert low < np.mean(once**2) < high


def test_delays_of_targets_without_terms_raise_an_alarm():
    runs, z = delays(False, 20)
    assert rms(z) > 1.3
    assert np.mean([alarmed(one) for one in runs]) >= 0.95


@pytest.mark.parametrize("gap_m", [1500.0, 300.0])
def test_close_formations_stay_honest(gap_m):
    """Pairs side by side whose identities are exchanged in 40 % of the scans."""
    every = []
    for seed in range(40):
        drawn = in_pairs(draw([12, seed], reports=2_500), gap_m, 0.4, [13, seed])
        every.append(numbers(run(drawn, seed)))
    assert at_least(every, 0.88)


def together(name: str, scene: str = "dirty") -> np.ndarray:
    return np.concatenate([getattr(seen(scene, seed), name) for seed in range(AT_BOUND)])


def reliability(bad, true, edges) -> list[tuple[float, float, int]]:
    """Mean probability, share that is bad, and count in each bin."""
    bins = np.digitize(bad, edges)
    own = [np.flatnonzero(bins == k) for k in range(1, len(edges))]
    return [(float(bad[i].mean()), float(true[i].mean()), len(i)) for i in own]


EDGES = (0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0 + 1e-9)


def test_bad_reports_are_found_one_by_one():
    bad, wrong, outlier = (together(name) for name in ("bad", "wrong", "outlier"))
    good = ~wrong & ~outlier
    assert roc_auc_score(~good, bad) > 0.995
    assert (bad[good] > 0.5).mean() < 0.002
    for claimed, share, count in reliability(bad, ~good, EDGES):
        assert abs(claimed - share) < 0.03 + 3.3 * 0.5 / np.sqrt(count)
    # control: probabilities that say a half of what they should are seen
    claimed, share, _ = reliability(0.5 * bad, ~good, EDGES)[3]
    assert abs(claimed - share) > 0.03


@pytest.mark.parametrize("turn", [0.0, 1.0])
def test_reconstructed_positions_are_where_the_targets_were(turn, monkeypatch):
    monkeypatch.setattr(_flights, "TURN_M_S2", turn)
    every = [numbers(run(draw([14, seed], **DIRTY), seed)) for seed in range(10)]
    distance2, claimed, off = (
        np.concatenate([getattr(one, name) for one in every])
        for name in ("distance2", "claimed", "off")
    )
    # states of one track hang together: of about 400 tracks the share has an sd near .004
    assert 0.88 < (distance2 < stats.chi2(2).ppf(0.9)).mean() < 0.93
    assert abs(np.sqrt(off.mean() / claimed.mean()) - 1.0) < 0.05
