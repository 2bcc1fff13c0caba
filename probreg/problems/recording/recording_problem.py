"""A recording as tracks: whose reports, by what kind of sensor, with which unknowns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from probreg.association import segments
from probreg.association.segments import GAP_S
from probreg.errors import InvalidInputError
from probreg.problems.recording.sensor_model import SensorModel
from probreg.problems.recording.track_reports import TrackReports
from probreg.recordings import (
    BiasModel,
    Recording,
    Setup,
    bias_model,
    observing_axes,
    places,
    turns,
)
from probreg.sensors import Sensor
from probreg.sensors.axes import EARTH_RADIUS_M, Axes
from probreg.sensors.terms import Term, known_terms
from probreg.typing import BoolArray, FloatArray, IntArray

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
    """

    recording: Recording
    setup: Setup
    model: BiasModel
    reports: TrackReports
    rows: IntArray
    owner: IntArray
    kinds: tuple[tuple[int, int], ...]

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
    if recording.sensors != setup.sensors:
        names = ([s.name for s in one.sensors] for one in (recording, setup))
        raise InvalidInputError(
            "sensors of recording and setup must be the same, in one order: {} and {}.".format(
                *names
            )
        )
    require_common(recording)
    model = bias_model(setup)
    beside = _beside(recording)
    track, owner = segments(recording.target, recording.time, recording.beside)
    _require_common_track(recording, track, beside)
    rows = np.flatnonzero(track >= 0)
    pairs, which = np.unique(
        np.stack([recording.sensor[rows], recording.sensor[beside[rows]]], axis=1),
        axis=0,
        return_inverse=True,
    )
    constants = tuple(setup.target_terms)
    axes = observing_axes(setup)
    models = tuple(_sensor_model(setup, model, axes, s, along) for s, along in pairs.tolist())
    number = np.full(len(recording), -1)
    number[rows] = np.arange(len(rows))
    own = recording.own_position
    reports = TrackReports(
        models,
        which.reshape(-1),
        track[rows],
        recording.time[rows],
        recording.values[rows][:, : max(len(m.sigmas) for m in models)],
        len(model.names),
        setup.dim,
        len(constants),
        EARTH_RADIUS_M if setup.dim == 3 and setup.origin is not None else np.inf,
        None if own is None else own[rows],
        turns(recording, setup, rows) if setup.body_frame else None,
        None if recording.beside is None else number[beside[rows]],
    )
    kinds = tuple((int(s), int(along)) for s, along in pairs)
    return RecordingProblem(recording, setup, model, reports, rows, owner, kinds)


def _beside(recording: Recording) -> IntArray:
    return np.arange(len(recording)) if recording.beside is None else recording.beside


def _sensor_model(
    setup: Setup, model: BiasModel, axes: tuple[Axes, ...], s: int, along: int
) -> SensorModel:
    """Sensor s whose reports come with those of another, by whose clock they are stamped."""
    sensor = setup.sensors[s]
    terms = list(zip(model.columns[s].tolist(), model.terms[s], strict=True))
    if s != along:
        clocks = zip(model.columns[along].tolist(), model.terms[along], strict=True)
        known = known_terms(sensor)
        terms += [(c, known[term.name]) for c, term in clocks if term.stamp]
    own = [
        (k, term)
        for k, name in enumerate(setup.target_terms)
        for term in [target_term(sensor, name)]
        if term is not None
    ]
    metric = tuple(
        sensor.kind.sigma_key(j).endswith("_m") and unit == "rad"
        for j, unit in enumerate(sensor.bias_units)
    )
    sigmas, mixing = sensor.principal
    return SensorModel(
        axes[s], sigmas, tuple(terms), tuple(own), sensor.azimuth_column, metric, mixing
    )


def target_term(sensor: Sensor, name: str) -> Term | None:
    """The term of that name where an error of it may belong to targets; None where not.

    A late stamp is a target's own only where the target reports its position itself.
    """
    term = known_terms(sensor).get(name)
    return None if term is None or (term.stamp and not sensor.cartesian) else term


def require_common(recording: Recording) -> None:
    """Refuse recordings that tell no bias.

    Raises
    ------
    InvalidInputError
        One sensor only; no target of two sensors.
    """
    sensor = recording.sensor[_beside(recording)]
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
