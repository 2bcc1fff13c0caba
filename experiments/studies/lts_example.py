"""LTS paper: one frame of the scene, and what a bias does to a position.

Figures 1 and 2 are drawn from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from experiments.lts_methods import LtsConfig, draw_frame
from probreg.association import nearest_neighbours, wrong_pairs


@dataclass(frozen=True)
class Config(LtsConfig):
    """Noise level of the frame."""

    replicates: int = 1
    sigma_m: float = 100.0


PROFILES = {"quick": Config(), "paper": Config()}
GRID = {"reading": ("literal", "symmetric")}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """Draw a frame; displace its targets by the range bias, the azimuth bias, and both."""
    frame = draw_frame(config, config.sigma_m, int(rng.integers(2**62)))
    first, second = frame.data
    pairs = nearest_neighbours(
        first.positions(), second.positions(), frame.scene.gate_m, frame.scene.objective
    )
    only = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    displaced = [
        [
            sensor.to_cartesian(sensor.to_report(frame.truth.positions) + mask * bias)
            for mask in only
        ]
        for sensor, bias in zip(frame.scene.sensors, frame.truth.bias.reshape(2, 2), strict=True)
    ]
    return xr.Dataset(
        {
            "first": (("first_report", "axis"), first.positions()),
            "second": (("second_report", "axis"), second.positions()),
            "pairs": (("pair", "side"), pairs),
            "wrong": (("pair",), wrong_pairs(pairs, *frame.truth.targets).astype(int)),
            "targets": (("target", "axis"), frame.truth.positions),
            "displaced": (("sensor", "bias", "target", "axis"), np.array(displaced)),
            "sensors": (("sensor", "axis"), np.array([s.position for s in frame.scene.sensors])),
        },
        {"sensor": ["A", "B"], "bias": ["none", "range", "azimuth", "both"], "axis": ["x", "y"]},
    )
