"""What a reader of a registration must know, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from probreg.association import OFF_PATH, TOO_FAST
from probreg.recordings import Recording, Setup
from probreg.recordings.checks import several_at_once
from probreg.registration._accuracy import Accuracy
from probreg.registration._checks import Checks
from probreg.registration._choice import Chosen
from probreg.registration._held_out import HeldOut
from probreg.registration._identities import Identified
from probreg.registration._observed import Determined
from probreg.samplers import Draws
from probreg.typing import FloatArray, IntArray

FAR_SIGMAS = 5.0  # of the prior, from zero
_NEAR = (0.7, 1.4)  # scales of the noise that nobody need look after
_FACTOR = (0.6, 1.6)  # scatter over the declared one that needs no remark
_CURVED = 0.3  # sag of the cross-range noise in range standard deviations that biases the range
_WHOLE_S = 1e-5  # how near to a whole second a stamp must be: POSIX seconds have seven digits


def remarks(
    known: Identified, chosen: Chosen, draws: Draws, scored: HeldOut | None, checks: Checks
) -> tuple[str, ...]:
    """Every remark, in the order of the steps that they are about."""
    given, problem = known.given, known.problem
    linked = [association(given, known.first)] if (given.target < 0).any() else []
    return (
        *at_once(given),
        *linked,
        *doubted(given, problem.setup, known.why),
        *stamps(given),
        *chosen.notes,
        *undetermined(checks.determined),
        *drawing(draws),
        *scale(*checks.noise_scale),
        *correction(scored),
        *curvature(problem.recording, chosen.choice.name),
        *accuracy(checks.accuracies),
        *far(problem.names, draws.mean[: len(problem.names)], problem.prior_sd),
    )


def association(before: Recording, after: Recording) -> str:
    """How many reports without identity got one."""
    missing = before.target < 0
    linked = int((missing & (after.target >= 0)).sum())
    return f"{int(missing.sum())} reports had no identity; {linked} of them were associated."


def at_once(recording: Recording) -> list[str]:
    """Say which sensors give one target several reports at one time: both cannot be."""
    return [
        f"{sensor.name} gives one target two reports at one time in {count} cases; identities or "
        "plot extraction need a look."
        for sensor, count in zip(recording.sensors, several_at_once(recording), strict=True)
        if count
    ]


def far(names: Sequence[str], mean: FloatArray, prior_sd: FloatArray) -> list[str]:
    """Say which biases are much larger than their prior allows."""
    size = np.abs(mean) / prior_sd
    return [
        f"{names[k]} is {size[k]:.0f} prior standard deviations from zero: check from_north, the "
        "place of the sensor and the units, or enlarge its prior_sd."
        for k in np.flatnonzero(size > FAR_SIGMAS).tolist()
    ]


def doubted(given: Recording, setup: Setup, why: IntArray) -> list[str]:
    """How many identities that were given the paths contradict, and how."""
    own = why[given.target >= 0]
    off, fast = int((own == OFF_PATH).sum()), int((own == TOO_FAST).sum())
    said = {
        f"farther than the gate of {setup.gate_m:g} m from the path": off,
        f"reached only faster than max_speed_m_s = {setup.max_speed_m_s:g} along the path": fast,
    }
    return [
        f"{count} of {len(given)} reports are {text} of the target whose identity they carry, and "
        "were left out."
        for text, count in said.items()
        if count
    ]


def left_out(before: Recording, after: Recording) -> FloatArray:
    """Share (sensors,) of each sensor's reports with identity that lost it; 0 of none."""
    count = len(before.sensors)
    named = before.target >= 0
    lost = named & (after.target < 0)
    total = np.bincount(before.sensor[named], minlength=count)
    return np.bincount(before.sensor[lost], minlength=count) / np.maximum(total, 1)


def undetermined(found: Determined) -> list[str]:
    """Combinations that only the prior determines."""
    return [f"no residual shows {text}: only the prior determines it." for text in found.hidden] + [
        f"the prior determines {text} more than the data do." for text in found.weak
    ]


def correction(scored: HeldOut | None) -> list[str]:
    """Say where correction shows no effect on targets held out."""
    if scored is None or scored.verdict != "neither":
        return []
    return [
        f"on {scored.targets} targets held out correction gains nothing measurable: its effect is "
        "within two standard errors of zero."
    ]


def drawing(draws: Draws) -> list[str]:
    """What the sampler warns of."""
    return [f"{draws.sampler}: {text}" for text in draws.warnings]


def scale(bulk: float, every: float) -> list[str]:
    """Say where the noise is not what the sensors declare."""
    if bulk < _NEAR[1] and every > _NEAR[0]:
        return []
    said = bulk if every > _NEAR[0] else every
    return [
        f"the noise is {said:.2g} times what sensors and acceleration_m_s2 declare; check both. "
        "The intervals are scaled for errors independent from report to report, not for what "
        "persists within a target."
    ]


def stamps(recording: Recording) -> list[str]:
    """Sensors whose stamps are all whole seconds while others' are not."""
    time = recording.time
    whole = np.abs(time - np.round(time)) < _WHOLE_S
    present = [k for k in range(len(recording.sensors)) if (recording.sensor == k).any()]
    even = [k for k in present if whole[recording.sensor == k].all()]
    if not even or len(even) == len(present):
        return []
    names = ", ".join(recording.sensors[k].name for k in even)
    return [
        f"every stamp of {names} is a whole second, those of others are not: if they were "
        "rounded, targets have moved on by up to half a second, always the same way for one target."
    ]


def curvature(recording: Recording, law: str) -> list[str]:
    """Radars whose cross-range noise bends away from the tangent, under a robust law.

    Azimuth noise of sd s puts a converted report of range r short of the tangent by r s^2 / 2 on
    average. Least squares is freed of this by the unbiased conversion; a robust law takes the
    skewed tail for outliers.
    """
    if law == "Gaussian":
        return []
    said = []
    for k, sensor in enumerate(recording.sensors):
        rows = recording.sensor == k
        if not {"range", "azimuth"} <= set(sensor.bias_names) or not rows.any():
            continue
        reports = recording.values[rows, : len(sensor.bias_names)]
        sigma_range, *angles = np.median(sensor.report_sd(reports), axis=0)
        r = float(np.quantile(recording.values[rows, 0], 0.9))
        bent = r * max(angles) ** 2 / sigma_range
        if bent > _CURVED:
            said.append(
                f"{sensor.name}: cross-range noise curves (r sigma_azimuth^2 / sigma_range is "
                f"{bent:.2g} at its far reports). The law {law} is symmetric, takes the bend for "
                "outliers and biases the range: prefer --law Gaussian, or leave far reports out."
            )
    return said


def accuracy(found: Sequence[Accuracy]) -> list[str]:
    """Sensors whose reports scatter otherwise than declared."""
    said = []
    for one in found:
        if not one.clear or _FACTOR[0] < one.factor < _FACTOR[1]:
            continue
        size = one.factor * one.declared
        size = np.rad2deg(size) if one.key.endswith("_deg") else size
        said.append(
            f"{one.sensor}: {one.component} spread {one.factor:.1f} times declared; set "
            f"{one.key} near {float(f'{size:.2g}'):g}."
        )
    return said
