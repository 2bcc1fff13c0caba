"""From a recording to biases with honest uncertainty."""

from probreg.registration._held_out import HeldOut
from probreg.registration._laws import LAWS, LawChoice
from probreg.registration._observed import Determined
from probreg.registration._registration import Registration, Verdict
from probreg.registration._run import register
from probreg.registration._terms import RankedTerms, compare_terms

__all__ = [
    "LAWS",
    "Determined",
    "HeldOut",
    "LawChoice",
    "RankedTerms",
    "Registration",
    "Verdict",
    "compare_terms",
    "register",
]
