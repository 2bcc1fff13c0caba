"""Recordings of simulated traffic, registered as a user does, and what came of them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from probreg.recordings import Recording, Setup
from probreg.registration import LAWS, Registration, register
from probreg.scenarios.traffic import TrafficScene, TrafficTruth, simulate
from tests.posterior.traffic_tracks import model_of, oracle

DIRTY = {"wrong_share": 0.2, "outlier_share": 0.05}
SCENES = {"clean": {}, "outliers": {"outlier_share": 0.05}, "dirty": DIRTY}
KNOWN_M = 1_000.0


class Drawn(NamedTuple):
    """A recording, what an engineer knows, and the truth."""

    recording: Recording
    setup: Setup
    truth: TrafficTruth


class Run(NamedTuple):
    """What `register` found, beside the truth; `bias` in the order of its names."""

    found: Registration
    drawn: Drawn
    bias: np.ndarray

    @property
    def z(self) -> np.ndarray:
        return np.asarray((self.found.mean - self.bias) / self.found.sd)

    @property
    def held(self) -> np.ndarray:
        low, high = self.found.interval(0.9).T
        return (low <= self.bias) & (self.bias <= high)


def draw(seed, **scene) -> Drawn:
    return Drawn(*simulate(TrafficScene(**scene), np.random.default_rng(seed)))


def run(drawn: Drawn, seed=0, laws=LAWS, **setup) -> Run:
    """Register, with parts of the setup changed."""
    given = replace(drawn.setup, **setup)
    found = register(drawn.recording, given, rng=np.random.default_rng([7, seed]), laws=laws)
    return Run(found, drawn, np.array([drawn.truth.bias[name] for name in found.names]))


def bound(one: Run):
    """The posterior of an oracle under the accelerations that `register` found."""
    recording, setup, truth = one.drawn
    model, names = model_of(recording, setup)
    assert tuple(names) == one.found.names
    found = one.found.fit.point.density
    density = np.full(int(truth.target.max()) + 1, found.min())
    for track, owner in enumerate(one.found.problem.owner):
        if owner < len(density):
            density[owner] = found[track]
    return oracle(model, truth, density)


def merged(parts: list[Drawn]) -> Drawn:
    """Recordings of one time, by the same sensors under the same biases, as one."""
    recordings, truths = [p.recording for p in parts], [p.truth for p in parts]
    first = np.cumsum([0, *(len(r.labels) for r in recordings)])
    time = np.concatenate([r.time for r in recordings])
    order = np.argsort(time, kind="stable")

    def joined(arrays):
        return np.concatenate(list(arrays))[order]

    recording = Recording(
        recordings[0].sensors,
        joined(r.sensor for r in recordings),
        time[order],
        joined(r.values for r in recordings),
        joined(r.target + k for r, k in zip(recordings, first, strict=False)),
        tuple(f"{0x400000 + k:06x}" for k in range(first[-1])),
    )
    truth = TrafficTruth(
        truths[0].bias,
        joined(t.time for t in truths),
        joined(t.positions for t in truths),
        joined(t.target + k for t, k in zip(truths, first, strict=False)),
        joined(t.wrong for t in truths),
        joined(t.outlier for t in truths),
    )
    return Drawn(recording, parts[0].setup, truth)


def delayed(drawn: Drawn, sd_m: float, seed) -> Drawn:
    """Every target's ranges are off by a constant of its own."""
    delay = sd_m * np.random.default_rng(seed).standard_normal(drawn.truth.target.max() + 1)
    values = drawn.recording.values.copy()
    values[:, 0] += delay[drawn.truth.target]
    return drawn._replace(recording=replace(drawn.recording, values=values))


def in_pairs(drawn: Drawn, gap_m: float, exchanged: float, seed) -> Drawn:
    """Every aircraft has a companion, seen in the same scans; identities are exchanged in some."""
    recording, _, truth = drawn
    rng, count = np.random.default_rng(seed), len(recording.labels)
    beside = truth.positions.copy()
    beside[:, :2] += gap_m * np.array([np.cos(1.0), np.sin(1.0)])
    values = recording.values.copy()
    for k, sensor in enumerate(recording.sensors):
        own = recording.sensor == k
        bias = [truth.bias[f"{sensor.name}.{term}"] for term in sensor.bias_names]
        noise = sensor.sample_noise(rng, own.sum(), beside[own, :2])
        values[own] = sensor.to_report(beside[own, :2]) + bias + noise
    companion = Drawn(
        replace(recording, values=values), drawn.setup, replace(truth, positions=beside)
    )
    both = merged([drawn, companion])
    # the two reports of a scan stand side by side: a stable sort keeps their order
    swap = np.repeat(rng.random(len(recording)) < exchanged, 2)
    partner = np.where(both.truth.target < count, count, -count) + both.truth.target
    target = np.where(swap, partner, both.truth.target)
    return both._replace(
        recording=replace(both.recording, target=target), truth=replace(both.truth, wrong=swap)
    )


class Numbers(NamedTuple):
    """Of one recording, by bias or by report; `claimed` is of the reconstructed positions."""

    z: np.ndarray
    held: np.ndarray
    error: np.ndarray
    sd: np.ndarray
    bad: np.ndarray
    wrong: np.ndarray
    outlier: np.ndarray
    distance2: np.ndarray
    claimed: np.ndarray
    off: np.ndarray

    @property
    def good(self) -> np.ndarray:
        return ~self.wrong & ~self.outlier

    @property
    def refused(self) -> float:
        """Share of the good reports that are not believed."""
        return float((self.bad[self.good] > 0.5).mean())


def numbers(one: Run) -> Numbers:
    recording, _, truth = one.drawn
    assert (one.found.problem.rows == np.arange(len(recording))).all()
    wrong = recording.target != truth.target
    error, sd = one.found.mean - one.bias, one.found.sd
    places = positions(one)
    return Numbers(one.z, one.held, error, sd, one.found.bad, wrong, truth.outlier, *places)


def positions(one: Run) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of reports believed, of the target that their track is of, and claimed to a kilometre.

    Squared distances of the true positions in claimed covariances, claimed and true mean squares.
    A target seen once or twice, moving as fast as it may, is claimed to no more than it is.
    """
    table, truth = one.found.tracks(), one.drawn.truth
    report = table["report"].to_numpy()
    owner = one.found.problem.owner[table["track"].to_numpy()]
    own = (owner == truth.target[report]) & table["used"].to_numpy()
    away = (table[["x", "y"]].to_numpy() - truth.positions[report, :2])[own]
    C = np.empty((len(away), 2, 2))
    C[:, 0, 0], C[:, 1, 1] = table["cov_xx"][own], table["cov_yy"][own]
    C[:, 0, 1] = C[:, 1, 0] = table["cov_xy"][own]
    known = np.trace(C, axis1=1, axis2=2) < KNOWN_M**2
    away, C = away[known], C[known]
    distance2 = np.einsum("ni,nij,nj->n", away, np.linalg.inv(C), away)
    return distance2, np.trace(C, axis1=1, axis2=2), (away**2).sum(axis=1)


@cache
def seen(scene: str, seed: int, reports: int = 5_000) -> Numbers:
    return numbers(run(draw([5, seed, reports], reports=reports, **SCENES[scene]), seed))


def rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def drifted(drawn: Drawn, name: str, path) -> Drawn:
    """A bias moves: what `path` has at the stamp of each report is added to it."""
    sensor, term = name.split(".")
    k = [s.name for s in drawn.recording.sensors].index(sensor)
    own = np.flatnonzero(drawn.recording.sensor == k)
    values = drawn.recording.values.copy()
    values[own, drawn.recording.sensors[k].bias_names.index(term)] += path(
        drawn.recording.time[own]
    )
    return drawn._replace(recording=replace(drawn.recording, values=values))


def walk_path(seed, sd_minute: float, end: float):
    """A random walk from zero, of so much in a root minute, drawn every second."""
    rng = np.random.default_rng([9, seed])
    time = np.arange(0.0, end + 60.0)
    steps = rng.normal(0.0, sd_minute / np.sqrt(60.0), len(time) - 1)
    walk = np.concatenate([[0.0], np.cumsum(steps)])
    return lambda at: np.interp(at, time, walk)


def step_path(seed, size: float, end: float):
    """A step at some time of the middle, and that time."""
    at = np.random.default_rng([9, seed]).uniform(0.3, 0.7) * end
    return at, lambda time: np.where(time >= at, size, 0.0)
