"""Alarms of a slice: steps and ramps of biases, noise that no longer fits, silent sensors."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from probreg.recordings import BiasModel
from probreg.typing import FloatArray, IntArray
from probreg.watch._calibration import SETTLE_S, change_threshold, steady
from probreg.watch._changes import (
    HOUR_S,
    Found,
    Slice,
    evidence,
    log_odds,
    most_probable,
    next_changes,
    no_changes,
)
from probreg.watch._watchdogs import (
    FACTORS,
    by_model,
    quieter,
    shares_of,
    shiryaev_roberts,
)
from probreg.watch.results import Alarm
from probreg.watch.settings import WatchSettings
from probreg.watch.state import Alarms, Changes

STEP_S, RAMP_S, RAMP_EVERY_S = 600.0, 1800.0, 60.0  # how long a change is in question
PARTS = (0.4, 0.2, 0.2, 0.2)  # of the false alarms: steps, ramps, noise, silence
STEP, RAMP, NOISE, SILENCE = range(4)
DAY_H = 24.0


class Clock(NamedTuple):
    """Slices as times.

    Attributes
    ----------
    origin, slice_s : float
    number : int
        Of the newest slice.
    """

    origin: float
    slice_s: float
    number: int

    def start(self, number: int) -> float:
        """When a slice begins, seconds."""
        return self.origin + number * self.slice_s


class Heard(NamedTuple):
    """Alarms after a slice, and the step among them that beliefs must follow.

    Attributes
    ----------
    alarms : Alarms
    raised : tuple of Alarm
    step : Found or None
    louder : tuple of (int, float)
        Sensor models whose noise has changed, and how many times.
    """

    alarms: Alarms
    raised: tuple[Alarm, ...]
    step: Found | None
    louder: tuple[tuple[int, float], ...] = ()


def first_alarms(models: int, sensors: int, p: int, C: int) -> Alarms:
    """Nothing has happened yet, and nothing is calibrated."""
    return Alarms(
        no_changes(p, C),
        no_changes(p, C),
        np.full((models, len(FACTORS)), -np.inf),
        np.zeros(sensors),
        np.full(sensors, -np.inf),
        np.full(4, np.inf),
    )


def kept(settings: WatchSettings) -> tuple[tuple[int, int], tuple[int, int]]:
    """For how many slices steps and ramps are in question, and how far apart they are."""
    lasts = [max(1, round(s / settings.slice_s)) for s in (STEP_S, RAMP_S, RAMP_EVERY_S)]
    return (lasts[0], 1), (lasts[1], lasts[2])


def calibrated(
    settings: WatchSettings,
    beliefs: tuple[FloatArray, FloatArray, FloatArray],
    groups: tuple[int, int],
    rng: np.random.Generator,
) -> FloatArray:
    """Thresholds (4,) for the stated rate of false alarms.

    `beliefs` are J (C, C) of a usual slice, variances (p,) of the steps of biases while nothing
    changes, and of their prior; `groups` how many models and sensors are watched.
    """
    J, step, prior = beliefs
    per_hour = HOUR_S / settings.slice_s
    covariance = steady(J, step, prior, round(SETTLE_S / settings.slice_s))
    rates = settings.false_alarms_per_day / DAY_H * np.array(PARTS)
    scale = np.sqrt(prior)
    found = np.empty(4)
    scales = (scale, 0.0), (scale / HOUR_S, settings.slice_s)
    for k, ((size, growth), keep) in enumerate(zip(scales, kept(settings), strict=True)):
        wanted = float(rates[k]), per_hour
        found[k] = change_threshold(J, covariance, size, growth, keep, wanted, rng)
    # of the sums of these the mean time to a false alarm is known to be above the threshold
    for k, count in zip((NOISE, SILENCE), groups, strict=True):
        found[k] = np.log(per_hour * count / rates[k])
    return found


def listen_changes(alarms: Alarms, now: Slice, clock: Clock, bias: BiasModel) -> Heard:
    """Steps and ramps."""
    growths, raised, step = (0.0, clock.slice_s), [], None
    unit = bias.prior_sd, bias.prior_sd / HOUR_S
    settings = WatchSettings(slice_s=clock.slice_s, lag_s=6 * clock.slice_s, delay_s=0.0)
    changed: list[Changes] = []
    for kind, keep in enumerate(kept(settings)):
        before = (alarms.steps, alarms.ramps)[kind]
        changes = next_changes(before, now, clock.number, growths[kind], keep)
        odds = log_odds(changes, unit[kind])
        strength = evidence(odds) - alarms.thresholds[kind]
        if strength > 0.0 and step is None:
            found = most_probable(changes, odds, unit[kind])
            raised.append(_alarm(("step", "ramp")[kind], found, strength, clock, bias))
            step = found if kind == STEP else step
            changes = no_changes(*changes.gap.shape[1:])
        changed.append(changes)
    if step is not None:
        changed = [no_changes(*c.gap.shape[1:]) for c in changed]
    return Heard(replace(alarms, steps=changed[0], ramps=changed[1]), tuple(raised), step)


def _alarm(kind: str, found: Found, strength: float, clock: Clock, bias: BiasModel) -> Alarm:
    sensor, term = bias.names[found.term].rsplit(".", 1)
    score = float(np.exp(min(strength, 500.0)))
    return Alarm(kind, sensor, term, clock.start(found.begun), found.size, found.sd, score)


def listen_noise(alarms: Alarms, ratio: FloatArray, names: tuple[str, ...], clock: Clock) -> Heard:
    """Noise of sensor models, `names` by their sensors, that no longer fits."""
    sums = shiryaev_roberts(alarms.noise, ratio)
    strength, raised, changed = by_model(sums) - alarms.thresholds[NOISE], [], []
    for s in np.flatnonzero(strength > 0.0).tolist():
        factor = float(FACTORS[int(np.argmax(sums[s]))])
        score = float(np.exp(min(strength[s], 500.0)))
        raised.append(
            Alarm("noise", names[s], "", clock.start(clock.number), factor, np.nan, score)
        )
        changed.append((s, factor))
        sums[s] = -np.inf
    return Heard(replace(alarms, noise=sums), tuple(raised), None, tuple(changed))


def listen_silence(alarms: Alarms, counts: IntArray, names: tuple[str, ...], clock: Clock) -> Heard:
    """Sensors that report less than the others would have it; one alarm a silence."""
    sums = shiryaev_roberts(alarms.silent, quieter(counts, alarms.expected))
    limit, raised = alarms.thresholds[SILENCE], []
    for s in np.flatnonzero((sums > limit) & (alarms.silent <= limit)).tolist():
        score = float(np.exp(min(sums[s] - limit, 500.0)))
        start = clock.start(clock.number)
        raised.append(Alarm("silence", names[s], "", start, np.nan, np.nan, score))
    # as sure as it can be: the first reports end it
    sums = np.minimum(sums, limit + 1.0)
    expected = shares_of(counts, alarms.expected, sums <= limit)
    return Heard(replace(alarms, silent=sums, expected=expected), tuple(raised), None)
