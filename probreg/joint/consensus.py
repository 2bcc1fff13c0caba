"""The bias on which most reports agree: hypotheses scored by re-association."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.association import Objective, assign
from probreg.errors import InvalidInputError, UnobservableError
from probreg.estimators import Estimate, LeastSquares, elemental_subsets, subset_solutions
from probreg.joint._frames import corrected_distances, mahalanobis, require_reports, with_pairs
from probreg.problems.contrast import ReportProblem
from probreg.sensors.reports import SensorReports, pair_up
from probreg.typing import FloatArray, IntArray
from probreg.validation import positive_number


@dataclass(frozen=True)
class Consensus:
    """Score every elemental hypothesis by re-association, refine the best, keep the best.

    Two pairs of a first association just determine the biases; each such hypothesis corrects
    all reports, which are then associated anew: its score is the cost of that association,
    truncated at `score_sigmas`. The `keep` best are refined by association and exact least
    squares in turn while the gate shrinks to `gate_sigmas`. The noise of the sensors, as they
    declare it, must be right: it is what tells agreement from chance.

    Parameters
    ----------
    search_gate : float
        Gate of the first association, metres: above the displacement that biases cause.
    objective : {"cost", "cardinality"}
        Of the first association.
    score_sigmas : float
        Truncation of the scores, standard deviations of a position difference; wide, because a
        hypothesis from two pairs is noisy far from them.
    gate_sigmas : float
        Final gate.
    keep : int
        Hypotheses refined.
    subsets : int
        Random hypotheses tried where there are more than so many.
    """

    search_gate: float = 8_000.0
    objective: Objective = "cost"
    score_sigmas: float = 12.0
    gate_sigmas: float = 5.0
    keep: int = 10
    subsets: int = 500

    def __post_init__(self) -> None:
        for name in ("search_gate", "score_sigmas", "gate_sigmas", "keep", "subsets"):
            positive_number(name, getattr(self, name))
        if self.gate_sigmas > self.score_sigmas:
            raise InvalidInputError("gate_sigmas must not exceed score_sigmas: gates shrink.")

    def estimate(
        self,
        first: SensorReports,
        second: SensorReports,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Least squares on the pairs on which most reports agree.

        A generator is needed where there are more than `subsets` hypotheses. `info`: "pairs",
        "cost" (the truncated cost of the final association, negative, lower is better),
        "hypotheses", and "runner_up" (cost of the next best different association, inf if
        there is none).

        Raises
        ------
        UnobservableError
            No hypothesis leaves enough pairs to determine the biases.
        """
        require_reports(first, second, 2)
        hypotheses = self._hypotheses(first, second, rng)
        d2 = mahalanobis(first, second, hypotheses)
        costs = np.array([_cost(each, self.score_sigmas) for each in d2])
        refined: dict[bytes, tuple[float, Estimate, IntArray]] = {}
        fits: dict[bytes, Estimate] = {}
        for k in np.argsort(costs, kind="stable")[: self.keep]:
            found = self._refine(first, second, hypotheses[k], fits)
            if found is not None:
                refined.setdefault(found[2].tobytes(), found)
        if not refined:
            raise UnobservableError(
                "no bias makes enough reports agree. Widen search_gate or gate_sigmas, check the "
                "declared accuracies, or join several frames."
            )
        best, *others = sorted(refined.values(), key=lambda each: each[0])
        runner_up = others[0][0] if others else np.inf
        return with_pairs(
            best[1], best[2], cost=best[0], hypotheses=len(hypotheses), runner_up=runner_up
        )

    def _hypotheses(
        self, first: SensorReports, second: SensorReports, rng: np.random.Generator | None
    ) -> FloatArray:
        zero = np.zeros(len(first.sensor.bias_names) + len(second.sensor.bias_names))
        raw = corrected_distances(first, second, zero)
        pairs = assign(raw, self.search_gate, self.objective)
        if len(pairs) < 2:
            raise InvalidInputError(
                f"{len(pairs)} pair(s) inside the search gate of {self.search_gate:g} m; widen it, "
                "or check that the sensors share a frame and targets."
            )
        rows = ReportProblem(pair_up(first, second, pairs)).one_shot().whitened()
        found = subset_solutions(rows, elemental_subsets(rows, self.subsets, rng))
        return found[np.isfinite(found).all(axis=1)]

    def _refine(
        self,
        first: SensorReports,
        second: SensorReports,
        theta: FloatArray,
        fits: dict[bytes, Estimate],
    ) -> tuple[float, Estimate, IntArray] | None:
        """Associate and fit while the gate shrinks, then until the pairs rest."""
        gate, last = self.score_sigmas, None
        for _ in range(40):
            d2 = mahalanobis(first, second, theta)
            pairs = assign(d2, gate)
            if last is not None and gate == self.gate_sigmas and np.array_equal(pairs, last):
                return _cost(d2, gate), fits[pairs.tobytes()], pairs
            key = pairs.tobytes()
            if key not in fits:
                try:
                    problem = ReportProblem(pair_up(first, second, pairs))
                    fits[key] = LeastSquares().estimate(problem)
                except (InvalidInputError, UnobservableError):
                    return None  # too few pairs agree with this hypothesis
            theta, last = fits[key].theta, pairs
            gate = max(self.gate_sigmas, 0.6 * gate)
        return None


def _cost(d2: FloatArray, gate: float) -> float:
    """Sum of d^2 - gate^2 over the best pairs, in units of gate^2: minus the pairs, at least."""
    pairs = assign(d2, gate)
    return float((d2[pairs[:, 0], pairs[:, 1]] / gate**2 - 1.0).sum())
