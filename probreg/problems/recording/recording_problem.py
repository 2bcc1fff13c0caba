"""A recording as tracks: whose reports, by what kind of sensor, with which unknowns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from probreg.association import segments
from probreg.association.segments import GAP_S
from probreg.errors import InvalidInputError
from probreg.problems.recording.first_guess import first_guess
from probreg.problems.recording.knots import Knots
from probreg.problems.recording.models import Models, companions, models_of
from probreg.problems.recording.track_reports import PathPoints, TrackReports
from probreg.recordings import (
    TARGET_HEIGHT_M,
    BiasModel,
    Recording,
    Setup,
    bias_model,
    places,
    turns,
)
from probreg.sensors.axes import EARTH_RADIUS_M
from probreg.typing import BoolArray, FloatArray, IntArray

SPACING_S = 15.0  # of knots, unless there would be more coefficients of drifting biases than
MOST_COEFFICIENTS = 600
MARGIN_M = 20_000.0  # about the places of reports, within which one of another target may lie


@dataclass(frozen=True, eq=False)
class RecordingProblem:
    """Tracks of a recording's targets, and the unknowns that their reports tell.

    Attributes
    ----------
    recording : Recording
    setup : Setup
    model : BiasModel
    reports : TrackReports
        Of the targets that are known; they number the tracks.
    rows : ndarray of int, shape (n,)
        Which report of the recording each of them is.
    owner : ndarray of int, shape (K,)
        Target of the recording that each track is of: one that was away for long has several.
    kinds : tuple of (int, int)
        Of each sensor model, its sensor, and the one whose reports it comes with.
    constants : dict of str to float
        Terms of which each target has one of its own, with their expected spread, SI units.
    known_constants : frozenset of str
        Those whose spread is as expected.
    guess : PathPoints
        Where reports place the targets.
    unplaced : int
        Reports that are left out, as nothing places their target.
    """

    recording: Recording
    setup: Setup
    model: BiasModel
    reports: TrackReports
    rows: IntArray
    owner: IntArray
    kinds: tuple[tuple[int, int], ...]
    constants: dict[str, float]
    known_constants: frozenset[str]
    guess: PathPoints
    unplaced: int

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the biases."""
        return self.model.names

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the biases, SI."""
        return self.model.units

    @property
    def prior_sd(self) -> FloatArray:
        """Prior standard deviations of the biases, (p,)."""
        return self.model.prior_sd

    @property
    def sensor(self) -> IntArray:
        """Sensor of the recording that each track report is of, (n,)."""
        return self.recording.sensor[self.rows]

    @cached_property
    def area_m2(self) -> float:
        """Of the scene, over which reports of other targets lie."""
        where = places(self.recording, self.setup, self.recording.values)[:, :2]
        where = where[np.isfinite(where).all(axis=1)]
        if not len(where):
            return float(MARGIN_M**2)
        low, high = np.quantile(where, [0.01, 0.99], axis=0)
        return float(np.prod(high - low + MARGIN_M))


def recording_problem(recording: Recording, setup: Setup) -> RecordingProblem:
    """Tracks of the reports with identity.

    Raises
    ------
    InvalidInputError
        Sensors other than the setup's, one sensor only, no target in common, no place for any.
    """
    _require_same_sensors(recording, setup)
    require_common(recording)
    model = bias_model(setup)
    beside = companions(recording)
    track, owner = segments(recording.target, recording.time, recording.beside)
    _require_common_track(recording, track, beside)
    rows = np.flatnonzero(track >= 0)
    seen = models_of(recording, setup, model, rows)
    knots = _knots(model, recording.time[rows])
    reports = _reports(recording, setup, seen, (rows, track[rows]), knots)
    guess, placed = _placed(reports, setup)
    if not placed.all():
        tracks, target = np.unique(reports.target[placed], return_inverse=True)
        keep = np.flatnonzero(placed)
        reports, rows, owner = reports.take(keep, target), rows[keep], owner[tracks]
        guess = PathPoints(*(part[keep] for part in guess))
    lost = int((~placed).sum())
    known = seen.kinds, seen.constants, seen.known, guess, lost
    return RecordingProblem(recording, setup, model, reports, rows, owner, *known)


def _reports(
    recording: Recording,
    setup: Setup,
    seen: Models,
    which: tuple[IntArray, IntArray],
    knots: Knots,
) -> TrackReports:
    """Reports `which` of a recording, and of which track each is."""
    rows, track = which
    number = np.full(len(recording), -1)
    number[rows] = np.arange(len(rows))
    own, beside = recording.own_position, recording.beside
    return TrackReports(
        seen.models,
        seen.which,
        track,
        recording.time[rows],
        recording.values[rows][:, : max(len(m.sigmas) for m in seen.models)],
        knots.num_biases,
        setup.dim,
        len(seen.constants),
        EARTH_RADIUS_M if setup.dim == 3 and setup.origin is not None else np.inf,
        None if own is None else own[rows],
        turns(recording, setup, rows) if setup.body_frame else None,
        None if beside is None else number[beside[rows]],
        knots,
    )


def _knots(model: BiasModel, time: FloatArray) -> Knots:
    """Knots over all stamps for the biases that drift."""
    drifting = tuple(model.drifts)
    if not drifting:
        return Knots(len(model.names))
    first, last = float(time.min()), float(time.max())
    most = MOST_COEFFICIENTS // len(drifting) - 1
    count = min(max(int(np.ceil((last - first) / SPACING_S)), 1), most)
    return Knots(len(model.names), drifting, np.linspace(first, max(last, first + 1.0), count + 1))


def _placed(reports: TrackReports, setup: Setup) -> tuple[PathPoints, BoolArray]:
    """A first guess of every path, and which reports are of targets that have one."""
    mean, _ = setup.target_height or TARGET_HEIGHT_M
    guess = first_guess(reports, mean, strict=False)
    placed = np.asarray(np.isfinite(guess.position).all(axis=1))
    if not placed.any():
        raise InvalidInputError(
            "no report places its target, and no lines of sight meet: add a sensor that measures "
            "range or position, or bearings from other places."
        )
    return guess, placed


def _require_same_sensors(recording: Recording, setup: Setup) -> None:
    if recording.sensors != setup.sensors:
        names = ([s.name for s in one.sensors] for one in (recording, setup))
        raise InvalidInputError(
            "sensors of recording and setup must be the same, in one order: {} and {}.".format(
                *names
            )
        )


def require_common(recording: Recording) -> None:
    """Refuse recordings that tell no bias.

    Raises
    ------
    InvalidInputError
        One sensor only; no target of two sensors.
    """
    sensor = recording.sensor[companions(recording)]
    seen = [recording.sensors[k].name for k in np.unique(sensor)]
    if len(seen) < 2:
        raise InvalidInputError(
            f"reports of {len(seen)} sensor(s) {seen}: a bias shows only where at least two "
            "sensors, or a sensor and a reference, report the same target."
        )
    if not _shared(recording.target, sensor).any():
        known = int((recording.target >= 0).sum())
        raise InvalidInputError(
            f"no target was seen by two of the sensors {seen}: {known} of {len(recording)} "
            "reports carry an identity. Check that identities are common to the sensors, or "
            "remove them and have the reports associated."
        )


def _shared(target: IntArray, sensor: IntArray) -> BoolArray:
    """Which targets are of two sensors or more."""
    known = target >= 0
    most = np.full(int(target.max(initial=-1)) + 1, -1)
    least = np.full(len(most), np.iinfo(np.int64).max)
    np.maximum.at(most, target[known], sensor[known])
    np.minimum.at(least, target[known], sensor[known])
    return np.asarray(most > least)


def _require_common_track(recording: Recording, track: IntArray, beside: IntArray) -> None:
    if not _shared(track, recording.sensor[beside]).any():
        raise InvalidInputError(
            "targets of two sensors were never seen by both within "
            f"{GAP_S:g} s. Check that the clocks have one zero."
        )
