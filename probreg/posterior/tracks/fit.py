"""The mode of a track posterior: biases with weights, identities, accelerations and laws."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from probreg.posterior.tracks import steps
from probreg.posterior.tracks._company import in_company
from probreg.posterior.tracks._offers import offer_refused
from probreg.posterior.tracks._search import (
    SETTLED,
    Search,
    Start,
    rest,
    settled,
    start_of,
    step,
    with_offer,
)
from probreg.posterior.tracks.model import TrackModel
from probreg.posterior.tracks.steps import Information, Point, Solution
from probreg.problems.recording.knots import Knots
from probreg.problems.recording.track_reports import TrackLinearisation
from probreg.recordings import Biases, BiasPaths
from probreg.typing import FloatArray, IntArray

WIDENED = (30.0, 10.0, 3.0, 1.0)  # noise at first, so that no report is refused too early
STEPS_EACH = 2
FIRST_REPORTS = 8_000  # enough to come near the mode of many
ONLY_PATHS = (10.0, 1.0)  # where biases and laws are known from some of the targets
GENEROUS = 900.0  # acceleration at first, over the prior's: a refused turn is never taken back
TANGENTS = 2  # at smoothed paths; the first is at the reports themselves
OFFERS = 2


@dataclass(frozen=True, eq=False)
class TrackFit:
    """Biases, paths and reports at the mode; arrays of reports in the order of the recording.

    Attributes
    ----------
    model : TrackModel
        Its reports under their last identities: refused ones may have found another target.
    point : Point
        Tangent, weights, accelerations, laws and shares at the mode.
    theta : ndarray, shape (P,)
        Coefficients: the biases, of those that drift at every knot; see `Knots`.
    covariance : ndarray, shape (P, P)
        Of the coefficients given the weights; paths integrated out.
    information : BiasInformation or DriftInformation
        By target, of the coefficients from those of the tangent.
    weights, wrong, log_density : ndarray, shape (n,)
        Expected precision, probability that the report is not of its (last) target, and
        leave-one-out score.
    probability : ndarray, shape (n, J)
        Of each Gaussian of the sensor's law.
    mean : ndarray, shape (n, size)
        Smoothed states at each report.
    settled : bool
        Whether the last step was below 0.02 standard deviations.
    """

    model: TrackModel
    point: Point
    theta: FloatArray
    covariance: FloatArray
    information: Information
    weights: FloatArray
    wrong: FloatArray
    log_density: FloatArray
    probability: FloatArray
    mean: FloatArray
    settled: bool

    @property
    def sd(self) -> FloatArray:
        """Posterior standard deviations of the coefficients, shape (P,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def knots(self) -> Knots:
        """Where the coefficients of the biases stand."""
        return self.model.reports.coefficients

    @property
    def biases(self) -> FloatArray:
        """The biases, of those that drift averages over the recording, shape (p,)."""
        return self.knots.averages(self.theta)

    @property
    def over_time(self) -> Biases:
        """The biases (p,), or their paths where some drift."""
        knots = self.knots
        if not knots.drifting:
            return self.theta
        return BiasPaths(knots.time, knots.at(self.theta, knots.time))

    @property
    def bias_covariance(self) -> FloatArray:
        """Covariance of `biases`, shape (p, p)."""
        return self.knots.averaged(self.covariance)

    @property
    def bias_sd(self) -> FloatArray:
        """Standard deviations of `biases`, shape (p,)."""
        return np.asarray(np.sqrt(np.diag(self.bias_covariance)))

    @property
    def target(self) -> IntArray:
        """Identities after refused reports were offered to other targets, shape (n,)."""
        return self.model.reports.target

    @property
    def outlier(self) -> FloatArray:
        """Probability of each report to be noisier than the first Gaussian of its law, (n,)."""
        return np.asarray(1.0 - self.wrong - self.probability[:, 0])

    def state_covariance(self) -> FloatArray:
        """Of the states at each report given the biases, shape (n, size, size); not kept.

        See `add_bias_uncertainty` for that of the biases themselves.
        """
        smoothed = steps.smooth(self.model, self.point, self.theta, covariance=True)
        assert smoothed.covariance is not None
        return smoothed.covariance[self.point.tangent.order]


def fit_tracks(model: TrackModel, offers: int = OFFERS, near: TrackFit | None = None) -> TrackFit:
    """Find the mode of biases, weights, accelerations and laws, the paths integrated out.

    Parameters
    ----------
    model : TrackModel
    offers : int
        How often refused reports are offered to other targets.
    near : TrackFit, optional
        Of some or more of the targets, with the same biases and sensors: its biases and
        acceleration, and its laws if the model has the same, are where the search starts.

    Returns
    -------
    TrackFit
    """
    search = settled(model, *_begin(model, near))
    for _ in range(offers if model.wrong_shares.any() else 0):
        start = start_of(model, search)
        offer = offer_refused(model, search.point, start.path, search.judged, start.theta)
        if offer is None:
            break
        del search  # room for the next
        moved = offer.target != model.reports.target
        model = replace(model, reports=replace(model.reports, target=offer.target))
        search = settled(model, with_offer(start, offer.path, moved), 1)
        del start, offer
    point, theta = search.point, search.solution.theta
    del search
    return _report(model, rest(model, point, theta, SETTLED))


def _begin(model: TrackModel, near: TrackFit | None) -> tuple[Start, int]:
    """Widened noise first, at the reports themselves: near the mode; and how many tangents follow.

    Of very many reports some find the biases, laws and accelerations; the others follow.
    """
    if near is not None:
        known = Solution(near.theta, near.covariance, near.information, np.nan)
        alike = (near.model.laws, near.model.unknown) == (model.laws, model.unknown)
        laws = near.point.laws if alike else model.laws
        point = _near(model, replace(near.point, laws=laws), near.theta)
        return _narrowed(model, point, known), 1
    count = np.bincount(model.reports.target, minlength=len(model.start))
    among = steps.some_targets(count, FIRST_REPORTS)
    if among is None:
        return _narrowed(model, _first(model)), TANGENTS
    part = model.of_targets(among)
    found = settled(part, _narrowed(part, _first(part)), TANGENTS)
    point = _near(model, found.point, found.solution.theta)
    return _narrowed(model, point, found.solution), 1


def _narrowed(model: TrackModel, point: Point, known: Solution | None = None) -> Start:
    """Steps as the noise shrinks to what it is; of the paths alone where biases are known."""
    widened = np.repeat(WIDENED, STEPS_EACH) if known is None else ONLY_PATHS
    for factor in widened:
        search = step(model, point, float(factor), known)
        point = search.point
    return start_of(model, search)


def _first(model: TrackModel) -> Point:
    """The tangent at the reports themselves, with laws as given."""
    tangent, weights = _at_reports(model, model.prior_coefficients)
    spread = np.asarray(model.constant_sd, dtype=float)
    q = (GENEROUS if model.acceleration_log_sd else 1.0) * model.acceleration
    return Point(tangent, weights, q, model.laws, model.wrong_shares, spread)


def _near(model: TrackModel, known: Point, theta: FloatArray) -> Point:
    """The tangent at the reports themselves, with all but paths as known from other targets."""
    tangent, weights = _at_reports(model, theta)
    # those targets may have flown straight: at least as generous as without them
    generous = GENEROUS * max(1.0, model.acceleration / known.q)
    both = (known.wrong > 0.0) & (model.wrong_shares > 0.0)
    return replace(
        known,
        tangent=tangent,
        weights=weights,
        wrong=np.where(both, known.wrong, model.wrong_shares),
        livelier=generous if model.acceleration_log_sd else 1.0,
    )


def _at_reports(model: TrackModel, theta: FloatArray) -> tuple[TrackLinearisation, FloatArray]:
    """A tangent without paths, and weights of no one's trust in particular."""
    assert model.guess is not None
    tangent = model.reports.linearise(theta, model.guess)
    weights = np.full(len(model.reports), WIDENED[0] ** -2.0)
    if model.wrong_shares.any():
        weights[~in_company(model, tangent)] = 0.0
    return tangent, weights


def _report(model: TrackModel, search: Search) -> TrackFit:
    """Everything as the last step found it, in the order of the recording."""
    point, solution, judged = search.before, search.solution, search.judged
    order = point.tangent.order
    return TrackFit(
        model=model,
        point=replace(point, spreads=solution.spreads),
        theta=solution.theta,
        covariance=solution.covariance,
        information=solution.information,
        weights=point.weights[order],
        wrong=judged.wrong[order],
        log_density=judged.log_density[order],
        probability=judged.probability[order],
        mean=search.smoothed.mean[order],
        settled=search.settled,
    )
