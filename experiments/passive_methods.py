"""What the bearings-only studies share: the papers' estimators, and scoring of paths."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from probreg.estimators import Estimate, Estimator, ExtendedKalman, LinesOfSight, Recursive
from probreg.estimators import RecursiveTls as Rtls
from probreg.noise import Gaussian, Igg3, StudentT
from probreg.sensors.reports import BearingReports
from probreg.typing import FloatArray

LINES = LinesOfSight(Recursive(Gaussian(), omega=1e8))


def filter_methods(k1: float, k2: float, gate: float, start_bearings: int) -> dict[str, Estimator]:
    """Estimators of the robust EKF paper, by the names in its figures, and one of ours."""
    law = Igg3(k1, k2)
    return {
        "LS": LINES,
        "EKF": ExtendedKalman(start_bearings=start_bearings),
        "REKF": ExtendedKalman(law, start_bearings=start_bearings),
        "chi2-REKF": ExtendedKalman(law, gate, start_bearings=start_bearings),
        "EKF, start reused": ExtendedKalman(start_bearings=start_bearings, reuse_start=True),
    }


def total_methods(r0: float, r1: float, reject: float) -> dict[str, Estimator]:
    """Estimators of the total-least-squares paper, by the names in its figures, and one of ours."""
    law = Igg3(r0, r1)
    return {
        "RLS": LINES,
        "RTLS": Rtls(),
        "XRTLS": Rtls(reject_above=reject),
        "RRTLS": Rtls(law),
        "RRTLS, robust start": Rtls(law, start=StudentT(1.0)),
    }


def squared_path(estimate: Estimate, emitter: FloatArray) -> FloatArray:
    """Squared position error after each bearing, shape (n,); NaN where there is no estimate."""
    assert estimate.path is not None
    gap: FloatArray = ((estimate.path[:, :2] - emitter) ** 2).sum(axis=1)
    return gap


def squared_error(theta: FloatArray, emitter: FloatArray) -> float:
    """Squared position error."""
    return float(((theta[:2] - emitter) ** 2).sum())


def squared_bound(bound: FloatArray) -> FloatArray:
    """Trace of the position part of bounds (..., p, p)."""
    return bound[..., 0, 0] + bound[..., 1, 1]


def outlier_sizes(
    simulate: Callable[[Any, np.random.Generator], tuple[BearingReports, Any]],
    scene: Any,
    clean: Any,
    seed: int,
) -> FloatArray:
    """Outliers as used, in standard deviations: the difference they make to the reports, (n,)."""
    struck, right = (simulate(s, np.random.default_rng(seed))[0] for s in (scene, clean))
    return np.round((struck.bearing - right.bearing) / right.sensor.sigma_bearing, 6)
