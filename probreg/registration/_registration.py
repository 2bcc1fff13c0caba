"""What a registration found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from probreg.diagnostics import Ranked
from probreg.posterior.posterior import Posterior
from probreg.problems.recording import RecordingProblem
from probreg.recordings import Recording, Setup, correct, restore
from probreg.registration._held_out import HeldOut
from probreg.registration._observed import Determined
from probreg.registration.residuals import (
    Component,
    Residuals,
    components,
    report_residuals,
)
from probreg.samplers import Draws
from probreg.typing import FloatArray

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Verdict:
    """A bias against the limit that the setup sets.

    Attributes
    ----------
    name : str
    limit : float
        SI units.
    probability : float
        That the bias exceeds the limit in size.
    """

    name: str
    limit: float
    probability: float

    @property
    def text(self) -> str:
        """Whether it "exceeds", is "within", or "undecided", at 95 %."""
        if self.probability > 0.95:
            return "exceeds"
        return "within" if self.probability < 0.05 else "undecided"


@dataclass(frozen=True, eq=False)
class Registration:
    """Biases of a recording's sensors and how well they are known.

    Attributes
    ----------
    recording : Recording
        As it was used: identities filled in, doubtful ones taken away.
    setup : Setup
    problem : RecordingProblem
        Its `plan` says which reports make which row.
    posterior : Posterior
        Of the rows linearised at the mode, under the law chosen.
    draws : Draws
    laws : tuple of Ranked
        Laws by leave-one-out, best first; one of them with elpd NaN where only one was tried.
    law_rows : int
        Rows that the comparison of laws is of.
    determined : Determined
    outlier_probability : ndarray, shape (rows,)
        That a row holds a report that its declared noise does not explain.
    held_out : HeldOut or None
    verdicts : tuple of Verdict
    cluster_ratio : ndarray, shape (p,)
        Standard deviation of each bias if errors of one target's reports may hang together, over
        the posterior's; far above one the intervals are too narrow. NaN with few targets.
    left_out : ndarray, shape (sensors,)
        Share of each sensor's reports with identity that fit no other sensor and lost it.
    noise_scale : tuple of float
        Standard deviation of the bulk of the rows, and of all rows with their tails, over what
        is declared.
    residuals : Residuals
        Of single reports, corrected by the posterior means.
    notes : tuple of str
        What a reader must know.
    seconds : mapping of str to float
        Time of each step.
    """

    recording: Recording
    setup: Setup
    problem: RecordingProblem
    posterior: Posterior
    draws: Draws
    laws: tuple[Ranked, ...]
    law_rows: int
    determined: Determined
    outlier_probability: FloatArray
    held_out: HeldOut | None
    verdicts: tuple[Verdict, ...]
    cluster_ratio: FloatArray
    left_out: FloatArray
    noise_scale: tuple[float, float]
    residuals: Residuals
    notes: tuple[str, ...]
    seconds: Mapping[str, float]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the biases."""
        return self.problem.names

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the biases, SI."""
        return self.problem.units

    @cached_property
    def bias_draws(self) -> FloatArray:
        """Draws of the biases, shape (k, p), without the noise parameters."""
        return self.draws.flat[:, : len(self.names)]

    @property
    def mean(self) -> FloatArray:
        """Posterior means, shape (p,)."""
        return self.bias_draws.mean(axis=0)

    @property
    def sd(self) -> FloatArray:
        """Posterior standard deviations, shape (p,)."""
        return self.bias_draws.std(axis=0, ddof=1)

    @property
    def median(self) -> FloatArray:
        """Posterior medians, shape (p,)."""
        return np.median(self.bias_draws, axis=0)

    def interval(self, probability: float = 0.9) -> FloatArray:
        """Equal-tailed credible intervals, shape (p, 2)."""
        return self.draws.interval(probability)[: len(self.names)]

    @property
    def covariance(self) -> FloatArray:
        """Posterior covariance of the biases, shape (p, p)."""
        return np.atleast_2d(np.cov(self.bias_draws.T))

    @property
    def correlation(self) -> FloatArray:
        """Posterior correlation of the biases, shape (p, p)."""
        return np.atleast_2d(np.corrcoef(self.bias_draws.T))

    @property
    def used(self) -> dict[str, int]:
        """Reports that stand in a row, by sensor; the others carry no information on the biases."""
        sensors = self.recording.sensors
        members = self.recording.sensor[self.problem.plan.members]
        count = np.bincount(members, minlength=len(sensors)).tolist()
        return {sensor.name: n for sensor, n in zip(sensors, count, strict=True)}

    @cached_property
    def residuals_before(self) -> Residuals:
        """Of single reports as they came, uncorrected."""
        return report_residuals(self.recording, self.setup, self.problem.start)

    @cached_property
    def components(self) -> list[Component]:
        """Residuals before and after correction of each component of each sensor."""
        return components(self.recording, self.residuals_before, self.residuals)

    @property
    def expected_outliers(self) -> float:
        """Expected number of rows that are outliers; NaN where that is not known."""
        return float(self.outlier_probability.sum())

    def table(self) -> pd.DataFrame:
        """One row a bias: mean, sd, 50 % and 90 % intervals in SI units, the data's share."""
        import pandas as pd

        half, most = self.interval(0.5), self.interval(0.9)
        return pd.DataFrame(
            {
                "unit": self.units,
                "mean": self.mean,
                "sd": self.sd,
                "50% low": half[:, 0],
                "50% high": half[:, 1],
                "90% low": most[:, 0],
                "90% high": most[:, 1],
                "determined by data": self.determined.share,
            },
            index=list(self.names),
        )

    def suspects(self, least: float = 0.5) -> pd.DataFrame:
        """Rows that are likely outliers, worst first, with their target, time and reports."""
        import pandas as pd

        rows = np.flatnonzero(self.outlier_probability > least)
        rows = rows[np.argsort(-self.outlier_probability[rows], kind="stable")]
        plan, names = self.problem.plan, np.array([s.name for s in self.recording.sensors])
        members = [plan.members[plan.start[r] : plan.start[r + 1]] for r in rows]
        return pd.DataFrame(
            {
                "row": rows,
                "target": plan.target[rows],
                "time": self.problem.time[rows],
                "probability": self.outlier_probability[rows],
                "reports": [tuple(own.tolist()) for own in members],
                "sensors": [tuple(names[self.recording.sensor[own]].tolist()) for own in members],
            }
        )

    def correct(self, recording: Recording | None = None) -> Recording:
        """A recording (by default this one) without the mean biases."""
        return correct(self.recording if recording is None else recording, self.setup, self.mean)

    def restore(self, recording: Recording) -> Recording:
        """The inverse of `correct`."""
        return restore(recording, self.setup, self.mean)
