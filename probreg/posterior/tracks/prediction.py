"""What reports say of biases that they were not fitted to, and each report against the others."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from probreg.motion.tracks import SmoothedTracks
from probreg.posterior.tracks.cavity import Judgement
from probreg.posterior.tracks.fit import TrackFit
from probreg.posterior.tracks.steps import Point, judge, smooth
from probreg.problems.recording.track_reports import PathPoints, TrackLinearisation
from probreg.typing import FloatArray, IntArray

ROUNDS = 3  # of weights and tangents, as biases that are far off bend the paths


class LeftOut(NamedTuple):
    """Equations of reports against the path that all others give.

    Attributes
    ----------
    residual, variance : ndarray, shape (E,)
        Metres; of the path by the others, then of the report itself at weight one.
    path_variance : ndarray, shape (E,)
        The first part of it.
    """

    residual: FloatArray
    variance: FloatArray
    path_variance: FloatArray


class Prediction(NamedTuple):
    """Reports of some targets at given biases.

    Attributes
    ----------
    rows : ndarray of int, shape (n,)
        Which reports of the fit they are.
    tangent : TrackLinearisation
    judged : Judgement
        In the order of the tangent.
    left_out : LeftOut
    """

    rows: IntArray
    tangent: TrackLinearisation
    judged: Judgement
    left_out: LeftOut


def predict(fit: TrackFit, theta: FloatArray, targets: IntArray) -> Prediction:
    """Reports of targets at biases theta (p,), laws and acceleration as in the fit."""
    model = fit.model.of_targets(targets)
    number = np.full(fit.model.reports.num_targets, -1)
    number[targets] = np.arange(len(targets))
    rows = np.flatnonzero(number[fit.model.reports.target] >= 0)
    d = model.reports.dim
    time = fit.model.reports.shifted_time(fit.theta)[rows]
    states = fit.mean[rows]
    path = PathPoints(time, states[:, :d], states[:, d : 2 * d])
    tangent = model.reports.linearise(theta, path)
    livelier = fit.point.livelier
    point = replace(
        fit.point,
        tangent=tangent,
        weights=fit.weights[rows][tangent.rows],
        livelier=livelier if np.ndim(livelier) == 0 else np.asarray(livelier)[targets],
    )
    for k in range(ROUNDS):
        smoothed = smooth(model, point, theta)
        judged = judge(model, point, smoothed)
        if k + 1 < ROUNDS:
            tangent = model.reports.linearise(theta, point.tangent.path(smoothed.mean))
            weights = judged.weight[point.tangent.order][tangent.rows]
            point = replace(point, tangent=tangent, weights=weights)
    return Prediction(rows, point.tangent, judged, left_out(point, smoothed))


def left_out(point: Point, smoothed: SmoothedTracks) -> LeftOut:
    """Residuals of reports against the paths without them; see `cavity`."""
    equations = point.tangent.equations
    count = np.diff(equations.report_start)
    precision = equations.precision(point.weights)
    E = len(equations.y)
    residual, path = np.empty(E), np.empty(E)
    assert smoothed.spread is not None
    for m in np.unique(count[count > 0]):
        rows = equations.report_start[:-1][count == m][:, None] + np.arange(m)
        A = smoothed.spread[rows][:, :, :m]
        B = np.eye(m) - A * precision[rows][:, None, :]
        both = np.concatenate([A, smoothed.residual[rows][..., None]], axis=2)
        solved = np.linalg.solve(B, both)
        residual[rows] = solved[..., m]
        path[rows] = np.maximum(np.einsum("nmm->nm", solved[..., :m]), 0.0)
    return LeftOut(residual, path + equations.variance, path)
