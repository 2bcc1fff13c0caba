"""Diagnostics of estimators: bounds, influence, bias and error with their Monte Carlo errors."""

from probreg.diagnostics.bound import cramer_rao_bound, cramer_rao_path
from probreg.diagnostics.influence import empirical_influence, m_influence
from probreg.diagnostics.monte_carlo import Measured, bias, rmse

__all__ = [
    "Measured",
    "bias",
    "cramer_rao_bound",
    "cramer_rao_path",
    "empirical_influence",
    "m_influence",
    "rmse",
]
