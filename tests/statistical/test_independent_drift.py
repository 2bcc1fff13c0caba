"""A walking azimuth in files of a simulator that shares no geometry with the package.

Four radars on the earth, one of them three-dimensional, heights by pressure, climbing and turning
aircraft, refraction by ray tracing. About ten minutes on one core.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from scipy import stats

from probreg import recordings
from probreg.recordings import setup_file
from probreg.registration import register
from probreg.watch import WatchSettings, advance, begin
from tests.independent.cases import CASES
from tests.independent.files import write
from tests.independent.simulate import Simulated, simulate

pytestmark = pytest.mark.slow
MOVING, WALK_DEG, FIRST_S = "east", 0.02, 180.0  # a root minute
RECORDINGS = 12
# errors of a path hang together over minutes: so many independent ones a recording, our estimate
OWN = 10


class Seen(NamedTuple):
    """Errors (T,) in degrees and in standard deviations, by the whole recording and online."""

    whole: np.ndarray
    whole_z: np.ndarray
    online: np.ndarray
    online_z: np.ndarray
    constant: np.ndarray


def walking(seed: int) -> tuple[Simulated, np.ndarray, np.ndarray]:
    """A recording, and what its radar's azimuth has gained by every second, degrees."""
    drawn = simulate(CASES["radar3d"](), np.random.default_rng([seed, 13]))
    second = np.arange(0.0, drawn.truth.time.max() + 2.0)
    steps = np.random.default_rng([seed, 17]).standard_normal(len(second))
    gained = np.cumsum(WALK_DEG / np.sqrt(60.0) * steps)
    own = drawn.reports["sensor"] == MOVING
    azimuth = drawn.reports["azimuth_deg"].copy()
    azimuth[own] = np.mod(azimuth[own] + np.interp(drawn.truth.time[own], second, gained), 360.0)
    return drawn._replace(reports={**drawn.reports, "azimuth_deg": azimuth}), second, gained


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """Register and watch a recording, once."""

    @cache
    def one(seed: int) -> Seen:
        drawn, second, gained = walking(seed)
        folder = tmp_path_factory.mktemp("walk")
        write(drawn, folder)
        read = recordings.read(folder / "reports.csv", setup_file.read(folder / "sensors.toml"))
        rng, name = np.random.default_rng(seed), f"{MOVING}.azimuth"
        azimuths = {f"{s.name}.azimuth": "walk" for s in read.setup.sensors if s.azimuth_column}
        setup = replace(read.setup, drift=azimuths)
        found = register(read.recording, setup, rng=rng)
        time = np.arange(60.0, second[-1] - 30.0, 10.0)

        def truth(at):
            return np.rad2deg(drawn.truth.bias[name]) + np.interp(at, second, gained)

        draws = np.rad2deg(found.path_draws(name, time))
        whole = draws.mean(axis=0) - truth(time)
        online, sd = followed(read.recording, read.setup, name, truth, rng)
        still = np.rad2deg(register(read.recording, read.setup, rng=rng).draws.flat)
        k = found.names.index(name)
        return Seen(whole, whole / draws.std(axis=0), online, online / sd,
                    still[:, k].mean() - truth(time))  # fmt: skip

    return one


def followed(recording, setup, name, truth, rng):
    """Errors and standard deviations (slices,) of a watch, degrees."""
    state = begin(recording.during(-np.inf, FIRST_S), setup, WatchSettings(), rng)
    away, sd, k = [], [], state.names.index(name)
    start = state.time
    while state.time < recording.time[-1]:
        end = start + state.settings.slice_s
        state, result = advance(state, recording.during(start, end), end)
        start = end
        away.append(np.rad2deg(result.mean[k]) - truth(end - 0.5 * state.settings.slice_s))
        sd.append(np.rad2deg(result.sd[k]))
    return np.array(away), np.array(sd)


def rms(parts):
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


@pytest.mark.parametrize(("which", "limit"), [("whole", 0.008), ("online", 0.0105)])
def test_a_walk_is_followed(seen, which, limit):
    every = [seen(seed) for seed in range(RECORDINGS)]
    assert rms([getattr(one, which) for one in every]) < limit
    # control: a constant bias cannot
    assert rms([one.constant for one in every]) > 3.0 * limit


@pytest.mark.parametrize("which", ["whole", "online"])
def test_bands_hold_the_walk(seen, which):
    z = np.concatenate([getattr(seen(seed), f"{which}_z") for seed in range(RECORDINGS)])
    held = (np.abs(z) < stats.norm.isf(0.05)).mean()
    # one false alarm in a hundred of so many independent errors
    low, high = stats.binom(RECORDINGS * OWN, 0.9).ppf([0.005, 0.995]) / (RECORDINGS * OWN)
    assert low <= held <= high
