"""The track model of a recording under a noise law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise import Contaminated, NoiseLaw, ScaleMixture
from probreg.posterior.tracks import TrackModel
from probreg.prior import GaussianPrior
from probreg.problems.recording import RecordingProblem
from probreg.problems.recording.track_reports import TrackReports
from probreg.recordings import TARGET_HEIGHT_M
from probreg.registration._laws import LawChoice

WRONG_SHARE = 0.05  # of reports that are of another target, expected; ten reports outweigh it
CAUTION = 81.0  # times the acceleration found, for the biases: see `TrackModel`
BESIDE = LawChoice.usual(Contaminated())  # of reports that come with others
START_M, CLIMB_M_S = 100_000.0, 50.0  # about where a target is first seen


def track_model(problem: RecordingProblem, choice: LawChoice) -> TrackModel:
    """Reports of tracks with the setup's priors, every sensor's noise under a law.

    Raises
    ------
    InvalidInputError
        A law that is no sum of Gaussians over whole reports; a target that nothing places.
    """
    setup, reports = problem.setup, problem.reports
    laws, unknown = _of_sensors(choice, reports)
    _, sd = setup.target_height or TARGET_HEIGHT_M
    return TrackModel(
        reports,
        GaussianPrior.from_sd(problem.prior_sd),
        laws,
        unknown,
        acceleration=setup.acceleration_m_s2**2,
        caution=CAUTION,
        wrong_share=WRONG_SHARE if len(problem.owner) > 1 else 0.0,
        area_m2=problem.area_m2,
        start_sd=(START_M, sd, setup.max_speed_m_s, CLIMB_M_S),
        constant_sd=tuple(problem.constants.values()),
        constant_known=tuple(name in problem.known_constants for name in problem.constants),
        guess=problem.guess,
        drifts=tuple(problem.model.drifts.values()),
    )


def under(model: TrackModel, choice: LawChoice) -> TrackModel:
    """The same reports and priors under another law."""
    laws, unknown = _of_sensors(choice, model.reports)
    return replace(model, laws=laws, unknown=unknown)


def _of_sensors(
    choice: LawChoice, reports: TrackReports
) -> tuple[tuple[ScaleMixture, ...], tuple[frozenset[str], ...]]:
    """The law chosen for reports that stand alone; heights in steps have outliers of their own."""
    chosen = [BESIDE if apart else choice for apart in comes_along(reports)]
    laws = tuple(require_mixture(one.law) for one in chosen)
    return laws, tuple(frozenset(p.name for p in one.unknown) for one in chosen)


def comes_along(reports: TrackReports) -> list[bool]:
    """Which sensor models are of reports that come with others."""
    if reports.beside is None:
        return [False] * len(reports.models)
    along = reports.beside != np.arange(len(reports))
    return [bool(along[reports.sensor == k].any()) for k in range(len(reports.models))]


def require_mixture(law: NoiseLaw) -> ScaleMixture:
    """Refuse laws that tracks cannot take.

    Raises
    ------
    InvalidInputError
        With the laws to take instead.
    """
    fine = isinstance(law, ScaleMixture) and law.scale_mixture and not law.componentwise
    if not fine:
        raise InvalidInputError(
            f"the law {type(law).__name__} is no sum of Gaussians over whole reports, which tracks "
            "need; take Contaminated, StudentT, Hyperbolic or Gaussian."
        )
    assert isinstance(law, ScaleMixture)
    return law
