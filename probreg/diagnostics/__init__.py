"""Diagnostics: bounds, influence, calibration, coverage, comparison of noise laws."""

from probreg.diagnostics.bound import cramer_rao_bound, cramer_rao_path
from probreg.diagnostics.coverage import Coverage, binomial_limits, coverage, normal_interval
from probreg.diagnostics.influence import empirical_influence, m_influence
from probreg.diagnostics.model_comparison import (
    Ranked,
    compare_laws,
    leave_one_out,
    outlier_probability,
)
from probreg.diagnostics.monte_carlo import Measured, bias, rmse
from probreg.diagnostics.sbc import Case, Ranks, calibrate, rank_truth

__all__ = [
    "Case",
    "Coverage",
    "Measured",
    "Ranked",
    "Ranks",
    "bias",
    "binomial_limits",
    "calibrate",
    "compare_laws",
    "coverage",
    "cramer_rao_bound",
    "cramer_rao_path",
    "empirical_influence",
    "leave_one_out",
    "m_influence",
    "normal_interval",
    "outlier_probability",
    "rank_truth",
    "rmse",
]
