"""The unknowns of a setup: terms of each sensor, and where they stand in theta."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings._setup import Setup
from probreg.sensors.drifts import Drift, known_drifts
from probreg.sensors.terms import Term, known_terms
from probreg.typing import FloatArray, IntArray

DRIFT_SHARE = 0.1  # of the prior standard deviation: prior median of how far a bias drifts


@dataclass(frozen=True, eq=False)
class BiasModel:
    """Terms by sensor, and the unknowns that they are multiplied by.

    Attributes
    ----------
    terms : tuple of tuple of Term
        Of each sensor.
    columns : tuple of ndarray of int
        For each sensor the numbers of its terms' coefficients in theta.
    names, units : tuple of str
    prior_sd : ndarray, shape (p,)
    numbers : mapping of str to int
        Of each name in theta; also of "sensor.term" where sensors share a coefficient.
    drifts : mapping of int to (Drift, float)
        Of each bias that drifts how it moves, and the prior median of its spread, SI units.
    """

    terms: tuple[tuple[Term, ...], ...]
    columns: tuple[IntArray, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    prior_sd: FloatArray
    numbers: Mapping[str, int]
    drifts: Mapping[int, tuple[Drift, float]] = field(default_factory=dict)

    @property
    def clocks(self) -> bool:
        """Whether a time stamp is in question."""
        return any(term.stamp for own in self.terms for term in own)

    def delay(self, sensor: int, theta: FloatArray) -> FloatArray:
        """What to take from the time stamps of a sensor, seconds, for biases (p,) or (p, n)."""
        stamps = [term.stamp for term in self.terms[sensor]]
        return np.asarray(np.dot(stamps, theta[self.columns[sensor]]))


def bias_model(setup: Setup) -> BiasModel:
    """The unknowns that a setup asks for.

    Raises
    ------
    InvalidInputError
        No unknown; a term that a sensor cannot have; a prior or a limit of an unknown that is
        not there.
    """
    numbers: dict[str, int] = {}
    aliases: dict[str, int] = {}
    units: list[str] = []
    spreads: list[float] = []
    terms, columns = [], []
    for sensor in setup.sensors:
        known, own, where = known_terms(sensor), [], []
        for name in setup.biases.get(sensor.name, ()):
            if name not in known or (name == "heading" and sensor.name not in setup.body_frame):
                raise InvalidInputError(
                    f"sensor {sensor.name!r} has no bias {name!r}; it can have "
                    f"{', '.join(sorted(known))} (heading only with body_frame)."
                )
            term = known[name]
            full = f"{term.owner}.{name}"
            if full not in numbers:
                numbers[full] = len(numbers)
                units.append(term.unit)
                spreads.append(setup.prior_sd.get(full, term.prior_sd))
            alias = f"{sensor.name}.{name}"  # what a file calls a coefficient that sensors share
            spreads[numbers[full]] = setup.prior_sd.get(alias, spreads[numbers[full]])
            aliases[alias] = numbers[full]
            own.append(term)
            where.append(numbers[full])
        terms.append(tuple(own))
        columns.append(np.array(where, dtype=np.int64))
    _require_known(setup, numbers, aliases)
    return BiasModel(
        tuple(terms),
        tuple(columns),
        tuple(numbers),
        tuple(units),
        np.array(spreads, dtype=float),
        aliases | numbers,
        _drifts(setup, aliases | numbers, spreads),
    )


def _require_known(setup: Setup, numbers: Mapping[str, int], aliases: Mapping[str, int]) -> None:
    asked = set(setup.prior_sd) | set(setup.limits) | set(setup.drift)
    strange = sorted(asked - set(numbers) - set(aliases))
    if not numbers or strange:
        what = f"prior_sd, limits or drift of {strange}" if numbers else "no bias to estimate"
        raise InvalidInputError(
            f"{what}; the setup's biases are {', '.join(numbers) or 'empty: name some'}."
        )


def _drifts(
    setup: Setup, numbers: Mapping[str, int], prior_sd: list[float]
) -> dict[int, tuple[Drift, float]]:
    """How biases drift, in the order of theta."""
    found = {}
    for name, kind in setup.drift.items():
        k = numbers[name]
        spread = setup.drift_sd.get(name, DRIFT_SHARE * prior_sd[k])
        found[k] = known_drifts()[kind], float(spread)
    return dict(sorted(found.items()))
