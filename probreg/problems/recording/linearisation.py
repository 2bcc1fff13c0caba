"""Equations of the reports of one sensor, tangent at biases and paths."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from probreg.motion.tracks import ScalarEquations, TrackEquations
from probreg.problems.recording.knots import Knots
from probreg.problems.recording.sensor_model import SensorModel
from probreg.sensors.geometry import wrap_angle
from probreg.typing import BoolArray, FloatArray, IntArray


class PathPoints(NamedTuple):
    """Where targets are at a time near that of each report, in the order of the reports.

    Attributes
    ----------
    time : ndarray, shape (n,)
    position, velocity : ndarray, shape (n, d)
    """

    time: FloatArray
    position: FloatArray
    velocity: FloatArray


@dataclass(frozen=True, eq=False)
class TrackLinearisation:
    """Equations of reports near biases and paths.

    Attributes
    ----------
    equations : TrackEquations
        In order of target and corrected time; biases are counted from `theta`.
    rows : ndarray of int, shape (n,)
        Which report stands in each place.
    order : ndarray of int, shape (n,)
        In which place each report stands.
    theta : ndarray, shape (p,)
    """

    equations: TrackEquations
    rows: IntArray
    order: IntArray
    theta: FloatArray

    def path(self, states: FloatArray) -> PathPoints:
        """Smoothed states (n, size) as a path in the order of the reports."""
        d = self.equations.dim
        own = states[self.order]
        return PathPoints(self.equations.time[self.order], own[:, :d], own[:, d : 2 * d])


class Where(NamedTuple):
    """Which components of a sensor's reports are given (n, q), their equations, their stamps."""

    given: BoolArray
    rows: IntArray
    stamp: FloatArray


class At(NamedTuple):
    """Where targets are, in the frame and from the platform, and how they move, (n, d)."""

    position: FloatArray
    away: FloatArray
    velocity: FloatArray
    steady: tuple[FloatArray, FloatArray] | None = None


def write_equations(
    scalar: ScalarEquations,
    where: Where,
    model: SensorModel,
    unknown: tuple[Knots, FloatArray],
    at: At,
    said: tuple[FloatArray, FloatArray | None],
) -> None:
    """Fill in the equations of the reports of one sensor."""
    given, rows, stamp = where
    knots, theta = unknown
    seen = model.axes.observe(at.away)
    values, turn = said
    expected = _turned(model, seen.value, turn)
    gradient = model.mixed(seen.gradient)
    moved = np.einsum("nqd,nd->nq", gradient, at.velocity)
    smooth, flow = expected, moved
    if at.steady is not None and model.varies:
        smooth = _turned(model, model.axes.observe(at.steady[0]).value, turn)
        flow = np.einsum("nqd,nd->nq", gradient, at.steady[1])
    off = values - expected
    assert scalar.column is not None
    assert scalar.response is not None
    assert scalar.constants is not None
    slot = 0
    for c, term in model.terms:
        off = off - np.reshape(knots.value(theta, c, stamp), (-1, 1)) * term.column(expected)
        own = model.mixed(seen.factor * term.column(smooth)) - term.stamp * flow
        for column, share in knots.parts(c, stamp):
            scalar.column[rows, slot] = _spread(column, given)
            scalar.response[rows, slot] = own[given] * _spread(share, given)
            slot += 1
    for c, term in model.own:
        own = model.mixed(seen.factor * term.column(expected)) - term.stamp * moved
        scalar.constants[rows, c] += own[given]
    off[:, model.axes.angles] = wrap_angle(off[:, model.axes.angles])
    at_path = np.einsum("nqd,nd->nq", gradient, at.position)
    scalar.y[rows] = (model.mixed(seen.factor * off) + at_path)[given]
    scalar.h[rows] = gradient[given]
    # a component that says nothing there, as an azimuth on a sensor's vertical, has no lever
    lever = np.where(seen.factor > 0.0, seen.factor, 1.0)
    sd = np.where(model.metric, 1.0, lever) * model.sigmas
    scalar.variance[rows] = (sd**2)[given]


def _spread(value: IntArray | FloatArray | float, given: BoolArray) -> FloatArray:
    """A value of each report, or of all, at each of its components."""
    return np.asarray(np.broadcast_to(np.reshape(value, (-1, 1)), given.shape)[given])


def _turned(model: SensorModel, value: FloatArray, turn: FloatArray | None) -> FloatArray:
    """Noise-free reports (n, q) as a sensor counts azimuth whose heading turns it."""
    if turn is None or model.azimuth is None:
        return value
    value = value.copy()
    value[:, model.azimuth] -= turn
    return value
