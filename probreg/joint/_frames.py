"""What joint methods share: association of corrected reports, and results that name pairs."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from probreg.association import squared_distances
from probreg.errors import InvalidInputError
from probreg.estimators import Estimate
from probreg.sensors.reports import SensorReports
from probreg.typing import FloatArray, IntArray


class JointEstimator(Protocol):
    """A method that estimates biases and says which reports belong together."""

    def estimate(
        self,
        first: SensorReports,
        second: SensorReports,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Estimate the biases of one frame, and its pairs.

        This is the contract of every joint method; the docstring of a method says what differs.

        Parameters
        ----------
        first, second : SensorReports
            One frame of each sensor.
        rng : numpy.random.Generator, optional
            Draws what a method draws at random.

        Returns
        -------
        Estimate
            `info["pairs"]` (k, 2) are the row numbers believed to belong together.

        Raises
        ------
        InvalidInputError
            Too few reports, or too few pairs inside the first gate.
        UnobservableError
            The pairs do not determine the biases.
        """


def split(first: SensorReports, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Biases of the first and of the second sensor from stacked ones, shape (..., p)."""
    q = len(first.sensor.bias_names)
    return theta[..., :q], theta[..., q:]


def corrected_distances(
    first: SensorReports, second: SensorReports, theta: FloatArray
) -> FloatArray:
    """Squared distances (n1, n2) in metres after correction by theta."""
    own, other = split(first, theta)
    return squared_distances(first.positions(own), second.positions(other))


def mahalanobis(first: SensorReports, second: SensorReports, theta: FloatArray) -> FloatArray:
    """Squared distances (..., n1, n2) in standard deviations after correction by theta (..., p).

    Covariances are taken at the uncorrected reports: biases hardly turn them.
    """
    own, other = split(first, np.asarray(theta)[..., None, :])
    gaps = first.positions(own)[..., :, None, :] - second.positions(other)[..., None, :, :]
    R = (
        first.sensor.covariance(first.positions())[:, None]
        + second.sensor.covariance(second.positions())[None, :]
    )
    return np.einsum("...ijk,ijkl,...ijl->...ij", gaps, np.linalg.inv(R), gaps)


def require_reports(first: SensorReports, second: SensorReports, least: int) -> None:
    """Raise unless both sensors have enough reports to determine the biases."""
    for reports in (first, second):
        if len(reports) < least:
            raise InvalidInputError(
                f"sensor {reports.sensor.name!r} has {len(reports)} report(s); at least {least} "
                "are needed to determine the biases from one frame. Join several frames."
            )
    if first.sensor.name == second.sensor.name:
        raise InvalidInputError(f"both sensors are called {first.sensor.name!r}.")


def with_pairs(estimate: Estimate, pairs: IntArray, **info: object) -> Estimate:
    """The estimate, with the pairs it believes."""
    return replace(estimate, info={**estimate.info, "pairs": pairs, **info})
