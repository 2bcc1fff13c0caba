"""The only place that knows ArviZ: its versions before and after 1.0 differ silently."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray

MIN_DRAWS = 4  # per chain, below which split chains cannot be compared
Groups = Mapping[str, Mapping[str, FloatArray]]


class Convergence(NamedTuple):
    """Diagnostics of each parameter, arrays of shape (d,)."""

    r_hat: FloatArray
    ess_bulk: FloatArray
    ess_tail: FloatArray
    mcse_mean: FloatArray


class LeaveOneOut(NamedTuple):
    """Expected log predictive density by leave-one-out.

    Attributes
    ----------
    elpd : float
        Sum over rows.
    standard_error : float
    pointwise : ndarray, shape (n,)
    pareto_k : ndarray, shape (n,)
        Above 0.7 the row's term is not to be trusted.
    """

    elpd: float
    standard_error: float
    pointwise: FloatArray
    pareto_k: FloatArray


def _arviz() -> Any:
    """ArviZ, which announces its next version when it loads."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)
        import arviz
    return arviz


def is_new() -> bool:
    """Whether the installed ArviZ is 1.0 or later."""
    arviz = _arviz()

    return int(arviz.__version__.split(".")[0]) >= 1


def convergence(theta: FloatArray) -> Convergence:
    """R-hat, bulk and tail effective sample size, Monte-Carlo error of draws (chain, draw, d).

    Raises
    ------
    InvalidInputError
        Too few draws to compare the halves of chains.
    """
    arviz = _arviz()

    _require_draws(theta)
    found = []
    for k in range(theta.shape[2]):
        x = np.ascontiguousarray(theta[:, :, k])
        with np.errstate(invalid="ignore", divide="ignore"):  # chains that never moved
            tail = arviz.ess(x, method="tail", prob=(0.05, 0.95))
            r_hat = arviz.rhat(x) if len(x) > 1 else np.nan  # of one chain ArviZ only complains
            values = r_hat, arviz.ess(x, method="bulk"), tail, arviz.mcse(x, method="mean")
        found.append([float(np.ravel(value)[0]) for value in values])
    return Convergence(*np.array(found).T)


def ess(x: FloatArray, method: str = "bulk") -> float:
    """Effective sample size of one quantity (chain, draw), "bulk" or "mean"."""
    arviz = _arviz()

    _require_draws(x[..., None])
    return float(np.ravel(arviz.ess(np.ascontiguousarray(x), method=method))[0])


def smooth_weights(log_ratios: FloatArray) -> tuple[FloatArray, float]:
    """Pareto-smooth importance log-ratios (k,): normalised log-weights and the Pareto k."""
    shifted = log_ratios - log_ratios.max()
    with np.errstate(over="ignore", under="ignore"):  # light tails overflow inside, harmlessly
        if is_new():
            from arviz_stats.base import array_stats

            smoothed, k = array_stats.psislw(-shifted)  # takes minus the log weights
        else:
            arviz = _arviz()

            smoothed, k = arviz.psislw(shifted)
    smoothed = np.asarray(smoothed, dtype=float)
    return smoothed - np.logaddexp.reduce(smoothed), float(k)


def inference_data(
    groups: Groups,
    coords: Mapping[str, Any],
    dims: Mapping[str, list[str]],
    attrs: Mapping[str, Any],
) -> Any:
    """InferenceData (before 1.0) or DataTree of groups of arrays (chain, draw, ...)."""
    arviz = _arviz()

    if is_new():
        data = arviz.from_dict(
            {name: dict(group) for name, group in groups.items()},
            coords=dict(coords),
            dims=dict(dims),
            attrs={name: dict(attrs) for name in groups},
        )
    else:
        named: dict[str, Any] = {name: dict(group) for name, group in groups.items()}
        data = arviz.from_dict(**named, coords=dict(coords), dims=dict(dims))
        for name in groups:
            data[name].attrs.update(attrs)
    return data


def leave_one_out(log_likelihood: FloatArray) -> LeaveOneOut:
    """PSIS-LOO from the log-likelihood of every row, shape (chain, draw, n)."""
    arviz = _arviz()

    _require_draws(log_likelihood)
    draws = {"x": np.zeros(log_likelihood.shape[:2])}
    groups: Groups = {"posterior": draws, "log_likelihood": {"y": log_likelihood}}
    data = inference_data(groups, {}, {"y": ["row"]}, {})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # bad rows are counted by the caller
        found = arviz.loo(data, pointwise=True)
    if is_new():
        elpd, se, pointwise = found.elpd, found.se, found.elpd_i
    else:
        elpd, se, pointwise = found.elpd_loo, found.se, found.loo_i
    terms, k = np.ravel(np.asarray(pointwise)), np.ravel(np.asarray(found.pareto_k))
    return LeaveOneOut(float(elpd), float(se), terms, k)


def _require_draws(theta: FloatArray) -> None:
    if theta.ndim != 3 or theta.shape[1] < MIN_DRAWS:
        raise InvalidInputError(
            f"draws of shape {theta.shape[:2]} (chains, draws) are too few for this diagnostic: "
            f"at least {MIN_DRAWS} draws a chain are needed. Set num_draws higher."
        )
