"""Residuals of single reports: what a sensor says less where the tracks put the target."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from probreg.posterior.tracks import LeftOut, TrackFit, left_out, smooth
from probreg.problems.recording import RecordingProblem
from probreg.problems.recording.track_reports import TrackLinearisation
from probreg.recordings import corrected_values, places
from probreg.typing import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Residuals:
    """Reports of a recording against the tracks, in the recording's order.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Corrected.
    where : ndarray, shape (n, d)
        Places of the corrected reports in the common frame, metres; NaN where they say none.
    values : ndarray, shape (n, q)
        Corrected reports.
    before, after : ndarray, shape (n, q)
        Uncorrected and corrected report less what the path by all other reports of its target
        says, in the sensor's components and SI units; NaN for reports of no track.
    sd : ndarray, shape (n, q)
        Of the residual after correction, as path and declared noise have it.
    """

    time: FloatArray
    where: FloatArray
    values: FloatArray
    before: FloatArray
    after: FloatArray
    sd: FloatArray


def report_residuals(problem: RecordingProblem, fit: TrackFit) -> Residuals:
    """Residuals at the mode of a fit to a problem."""
    recording = problem.recording
    values, time = corrected_values(recording, problem.setup, fit.over_time)
    shape = values.shape
    before, after, sd = (np.full(shape, np.nan) for _ in range(3))
    tangent, left = left_out_of(fit)
    units = _units(fit, tangent)
    bias = np.einsum("es,es->e", tangent.equations.response, fit.theta[tangent.equations.column])
    columns = (left.residual + bias, left.residual, np.sqrt(left.variance))
    place = problem.rows[tangent.rows[tangent.equations.report]], _component(fit, tangent)
    for out, metres in zip((before, after, sd), columns, strict=True):
        out[place] = metres / units
    return Residuals(time, places(recording, problem.setup, values), values, before, after, sd)


def left_out_of(fit: TrackFit) -> tuple[TrackLinearisation, LeftOut]:
    """The tangent of a fit, and its equations against the paths by all other reports."""
    smoothed = smooth(fit.model, fit.point, fit.theta)
    return fit.point.tangent, left_out(fit.point, smoothed)


def _component(fit: TrackFit, tangent: TrackLinearisation) -> IntArray:
    """Which component of its report each equation is of."""
    given = fit.model.reports.given[tangent.rows]
    return np.nonzero(given)[1]


def _units(fit: TrackFit, tangent: TrackLinearisation) -> FloatArray:
    """Metres a unit of each equation's component."""
    reports = fit.model.reports
    factor = np.ones(reports.values.shape)
    for k, model in enumerate(reports.models):
        own = np.flatnonzero(reports.sensor == k)
        if own.size:
            where = fit.mean[own, : reports.dim]
            where = where if reports.own is None else where - reports.own[own]
            found = model.axes.observe(where).factor
            factor[own, : len(model.sigmas)] = np.where(found > 0.0, found, np.inf)
    return np.asarray(factor[tangent.rows][reports.given[tangent.rows]])


@dataclass(frozen=True)
class Spread:
    """Median and robust standard deviation of residuals, SI units."""

    median: float
    sd: float


def spread(residual: FloatArray) -> Spread:
    """Median, and 1.4826 times the median distance from it."""
    if not residual.size:
        return Spread(np.nan, np.nan)
    middle = float(np.median(residual))
    return Spread(middle, 1.4826 * float(np.median(np.abs(residual - middle))))


@dataclass(frozen=True, eq=False)
class Component:
    """Residuals of one component of one sensor before and after, of the same reports.

    Attributes
    ----------
    sensor, name, unit : str
        Unit inside: "m" or "rad".
    rows : ndarray of int, shape (k,)
        Reports of the recording.
    before, after, sd : ndarray, shape (k,)
    """

    sensor: str
    name: str
    unit: str
    rows: IntArray
    before: FloatArray
    after: FloatArray
    sd: FloatArray

    @cached_property
    def spreads(self) -> tuple[Spread, Spread]:
        """Median and robust standard deviation before and after."""
        return spread(self.before), spread(self.after)


def components(problem: RecordingProblem, found: Residuals) -> list[Component]:
    """Every component of every sensor that has residuals."""
    recording, said = problem.recording, []
    for k, sensor in enumerate(recording.sensors):
        names = zip(sensor.bias_names, sensor.bias_units, strict=True)
        for j, (name, unit) in enumerate(names):
            rows = np.flatnonzero(np.isfinite(found.after[:, j]) & (recording.sensor == k))
            if rows.size:
                parts = (part[rows, j] for part in (found.before, found.after, found.sd))
                said.append(Component(sensor.name, name, unit, rows, *parts))
    return said
