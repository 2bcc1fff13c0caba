"""What a reader of a registration must know, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from probreg.association.segments import GAP_S
from probreg.posterior.tracks import TrackFit
from probreg.problems.recording import RecordingProblem
from probreg.recordings import Recording
from probreg.recordings.checks import several_at_once
from probreg.registration._accuracy import Accuracy
from probreg.registration._checks import Checks
from probreg.registration._choice import Chosen
from probreg.registration._held_out import HeldOut
from probreg.registration._identities import Identified
from probreg.registration._missing import MissingTerm
from probreg.registration._observed import Determined
from probreg.registration._posterior import Fitted
from probreg.typing import FloatArray

FAR_SIGMAS = 5.0  # of the prior, from zero
_NEAR = (0.7, 1.4)  # scales of the noise that nobody need look after
_FACTOR = (0.6, 1.6)  # scatter over the declared one that needs no remark
_FAST, _FEW_FAST = 1.1, 0.02  # times the largest speed; share of the reports
_WHOLE_S = 1e-5  # how near to a whole second a stamp must be: POSIX seconds have seven digits


def remarks(
    known: Identified,
    chosen: Chosen,
    fitted: Fitted,
    scored: HeldOut | None,
    checks: Checks,
    missing: Sequence[MissingTerm],
) -> tuple[str, ...]:
    """Every remark, in the order of the steps that they are about."""
    given, problem, fit = known.given, known.problem, fitted.fit
    linked = [association(given, known.first)] if (given.target < 0).any() else []
    names = [sensor.name for sensor in problem.recording.sensors]
    return (
        *at_once(given),
        *linked,
        *cut_short(problem),
        *wrong_identities(problem, fit),
        *fast(problem, fit),
        *stamps(given),
        *chosen.notes,
        *undetermined(checks.determined),
        *drawing(fitted),
        # where a term is missing reports scatter for that reason
        *([] if missing else scale(names, checks.noise_scale)),
        *correction(scored),
        *([] if missing else accuracy(checks.accuracies)),
        *far(problem.names, fit.biases, problem.prior_sd),
        *clocks(fit),
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


def cut_short(problem: RecordingProblem) -> list[str]:
    """What the tracks leave out or cut: targets that nothing places, long gaps, lone reports."""
    lone = int((problem.reports.counts == 1).sum())
    said = []
    if problem.unplaced:
        said.append(
            f"{problem.unplaced} reports are of targets that nothing places (bearings that do not "
            "meet); they were left out."
        )
    split = len(problem.owner) - len(np.unique(problem.owner))
    if split:
        said.append(
            f"{split} times an identity was away for more than {GAP_S:g} s: no motion is known "
            "over such a gap, so what follows is a track of its own."
        )
    if lone:
        said.append(f"{lone} tracks have one report only, which tells nothing of the biases.")
    return said


def wrong_identities(problem: RecordingProblem, fit: TrackFit) -> list[str]:
    """How many reports are of other targets than they say."""
    moved = int((fit.target != problem.reports.target).sum())
    refused = int((fit.wrong > 0.5).sum())
    said = []
    if moved:
        said.append(
            f"{moved} of {len(fit.target)} reports fit another target than the one whose identity "
            "they carry, and were given to it."
        )
    if refused:
        said.append(
            f"{refused} of {len(fit.target)} reports fit no target: their identity is wrong with "
            "more than even odds, and they count for nothing."
        )
    return said


def refused(problem: RecordingProblem, fit: TrackFit) -> FloatArray:
    """Share (sensors,) of each sensor's reports with identity that fit no target."""
    count = len(problem.recording.sensors)
    total = np.bincount(problem.sensor, minlength=count)
    lost = np.bincount(problem.sensor[fit.wrong > 0.5], minlength=count)
    return lost / np.maximum(total, 1)


def fast(problem: RecordingProblem, fit: TrackFit) -> list[str]:
    """Say where targets fly faster than the setup allows."""
    d, most = fit.model.reports.dim, problem.setup.max_speed_m_s
    speed = np.linalg.norm(fit.mean[:, d : 2 * d], axis=1)
    over = int((speed[fit.wrong <= 0.5] > _FAST * most).sum())
    if over <= _FEW_FAST * len(fit.target):
        return []
    return [
        f"{over} of {len(fit.target)} reports are of targets faster than max_speed_m_s = "
        f"{most:g}: enlarge it, or look for wrong identities and for units of time and place."
    ]


def clocks(fit: TrackFit) -> list[str]:
    """Say where all clocks are in question."""
    if fit.model.all_clocks is None:
        return []
    return [
        "every sensor has a clock term: only differences of clocks show, their common offset is "
        "that of the priors."
    ]


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


def drawing(fitted: Fitted) -> list[str]:
    """What the sampler warns of, and where the mode does not tell the posterior."""
    said = [f"{fitted.draws.sampler}: {text}" for text in fitted.draws.warnings]
    if fitted.check is not None and not fitted.check.agrees:
        facts = fitted.draws.facts
        said.append(
            "short chains disagree with the normal law at the mode (standard deviations "
            f"{1.0 / facts['sd_ratio']:.2f} times as large, means within {facts['shift']:.2f} of "
            f"them): the result is of {fitted.draws.sampler}."
        )
    if not fitted.fit.settled:
        said.append("the fit had not come to rest when it was ended; numbers may still move.")
    return said


def scale(names: Sequence[str], found: FloatArray) -> list[str]:
    """Say where the noise is not what the sensors declare."""
    said = []
    for name, (bulk, every) in zip(names, found.tolist(), strict=True):
        if np.isnan(bulk) or (bulk < _NEAR[1] and every > _NEAR[0]):
            continue
        size = bulk if every > _NEAR[0] else every
        said.append(
            f"the noise of {name} is {size:.2g} times what it declares; check its accuracies. "
            "The intervals are scaled for errors independent from report to report, not for what "
            "persists within a target."
        )
    return said


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
