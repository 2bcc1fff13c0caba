"""What is seen and believed of tracks: reports, laws of their noise, identities, motion, priors."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.tracks import TrackEquations, TrackMotion, track_motion
from probreg.noise import ScaleMixture
from probreg.posterior.tracks.cavity import ReportMixtures
from probreg.posterior.tracks.drifting import DriftPrior
from probreg.prior import GaussianPrior
from probreg.problems.recording.first_guess import first_guess
from probreg.problems.recording.track_reports import PathPoints, TrackLinearisation, TrackReports
from probreg.sensors.drifts import Drift
from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.validation import positive_number

LAYER_M = 12_000.0  # heights among which a report of another target lies
WIDEST_M = 5_000.0  # cavity standard deviation beyond which a report is placed by no other


@dataclass(frozen=True, eq=False)
class TrackModel:
    """A posterior over biases, paths, precisions and identities of reports.

    Parameters
    ----------
    reports : TrackReports
    prior : GaussianPrior
        Of the biases.
    laws : tuple of ScaleMixture
        Of the noise of each sensor, with the parameters to start from.
    unknown : tuple of frozenset of str, optional
        Parameters of each sensor's law that are estimated; by default all of `supports`.
    acceleration : float
        Density of the targets' acceleration, (m/s^2)^2 / Hz: the prior median, and its
        standard deviation in the logarithm, zero if it is known.
    acceleration_log_sd : float
    levels : tuple of float
        How many times the common density single targets may have, from 1 up; (1.0,) if all move
        alike. Not used if the acceleration is known.
    caution : float
        How many times the acceleration that is found counts when biases are solved for, from 1.
        A target that turns now and then bends biases under the density of its whole flight, by
        several standard deviations where nothing reports its place; 81 times the density costs
        two per cent of standard deviation.
    wrong_share : float or tuple of float
        Of the reports that are of another target than they say, the prior mean, for all sensors
        or for each; zero if none are.
    area_m2 : float
        Of the scene, over which reports of other targets lie.
    start_sd : tuple of float
        Standard deviations about the first guess, across and up: of position in metres, then of
        velocity in m/s.
    constant_sd : tuple of float
        Prior spread of the constants of targets.
    constant_known : tuple of bool, optional
        Constants whose spread is as given; by default none is.
    guess : PathPoints, optional
        Of every path, by default where the reports themselves place it.
    drifts : tuple of (Drift, float)
        How each drifting bias moves, in the order of the reports' knots, and the prior median of
        its spread. The prior is then of the levels.

    Raises
    ------
    InvalidInputError
        Parts that do not fit together, numbers out of range.
    """

    reports: TrackReports
    prior: GaussianPrior
    laws: tuple[ScaleMixture, ...]
    unknown: tuple[frozenset[str], ...] | None = None
    acceleration: float = 1.0
    acceleration_log_sd: float = 1.5
    levels: tuple[float, ...] = (1.0, 9.0, 81.0)
    caution: float = 1.0
    wrong_share: float | tuple[float, ...] = 0.0
    area_m2: float = 1e11
    start_sd: tuple[float, float, float, float] = (100_000.0, 10_000.0, 350.0, 50.0)
    constant_sd: tuple[float, ...] = ()
    constant_known: tuple[bool, ...] = ()
    guess: PathPoints | None = None
    drifts: tuple[tuple[Drift, float], ...] = ()
    start: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        reports, S = self.reports, len(self.reports.models)
        for name in ("acceleration", "area_m2"):
            positive_number(name, getattr(self, name))
        positive_number("acceleration_log_sd", self.acceleration_log_sd, zero=True)
        if not 1.0 <= self.caution < np.inf:
            raise InvalidInputError(f"caution is {self.caution}; it must be 1 or more.")
        for value in (*self.start_sd, *self.constant_sd):
            positive_number("start_sd or constant_sd", value)
        wrong = np.asarray(self.wrong_share, dtype=float)
        if wrong.shape not in ((), (S,)) or not ((wrong >= 0.0) & (wrong < 1.0)).all():
            raise InvalidInputError(
                f"wrong_share is {self.wrong_share}; a share below 1, or {S}, one a sensor."
            )
        if self.levels[:1] != (1.0,) or not (np.diff(self.levels) > 0.0).all():
            raise InvalidInputError(f"levels are {self.levels}; from 1 up.")
        if len(self.laws) != S or not all(isinstance(law, ScaleMixture) for law in self.laws):
            raise InvalidInputError(f"{S} scale-mixture laws, one a sensor, are needed.")
        if any(not law.scale_mixture or law.componentwise for law in self.laws):
            raise InvalidInputError("laws must be scale mixtures and weigh whole reports.")
        if self.prior.mean.size != reports.num_biases:
            raise InvalidInputError(f"the prior must be of {reports.num_biases} biases.")
        if len(self.drifts) != len(reports.coefficients.drifting):
            raise InvalidInputError("each bias with knots needs a kind of drift, no other one.")
        known = self.constant_known or (False,) * len(self.constant_sd)
        object.__setattr__(self, "constant_known", known)
        if not len(self.constant_sd) == len(known) == reports.num_constants:
            raise InvalidInputError(f"constant_sd of {reports.num_constants} constants are needed.")
        unknown = tuple(frozenset(law.supports) for law in self.laws)
        object.__setattr__(self, "unknown", self.unknown or unknown)
        guess = first_guess(reports) if self.guess is None else self.guess
        first = np.zeros(reports.num_targets, dtype=np.int64)
        order = np.lexsort([-reports.time, reports.target])
        first[reports.target[order]] = order  # the last written is the earliest
        object.__setattr__(self, "guess", guess)
        object.__setattr__(self, "start", guess.position[first])

    @cached_property
    def drift(self) -> DriftPrior | None:
        """Prior of all coefficients where some biases drift."""
        if not self.drifts:
            return None
        kinds, scales = zip(*self.drifts, strict=True)
        return DriftPrior(self.prior, self.reports.coefficients, kinds, np.array(scales))

    @property
    def prior_coefficients(self) -> FloatArray:
        """Prior mean of all coefficients, (P,)."""
        return self.prior.mean if self.drift is None else self.drift.mean

    @property
    def wrong_shares(self) -> FloatArray:
        """Prior share of wrong identities of each sensor."""
        return np.full(len(self.laws), self.wrong_share)

    @property
    def all_clocks(self) -> FloatArray | None:
        """The direction in which all clocks move together, if every sensor has a clock term."""
        columns = [[c for c, term in model.terms if term.stamp] for model in self.reports.models]
        if not all(columns) or not self.reports.num_biases:
            return None
        together = np.zeros(self.reports.num_biases)
        together[np.concatenate(columns).astype(int)] = 1.0
        moved = self.reports.coefficients.spread(together)
        return np.asarray(moved / np.linalg.norm(moved))

    def of_targets(self, targets: IntArray) -> TrackModel:
        """The model of the reports of some targets, renumbered in the order given."""
        number = np.full(self.reports.num_targets, -1)
        number[targets] = np.arange(len(targets))
        own = np.flatnonzero(number[self.reports.target] >= 0)
        reports = self.reports.take(own, number[self.reports.target[own]])
        assert self.guess is not None
        guess = PathPoints(*(array[own] for array in self.guess))
        return replace(self, reports=reports, guess=guess)

    def motion(
        self, equations: TrackEquations, q: float | FloatArray, constant_sd: FloatArray
    ) -> TrackMotion:
        """How targets move at a density q, of all or of each, and a spread of the constants."""
        d, c = self.reports.dim, self.reports.num_constants
        level = min(d, 2)
        position, velocity = (self.start_sd[k : k + 2] for k in (0, 2))
        spread = [np.repeat(pair, (level, d - level)) for pair in (position, velocity)]
        sd = np.concatenate([*spread, constant_sd])
        mean = np.hstack([self.start, np.zeros((len(self.start), d + c))])
        return track_motion(equations, q, mean, sd)

    def mixtures(
        self,
        tangent: TrackLinearisation,
        laws: tuple[ScaleMixture, ...],
        wrong: FloatArray,
        widened: float = 1.0,
    ) -> ReportMixtures:
        """The Gaussians of each report's noise and the density of a wrong identity.

        `widened` multiplies every standard deviation.
        """
        models = self.reports.models
        parts = [law.mixture(len(m.sigmas)) for law, m in zip(laws, models, strict=True)]
        J = max(len(part.share) for part in parts)
        log_share, variance = np.full((len(parts), J), -np.inf), np.ones((len(parts), J))
        with np.errstate(divide="ignore"):
            for s, part in enumerate(parts):
                good = part.share * (1.0 - wrong[s])
                log_share[s, : len(part.share)] = np.log(good)
                variance[s, : len(part.share)] = part.variance * widened**2
            log_wrong = np.log(wrong)[self.reports.sensor] + self._log_elsewhere
        sensor = np.ascontiguousarray(self.reports.sensor[tangent.rows], dtype=np.int64)
        return ReportMixtures(sensor, log_share, variance, log_wrong[tangent.rows])

    @cached_property
    def _log_elsewhere(self) -> FloatArray:
        """Log density of each report if it is of another target, its errors in metres."""
        vertical: BoolArray = np.zeros(self.reports.values.shape, dtype=bool)
        for k, model in enumerate(self.reports.models):
            own = np.flatnonzero(self.reports.sensor == k)
            vertical[own, : len(model.sigmas)] = model.axes.vertical
        given = np.isfinite(self.reports.values)
        across = (given & ~vertical).sum(axis=1)
        up = (given & vertical).sum(axis=1)
        return np.asarray(-0.5 * across * np.log(self.area_m2) - up * np.log(LAYER_M))
