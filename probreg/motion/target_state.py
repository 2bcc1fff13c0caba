"""Target and bias followed together: the state is the target's motion and the sensors' offsets.

Source of the model: Zhou, Liang and Pan, Systems Engineering and Electronics 34(3), 2012,
section 2, with a second sensor, without which target and bias cannot be told apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from probreg.errors import InvalidInputError, UnobservableError
from probreg.motion.dynamics import Dynamics, NearConstantVelocity, Together
from probreg.motion.state_space import in_order
from probreg.motion.trajectory import Trajectory
from probreg.prior import GaussianPrior
from probreg.sensors.reports import AssociatedReports
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_number


@dataclass(frozen=True, eq=False)
class Target:
    """What is known of a target before its first report.

    Parameters
    ----------
    position, velocity : ndarray, shape (d,)
        Prior means at the first scan, metres and m/s.
    position_sd, velocity_sd : float
    acceleration_sd : float
        Of a step, m/s^2.

    Raises
    ------
    InvalidInputError
        A standard deviation that is not above zero, numbers that are not finite.
    """

    position: FloatArray
    velocity: FloatArray
    position_sd: float = 1_000.0
    velocity_sd: float = 50.0
    acceleration_sd: float = 5.0

    def __post_init__(self) -> None:
        for name in ("position_sd", "velocity_sd", "acceleration_sd"):
            positive_number(f"{name} of Target", getattr(self, name))
        for name in ("position", "velocity"):
            value = finite_array(f"{name} of Target", getattr(self, name), (None,))
            object.__setattr__(self, name, value)


def follow_target(
    data: AssociatedReports,
    target: Target,
    biases: Mapping[str, tuple[Dynamics, GaussianPrior]],
) -> Trajectory:
    """One target seen scan by scan by sensors that report positions, some of them biased.

    Parameters
    ----------
    data : AssociatedReports
        Of `PositionSensor`s, with times; each row is a scan of the same target.
    target : Target
    biases : mapping of str to (Dynamics, GaussianPrior)
        For each biased sensor's name how its offsets move, and their prior at the first
        scan. Sensors that are not named are calibrated.

    Returns
    -------
    Trajectory
        States "target.x", ..., "target.vx", ..., "sensor.x", ...; each sensor's report is a row
        of its own.

    Raises
    ------
    UnobservableError
        Every sensor is biased: target and biases could be moved together.
    InvalidInputError
        Other sensors, no times, a bias of a sensor that is not there.
    """
    _check(data, biases)
    d, T = data.sensors[0].dim, len(data)
    biased = [s.name for s in data.sensors if s.name in biases]
    H, R = _scan(data, biased)
    own = NearConstantVelocity(target.acceleration_sd)
    moves = Together(((own, 2 * d), *((biases[name][0], d) for name in biased)))
    p = H.shape[1]
    time = in_order(np.asarray(data.time), T)
    steps = [moves.step(p, float(interval)) for interval in np.diff(time)]
    return Trajectory(
        y=np.concatenate(data.values, axis=1),
        H=np.tile(H, (T, 1, 1)),
        R=np.tile(R, (T, 1, 1, 1)),
        F=np.array([F for F, _ in steps]).reshape(T - 1, p, p),
        Q=np.array([Q for _, Q in steps]).reshape(T - 1, p, p),
        prior=_prior(target, [biases[name][1] for name in biased]),
        time=time,
        names=_names(d, biased),
        units=("m",) * d + ("m/s",) * d + ("m",) * (p - 2 * d),
        width=d,
    )


def _names(d: int, biased: list[str]) -> tuple[str, ...]:
    axes = "xyz"[:d]
    own = [f"target.{v}{a}" for v in ("", "v") for a in axes]
    return (*own, *(f"{name}.{a}" for name in biased for a in axes))


def _scan(data: AssociatedReports, biased: list[str]) -> tuple[FloatArray, FloatArray]:
    """Sensitivity (k d, p) of the k sensors' reports to the state, and their R (k, d, d)."""
    d, k = data.sensors[0].dim, len(data.sensors)
    H, R = np.zeros((k, d, 2 * d + d * len(biased))), np.zeros((k, d, d))
    for j, sensor in enumerate(data.sensors):
        H[j, :, :d] = np.eye(d)
        R[j] = sensor.covariance(np.zeros(d))
        if sensor.name in biased:
            at = 2 * d + d * biased.index(sensor.name)
            H[j, :, at : at + d] = np.eye(d)
    return H.reshape(k * d, -1), R


def _prior(target: Target, offsets: list[GaussianPrior]) -> GaussianPrior:
    d = len(target.position)
    own = np.repeat([target.position_sd**2, target.velocity_sd**2], d)
    return GaussianPrior(
        np.concatenate([target.position, target.velocity, *(prior.mean for prior in offsets)]),
        block_diag(np.diag(own), *(prior.covariance for prior in offsets)),
    )


def _check(data: AssociatedReports, biases: Mapping[str, object]) -> None:
    names = [sensor.name for sensor in data.sensors]
    if data.time is None:
        raise InvalidInputError("a target that moves needs the times of its reports.")
    other = [s.name for s in data.sensors if not s.cartesian]
    if other:
        raise InvalidInputError(
            f"{other} do not report positions: target and bias together are linear for "
            "PositionSensor only. Take problems.drifting of a linearised ReportProblem."
        )
    strange = set(biases) - set(names)
    if strange or not biases:
        raise InvalidInputError(f"biases of {sorted(strange)} given; the sensors are {names}.")
    if set(names) <= set(biases):
        raise UnobservableError(
            f"every sensor ({', '.join(names)}) is biased: the same shift of the target and of all "
            "offsets changes no report, so only differences are determined. Leave one sensor out "
            "of `biases`: the offsets are then relative to it."
        )
