"""Estimators, one method a module, each a frozen dataclass of its settings."""

from probreg.estimators._estimate import Estimate, Estimator
from probreg.estimators._subsets import elemental_subsets, required_subsets, subset_solutions
from probreg.estimators.extended_kalman import ExtendedKalman
from probreg.estimators.irls import Irls
from probreg.estimators.least_squares import LeastSquares
from probreg.estimators.lines_of_sight import LinesOfSight
from probreg.estimators.lms import Lms
from probreg.estimators.lts import Lts
from probreg.estimators.mm import Mm
from probreg.estimators.recursive import Recursive
from probreg.estimators.recursive_tls import RecursiveTls
from probreg.estimators.reweighted_least_squares import ReweightedLeastSquares
from probreg.estimators.total_least_squares import TotalLeastSquares

__all__ = [
    "Estimate",
    "Estimator",
    "ExtendedKalman",
    "Irls",
    "LeastSquares",
    "LinesOfSight",
    "Lms",
    "Lts",
    "Mm",
    "Recursive",
    "RecursiveTls",
    "ReweightedLeastSquares",
    "TotalLeastSquares",
    "elemental_subsets",
    "required_subsets",
    "subset_solutions",
]
