"""Accuracies of single sensors, told from the scatter about the others' reports."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg.posterior.tracks import fit_tracks
from probreg.problems.recording import recording_problem
from probreg.registration import LAWS, register
from probreg.registration._accuracy import accuracies, variance_factor
from probreg.registration._identities import PROVISIONAL
from probreg.registration._track_model import track_model
from probreg.scenarios.traffic import TrafficScene, simulate


def declared(recording, setup, **factors):
    """The recording and its setup with other accuracies declared: "radar1_range" times."""

    def changed(sensor):
        own = {name.split("_", 1)[1]: f for name, f in factors.items() if sensor.name in name}
        sigmas = {f"sigma_{part}": f * getattr(sensor, f"sigma_{part}") for part, f in own.items()}
        return dataclasses.replace(sensor, **sigmas)

    sensors = tuple(changed(sensor) for sensor in setup.sensors)
    return (
        dataclasses.replace(recording, sensors=sensors),
        dataclasses.replace(setup, sensors=sensors),
    )


def fitted(recording, setup):
    problem = recording_problem(recording, setup)
    return problem, fit_tracks(track_model(problem, PROVISIONAL))


@pytest.fixture(scope="module")
def traffic():
    scene = TrafficScene(6_000, outlier_share=0.03)
    return simulate(scene, np.random.default_rng(1))[:2]


@pytest.mark.parametrize(
    "factors",
    [
        {},
        {"radar1_range": 1 / 3},
        {"radar2_azimuth": 1 / 3},
        {"radar3_range": 3.0, "radar1_azimuth": 0.5},
    ],
    ids=str,
)
def test_each_declared_accuracy_is_told(traffic, factors):
    found = accuracies(*fitted(*declared(*traffic, **factors)))
    names = {(one.sensor, one.component): one for one in found}
    assert set(names) == {(f"radar{k}", part) for k in (1, 2, 3) for part in ("range", "azimuth")}
    for (sensor, part), one in names.items():
        # the oracle: what the simulation drew, over what is declared; outliers add a little
        wanted = 1.0 / factors.get(f"{sensor}_{part}", 1.0)
        assert one.factor == pytest.approx(wanted, rel=0.25)
        assert one.clear or wanted == 1.0


def test_the_remark_names_the_sensor_and_the_accuracy_to_set():
    recording, setup, _ = simulate(TrafficScene(3_000), np.random.default_rng(3))
    rng = np.random.default_rng(4)
    right = register(recording, setup, rng=rng, laws=LAWS[:1])
    assert not any("times declared" in text for text in right.notes)
    wrong = declared(recording, setup, radar1_azimuth=1 / 3)
    found = register(*wrong, rng=rng, laws=LAWS[:1])
    (said,) = (text for text in found.notes if "times declared" in text)
    assert said.startswith("radar1: azimuth spread ")
    assert "set sigma_azimuth_deg near 0." in said
    value = float(said.rsplit(" ", 1)[1].rstrip("."))
    assert value == pytest.approx(0.1, rel=0.2)


def test_small_recordings_claim_nothing_by_chance():
    for seed in range(10):
        recording, setup, _ = simulate(TrafficScene(400), np.random.default_rng(seed))
        found = accuracies(*fitted(recording, setup))
        assert not any(one.clear and not 0.6 < one.factor < 1.6 for one in found)


def test_the_factor_is_that_of_normal_residuals():
    rng = np.random.default_rng(1)
    path, sigma2 = rng.uniform(0.1, 2.0, 20_000), rng.uniform(0.5, 3.0, 20_000)
    for factor in (0.25, 1.0, 9.0):
        square = (path + factor * sigma2) * rng.chisquare(1, 20_000)
        # sd of a robust variance: 2.33 / sqrt(20 000), and the path's share of it
        assert variance_factor(square, path, sigma2) == pytest.approx(factor, rel=0.15)
