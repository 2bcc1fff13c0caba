"""The whole chain on simulated traffic."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg.diagnostics import Coverage
from probreg.errors import InvalidInputError
from probreg.registration import LAWS, compare_terms, register
from probreg.scenarios.traffic import TrafficScene, radars, simulate

DIRTY = {"wrong_share": 0.2, "outlier_share": 0.05}


def truth_of(found, truth):
    return np.array([truth.bias.get(name, 0.0) for name in found.names])


@pytest.fixture(scope="module")
def registered():
    scene = TrafficScene(3_000, **DIRTY)
    recording, setup, truth = simulate(scene, np.random.default_rng(11))
    setup = dataclasses.replace(setup, limits={"radar1.range": 5.0, "radar2.azimuth": 0.5})
    return register(recording, setup, rng=np.random.default_rng(12)), truth


def test_biases_are_found_in_dirty_reports(registered):
    found, truth = registered
    # 6 biases at 4.5 posterior standard deviations: false alarm about 1e-4 with some tail
    assert (np.abs(found.mean - truth_of(found, truth)) < 4.5 * found.sd).all()
    assert (found.sd < 0.2 * found.problem.prior_sd).all()
    table = found.table()
    assert list(table.index) == list(found.names)
    assert (table["90% low"] < table["50% low"]).all()
    assert np.allclose(np.diag(found.correlation), 1.0)


def test_held_out_targets_are_corrected(registered):
    found, _ = registered
    before, after = found.held_out.medians_m
    assert after < 0.4 * before
    assert found.held_out.after_log_score > found.held_out.before_log_score + 1.0
    assert 0 < found.held_out.targets < len(np.unique(found.problem.plan.target))


def test_outliers_are_marked(registered):
    found, truth = registered
    # `truth` counts reports as the recording does: registration does not reorder them
    plan = found.problem.plan
    bad = truth.outlier | truth.wrong
    spoilt = np.maximum.reduceat(bad[plan.members], plan.start[:-1])
    chance = found.outlier_probability
    # ten times the noise is at times no more than the usual: not every outlier can be seen
    assert chance[spoilt].mean() > 0.35
    assert chance[~spoilt].mean() < 0.05
    suspects = found.suspects()
    assert set(suspects["row"]) == set(np.flatnonzero(chance > 0.5))
    assert (np.diff(suspects["probability"]) <= 0.0).all()


def test_laws_verdicts_notes_and_times(registered):
    found, _ = registered
    assert {law.name for law in found.laws} == {choice.name for choice in LAWS}
    assert found.laws[-1].name == "Gaussian"
    by_name = {verdict.name: verdict for verdict in found.verdicts}
    assert by_name["radar2.azimuth"].text == "within"
    size = np.abs(found.bias_draws[:, found.names.index("radar1.range")])
    assert by_name["radar1.range"].probability == (size > 5.0).mean()
    assert any("farther than the gate" in note for note in found.notes)
    assert {"rows", "laws", "draws"} <= set(found.seconds)


def test_correcting_is_undone_by_restoring(registered):
    found, _ = registered
    back = found.restore(found.correct())
    np.testing.assert_allclose(back.values, found.recording.values, rtol=1e-14)


def test_residuals_are_of_the_reports_less_the_posterior_means(registered):
    found, _ = registered
    recording, mean = found.recording, dict(zip(found.names, found.mean, strict=True))
    for k, sensor in enumerate(recording.sensors):
        rows = recording.sensor == k
        bias = [mean[f"{sensor.name}.{name}"] for name in sensor.bias_names]
        wanted = recording.values[rows, :2] - bias
        got = found.residuals.values[rows, :2]
        np.testing.assert_allclose(got[:, 0], wanted[:, 0], rtol=1e-12)
        np.testing.assert_allclose(np.exp(1j * got[:, 1]), np.exp(1j * wanted[:, 1]), rtol=1e-12)
        raw = found.residuals_before.values[rows, 0]
        np.testing.assert_allclose(raw, recording.values[rows, 0], rtol=1e-12)
    ranges = [one.spreads for one in found.components if one.unit == "m"]
    before, after = (sum(abs(spreads[k].median) for spreads in ranges) for k in (0, 1))
    assert after < 0.2 * before


def test_equal_seeds_give_equal_results():
    scene = TrafficScene(400, **DIRTY)
    recording, setup, _ = simulate(scene, np.random.default_rng(1))
    one, two = (register(recording, setup, rng=np.random.default_rng(2)) for _ in range(2))
    np.testing.assert_array_equal(one.draws.theta, two.draws.theta)


def test_clock_and_gain_are_found_and_compared():
    extra = {"radar1.range": 40.0, "radar2.time": 0.8, "radar3.range_gain": 2e-3}
    recording, setup, truth = simulate(TrafficScene(4_000, biases=extra), np.random.default_rng(4))
    found = register(recording, setup, rng=np.random.default_rng(5))
    assert {"radar2.time", "radar3.range_gain"} <= set(found.names)
    assert (np.abs(found.mean - truth_of(found, truth)) < 4.5 * found.sd).all()
    offsets = {s.name: ("range", "azimuth") for s in setup.sensors}
    every = {name: (*terms, "azimuth_sine") for name, terms in setup.biases.items()}
    ranked = compare_terms(
        found.recording,
        setup,
        {"offsets": offsets, "asked for": setup.biases, "and eccentricity": every},
        rng=np.random.default_rng(6),
    )
    assert ranked[-1].name == "offsets"
    assert ranked[-1].behind > 5.0 * ranked[-1].standard_error
    # a term that is not there costs next to nothing and gains nothing
    assert abs(ranked[1].behind) < 20.0


def test_bad_requests():
    recording, setup, _ = simulate(TrafficScene(300), np.random.default_rng(1))
    rng = np.random.default_rng(2)
    with pytest.raises(InvalidInputError, match="holdout 1.5 must be in"):
        register(recording, setup, rng=rng, holdout=1.5)
    with pytest.raises(InvalidInputError, match="laws must be different, one at least"):
        register(recording, setup, rng=rng, laws=[])
    with pytest.raises(InvalidInputError, match="two bias models"):
        compare_terms(recording, setup, {"one": setup.biases}, rng=rng)
    other = dataclasses.replace(setup, sensors=radars(2), biases={"radar1": ("range",)})
    with pytest.raises(InvalidInputError, match="must be the same, in one order"):
        register(recording, other, rng=rng)


@pytest.mark.slow
@pytest.mark.parametrize("reports", [500, 50_000])
def test_intervals_cover(reports):
    # 200 recordings of 6 biases; pooled coverage within exact binomial limits, false alarm 5 %
    held, count = 0, 0
    for seed in range(200):
        rng = np.random.default_rng([77, reports, seed])
        recording, setup, truth = simulate(TrafficScene(reports, **DIRTY), rng)
        found = register(recording, setup, rng=rng)
        low, high = found.interval(0.9).T
        inside = (low <= truth_of(found, truth)) & (truth_of(found, truth) <= high)
        held, count = held + int(inside.sum()), count + inside.size
    assert Coverage(held, count, 0.9).honest(0.05)


@pytest.mark.slow
def test_a_million_reports():
    import resource

    recording, setup, truth = simulate(TrafficScene(1_000_000, **DIRTY), np.random.default_rng(1))
    found = register(recording, setup, rng=np.random.default_rng(2))
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < 4e6  # kilobytes
    assert (np.abs(found.mean - truth_of(found, truth)) < 4.5 * found.sd).all()
