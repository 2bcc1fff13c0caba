"""Accuracies of single sensors, estimated from how their reports scatter about the others'."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.recordings import Recording, Setup
from probreg.registration._fit import thinned
from probreg.registration.residuals import (
    Between,
    Residuals,
    between,
    spread,
)
from probreg.typing import FloatArray, IntArray

_FEWEST = 50  # reports from which a spread can be estimated
_MOST = 20_000  # reports of a sensor that are enough for it
_PASSES = 20
_OWN = 0.1  # of a residual's variance; below, the neighbours' noise hides the sensor's own
_ERROR = 3.5  # sd of a robust variance times root n: 2.33, half more as residuals share reports
_LEAST = 1e-3  # variance over the declared one that is as good as none


class Accuracy(NamedTuple):
    """Standard deviation of a sensor's reports over the declared one.

    Attributes
    ----------
    sensor, component : str
    key : str
        Of the accuracy in the setup file.
    declared : float
        In the SI unit of the key.
    factor : float
        The scatter over it.
    clear : bool
        Whether its square is off one by three standard errors.
    """

    sensor: str
    component: str
    key: str
    declared: float
    factor: float
    clear: bool


def accuracies(recording: Recording, setup: Setup, found: Residuals) -> list[Accuracy]:
    """Every accuracy that the residuals after correction determine.

    A residual against the line between two reports of other sensors has the variance of the
    report, of the two, and of the path. One factor on every declared variance is fitted so that
    each component's standardised residuals spread by one, robustly.
    """
    firsts = np.cumsum([0, *(len(s.bias_names) for s in recording.sensors)])
    parts = _parts(recording, setup, found, firsts)
    factor, own_share, error = np.ones(firsts[-1]), np.zeros(firsts[-1]), np.zeros(firsts[-1])
    for _ in range(_PASSES):
        before = factor.copy()
        for number, (residual, shares, path) in parts.items():
            total = shares @ before + path
            ratio = spread(residual / np.sqrt(total)).sd ** 2
            own = float(np.median(shares[:, number] / total))
            # half a step: neighbours answer one another's
            grown = before[number] + 0.5 * (ratio - 1.0) / own
            factor[number] = np.clip(grown, max(0.25 * before[number], _LEAST), 4 * before[number])
            own_share[number] = own * factor[number]
            error[number] = _ERROR / np.sqrt(len(residual)) / own
    said = []
    for k, sensor in enumerate(recording.sensors):
        for j, (name, sigma) in enumerate(zip(sensor.bias_names, sensor.sigmas, strict=True)):
            number = firsts[k] + j
            if number in parts and own_share[number] > _OWN:
                ratio = float(np.sqrt(factor[number]))
                clear = bool(abs(factor[number] - 1.0) > 3.0 * error[number])
                key = sensor.kind.sigma_key(j)
                said.append(Accuracy(sensor.name, name, key, float(sigma), ratio, clear))
    return said


def _parts(
    recording: Recording, setup: Setup, found: Residuals, firsts: IntArray
) -> dict[int, tuple[FloatArray, FloatArray, FloatArray]]:
    """Of each component: residuals (n,), declared variances (n, all components), path's (n,)."""
    shape = found.where.shape
    own = np.zeros(shape) if recording.own_position is None else recording.own_position
    parts: dict[int, tuple[FloatArray, FloatArray, FloatArray]] = {}
    for k, sensor in enumerate(recording.sensors):
        if not sensor.gives_position:
            continue
        line = between(recording, found.time, found.where, k, setup.window_s)
        if len(line.rows) < _FEWEST:
            continue
        some = thinned(len(line.rows), _MOST)
        line = Between._make(part[some] for part in line)
        reports = found.values[line.rows, : len(sensor.bias_names)]
        back = np.linalg.inv(sensor.observe(reports, line.expected, own[line.rows]).D)
        # integrated white acceleration against the line between its ends
        path = (setup.acceleration_m_s2 * line.share * (1.0 - line.share)) ** 2 * line.gap**3 / 3.0
        for j, sd in enumerate(sensor.report_sd(reports).T):
            by = back[:, j]
            shares = np.zeros((len(line.rows), int(firsts[-1])))
            for rows, weight in ((line.left, 1.0 - line.share), (line.right, line.share)):
                columns = _columns(recording, found, own, firsts, rows)
                moved = np.einsum("nd,ndp->np", by, columns)
                shares += (weight[:, None] * moved) ** 2
            shares[:, firsts[k] + j] += sd**2
            residual = found.residual[line.rows, j]
            parts[int(firsts[k] + j)] = residual, shares, path * np.einsum("nd,nd->n", by, by)
    return parts


def _columns(
    recording: Recording,
    found: Residuals,
    own: FloatArray,
    firsts: IntArray,
    rows: IntArray,
) -> FloatArray:
    """What one declared sd of each component moves reports `rows` (n, d, all components)."""
    columns = np.zeros((len(rows), found.where.shape[1], int(firsts[-1])))
    for k, sensor in enumerate(recording.sensors):
        of = np.flatnonzero(recording.sensor[rows] == k)
        if of.size:
            some = rows[of]
            reports = found.values[some, : len(sensor.bias_names)]
            moved = sensor.observe(reports, found.where[some], own[some]).D
            sd = sensor.report_sd(reports)[:, None]
            columns[of, :, firsts[k] : firsts[k + 1]] = moved * sd
    return columns
