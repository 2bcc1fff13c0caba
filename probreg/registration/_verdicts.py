"""Which reports are outliers, and which biases exceed their limits."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from probreg.noise import Contaminated
from probreg.posterior.tracks import TrackFit, fit_tracks, judge, smooth
from probreg.registration._choice import LAW_REPORTS, Chosen
from probreg.registration._identities import Identified, of_some
from probreg.registration._laws import LawChoice
from probreg.registration._posterior import Fitted
from probreg.registration._registration import Verdict
from probreg.registration._track_model import under
from probreg.samplers.tracks import BiasDraws
from probreg.typing import FloatArray


class Judged(NamedTuple):
    """Reports and biases, each with the probability that speaks against it.

    Attributes
    ----------
    outlier_probability : ndarray, shape (reports of the problem,)
        That a report is noisier than its sensor usually is.
    verdicts : tuple of Verdict
    """

    outlier_probability: FloatArray
    verdicts: tuple[Verdict, ...]


def judge_reports(known: Identified, chosen: Chosen, fitted: Fitted) -> Judged:
    """Judge reports under the contaminated law, which marks outliers, whichever law was chosen."""
    model = known.problem.model
    found = []
    for name, limit in known.problem.setup.limits.items():
        exceeds = _exceeds(fitted.draws, model.numbers[name], limit)
        found.append(Verdict(name=name, limit=float(limit), probability=exceeds))
    return Judged(_outliers(known, chosen, fitted.fit), tuple(found))


def _exceeds(draws: BiasDraws, number: int, limit: float) -> float:
    """Probability that a bias is beyond its limit; of one that drifts at the worst time."""
    paths = draws.paths
    if paths is None or number not in paths.number:
        return float((np.abs(draws.flat[:, number]) > limit).mean())
    path = paths.flat[..., paths.number.index(number)]
    return float((np.abs(path) > limit).mean(axis=0).max())


def _outliers(known: Identified, chosen: Chosen, fit: TrackFit) -> FloatArray:
    if all(isinstance(law, Contaminated) for law in fit.point.laws):
        return fit.outlier
    name = Contaminated.__name__
    some = chosen.fits.get(name)
    if some is None:
        some = fit_tracks(of_some(under(known.model, LawChoice.usual(Contaminated())), LAW_REPORTS))
    point = replace(fit.point, laws=some.point.laws, wrong=some.point.wrong)
    model = replace(fit.model, laws=some.model.laws, unknown=some.model.unknown)
    judged = judge(model, point, smooth(model, point, fit.theta))
    spoilt = 1.0 - judged.wrong - judged.probability[:, 0]
    return np.asarray(spoilt[point.tangent.order])
