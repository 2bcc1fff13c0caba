"""The per-scan tracker: exact truncated means, quadrature, Kalman filter, independent numbers."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import integrate, stats

from probreg import GaussianPrior, ReportProblem, arviz_adapter
from probreg.errors import ImproperLawError, InvalidInputError
from probreg.motion.dynamics import Constant, RandomWalk
from probreg.motion.trajectory import Trajectory
from probreg.noise import Contaminated, Gaussian, HardReject, Huber, Hyperbolic, StudentT
from probreg.problems import as_trajectory
from probreg.samplers.scans import (
    AccumulatedMemory,
    AllScans,
    AsPrinted,
    Flat,
    GaussianMemory,
    ParticleFilter,
    ParticleMemory,
    ScanMetropolis,
    _scan_chain,
)
from probreg.scenarios.uturn import UturnScene, simulate


def rng(seed=1):
    return np.random.default_rng(seed)


def one_scan(y=470.0, variance=4000.0, prior_sd=1e6):
    one = np.ones((1, 1, 1))
    prior = GaussianPrior.from_sd(np.array([prior_sd]))
    empty = np.empty((0, 1, 1))
    return Trajectory(np.array([[y]]), one, variance * one, empty, empty, prior)


def scene(form="reference", drifting=True, seed=0, scans=180):
    """The sensor's two biases; those of the reference are known to be zero."""
    data, truth = simulate(UturnScene(form, drifting, scans=scans), rng(seed))
    linear = ReportProblem(data).linearise(np.zeros(4))
    own = type(linear)(linear.y, linear.B[:, :, :2], linear.R, linear.time, linear.names[:2])
    if drifting:
        prior = GaussianPrior(np.zeros(2), 1000.0 * np.eye(2))
        return as_trajectory(own, RandomWalk(np.full(2, 1000.0)), prior), truth
    prior = GaussianPrior(np.zeros(2), 300.0**2 * np.eye(2))
    return as_trajectory(own, Constant(), prior), truth


def judged(draws, mean, variance):
    x = draws[None]
    ess = arviz_adapter.ess(x, "mean"), arviz_adapter.ess((x - mean) ** 2, "mean")
    assert min(ess) > 2000
    return np.array([
        (x.mean() - mean) / (x.std() / np.sqrt(ess[0])),
        (((x - mean) ** 2).mean() - variance) / (((x - mean) ** 2).std() / np.sqrt(ess[1])),
    ])  # fmt: skip


@pytest.mark.parametrize("share_global", [0.0, 0.1, 0.9])
def test_at_the_box_the_mean_is_the_exact_truncated_one(share_global):
    # y = 470, box 500: 436.96; clipping would give 450 and more; two scores at 4.5
    tracker = ScanMetropolis(
        steps=400_000, burn_in=1000, box=500.0, share_global=share_global, step=106.0
    )
    found = tracker.track(one_scan(), rng()).draws[0, :, 0]
    law = stats.truncnorm((-500 - 470) / 4000**0.5, (500 - 470) / 4000**0.5, 470.0, 4000**0.5)
    assert law.mean() == pytest.approx(436.96, abs=0.01)
    assert (np.abs(judged(found, law.mean(), law.var())) < 4.5).all()
    # negative control: proposals clipped to the box pile up at its edge
    clipped = np.minimum(470.0 + 4000**0.5 * rng(2).standard_normal(400_000), 500.0)
    assert np.abs(judged(clipped, law.mean(), law.var())[0]) > 4.5


@pytest.mark.parametrize(
    "law",
    [Gaussian(), StudentT(3.0), Contaminated(0.2, 6.0), Huber(1.0), Hyperbolic(0.3)],
    ids=repr,
)
def test_every_law_has_the_moments_of_quadrature(law):
    model = one_scan(y=1.5, variance=1.0, prior_sd=2.0)
    tracker = ScanMetropolis(GaussianMemory(), law, steps=400_000, burn_in=1000, box=60.0, step=2.4)
    found = tracker.track(model, rng()).draws[0, :, 0]

    def density(b, power):
        rows = float(law.log_density(np.array([[1.5 - b]]))[0])
        return b**power * np.exp(rows - 0.125 * b**2)

    whole = [integrate.quad(density, -20, 20, args=(k,), points=[0.0, 1.5])[0] for k in range(3)]
    mean = whole[1] / whole[0]
    assert (np.abs(judged(found, mean, whole[2] / whole[0] - mean**2)) < 4.5).all()


def test_sharpening_divides_the_variance_and_is_said():
    tracker = ScanMetropolis(steps=200_000, burn_in=1000, gamma=4.0)
    found = tracker.track(one_scan(), rng())
    assert (np.abs(judged(found.draws[0, :, 0], 470.0, 1000.0)) < 4.5).all()
    assert "not the posterior" in found.warnings[0]


def test_sequential_inference_is_the_kalman_filter():
    model, _ = scene()
    kalman = model.filter()
    for target in (AccumulatedMemory(), GaussianMemory(), ParticleMemory(800)):
        found = ScanMetropolis(target, steps=6000, burn_in=500).track(model, rng())
        gap = found.mean - kalman.mean
        sd = np.sqrt(np.einsum("taa->ta", kalman.covariance))
        assert np.sqrt(np.mean((gap / sd) ** 2)) < 0.25
        assert np.mean(found.draws.std(axis=1) / sd) == pytest.approx(1.0, abs=0.06)
    # negative control: forgetting the past
    forgets = ScanMetropolis(Flat(), steps=6000, burn_in=500).track(model, rng())
    assert np.sqrt(np.mean(((forgets.mean - kalman.mean) / sd) ** 2)) > 1.0


# bias RMSE, 400 runs of an independent implementation
PAPER = ScanMetropolis(
    Flat(), steps=50, burn_in=0, step=20.0, gamma=10.0, estimate="last",
    start=np.array([-1000.0, -1000.0]),
)  # fmt: skip
EXPECTED = {
    ("paper", "reference", True): 92.8,
    ("paper", "pair", True): 127.5,
    ("paper", "reference", False): 92.9,
    ("paper", "pair", False): 127.7,
    ("flat", "reference", True): 89.9,
    ("flat", "pair", True): 127.3,
    ("sequential", "reference", True): 56.4,
    ("sequential", "pair", True): 69.8,
    ("accumulated", "reference", False): 15.8,
    ("accumulated", "pair", False): 22.3,
}
TRACKERS = {
    "paper": PAPER,
    "flat": ScanMetropolis(),
    "sequential": ScanMetropolis(GaussianMemory()),
    "accumulated": ScanMetropolis(AccumulatedMemory()),
}


@pytest.mark.parametrize("key", EXPECTED, ids=str)
def test_errors_are_those_of_an_independent_implementation(key):
    # 10 comparisons at 4 standard errors of the difference: false-alarm rate 6e-4
    name, form, drifting = key
    squares = []
    for seed in range(40):
        model, truth = scene(form, drifting, seed)
        late = slice(60, None) if name == "paper" else slice(None)
        gap = (TRACKERS[name].track(model, rng(seed)).mean - truth.bias)[late]
        squares.append((gap**2).sum(axis=1).mean())
    rmse = np.sqrt(np.mean(squares))
    error = np.std(squares) / 2.0 / rmse * np.sqrt(1.0 / 40 + 1.0 / 400)
    assert abs(rmse - EXPECTED[key]) < 4.0 * error + 0.3


def test_refitted_moments_lose_coverage_of_a_constant_bias():
    shares = {}
    for target in (AccumulatedMemory(), GaussianMemory()):
        held = []
        for seed in range(12):
            model, truth = scene("reference", False, seed)
            low, high = np.moveaxis(
                ScanMetropolis(target).track(model, rng(seed)).interval(0.9), -1, 0
            )
            held.append(np.mean((low <= truth.bias) & (truth.bias <= high)))
        shares[type(target).__name__] = np.mean(held)
    assert shares["AccumulatedMemory"] > 0.8
    assert shares["GaussianMemory"] < 0.7


def test_the_printed_density_drives_the_bias_into_a_corner_and_says_so():
    model, _ = scene(scans=20)
    found = ScanMetropolis(AsPrinted(), box=2000.0).track(model, rng())
    assert (np.abs(found.mean[5:]) > 1200.0).all()
    assert any("edge of the box" in text for text in found.warnings)


def test_two_modes_are_crossed_by_global_moves_only():
    # a bias of +-600 m, each with a likelihood of its own, as two rows under a law of heavy tails
    model = Trajectory(
        np.array([[600.0, -600.0]]),
        np.ones((1, 2, 1)),
        np.eye(2)[None],
        np.empty((0, 1, 1)),
        np.empty((0, 1, 1)),
        GaussianPrior.from_sd(np.array([1e6])),
        width=1,
    )

    def share(share_global):
        start = np.array([600.0])
        tracker = ScanMetropolis(
            Flat(), StudentT(1.0), 400_000, 0, 2.0, share_global, box=800.0, start=start
        )
        return np.mean(tracker.track(model, rng()).draws < 0.0)

    assert share(0.0) == 0.0
    assert share(0.5) == pytest.approx(0.5, abs=0.2)


def test_same_seed_same_track():
    model, _ = scene(scans=10)
    one, two = (ScanMetropolis(ParticleMemory()).track(model, rng(3)) for _ in range(2))
    np.testing.assert_array_equal(one.draws, two.draws)


def test_compiled_chain_is_the_same_code_in_plain_python(monkeypatch):
    model, _ = scene(scans=3)
    tracker = ScanMetropolis(GaussianMemory(), steps=200, burn_in=10)
    quick = tracker.track(model, rng(4))
    for name in ("_propose", "_log_rows", "_log_prior"):
        monkeypatch.setattr(_scan_chain, name, getattr(_scan_chain, name).py_func)
    plain = _scan_chain.run_scan.py_func

    def with_kernel(*arguments):
        listed = list(arguments)
        listed[2] = lambda d2, m, params: -0.5 * d2  # a function pointer cannot be called here
        return plain(*listed)

    monkeypatch.setattr("probreg.samplers.scans.scan_metropolis.run_scan", with_kernel)
    slow = tracker.track(model, rng(4))
    np.testing.assert_allclose(slow.draws, quick.draws, rtol=1e-9)


def test_bad_settings_are_refused():
    with pytest.raises(InvalidInputError, match="gamma"):
        ScanMetropolis(gamma=0.0)
    with pytest.raises(InvalidInputError, match="burn_in"):
        ScanMetropolis(steps=10, burn_in=10)
    with pytest.raises(InvalidInputError, match="share_global"):
        ScanMetropolis(share_global=1.5)
    with pytest.raises(InvalidInputError, match="'mean' or 'last'"):
        ScanMetropolis(estimate="median")
    with pytest.raises(ImproperLawError, match="no density"):
        ScanMetropolis(noise=HardReject())
    with pytest.raises(InvalidInputError, match="not an array"):
        ScanMetropolis(noise=StudentT(np.array([3.0, 4.0])))
    with pytest.raises(InvalidInputError, match="box must be"):
        ScanMetropolis(box=np.zeros((1, 2))).track(one_scan(), rng())
    with pytest.raises(InvalidInputError, match="at least two particles"):
        ParticleMemory(1)
    model, _ = scene(drifting=False, scans=5)
    with pytest.raises(InvalidInputError, match="Q is singular"):
        ScanMetropolis(ParticleMemory()).track(model, rng())


def test_a_cold_start_begins_each_scan_anew():
    model, _ = scene(scans=40)
    settings = {"steps": 20, "burn_in": 0, "step": 30.0, "share_global": 0.0}
    start = np.array([1500.0, -1500.0])
    warm, cold = (
        ScanMetropolis(Flat(), start=start, warm_start=w, **settings).track(model, rng())
        for w in (True, False)
    )
    np.testing.assert_array_equal(cold.draws[0], warm.draws[0])
    assert np.abs(cold.draws[:, 0] - start).max() < 5.0 * 30.0
    assert np.abs(warm.draws[39, 0] - start).max() > 500.0


def test_all_scans_of_a_constant_bias_agree_with_quadrature_under_any_law():
    # one bias, eight scans, Student-t; mean and variance after the last, limit 4.4 errors of 2
    one, generator = np.ones((8, 1, 1)), rng(4)
    y = 1.5 + StudentT(3.0).sample(generator, 8, 1)
    prior = GaussianPrior.from_sd(np.array([2.0]))
    model = Trajectory(y, one, one, one[:-1], 0.0 * one[:-1], prior)
    x = np.linspace(-12.0, 12.0, 4001)
    height = -0.125 * x**2 + sum(StudentT(3.0).log_density((v - x)[:, None]) for v in y[:, 0])
    weight = np.exp(height - height.max())
    weight /= weight.sum()
    mean = weight @ x
    tracker = ScanMetropolis(AllScans(), StudentT(3.0), 40_000, 1000, box=12.0)
    draws = tracker.track(model, rng()).draws[-1, :, 0]
    assert np.abs(judged(draws, mean, weight @ (x - mean) ** 2)).max() < 4.4
    # negative control: what is kept under Gaussian noise is refused
    with pytest.raises(InvalidInputError, match="take AllScans"):
        ScanMetropolis(AccumulatedMemory(), StudentT(3.0)).track(model, rng())
    drifting, _ = scene(scans=3)
    with pytest.raises(InvalidInputError, match="they drift here"):
        ScanMetropolis(AllScans()).track(drifting, rng())


def test_draws_that_span_no_volume_are_explained():
    model, _ = scene(drifting=False, scans=10)
    tracker = ScanMetropolis(GaussianMemory(), steps=3, burn_in=1, step=1e-9, share_global=0.0)
    with pytest.raises(InvalidInputError, match="hardly moved"):
        tracker.track(model, rng())


def test_several_rows_a_scan_step_by_the_law_of_one_row():
    # 40 rows of three: the information of a law of 120 components is another number
    generator = rng(2)
    H = np.tile(np.eye(3), (5, 40, 1)).reshape(5, 120, 3)
    prior = GaussianPrior.from_sd(np.full(3, 10.0))
    model = Trajectory(
        generator.normal(size=(5, 120)), H, np.tile(np.eye(120), (5, 1, 1)),
        np.eye(3), 0.01 * np.eye(3), prior, width=3,
    )  # fmt: skip
    track = ScanMetropolis(GaussianMemory(), Contaminated(0.3, 30.0)).track(model, rng())
    assert 0.15 < track.facts["acceptance"].mean() < 0.5


def padded(law_width=2):
    """One scan, one row of two components, the second not reported."""
    one = np.ones((1, 2, 1))
    prior = GaussianPrior.from_sd(np.array([2.0]))
    empty = np.empty((0, 1, 1))
    present = np.array([[True, False]])
    return Trajectory(np.array([[1.5, 0.0]]), one, np.eye(2)[None], empty, empty, prior,
                      present=present, width=law_width)  # fmt: skip


def test_rows_reported_in_part_have_the_law_of_their_own_size():
    # Student-t of one component; as one of two the variance would be .889. Limit 4.4, two scores
    x = np.linspace(-40.0, 40.0, 40_001)
    height = StudentT(3.0).log_density((1.5 - x)[:, None]) - 0.125 * x**2
    weight = np.exp(height - height.max())
    weight /= weight.sum()
    mean = weight @ x
    variance = weight @ (x - mean) ** 2
    assert variance > 1.1
    tracker = ScanMetropolis(GaussianMemory(), StudentT(3.0), 400_000, 1000, box=40.0)
    draws = tracker.track(padded(), rng()).draws[0, :, 0]
    assert np.abs(judged(draws, mean, variance)).max() < 4.4


def test_accumulated_memory_takes_the_declared_scale_only():
    model, _ = scene(drifting=False, scans=5)
    with pytest.raises(InvalidInputError, match="noise of scale"):
        ScanMetropolis(AccumulatedMemory(), Gaussian(scale=3.0)).track(model, rng())


def test_the_default_box_follows_the_prior_in_any_unit():
    model, _ = scene(scans=30)
    scaled = dataclasses.replace(
        model, H=1e6 * model.H, Q=1e-12 * model.Q,
        prior=GaussianPrior(1e-6 * model.prior.mean, 1e-12 * model.prior.covariance),
    )  # fmt: skip
    metres, small = (ScanMetropolis(GaussianMemory()).track(m, rng()).mean for m in (model, scaled))
    np.testing.assert_allclose(1e6 * small, metres, rtol=1e-6)


@pytest.mark.parametrize(("settings", "text"), [
    ({"step": np.nan}, "step is"),
    ({"step": 0.0}, "step is"),
    ({"target": Flat}, "an instance"),
    ({"box": np.array([[-np.inf, np.inf]] * 2)}, "all finite"),
    ({"start": np.array([5000.0, 0.0]), "box": 2000.0}, "outside its box"),
], ids=str)  # fmt: skip
def test_settings_under_which_nothing_moves_are_refused(settings, text):
    model, _ = scene(scans=2)
    with pytest.raises(InvalidInputError, match=text):
        ScanMetropolis(**settings).track(model, rng())


def test_what_cannot_be_followed_is_refused():
    for tracker in (ScanMetropolis(), ParticleFilter()):
        with pytest.raises(InvalidInputError, match="follows a Trajectory"):
            tracker.track(np.zeros(3), rng())
        with pytest.raises(InvalidInputError, match="Generator"):
            tracker.track(padded(), 3)
