"""Diagnostics of estimators: bounds, bias and error with their Monte Carlo errors."""

from probreg.diagnostics.bound import cramer_rao_bound
from probreg.diagnostics.monte_carlo import Measured, bias, rmse

__all__ = ["Measured", "bias", "cramer_rao_bound", "rmse"]
