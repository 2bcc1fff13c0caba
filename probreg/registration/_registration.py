"""What a registration found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from probreg.numerics.intervals import equal_tailed
from probreg.posterior.tracks import TrackFit
from probreg.problems.recording import RecordingProblem
from probreg.recordings import Biases, BiasPaths, Recording, Setup, correct, restore
from probreg.registration._accuracy import Accuracy
from probreg.registration._choice import RankedLaw
from probreg.registration._held_out import HeldOut
from probreg.registration._missing import MissingTerm
from probreg.registration._observed import Determined
from probreg.registration._paths import Change, changes, path_draws, paths_table
from probreg.registration._tracks import reports_table, tracks_table
from probreg.registration.residuals import (
    Component,
    Residuals,
    components,
    report_residuals,
)
from probreg.samplers.tracks import BiasDraws
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
        As it was used: missing identities filled in.
    setup : Setup
    problem : RecordingProblem
        Its tracks; arrays of track reports are in the order of its `rows`.
    fit : TrackFit
        Of the tracks, at the mode.
    draws : BiasDraws
    law : str
        Noise law that was used.
    laws : tuple of RankedLaw
        Laws by leave-one-out, best first; one of them with elpd NaN where only one was tried.
    law_reports : int
        Reports that the comparison of laws is of.
    determined : Determined
    outlier : ndarray, shape (track reports,)
        Probability that a report is much noisier than its sensor usually is.
    held_out : HeldOut or None
    verdicts : tuple of Verdict
    cluster_ratio : ndarray, shape (p,)
        Standard deviation of each bias if errors of one target's reports may hang together, over
        the posterior's; far above one the intervals are too narrow. NaN with few targets.
    missing : tuple of MissingTerm
        Terms that the setup leaves out and the recording asks for, strongest first.
    left_out : ndarray, shape (sensors,)
        Share of each sensor's reports with identity that fit no target.
    noise_scale : ndarray, shape (sensors, 2)
        Standard deviation of the bulk of a sensor's reports, and of all with their tails, over
        what is declared.
    accuracies : tuple of Accuracy
    notes : tuple of str
        What a reader must know.
    seconds : mapping of str to float
        Time of each step.
    """

    recording: Recording
    setup: Setup
    problem: RecordingProblem
    fit: TrackFit
    draws: BiasDraws
    law: str
    laws: tuple[RankedLaw, ...]
    law_reports: int
    determined: Determined
    outlier: FloatArray
    held_out: HeldOut | None
    verdicts: tuple[Verdict, ...]
    cluster_ratio: FloatArray
    missing: tuple[MissingTerm, ...]
    left_out: FloatArray
    noise_scale: FloatArray
    accuracies: tuple[Accuracy, ...]
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

    @property
    def bias_draws(self) -> FloatArray:
        """Draws of the biases, shape (k, p)."""
        return self.draws.flat

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
        return equal_tailed(self.bias_draws, probability, (0,))

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
        """Reports of tracks that are believed to be of their target, by sensor."""
        sensors = self.recording.sensors
        believed = self.problem.sensor[self.fit.wrong <= 0.5]
        count = np.bincount(believed, minlength=len(sensors)).tolist()
        return {sensor.name: n for sensor, n in zip(sensors, count, strict=True)}

    @cached_property
    def residuals(self) -> Residuals:
        """Of every report against the tracks."""
        return report_residuals(self.problem, self.fit)

    @cached_property
    def components(self) -> list[Component]:
        """Residuals before and after correction of each component of each sensor."""
        return components(self.problem, self.residuals)

    @property
    def bad(self) -> FloatArray:
        """Probability (track reports,) that each is an outlier or not of the target it names."""
        moved = self.fit.target != self.problem.reports.target
        return np.where(moved, 1.0 - self.fit.wrong, self.fit.wrong + self.outlier)

    @property
    def expected_outliers(self) -> float:
        """Expected number of reports that are outliers or not of the target they name."""
        return float(self.bad.sum())

    @property
    def drifting(self) -> tuple[str, ...]:
        """Names of the biases that drift; `mean`, `sd`, ... are then of averages over time."""
        paths = self.draws.paths
        return () if paths is None else tuple(self.names[k] for k in paths.number)

    @property
    def over_time(self) -> Biases:
        """Mean biases (p,), or their paths where some drift."""
        paths = self.draws.paths
        if paths is None:
            return self.mean
        values = np.tile(self.mean, (len(paths.time), 1))
        values[:, list(paths.number)] = paths.flat.mean(axis=0)
        return BiasPaths(paths.time, values)

    def path_draws(self, name: str, time: FloatArray | None = None) -> FloatArray:
        """Draws (k, n) of a bias at times (n,) of the recording, by default those of the knots.

        Between knots a bias may leave the line from one to the next; draws have that too.

        Raises
        ------
        InvalidInputError
            No such bias; one that does not drift, without times.
        """
        return path_draws(self.draws, name, time)

    def paths(self, time: FloatArray | None = None) -> pd.DataFrame:
        """Drifting biases over time, by default at the knots; see `paths_table`."""
        return paths_table(self.draws, time)

    @property
    def changes(self) -> tuple[Change, ...]:
        """Steps of the biases that drift by steps, in order of time."""
        return changes(self.draws)

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

    def tracks(self) -> pd.DataFrame:
        """The reconstructed trajectories: one row a report; see `tracks_table`."""
        return tracks_table(self.problem, self.fit)

    def reports(self) -> pd.DataFrame:
        """One row a track report: residuals with their sd, and what speaks against it."""
        return reports_table(self.problem, self.fit, self.residuals, self.outlier)

    def suspects(self, least: float = 0.5) -> pd.DataFrame:
        """Reports that are likely outliers or of another target, worst first."""
        import pandas as pd

        bad = self.bad
        rows = np.flatnonzero(bad > least)
        rows = rows[np.argsort(-bad[rows], kind="stable")]
        report = self.problem.rows[rows]
        names = np.array([sensor.name for sensor in self.recording.sensors])
        moved = self.fit.target[rows] != self.problem.reports.target[rows]
        return pd.DataFrame(
            {
                "report": report,
                "sensor": names[self.recording.sensor[report]],
                "target": self.recording.target[report],
                "time": self.recording.time[report],
                "probability": bad[rows],
                "other target": np.where(moved, 1.0, self.fit.wrong[rows]),
                "fits target": np.where(moved, self.problem.owner[self.fit.target[rows]], -1),
            }
        )

    def correct(self, recording: Recording | None = None) -> Recording:
        """A recording (by default this one) without the mean biases."""
        return correct(
            self.recording if recording is None else recording, self.setup, self.over_time
        )

    def restore(self, recording: Recording) -> Recording:
        """The inverse of `correct`."""
        return restore(recording, self.setup, self.over_time)
