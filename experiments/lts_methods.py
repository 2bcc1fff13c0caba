"""What the LTS studies share: settings, frames, and how one run is scored."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.study import StudyError
from probreg import ReportProblem
from probreg.association import nearest_neighbours, wrong_pairs
from probreg.diagnostics import cramer_rao_bound
from probreg.scenarios.lts import READINGS, LtsScene, LtsTruth, simulate
from probreg.sensors.reports import AssociatedReports, SensorReports, pair_up
from probreg.typing import FloatArray


@dataclass(frozen=True)
class LtsConfig:
    """Settings of the paper's experiments; a replicate is a block of runs.

    The scene's square and gate follow from the reading.
    """

    reading: str = "literal"
    replicates: int = 20
    runs: int = 25
    seed: int = 20180307
    coverage: float = 0.75
    threshold: float = 3.0
    subsets: int = 500

    def __post_init__(self) -> None:
        if self.reading not in READINGS:
            raise StudyError(f"reading {self.reading!r} does not exist; known: {list(READINGS)}.")

    def scene(self, sigma_m: float) -> LtsScene:
        """The scene at a noise level."""
        return dataclasses.replace(READINGS[self.reading], sigma_m=sigma_m)

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        scene = dataclasses.asdict(READINGS[self.reading])
        return {**dataclasses.asdict(self), "scene": scene}


@dataclass(frozen=True, eq=False)
class Frame:
    """One run at one noise level."""

    scene: LtsScene
    data: tuple[SensorReports, SensorReports]
    truth: LtsTruth
    paired: AssociatedReports
    wrong: float


def draw_frame(config: LtsConfig, sigma_m: float, seed: int) -> Frame:
    """Simulate and associate; one seed gives the same draws at every noise level."""
    scene = config.scene(sigma_m)
    (first, second), truth = simulate(scene, np.random.default_rng(seed))
    pairs = nearest_neighbours(first.positions(), second.positions(), scene.gate_m, scene.objective)
    wrong = float(np.mean(wrong_pairs(pairs, *truth.targets)))
    return Frame(scene, (first, second), truth, pair_up(first, second, pairs), wrong)


def bound_sd(frame: Frame) -> FloatArray:
    """Cramer-Rao standard deviations (4,) with the right pairs, from noise-free reports."""
    common = frame.truth.positions[frame.truth.common()]
    halves = frame.truth.bias.reshape(2, 2)
    sensors = tuple(reports.sensor for reports in frame.data)
    values = tuple(s.to_report(common) + b for s, b in zip(sensors, halves, strict=True))
    problem = ReportProblem(AssociatedReports(sensors, values))
    return np.sqrt(np.diag(cramer_rao_bound(problem, frame.truth.bias)))
