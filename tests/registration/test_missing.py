"""Terms that a setup leaves out are named, and those of targets beside those of sensors."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg import recordings
from probreg.page import matters
from probreg.problems.recording import recording_problem
from probreg.recordings import setup_file
from probreg.registration import LAWS, register
from probreg.scenarios.traffic import TrafficScene, simulate
from tests.independent import files
from tests.independent.cases import CASES
from tests.independent.simulate import simulate as simulate_on_earth


def delayed(sd_m, seed=1):
    """Traffic in which every target answers early or late by its own constant."""
    recording, setup, truth = simulate(TrafficScene(3_000), np.random.default_rng(seed))
    late = sd_m * np.random.default_rng(seed + 1).standard_normal(truth.target.max() + 1)
    values = recording.values.copy()
    values[:, 0] += late[truth.target]
    return dataclasses.replace(recording, values=values), setup


def test_delays_of_targets_are_named_and_go_with_the_term_that_is_advised():
    recording, setup = delayed(30.0)
    found = register(recording, setup, rng=np.random.default_rng(3), laws=LAWS[:1])
    assert [term.name for term in found.missing][:1] == ["targets.range"]
    # a spread of 30 m by 46 targets is known to a tenth
    assert found.missing[0].value == pytest.approx(30.0, rel=0.4)
    assert found.cluster_ratio.max() > 1.8
    (said,) = (text for text in matters(found) if "range errors of their own" in text)
    assert "Add target_terms = {range_m = " in said
    cured = dataclasses.replace(setup, target_terms={"range": found.missing[0].value})
    again = register(recording, cured, rng=np.random.default_rng(3), laws=LAWS[:1])
    assert not again.missing
    assert again.cluster_ratio.max() < 1.8
    assert (again.sd[::2] > 1.7 * found.sd[::2]).all()


def test_nothing_is_named_where_nothing_is_missing():
    recording, setup = delayed(0.0)
    found = register(recording, setup, rng=np.random.default_rng(3), laws=LAWS[:1])
    assert found.missing == ()
    assert found.cluster_ratio.max() < 1.8


def on_earth(folder, case, asked=None, seed=1, **changes):
    scene = dataclasses.replace(CASES[case](), **changes)
    simulated = simulate_on_earth(scene, np.random.default_rng(seed))
    files.write(simulated, folder, asked)
    setup = setup_file.read(folder / "sensors.toml")
    return recordings.read(folder / "reports.csv", setup), simulated.truth


def test_an_offset_of_all_heights_does_not_hide_among_constants_of_targets(tmp_path):
    asked = {"barometer": ()}
    read, _ = on_earth(tmp_path, "barometric_200", asked, duration_s=100.0, aircraft=14)
    problem = recording_problem(read.recording, read.setup)
    assert problem.known_constants == {"height"}
    found = register(read.recording, read.setup, rng=np.random.default_rng(2), laws=LAWS[:1])
    assert found.missing[0].name == "barometer.height"
    assert found.missing[0].value == pytest.approx(200.0, abs=30.0)


def test_the_constants_of_a_barometer_with_unknowns_have_an_unknown_spread(tmp_path):
    read, truth = on_earth(tmp_path, "barometric_200", duration_s=100.0, aircraft=14)
    assert recording_problem(read.recording, read.setup).known_constants == frozenset()
    found = register(read.recording, read.setup, rng=np.random.default_rng(2), laws=LAWS[:1])
    assert found.missing == ()
    wanted = np.array([truth.bias.get(name, 0.0) for name in found.names])
    # ten biases at 4.5 posterior standard deviations
    assert (np.abs(found.mean - wanted) < 4.5 * found.sd).all()
