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
    kinds_of,
    log_odds,
    most_probable,
    next_changes,
    no_changes,
)
from probreg.watch._usual import (
    fade_of,
    forgotten,
    next_scores,
    no_scores,
    noise_threshold,
    strengths,
)
from probreg.watch._watchdogs import COMPARED, FACTORS, quieter, shares_of, shiryaev_roberts
from probreg.watch.results import Alarm
from probreg.watch.settings import WatchSettings
from probreg.watch.state import Alarms

PARTS = (0.6, 0.2, 0.2)  # of the false alarms: changes of biases, noise, silence
CHANGE, NOISE, SILENCE = range(3)
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
        no_scores(models, len(FACTORS)),
        np.zeros(sensors),
        np.full(sensors, -np.inf),
        np.full(3, np.inf),
    )


def calibrated(
    settings: WatchSettings,
    beliefs: tuple[FloatArray, FloatArray, FloatArray],
    groups: tuple[int, int],
    rng: np.random.Generator,
) -> FloatArray:
    """Thresholds (3,) for the stated rate of false alarms.

    `beliefs` are J (C, C) of a usual slice, variances (p,) of the steps of biases while nothing
    changes, and of their prior; `groups` how many models and sensors are watched.
    """
    J, step, prior = beliefs
    per_hour = HOUR_S / settings.slice_s
    covariance = steady(J, step, prior, round(SETTLE_S / settings.slice_s))
    rates = settings.false_alarms_per_day / DAY_H * np.array(PARTS)
    kinds = kinds_of(settings.slice_s, np.sqrt(prior))
    change = change_threshold(J, covariance, kinds, (float(rates[CHANGE]), per_hour), rng)
    models, sensors = groups
    rare = float(rates[NOISE]) / per_hour / (2 * models)  # less and more noise of every model
    noise = noise_threshold(rare, fade_of(settings.slice_s), rng)
    # of this sum the mean time to a false alarm is at least the threshold
    return np.array([change, noise, np.log(per_hour * sensors / rates[SILENCE])])


def listen_changes(alarms: Alarms, now: Slice, clock: Clock, bias: BiasModel) -> Heard:
    """Steps and ramps: together they raise an alarm, the most probable one names it."""
    kinds = kinds_of(clock.slice_s, bias.prior_sd)
    before = alarms.steps, alarms.ramps
    changes = [
        next_changes(one, now, clock.number, k) for one, k in zip(before, kinds, strict=True)
    ]
    odds = tuple(log_odds(one, k.scale) for one, k in zip(changes, kinds, strict=True))
    strength = evidence(odds) - alarms.thresholds[CHANGE]
    if not strength > 0.0:
        return Heard(replace(alarms, steps=changes[0], ramps=changes[1]), (), None)
    which = int(np.argmax([one.max(initial=-np.inf) for one in odds]))
    found = most_probable(changes[which], odds[which], kinds[which].scale)
    raised = _alarm(kinds[which].name, found, strength, clock, bias)
    none = no_changes(*changes[0].gap.shape[1:])
    step = found if which == 0 else None
    return Heard(replace(alarms, steps=none, ramps=none), (raised,), step)


def _alarm(kind: str, found: Found, strength: float, clock: Clock, bias: BiasModel) -> Alarm:
    sensor, term = bias.names[found.term].rsplit(".", 1)
    score = float(np.exp(min(strength, 500.0)))
    return Alarm(kind, sensor, term, clock.start(found.begun), found.size, found.sd, score)


def listen_noise(
    alarms: Alarms,
    ratios: tuple[FloatArray, IntArray],
    names: tuple[str, ...],
    clock: Clock,
) -> Heard:
    """Noise of sensor models, `names` by their sensors, that is no longer what it was.

    `ratios` are log likelihood ratios by factor, and the reports of each model.
    """
    scores = next_scores(alarms.noise, *ratios, COMPARED, fade_of(clock.slice_s))
    strength = strengths(scores) - alarms.thresholds[NOISE]
    loud, raised, changed = strength > 0.0, [], []
    for s in np.flatnonzero(loud.any(axis=1)).tolist():
        more = bool(strength[s, 1] >= strength[s, 0])
        own = (np.array(FACTORS) > 1.0) == more
        factor = float(FACTORS[int(np.argmax(np.where(own, scores.recent[s], -np.inf)))])
        score = float(np.exp(min(strength[s].max(), 500.0)))
        start = clock.start(clock.number)
        raised.append(Alarm("noise", names[s], "", start, factor, np.nan, score))
        changed.append((s, factor))
    scores = forgotten(scores, loud.any(axis=1))
    return Heard(replace(alarms, noise=scores), tuple(raised), None, tuple(changed))


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
