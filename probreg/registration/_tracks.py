"""Reconstructed trajectories and reports as tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from probreg.motion.tracks import add_bias_uncertainty
from probreg.posterior.tracks import TrackFit, as_constant, local_covariance, smooth
from probreg.problems.recording import RecordingProblem
from probreg.registration.residuals import Residuals
from probreg.sensors.frame import LocalFrame
from probreg.typing import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    import pandas as pd

_Columns = dict[str, FloatArray | IntArray | BoolArray | list[str]]
AXES = ("x", "y", "z")
BELIEVED = 0.5


def tracks_table(problem: RecordingProblem, fit: TrackFit) -> pd.DataFrame:
    """Where every target was at the corrected time of each of its reports.

    Parameters
    ----------
    problem : RecordingProblem
    fit : TrackFit

    Returns
    -------
    DataFrame
        By target and time: `time`, `target` (label), `track`, `report` (number in the
        recording), `sensor`, `used` (whether the report is believed to be of this target),
        `x`, `y` (`z`) in metres and `vx`, ... in m/s of the common frame, the covariance of the
        position `cov_xx`, `cov_xy`, ... and the standard deviations `sd_vx`, ... with what is
        not known of the biases; on the earth also latitude, longitude (degrees) and height (m).
    """
    import pandas as pd

    model, point = fit.model, fit.point
    tangent, d = point.tangent, fit.model.reports.dim
    smoothed = smooth(model, point, fit.theta, covariance=True)
    assert smoothed.covariance is not None
    motion = model.motion(tangent.equations, point.density, point.constant_sd)
    own = fit.covariance
    if fit.knots.drifting:
        own = local_covariance(fit, model.reports.time[tangent.rows])
    covariance = add_bias_uncertainty(
        smoothed.covariance, as_constant(fit), motion, own, point.weights
    )
    row = problem.rows[tangent.rows]
    recording = problem.recording
    track = fit.target[tangent.rows]
    columns: _Columns = {
        "time": tangent.equations.time,
        "target": labels_of(problem, track),
        "track": track,
        "report": row,
        "sensor": [recording.sensors[k].name for k in recording.sensor[row]],
        "used": fit.wrong[tangent.rows] <= BELIEVED,
        **_states(smoothed.mean, covariance, d),
    }
    if problem.setup.origin is not None:
        places = LocalFrame(*problem.setup.origin).to_geodetic(smoothed.mean[:, :d])
        columns |= dict(zip(("latitude_deg", "longitude_deg"), places.T[:2], strict=True))
        if d == 3:
            columns["height_m"] = places[:, 2]
    return pd.DataFrame(columns)


def _states(mean: FloatArray, covariance: FloatArray, d: int) -> _Columns:
    """Positions, velocities, covariance of the position, standard deviations of the velocity."""
    columns: _Columns = {axis: mean[:, k] for k, axis in enumerate(AXES[:d])}
    columns |= {f"v{axis}": mean[:, d + k] for k, axis in enumerate(AXES[:d])}
    for i in range(d):
        for j in range(i, d):
            columns[f"cov_{AXES[i]}{AXES[j]}"] = covariance[:, i, j]
    for k in range(d):
        columns[f"sd_v{AXES[k]}"] = np.sqrt(covariance[:, d + k, d + k])
    return columns


def labels_of(problem: RecordingProblem, track: IntArray) -> list[str]:
    """Names of the targets that tracks are of."""
    names = problem.recording.labels
    return [names[k] if k < len(names) else str(k) for k in problem.owner[track].tolist()]


def reports_table(
    problem: RecordingProblem, fit: TrackFit, found: Residuals, outlier: FloatArray
) -> pd.DataFrame:
    """One row a track report: `report`, `sensor`, `target`, `time`, and what speaks against it.

    `wrong` is the probability that it is of no known target, `outlier` that it is much noisier
    than its sensor usually is, `moved` whether it was given to another target than it names. For
    each component a residual after correction, and its standard deviation, SI units.
    """
    import pandas as pd

    recording, rows = problem.recording, problem.rows
    columns: _Columns = {
        "report": rows,
        "sensor": [recording.sensors[k].name for k in recording.sensor[rows]],
        "target": labels_of(problem, fit.target),
        "time": found.time[rows],
        "wrong": fit.wrong,
        "outlier": outlier,
        "moved": fit.target != problem.reports.target,
    }
    for sensor in recording.sensors:
        for j, name in enumerate(sensor.bias_names):
            own = recording.sensor[rows] == recording.sensors.index(sensor)
            for title, values in (("", found.after), ("_sd", found.sd)):
                column = columns.setdefault(f"{name}{title}", np.full(len(rows), np.nan))
                np.asarray(column)[own] = values[rows[own], j]
    return pd.DataFrame(columns)
