"""Estimators, one method a module, each a frozen dataclass of its settings."""

from probreg.estimators._estimate import Estimate, Estimator
from probreg.estimators.irls import Irls
from probreg.estimators.least_squares import LeastSquares
from probreg.estimators.lms import Lms
from probreg.estimators.recursive import Recursive

__all__ = ["Estimate", "Estimator", "Irls", "LeastSquares", "Lms", "Recursive"]
