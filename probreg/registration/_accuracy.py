"""Accuracies of single sensors, estimated from how their reports scatter about the tracks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.posterior.tracks import TrackFit
from probreg.problems.recording import RecordingProblem
from probreg.registration.residuals import left_out_of
from probreg.typing import FloatArray

_FEWEST = 50  # reports from which a spread can be estimated
_ENOUGH = 20_000  # that settle it
_OWN = 0.1  # of a residual's variance; below, the path's own error hides the sensor's
_ERROR = 2.33  # sd of a robust variance, over the variance, times root n
_BELIEVED = 0.5  # probability of being of another target, below which a report counts
_MIDDLE = 0.4549364231195728  # median of chi-square with one degree of freedom
_ROUNDS = 40


class Accuracy(NamedTuple):
    """Standard deviation of a sensor's reports over the declared one.

    Attributes
    ----------
    sensor, component : str
    key : str
        Of the accuracy in the setup file.
    declared : float
        In the SI unit of the key.
    factor : float
        The scatter over it.
    clear : bool
        Whether its square is off one by three standard errors.
    """

    sensor: str
    component: str
    key: str
    declared: float
    factor: float
    clear: bool


def accuracies(problem: RecordingProblem, fit: TrackFit) -> list[Accuracy]:
    """Every accuracy that the residuals determine.

    A residual against the path by all other reports has the variance of that path and of the
    report. A factor on the declared variance is fitted to each component so that the median
    squared residual is that of a normal law.
    """
    tangent, left = left_out_of(fit)
    good = (fit.wrong < _BELIEVED)[tangent.rows]
    report = tangent.equations.report
    fine = good[report]
    row = problem.rows[tangent.rows[report]]
    component = np.nonzero(fit.model.reports.given[tangent.rows])[1]
    sensor = problem.recording.sensor[row]
    said = []
    for k, one in enumerate(problem.recording.sensors):
        if one.principal[1] is not None:
            continue  # components whose errors correlate have no accuracies of their own
        for j, (name, sigma) in enumerate(zip(one.bias_names, one.sigmas, strict=True)):
            own = np.flatnonzero(fine & (sensor == k) & (component == j))
            if len(own) < _FEWEST:
                continue
            own = own[:: -(-len(own) // _ENOUGH)]
            path, declared = left.path_variance[own], tangent.equations.variance[own]
            factor = variance_factor(left.residual[own] ** 2, path, declared)
            share = float(np.median(factor * declared / (path + factor * declared)))
            if share < _OWN:
                continue
            error = _ERROR * max(factor, 1e-3) / np.sqrt(len(own)) / share
            key = one.kind.sigma_key(j)
            clear = abs(factor - 1.0) > 3.0 * error
            said.append(
                Accuracy(one.name, name, key, float(sigma), float(np.sqrt(factor)), bool(clear))
            )
    return said


def variance_factor(square: FloatArray, path: FloatArray, declared: FloatArray) -> float:
    """Factor f at which the median of square / (path + f declared) is that of a normal law."""
    low, high = 1e-3, 1e4
    for _ in range(_ROUNDS):
        middle = float(np.sqrt(low * high))
        if np.median(square / (path + middle * declared)) > _MIDDLE:
            low = middle
        else:
            high = middle
    return float(np.sqrt(low * high))
