"""Which noise law the reports follow, by leave-one-out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.posterior.tracks import TrackFit, TrackModel, fit_tracks
from probreg.registration._identities import of_some
from probreg.registration._laws import LawChoice
from probreg.registration._track_model import comes_along, under
from probreg.typing import FloatArray, IntArray

LAW_REPORTS = 4_000  # for the comparison of laws
# on Gaussian reports Student's t seems ahead by .01 a report: weights of a report's neighbours
# have seen the report
FLATTERY = 0.02


class RankedLaw(NamedTuple):
    """A noise law's place among those compared.

    Attributes
    ----------
    name : str
    elpd : float
        Log density of every report given all others, summed; NaN of a law without rivals.
    behind : float
        How far below the best.
    standard_error : float
        Of `behind`, from the targets' differences; 0 for the best.
    """

    name: str
    elpd: float
    behind: float
    standard_error: float


class Chosen(NamedTuple):
    """The law chosen, and the competition.

    Attributes
    ----------
    choice : LawChoice
    ranked : tuple of RankedLaw
        Best first.
    fits : dict of str to TrackFit
        Of some targets, by law.
    reports : int
        That the comparison is of.
    notes : tuple of str
    """

    choice: LawChoice
    ranked: tuple[RankedLaw, ...]
    fits: dict[str, TrackFit]
    reports: int
    notes: tuple[str, ...]


def choose(model: TrackModel, laws: Sequence[LawChoice]) -> Chosen:
    """Rank laws on some targets, and take the first of those given that is as good as the best.

    As good: within the standard error of the difference, and what weights flatter.

    Raises
    ------
    InvalidInputError
        No law, a name twice, or none of them can be fitted.
    """
    by_name = {choice.name: choice for choice in laws}
    if not laws or len(by_name) < len(laws):
        raise InvalidInputError(f"laws must be different, one at least: {[c.name for c in laws]}.")
    if len(laws) == 1:
        under(model, laws[0])
        return Chosen(laws[0], (RankedLaw(laws[0].name, np.nan, 0.0, 0.0),), {}, 0, ())
    fits: dict[str, TrackFit] = {}
    some, notes = of_some(model, LAW_REPORTS), []
    for name, choice in by_name.items():
        try:
            before = next(iter(fits.values()), None)
            fits[name] = fit_tracks(under(some, choice), near=before)
        except InvalidInputError as error:
            notes.append(f"the law {name} could not be fitted and is left out: {error}")
    if not fits:
        raise InvalidInputError("no noise law could be fitted: " + " ".join(notes))
    # heights beside plots have a law of their own whichever is chosen
    along = np.array(comes_along(some.reports))
    alone = np.flatnonzero(~along[some.reports.sensor])
    scores = {name: fit.log_density[alone] for name, fit in fits.items()}
    ranked = _ranked(scores, some.reports.target[alone])
    slack = FLATTERY * len(alone)
    good = {law.name for law in ranked if law.behind <= law.standard_error + slack}
    choice = next(by_name[name] for name in by_name if name in good)
    return Chosen(choice, tuple(ranked), fits, len(alone), tuple(notes))


def _ranked(scores: dict[str, FloatArray], target: IntArray) -> list[RankedLaw]:
    order = sorted(scores, key=lambda name: -float(scores[name].sum()))
    best = scores[order[0]]
    ranked = []
    for name in order:
        gap = np.bincount(target, best - scores[name])
        error = float(np.sqrt(gap.size * np.var(gap))) if name != order[0] else 0.0
        ranked.append(RankedLaw(name, float(scores[name].sum()), float(gap.sum()), error))
    return ranked
