"""A kind of sensor is one module: dropped into the package, every room knows it."""

from __future__ import annotations

import dataclasses
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from probreg import Radar2D, recordings
from probreg.association import associate
from probreg.problems.recording import RecordingProblem
from probreg.recordings import new_table, setup_file
from probreg.sensors import kinds, known_kinds
from tests.conformance.sensor_facts import FACTS, made
from tests.registration.conftest import ANGLE, fly, vector

THETA = {"a.range": 40.0, "a.azimuth": 4e-3, "b.range": -30.0, "b.azimuth": -5e-3, "new.range": 25}


@pytest.fixture
def ranging(tmp_path, monkeypatch):
    shutil.copy(Path(__file__).with_name("ranging_kind.py"), tmp_path / "ranging.py")
    monkeypatch.setattr(kinds, "__path__", [*kinds.__path__, str(tmp_path)])
    known_kinds.cache_clear()
    yield known_kinds()["ranging"]
    sys.modules.pop(f"{kinds.__name__}.ranging")
    vars(kinds).pop("ranging")
    known_kinds.cache_clear()


def scene(ranging, **changes):
    a = Radar2D((0.0, 0.0), 20.0, ANGLE, "a")
    b = Radar2D((30e3, 5e3), 30.0, 1.5 * ANGLE, "b", from_north=True)
    return fly((a, b, ranging((-10e3, 20e3), 10.0, "new")), THETA, targets=20, **changes)


def test_it_conforms(ranging):
    for fact in FACTS:
        fact(made("ranging"))


def test_files_and_registration_know_it(ranging, tmp_path):
    flown = scene(ranging, noise=0.0)
    recording = dataclasses.replace(flown.recording, labels=tuple("abcdefghijklmnopqrst"))
    setup_file.write(tmp_path / "sensors.toml", flown.setup)
    new_table.create(tmp_path / "r.csv", recording, flown.setup)
    setup = setup_file.read(tmp_path / "sensors.toml")
    read = recordings.read(tmp_path / "r.csv", setup).recording
    problem = RecordingProblem(read, setup)
    truth = vector(flown, problem.names)
    assert not problem.metric.all()  # rows with distances
    # without noise nothing is left at the truth but what curves, in standard deviations
    assert misfit(problem, truth) < 0.1
    assert misfit(problem, 0.0 * truth) > 3.0


def misfit(problem, theta):
    linear = problem.linearise(theta)
    left = linear.residual(theta)
    whole = np.einsum("nm,nm->n", left, np.linalg.solve(linear.R, left[..., None])[..., 0])
    return np.sqrt(whole.max())


def test_its_reports_are_associated(ranging):
    flown = scene(ranging)
    target = flown.recording.target.copy()
    lost = flown.recording.sensor == 2
    target[lost] = -1
    blind = dataclasses.replace(flown.recording, target=target)
    found = associate(blind, flown.setup, vector(flown, RecordingProblem(*flown[:2]).names))
    given = lost & (found.target >= 0)
    assert given.sum() > 0.6 * lost.sum()
    assert (found.target[given] == flown.recording.target[given]).mean() > 0.95
