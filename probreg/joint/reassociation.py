"""Debias, associate, estimate, until the pairs are stable."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from probreg.association import Objective, assign
from probreg.errors import InvalidInputError, UnobservableError
from probreg.estimators import Estimate, Estimator, ReweightedLeastSquares
from probreg.joint._frames import corrected_distances, require_reports, with_pairs
from probreg.problems.contrast import ReportProblem
from probreg.sensors.reports import SensorReports, pair_up
from probreg.typing import FloatArray, IntArray
from probreg.validation import positive_number


@dataclass(frozen=True)
class Reassociation:
    """Alternate between global nearest neighbour and a robust estimate.

    The first association is of the raw reports; each later one of reports corrected by the
    last estimate, with the gate shrunk towards `last_gate`.

    Parameters
    ----------
    gate : float
        First gate, metres: above the displacement that the biases cause.
    last_gate : float
        Smallest gate, metres: a few standard deviations of a position difference.
    shrink : float
        Factor on the gate from round to round.
    estimator : Estimator
        Applied to the re-linearised problem of the paired reports.
    objective : {"cost", "cardinality"}
        As in `association.nearest_neighbours`.
    max_rounds : int
    """

    gate: float = 8_000.0
    last_gate: float = 1_000.0
    shrink: float = 0.5
    estimator: Estimator = field(default_factory=ReweightedLeastSquares)
    objective: Objective = "cost"
    max_rounds: int = 30

    def __post_init__(self) -> None:
        positive_number("gate", self.gate)
        positive_number("last_gate", self.last_gate)
        positive_number("shrink", self.shrink)
        if self.max_rounds < 1:
            raise InvalidInputError(f"max_rounds is {self.max_rounds}; at least one is needed.")

    def estimate(
        self,
        first: SensorReports,
        second: SensorReports,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Run to stable pairs; the generator is passed to the estimator.

        `info`: "pairs" and "rounds". `converged` is False where the pairs still changed at the
        last round, or where an estimate left too few pairs to go on from: the one before it is
        then returned.
        """
        require_reports(first, second, 2)
        theta: FloatArray = np.zeros(len(first.sensor.bias_names) + len(second.sensor.bias_names))
        pairs: IntArray = np.empty((0, 2), dtype=int)
        gate, rounds, stable = self.gate, 0, False
        history: list[tuple[Estimate, IntArray]] = []
        while rounds < self.max_rounds and not stable:
            rounds += 1
            last, at_last_gate = pairs, gate == self.last_gate
            pairs = assign(corrected_distances(first, second, theta), gate, self.objective)
            stable = at_last_gate and np.array_equal(pairs, last)
            if stable:
                break
            try:
                problem = ReportProblem(pair_up(first, second, pairs))
                estimate = self.estimator.estimate(problem, None, rng)
            except (InvalidInputError, UnobservableError):
                if not history:
                    raise
                # the last estimate left too few pairs to go on from: take the one before
                history = history[:-1] or history
                break
            history.append((estimate, pairs))
            theta = estimate.theta
            gate = max(self.last_gate, self.shrink * gate)
        estimate, pairs = history[-1]
        done = replace(estimate, converged=stable and estimate.converged)
        return with_pairs(done, pairs, rounds=rounds)
