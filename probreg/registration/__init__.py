"""From a recording to biases with honest uncertainty."""

from probreg.registration._choice import RankedLaw
from probreg.registration._further import further_drifts, further_terms
from probreg.registration._held_out import HeldOut
from probreg.registration._laws import LAWS, LawChoice, known_laws
from probreg.registration._missing import MissingTerm
from probreg.registration._observed import Determined
from probreg.registration._registration import Registration, Verdict
from probreg.registration._run import STEPS, register
from probreg.registration._terms import RankedTerms, compare_setups, compare_terms, with_biases
from probreg.samplers.tracks import BiasDraws

__all__ = [
    "LAWS",
    "STEPS",
    "BiasDraws",
    "Determined",
    "HeldOut",
    "LawChoice",
    "MissingTerm",
    "RankedLaw",
    "RankedTerms",
    "Registration",
    "Verdict",
    "compare_setups",
    "compare_terms",
    "further_drifts",
    "further_terms",
    "known_laws",
    "register",
    "with_biases",
]
