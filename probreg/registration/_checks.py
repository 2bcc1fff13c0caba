"""What speaks for and against a fit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.posterior.tracks import TrackFit
from probreg.registration._accuracy import Accuracy, accuracies
from probreg.registration._clusters import cluster_ratio
from probreg.registration._identities import Identified
from probreg.registration._observed import Determined, determined_by
from probreg.typing import FloatArray


class Checks(NamedTuple):
    """What the data determine, how noisy the reports are, whether their errors hang together.

    Attributes
    ----------
    determined : Determined
    noise_scale : ndarray, shape (sensors, 2)
        Standard deviation of the bulk of a sensor's reports, and of all with their tails, over
        what is declared; NaN of sensors without reports.
    accuracies : list of Accuracy
    cluster_ratio : ndarray, shape (p,)
    """

    determined: Determined
    noise_scale: FloatArray
    accuracies: list[Accuracy]
    cluster_ratio: FloatArray


def check(known: Identified, fit: TrackFit) -> Checks:
    """Look at the fit from every side; see `Registration` for what each number means."""
    return Checks(
        determined=determined_by(fit, known.problem.names),
        noise_scale=noise_scale(known, fit),
        accuracies=accuracies(known.problem, fit),
        cluster_ratio=cluster_ratio(fit),
    )


def noise_scale(known: Identified, fit: TrackFit) -> FloatArray:
    """Scales (sensors, 2) of the noise of reports that stand alone.

    The second counts heavy tails and outliers; infinite where the law has no variance.
    """
    out = np.full((len(known.problem.recording.sensors), 2), np.nan)
    for law, (sensor, along) in zip(fit.point.laws, known.problem.kinds, strict=True):
        if np.isnan(out[sensor, 0]) or sensor == along:
            out[sensor] = float(law.unit), float(np.sqrt(law.covariance_factor(2)))
    return out
