"""The mode of a track posterior: biases with weights, identities, accelerations and laws."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np

from probreg.motion.tracks import BiasInformation, SmoothedTracks
from probreg.posterior.tracks import steps
from probreg.posterior.tracks._company import in_company
from probreg.posterior.tracks._offers import offer_refused
from probreg.posterior.tracks.accelerations import fit_acceleration
from probreg.posterior.tracks.cavity import Judgement
from probreg.posterior.tracks.model import TrackModel
from probreg.posterior.tracks.steps import Point, Solution
from probreg.problems.recording.track_reports import PathPoints
from probreg.typing import FloatArray, IntArray

WIDENED = (30.0, 10.0, 3.0, 1.0)  # noise at first, so that no report is refused too early
STEPS_EACH = 2
FIRST_REPORTS = 8_000  # enough to come near the mode of many
ONLY_PATHS = (10.0, 1.0)  # where biases and laws are known from some of the targets
GENEROUS = 9.0  # acceleration at first, over the prior's: weights of zero absorb
SETTLED = 0.02  # posterior standard deviations of a last step,
NEARLY = 0.3  # and of one after which tangent or identities change
MOST_STEPS = 30
TANGENTS = 2  # at smoothed paths; the first is at the reports themselves
OFFERS = 2
LONE_WEIGHT = 1e-5


@dataclass(frozen=True, eq=False)
class TrackFit:
    """Biases, paths and reports at the mode; arrays of reports in the order of the recording.

    Attributes
    ----------
    model : TrackModel
        Its reports under their last identities: refused ones may have found another target.
    point : Point
        Tangent, weights, accelerations, laws and shares at the mode.
    theta : ndarray, shape (p,)
    covariance : ndarray, shape (p, p)
        Of the biases given the weights; paths integrated out.
    information : BiasInformation
        By target, of the biases from those of the tangent.
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
    information: BiasInformation
    weights: FloatArray
    wrong: FloatArray
    log_density: FloatArray
    probability: FloatArray
    mean: FloatArray
    settled: bool

    @property
    def sd(self) -> FloatArray:
        """Posterior standard deviations of the biases, shape (p,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

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


def fit_tracks(model: TrackModel, offers: int = OFFERS) -> TrackFit:
    """Find the mode of biases, weights, accelerations and laws, the paths integrated out.

    Parameters
    ----------
    model : TrackModel
    offers : int
        How often refused reports are offered to other targets.

    Returns
    -------
    TrackFit
    """
    search = _settled(model, *_begin(model))
    for _ in range(offers if model.wrong_shares.any() else 0):
        start = _start_of(search)
        offer = offer_refused(model, search.point, start.path, search.judged, start.theta)
        if offer is None:
            break
        del search  # room for the next
        model = replace(model, reports=replace(model.reports, target=offer.target))
        search = _settled(model, start._replace(path=offer.path), 1)
        del start, offer
    point, theta = search.point, search.solution.theta
    del search
    return _report(model, _rest(model, point, theta, SETTLED))


class _Start(NamedTuple):
    """Where to linearise next: all but a tangent, arrays in the order of the recording."""

    theta: FloatArray
    path: PathPoints
    weights: FloatArray
    rest: dict[str, Any]

    def point(self, model: TrackModel) -> Point:
        """With the tangent there."""
        tangent = model.reports.linearise(self.theta, self.path)
        return Point(tangent, self.weights[tangent.rows], **self.rest)


class _Search(NamedTuple):
    """Where a search stands: the point after a step, that before it, and what was found there."""

    point: Point
    before: Point
    solution: Solution
    smoothed: SmoothedTracks
    judged: Judgement
    settled: bool = False


def _start_of(search: _Search) -> _Start:
    """From the paths that a step has found."""
    point = search.point
    names = [f.name for f in fields(Point) if f.name not in ("tangent", "weights")]
    return _Start(
        search.solution.theta,
        point.tangent.path(search.smoothed.mean),
        point.weights[point.tangent.order],
        {name: getattr(point, name) for name in names},
    )


def _begin(model: TrackModel) -> tuple[_Start, int]:
    """Widened noise first, at the reports themselves: near the mode; and how many tangents follow.

    Of very many reports some find the biases, laws and accelerations; the others follow.
    """
    count = np.bincount(model.reports.target, minlength=len(model.start))
    among = steps.some_targets(count, FIRST_REPORTS)
    if among is None:
        return _narrowed(model, _first(model), WIDENED, STEPS_EACH), TANGENTS
    part = model.of_targets(among)
    start = _narrowed(part, _first(part), WIDENED, STEPS_EACH)
    found = _settled(part, start, TANGENTS)
    return _narrowed(model, _first(model, found), ONLY_PATHS, 1, found.solution), 1


def _narrowed(
    model: TrackModel,
    point: Point,
    widened: tuple[float, ...],
    each: int,
    known: Solution | None = None,
) -> _Start:
    """Steps as the noise shrinks to what it is."""
    for factor in widened:
        for _ in range(each):
            search = _step(model, point, factor, known)
            point = search.point
    return _start_of(search)


def _first(model: TrackModel, known: _Search | None = None) -> Point:
    """The tangent at the reports themselves, with laws as given or as known from some."""
    assert model.guess is not None
    theta = model.prior.mean if known is None else known.solution.theta
    tangent = model.reports.linearise(theta, model.guess)
    weights = np.full(len(model.reports), WIDENED[0] ** -2.0)
    if model.wrong_shares.any():
        weights[~in_company(model, tangent)] = 0.0
    generous = GENEROUS if model.acceleration_log_sd else 1.0
    if known is not None:
        return replace(known.point, tangent=tangent, weights=weights, livelier=generous)
    spread = np.asarray(model.constant_sd, dtype=float)
    q = generous * model.acceleration
    return Point(tangent, weights, q, model.laws, model.wrong_shares, spread)


def _step(
    model: TrackModel, point: Point, widened: float = 1.0, known: Solution | None = None
) -> _Search:
    """Biases unless known, paths, weights; the laws' parameters too if the noise is as it is."""
    solution = steps.solve(model, point) if known is None else known
    constants = model.reports.num_constants > 0
    smoothed = steps.smooth(model, point, solution.theta, covariance=constants)
    judged = steps.judge(model, point, smoothed, widened)
    after = point
    if widened == 1.0 and known is None:
        after = steps.refit(model, point, judged)
        after = steps.refit_constants(model, after, smoothed)
    # reports that no other places must not agree on a path of their own, nor be lost for ever
    lone = np.minimum(judged.weight, LONE_WEIGHT)
    weights = np.where(judged.placed, judged.weight, lone)
    return _Search(replace(after, weights=weights), point, solution, smoothed, judged)


def _settled(model: TrackModel, start: _Start, tangents: int) -> _Search:
    """Steps to near rest at the tangent at a path, and again at the paths found there."""
    for again in range(tangents):
        point = fit_acceleration(model, start.point(model), start.theta)
        search = _rest(model, point, start.theta, NEARLY)
        del point
        if again + 1 < tangents:
            start = _start_of(search)
            del search  # room for the next
    return search


def _rest(model: TrackModel, point: Point, theta: FloatArray, least: float) -> _Search:
    """Steps until the biases stay where they are."""
    for _ in range(MOST_STEPS - 1):
        search = _step(model, point)
        away = np.abs(search.solution.theta - theta)
        if np.all(away < least * np.sqrt(np.diag(search.solution.covariance))):
            return search._replace(settled=True)
        point, theta = search.point, search.solution.theta
        del search  # room for the next
    return _step(model, point)


def _report(model: TrackModel, search: _Search) -> TrackFit:
    """Everything as the last step found it, in the order of the recording."""
    point, solution, judged = search.before, search.solution, search.judged
    order = point.tangent.order
    return TrackFit(
        model=model,
        point=point,
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
