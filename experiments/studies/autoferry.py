"""Real recordings of a ferry in a harbour: biases of radar, lidar and cameras by scenario.

Needs the public Autoferry benchmark: its folders `scenario2`, ... in the folder `autoferry` of the
one that the environment variable PROBREG_DATA names. Figure `autoferry_bias` is drawn from it.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from probreg.recordings import Recording, Setup
from probreg.recordings.formats import autoferry
from probreg.registration import Registration, register
from probreg.registration.hierarchy import Pooled, pool
from probreg.sensors.geometry import wrap_angle
from probreg.typing import FloatArray

VARIABLE = "PROBREG_DATA"
REFERENCE = ("lidar", "radar", "gnss")
CAMERAS = ("infrared", "electro_optical", "gnss")
BIASES = ("radar.range", "radar.azimuth", "lidar.range", "lidar.azimuth")
BEARINGS = ("infrared.bearing", "electro_optical.bearing")
RELATIVE = ("radar.range", "radar.azimuth")
CORRECTIONS = ("none", "own", "others")


@dataclass(frozen=True)
class Config:
    """There is one replicate: the recordings are what they are."""

    replicates: int = 1
    seed: int = 20220301
    scenarios: tuple[int, ...] = (2, 3, 4, 5, 13, 17)
    num_draws: int = 2000
    near_m: float = 30.0
    near_deg: float = 5.0
    camera_gate_m: float = 8.0
    block_s: float = 10.0
    bootstraps: int = 1000
    common_sd: tuple[float, float] = (20.0, 0.2)
    spread_sd: tuple[float, float] = (5.0, 0.1)
    target_terms: tuple[float, float] = (2.0, 0.01)  # range, azimuth: hulls about their antennas

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        return dataclasses.asdict(self)


PROFILES = {"quick": Config(scenarios=(2, 13), num_draws=400), "paper": Config()}
GRID: dict[str, tuple[Any, ...]] = {}


def missing() -> str:
    """Why the study cannot run here; empty if it can."""
    place = os.environ.get(VARIABLE, "")
    if place and (Path(place) / "autoferry").is_dir():
        return ""
    return (
        f"the Autoferry benchmark is not here. Get it from its publishers, put its scenarios into "
        f"a folder autoferry, and name the folder that holds it in {VARIABLE}."
    )


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """All scenarios: posteriors against GNSS, radar against lidar, direct offsets, pooling.

    `own` are the posteriors of radar and lidar if each vessel has errors of its own.
    """
    folder = Path(os.environ[VARIABLE]) / "autoferry"
    names = [*BIASES, *BEARINGS]
    terms = dict(zip(("range", "azimuth"), config.target_terms, strict=True))
    kinds = "posterior", "own", "direct", "relative", "count"
    table: dict[str, list[Any]] = {kind: [] for kind in kinds}
    residuals: list[list[FloatArray]] = []
    for number in config.scenarios:
        recording, setup = autoferry.read(folder, number), autoferry.setup()
        # cameras see much that is no vessel with GNSS: a narrower gate
        cameras = dataclasses.replace(setup, gate_m=config.camera_gate_m)
        hulls = dataclasses.replace(setup, target_terms=terms)
        parts = (REFERENCE, setup), (CAMERAS, cameras), (REFERENCE, hulls)
        *truth, own = [_register(recording, part, one, config, rng) for part, one in parts]
        table["posterior"].append(np.concatenate([_summary(r, None) for r in truth])[_order(truth)])
        table["own"].append(_summary(own, BIASES))
        found = [_residuals(recording, name, config) for name in names]
        direct = [_robust(time, values, config, rng) for time, values in found]
        table["direct"].append(direct)
        table["count"].append([len(values) for _, values in found])
        residuals.append([values for _, values in found])
        lidar = dataclasses.replace(setup, biases={"radar": ("range", "azimuth")})
        pair = recording.only("lidar", "radar")
        against = register(pair, _part_of(lidar, pair), rng=rng, num_draws=config.num_draws)
        table["relative"].append(_summary(against, RELATIVE))
    posterior = np.array(table["posterior"])
    known = _without_prior(posterior, np.array(table["direct"]), names)
    pooled = [_pool(known[:, k], name, config, rng) for k, name in enumerate(names)]
    return xr.Dataset(
        {
            "posterior": (("scenario", "bias", "number"), posterior),
            "own": (("scenario", "polar", "number"), np.array(table["own"])),
            "direct": (("scenario", "bias", "moment"), np.array(table["direct"])),
            "count": (("scenario", "bias"), np.array(table["count"])),
            "relative": (("scenario", "component", "number"), np.array(table["relative"])),
            "pooled": (("bias", "level", "bound"), np.array([p.interval(0.9) for p in pooled])),
            "score": (
                ("scenario", "bias", "correction"),
                _scores(known, residuals, names, config, rng),
            ),
        },
        {
            "scenario": list(config.scenarios),
            "bias": names,
            "polar": list(BIASES),
            "component": list(RELATIVE),
            "number": ["mean", "sd", "low", "high"],
            "moment": ["median", "error"],
            "level": ["common", "spread", "new"],
            "bound": ["low", "high"],
            "correction": list(CORRECTIONS),
        },
    )


def _register(
    recording: Recording,
    names: Sequence[str],
    setup: Setup,
    config: Config,
    rng: np.random.Generator,
) -> Registration:
    part = recording.only(*names)
    return register(part, _part_of(setup, part), rng=rng, num_draws=config.num_draws)


def _part_of(setup: Setup, part: Recording) -> Setup:
    """The setup of the sensors that a part of a recording has."""
    here = {sensor.name for sensor in part.sensors}
    biases = {name: terms for name, terms in setup.biases.items() if name in here}
    return dataclasses.replace(setup, sensors=part.sensors, biases=biases)


def _summary(found: Registration, names: Sequence[str] | None) -> FloatArray:
    """Mean, sd and 90 % interval of biases, shape (k, 4)."""
    rows = np.column_stack([found.mean, found.sd, found.interval(0.9)])
    return rows if names is None else rows[[found.names.index(name) for name in names]]


def _order(found: Sequence[Registration]) -> list[int]:
    """Where the biases of the table are among those of several registrations."""
    every = [name for one in found for name in one.names]
    return [every.index(name) for name in (*BIASES, *BEARINGS)]


def _residuals(recording: Recording, name: str, config: Config) -> tuple[FloatArray, FloatArray]:
    """Times and report minus truth of one component, of the reports nearest to each vessel."""
    sensor, component = name.split(".")
    own = recording.only(sensor)
    gnss = recording.only("gnss")
    assert own.own_position is not None
    column = own.sensors[0].bias_names.index(component)
    times, found = [], []
    for target in range(len(gnss.labels)):
        rows = gnss.target == target
        for time in np.unique(own.time):
            seen = own.time == time
            path = [np.interp(time, gnss.time[rows], gnss.values[rows, k]) for k in (0, 1)]
            relative = np.array(path) - own.own_position[seen][0]
            true = np.array([np.hypot(*relative), np.arctan2(*relative)])
            gap, near = _gaps(own.values[seen], true, config, component == "bearing")
            if near is not None:
                times.append(time)
                found.append(gap[near, column])
    return np.array(times), np.array(found)


def _gaps(
    values: FloatArray, true: FloatArray, config: Config, bearing: bool
) -> tuple[FloatArray, int | None]:
    """Report minus truth of all reports at one time, and which is the vessel's."""
    if bearing:
        gap = wrap_angle(values[:, :1] - true[1])
        distance, limit = np.abs(gap[:, 0]), np.deg2rad(config.near_deg)
    else:
        gap = np.column_stack([values[:, 0] - true[0], wrap_angle(values[:, 1] - true[1])])
        # law of cosines: between the reported and the true position
        product = 2.0 * values[:, 0] * true[0] * (1.0 - np.cos(gap[:, 1]))
        distance, limit = np.sqrt(gap[:, 0] ** 2 + product), config.near_m
    near = int(distance.argmin())
    return gap, near if distance[near] < limit else None


def _robust(
    time: FloatArray, values: FloatArray, config: Config, rng: np.random.Generator
) -> tuple[float, float]:
    """Median, and its standard error by resampling blocks of time: neighbours are alike."""
    block = np.floor((time - time.min()) / config.block_s).astype(int)
    parts = [values[block == k] for k in np.unique(block)]
    medians = []
    for _ in range(config.bootstraps):
        chosen = rng.integers(len(parts), size=len(parts))
        medians.append(np.median(np.concatenate([parts[k] for k in chosen])))
    return float(np.median(values)), float(np.std(medians))


def _without_prior(posterior: FloatArray, direct: FloatArray, names: list[str]) -> FloatArray:
    """Means and standard errors (scenarios, biases, 2) as pooling wants them.

    The prior of the registration is divided out. Neighbouring reports are alike, so a posterior
    is too sure; where the error by blocks of time is larger, it is taken.
    """
    spread = {f"{s.name}.{b}": sd for s in autoferry.sensors()
              for b, sd in zip(s.bias_names, s.bias_sd, strict=True)}  # fmt: skip
    prior = np.array([spread[name] for name in names])
    variance = 1.0 / (1.0 / posterior[..., 1] ** 2 - 1.0 / prior**2)
    mean = posterior[..., 0] * variance / posterior[..., 1] ** 2
    return np.stack([mean, np.maximum(np.sqrt(variance), direct[..., 1])], axis=-1)


def _pool(posterior: FloatArray, name: str, config: Config, rng: np.random.Generator) -> Pooled:
    """Common value of a bias, from means and standard errors (scenarios, 2)."""
    k = 0 if name.endswith("range") else 1
    return pool(
        posterior[:, 0],
        posterior[:, 1],
        common_sd=config.common_sd[k],
        spread_sd=config.spread_sd[k],
        num_draws=config.num_draws,
        rng=rng,
    )


def _scores(
    posterior: FloatArray,
    residuals: list[list[FloatArray]],
    names: list[str],
    config: Config,
    rng: np.random.Generator,
) -> FloatArray:
    """Median absolute residual uncorrected, with the own bias (in sample), and with the others'."""
    scores = np.empty((len(posterior), len(names), len(CORRECTIONS)))
    for s in range(len(posterior)):
        others = np.delete(posterior, s, axis=0)
        for k, name in enumerate(names):
            # one other scenario is no population: its own value is all there is
            common = others[0, k, 0]
            if len(others) > 1:
                common = _pool(others[:, k], name, config, rng).common.mean()
            for c, correction in enumerate((0.0, posterior[s, k, 0], common)):
                scores[s, k, c] = np.median(np.abs(residuals[s][k] - correction))
    return scores
