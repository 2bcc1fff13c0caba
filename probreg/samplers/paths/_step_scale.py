"""How strongly the states drift, where nobody knows it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.trajectory import Filtered, Trajectory
from probreg.typing import FloatArray
from probreg.validation import positive_number

_MAX_WIDENINGS = 50
_MAX_SHRINKS = 200


@dataclass(frozen=True)
class StepScale:
    """An unknown factor on the process noise of some states, with a log-normal prior.

    Parameters
    ----------
    states : tuple of str
        Names of the states whose noise it multiplies, in standard deviation.
    median : float
        Prior median of the factor: 1 trusts the trajectory's own Q.
    spread : float
        Prior standard deviation of its logarithm: 1 is about a factor of three either way.

    Raises
    ------
    InvalidInputError
        A median or spread that is not above zero.
    """

    states: tuple[str, ...]
    median: float = 1.0
    spread: float = 1.0

    def __post_init__(self) -> None:
        positive_number("median of StepScale", self.median)
        positive_number("spread of StepScale", self.spread)

    def log_prior(self, log_factor: float) -> float:
        """Log-density of the logarithm, up to a constant."""
        return -0.5 * ((log_factor - np.log(self.median)) / self.spread) ** 2

    def spots(self, model: Trajectory) -> FloatArray:
        """1 for the states it acts on, shape (d,).

        Raises
        ------
        InvalidInputError
            A state that is not there, or that no process noise moves.
        """
        found = np.array([float(name in self.states) for name in model.names])
        strange = set(self.states) - set(model.names)
        if strange or not self.states:
            raise InvalidInputError(f"no state {sorted(strange)}; there are {model.names}.")
        if not np.einsum("tdd,d->", model.Q, found) > 0.0:
            raise InvalidInputError(
                f"{self.states} have no process noise to scale: give Q a first guess above zero."
            )
        return found


def redraw(
    model: Trajectory,
    weights: FloatArray,
    scales: tuple[StepScale, ...],
    log_factors: FloatArray,
    rng: np.random.Generator,
) -> Filtered:
    """Slice-sample every log factor (k,) in place, the path integrated out; the last filter."""
    spots = np.array([scale.spots(model) for scale in scales])

    def look(values: FloatArray) -> tuple[Filtered, float]:
        filtered = model.filter(weights, np.exp(values @ spots))
        prior = sum(s.log_prior(value) for s, value in zip(scales, values, strict=True))
        return filtered, filtered.log_likelihood + prior

    filtered, height = look(log_factors)
    for k, scale in enumerate(scales):
        level = height - rng.exponential()
        low, high = _bracket(look, log_factors, k, scale.spread, level, rng)
        for _ in range(_MAX_SHRINKS):
            value = rng.uniform(low, high)
            trial = log_factors.copy()
            trial[k] = value
            filtered, height = look(trial)
            if height >= level:
                log_factors[k] = value
                break
            low, high = (value, high) if value < log_factors[k] else (low, value)
        else:
            raise InvalidInputError(
                f"the factor of {scale.states} cannot be drawn: its density is too rough."
            )
    return filtered


def _bracket(
    look: object, at: FloatArray, k: int, width: float, level: float, rng: np.random.Generator
) -> tuple[float, float]:
    """Ends outside the slice, by stepping out (Neal 2003)."""
    assert callable(look)

    def outside(value: float) -> bool:
        trial = at.copy()
        trial[k] = value
        return bool(look(trial)[1] < level)

    low = at[k] - width * rng.random()
    high = low + width
    for _ in range(_MAX_WIDENINGS):
        if outside(low):
            break
        low -= width
    for _ in range(_MAX_WIDENINGS):
        if outside(high):
            break
        high += width
    return low, high
