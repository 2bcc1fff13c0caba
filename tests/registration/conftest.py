"""Small asynchronous recordings with known truth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg import BearingSensor, PositionSensor, Radar2D, Radar3D
from probreg.recordings import Recording, Setup
from probreg.sensors.terms import add_terms, known_terms

ANGLE = 2e-3
BEARINGS_FROM = (10e3, -15e3)


class Made(NamedTuple):
    recording: Recording
    setup: Setup
    theta: dict
    paths: tuple


def sensors_2d():
    return (
        Radar2D((0.0, 0.0), 20.0, ANGLE, "a"),
        Radar2D((30e3, 5e3), 30.0, 1.5 * ANGLE, "b", from_north=True),
        PositionSensor(((400.0, 50.0), (50.0, 300.0)), "c"),
    )


def sensors_3d():
    return (
        Radar3D((0.0, 0.0, 50.0), 20.0, ANGLE, ANGLE, "a"),
        Radar3D((30e3, 5e3, 10.0), 30.0, ANGLE, 1.5 * ANGLE, "b", from_north=True),
    )


def reported(sensor, where, own, heading, theta):
    """Noise-free reports (n, 3) with the biases of theta; NaN beyond the sensor's components."""
    report = sensor.to_report(where, own)
    if heading is not None:
        report[:, 1] -= 0.5 * np.pi - heading if sensor.from_north else heading
    terms = [t for n, t in known_terms(sensor).items() if f"{t.owner}.{n}" in theta]
    terms = [t for t in terms if t.name != "heading"]
    own_theta = np.array([theta[f"{t.owner}.{t.name}"] for t in terms])
    values = np.full((len(where), 3), np.nan)
    values[:, : report.shape[1]] = add_terms(terms, own_theta, report)
    return values


def fly(
    sensors,
    theta,
    *,
    seed=1,
    targets=12,
    scans=10,
    noise=1.0,
    periods=(4.0, 5.0, 6.0),
    together=False,
    own_speed=None,
    body_frame=(),
    heading_error=0.0,
    **setup,
):
    """Targets on straight lines, each sensor with its own scan; theta by "sensor.term"."""
    rng = np.random.default_rng(seed)
    dim = sensors[0].dim
    start = rng.uniform(-40e3, 40e3, (targets, dim))
    velocity = rng.uniform(-200.0, 200.0, (targets, dim))
    if dim == 3:
        start[:, 2], velocity[:, 2] = rng.uniform(3e3, 9e3, targets), 0.0
    parts = []
    for k, sensor in enumerate(sensors):
        period = 4.0 if together else periods[k]
        offset = np.zeros(targets) if together else rng.uniform(0.0, period, targets)
        time = (offset[:, None] + period * np.arange(scans)).ravel()
        target = np.repeat(np.arange(targets), scans)
        where = start[target] + velocity[target] * time[:, None]
        own = np.zeros((len(time), dim))
        heading = np.full(len(time), np.nan)
        if own_speed is not None and sensor.name in body_frame:
            own[:, :2] = time[:, None] * np.asarray(own_speed)
            heading[:] = 0.3 + 0.01 * time
        if isinstance(sensor, BearingSensor):
            own = own + np.asarray(BEARINGS_FROM)
        turned_by = heading if sensor.name in body_frame else None
        values = reported(sensor, where, own, turned_by, theta)
        values[:, : len(sensor.bias_names)] += noise * (
            sensor.sample_noise(rng, len(time), where - own)
        )
        stamp = time + theta.get(f"{sensor.name}.time", 0.0)
        recorded = heading + theta.get("platform.heading", 0.0)
        parts.append((np.full(len(time), k), stamp, values, target, own, recorded))
    sensor, time, values, target, own, heading = (
        np.concatenate(part) for part in zip(*parts, strict=True)
    )
    order = np.argsort(time, kind="stable")
    moving = own_speed is not None or any(isinstance(s, BearingSensor) for s in sensors)
    recording = Recording(
        tuple(sensors),
        sensor[order],
        time[order],
        values[order],
        target[order],
        own_position=own[order] if moving else None,
        heading=heading[order] if own_speed is not None else None,
    )
    biases = {}
    for s in sensors:
        biases[s.name] = tuple(
            n
            for n, t in known_terms(s).items()
            if f"{t.owner}.{n}" in theta and (n != "heading" or s.name in body_frame)
        )
    made = Setup(
        tuple(sensors),
        biases,
        body_frame=frozenset(body_frame),
        **{"acceleration_m_s2": 0.1, **setup},
    )
    return Made(recording, made, theta, (start, velocity))


def vector(made, names):
    return np.array([made.theta[name] for name in names])
