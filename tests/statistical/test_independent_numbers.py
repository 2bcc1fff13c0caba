"""What `register` finds in files of a simulator that shares no geometry with the package.

Biases are on the earth, reports from ray tracing and each radar's own vertical, aircraft climb
and turn. A case takes five minutes (40 recordings of some 45 000 reports), all of them with the
wrong models about two hours on one core.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from scipy import stats

from probreg import recordings
from probreg.diagnostics import Coverage
from probreg.recordings import setup_file
from probreg.registration import Registration, register
from tests.independent.cases import CASES, barometric, easy, late_adsb, transponder_delays
from tests.independent.files import write
from tests.independent.scene import Scene
from tests.independent.simulate import Simulated, simulate

pytestmark = pytest.mark.slow
RECORDINGS = 40
WRONG_RECORDINGS = 20


class Wrong(NamedTuple):
    """A scene of which the setup file does not ask for everything, and what it leaves out."""

    scene: Scene
    asked: dict[str, tuple[str, ...]]
    missing: tuple[str, ...]


def hidden(name: str, value: float) -> Wrong:
    """A term that one radar has and nobody asks for, in metres, seconds and degrees."""
    return Wrong(replace(easy(), fixed={name: value}), {}, (name,))


WRONG = {
    "clock": hidden("east.time", 0.3),
    "gain": hidden("south.range_gain", 5e-4),
    "eccentricity": hidden("west.azimuth_sine", 0.1),
    "late ADS-B": Wrong(late_adsb(), {"adsb": ()}, ("adsb.time",)),
    "barometric offset": Wrong(
        barometric(100.0, reference=True),
        {"barometer": ()},
        ("barometer.height", "barometer.height_gain"),
    ),
    "transponder delays": Wrong(transponder_delays(), {"targets": ()}, ("targets.range",)),
}


def registered(
    scene: Scene, seed: int, folder, asked: dict[str, tuple[str, ...]] | None = None
) -> tuple[Simulated, Registration]:
    """Write a recording's files, read them, register."""
    simulated = simulate(scene, np.random.default_rng([seed, 7]))
    write(simulated, folder, asked)
    read = recordings.read(folder / "reports.csv", setup_file.read(folder / "sensors.toml"))
    found = register(read.recording, read.setup, rng=np.random.default_rng(seed))
    return simulated, found


def unpulled(simulated: Simulated, found: Registration) -> np.ndarray:
    """Means (p,) without what the prior takes off biases that no recording draws from it.

    An offset fixed at three standard deviations of its prior is pulled towards zero, and rightly.
    """
    fixed = [name in simulated.scene.fixed for name in found.names]
    away = np.array([simulated.truth.bias[name] for name in found.names]) * fixed
    pull = found.covariance @ (away / np.square(found.problem.prior_sd))
    return np.asarray(found.mean + pull)


def own_count(z: np.ndarray) -> int:
    """How many independent numbers have squares whose mean is as uncertain as theirs."""
    C = np.corrcoef(z.T)
    return round(z.shape[0] * z.shape[1] ** 2 / (C**2).sum())


class Judged(NamedTuple):
    """Of the recordings of one case: errors in standard deviations, and what was named."""

    names: tuple[str, ...]
    z: np.ndarray
    held: np.ndarray
    named: list[tuple[str, ...]]


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """Judge a case, once."""

    @cache
    def judge(case: str) -> Judged:
        z, held, named = [], [], []
        for seed in range(RECORDINGS):
            folder = tmp_path_factory.mktemp("case")
            simulated, found = registered(CASES[case](), seed, folder)
            truth = np.array([simulated.truth.bias[name] for name in found.names])
            mean = unpulled(simulated, found)
            low, high = found.interval(0.9).T + (mean - found.mean)
            z.append((mean - truth) / found.sd)
            held.append((low <= truth) & (truth <= high))
            named.append(tuple(one.name for one in found.missing))
        return Judged(found.names, np.array(z), np.array(held), named)

    return judge


@pytest.mark.parametrize("case", CASES)
def test_biases_are_as_far_off_as_is_said(case, judged):
    found = judged(case)
    rms = np.sqrt(np.mean(found.z**2))
    # of 40 recordings of eight biases an rms has a standard deviation of about .045
    assert 0.85 < rms < 1.15
    # biases of a recording err together; one false alarm in a hundred cases
    count = own_count(found.z)
    assert Coverage(round(found.held.mean() * count), count, 0.9).honest(0.01)


@pytest.mark.parametrize("case", CASES)
def test_ranges_are_not_off_all_one_way(case, judged):
    found = judged(case)
    ranges = [k for k, name in enumerate(found.names) if name.endswith(".range")]
    # what heights and delays do to all ranges of a recording alike is averaged over recordings
    assert abs(found.z[:, ranges].mean()) < 0.5


@pytest.mark.parametrize("case", CASES)
def test_nothing_is_named_where_nothing_is_missing(case, judged):
    named = [names for names in judged(case).named if names]
    # at most 5 %: of 40 recordings seven and more are rarer than one in two hundred
    assert len(named) <= stats.binom(RECORDINGS, 0.05).ppf(0.995)


@pytest.mark.parametrize("wrong", WRONG)
def test_what_is_missing_is_named_first(wrong, tmp_path):
    scene, asked, missing = WRONG[wrong]
    first = []
    for seed in range(WRONG_RECORDINGS):
        _, found = registered(scene, seed, tmp_path, asked)
        first.append(found.missing[0].name if found.missing else "")
    right = sum(name in missing for name in first)
    assert right >= stats.binom(WRONG_RECORDINGS, 0.95).ppf(0.005), first
