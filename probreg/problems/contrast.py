"""Registration from reports: contrasts between sensors, re-linearised at the bias."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from probreg.errors import InvalidInputError
from probreg.numerics.linalg import precision_weighted_mean
from probreg.problems.linear import LinearProblem, Whitened, bias_scale
from probreg.problems.observability import Observability
from probreg.sensors import PlacingSensor
from probreg.sensors.reports import AssociatedReports
from probreg.typing import FloatArray, IntArray
from probreg.validation import finite_array


@dataclass(frozen=True, eq=False)
class _Rows:
    """Position differences between consecutive sensors, with their B and R, of one group."""

    y: FloatArray
    B: FloatArray
    R: FloatArray


class ReportProblem:
    """The nonlinear registration problem of associated reports.

    The residual at theta is the contrast of the reports corrected by theta and converted
    with the unbiased factors. B and R are evaluated at the fused position of the row (the
    precision-weighted mean of the corrected reports), so that they hardly depend on the
    noise of the row; evaluated at a raw report they would bias the estimate.

    Parameters
    ----------
    *reports : AssociatedReports
        One group for every combination of sensors that saw targets in common. A sensor
        that appears in several groups is one sensor (same name, same description).

    Attributes
    ----------
    names, units : tuple of str
        "sensor.bias" and "m" or "rad", in order of first appearance of the sensors.
    sensors : tuple of PlacingSensor
    time : ndarray, shape (n,), or None
    size : ndarray of int, shape (n,)
        Number of real components of each row.

    Raises
    ------
    InvalidInputError
        No group, no row, one name for different sensors, time in some groups only.
    """

    linear = False

    def __init__(self, *reports: AssociatedReports) -> None:
        if not reports or sum(len(group) for group in reports) == 0:
            raise InvalidInputError("no associated report: no target was seen in common.")
        by_name: dict[str, PlacingSensor] = {}
        for sensor in (sensor for group in reports for sensor in group.sensors):
            if by_name.setdefault(sensor.name, sensor) != sensor:
                raise InvalidInputError(f"two different sensors are called {sensor.name!r}.")
        self.reports = tuple(_ordered(group) for group in reports)
        self.sensors = tuple(by_name.values())
        self.names = tuple(f"{s.name}.{bias}" for s in self.sensors for bias in s.bias_names)
        self.units = tuple(unit for s in self.sensors for unit in s.bias_units)
        ends = np.cumsum([len(s.bias_names) for s in self.sensors])
        self._columns = {
            s.name: slice(end - len(s.bias_names), end)
            for s, end in zip(self.sensors, ends, strict=True)
        }
        timed = [group.time is not None for group in reports]
        if any(timed) and not all(timed):
            raise InvalidInputError("some groups of reports have times and some have none.")
        times = [group.time for group in reports if group.time is not None]
        self.time: FloatArray | None = np.concatenate(times) if times else None

    @cached_property
    def size(self) -> IntArray:
        """Number of real components of each row, shape (n,)."""
        sizes = [(len(g.sensors) - 1) * g.sensors[0].dim for g in self.reports]
        return np.repeat(sizes, [len(g) for g in self.reports])

    @property
    def start(self) -> FloatArray:
        """Zero bias, shape (p,)."""
        return np.zeros(len(self.names))

    @property
    def scale(self) -> FloatArray:
        """One metre or one milliradian for each bias, shape (p,)."""
        return bias_scale(self.units)

    @property
    def prior_sd(self) -> FloatArray:
        """What sensors of these types are found to have, shape (p,)."""
        return np.concatenate([sensor.bias_sd for sensor in self.sensors])

    @property
    def exact(self) -> None:
        """None: R changes with theta, so densities use the linear form at the mode."""
        return

    def shifted(self, row: int, component: int, by: float) -> ReportProblem:
        """The same problem with one component of the reports of one row moved.

        Components count through the reports of the row's sensors, in the order of `reports`.
        """
        groups = []
        for group in self.reports:
            if 0 <= row < len(group):
                values = [np.array(v) for v in group.values]
                ends = np.cumsum([v.shape[1] for v in values])
                sensor = int(np.searchsorted(ends, component, side="right"))
                values[sensor][row, component - int(ends[sensor])] += by
                group = AssociatedReports(group.sensors, tuple(values), group.time, group.tracks)
            groups.append(group)
            row -= len(group)
        return ReportProblem(*groups)

    def residual(self, theta: FloatArray) -> FloatArray:
        """Contrasts of the corrected reports, shape (n, M), metres."""
        theta = self._check(theta)
        parts = [_differences(self._corrected(group, theta)) for group in self.reports]
        return np.concatenate([self._pad(part, axes=1) for part in parts])

    def jacobian(self, theta: FloatArray) -> FloatArray:
        """Derivative of the residuals, -B at the fused positions, shape (n, M, p)."""
        return -self.linearise(theta).B

    def linearise(self, theta: FloatArray) -> LinearProblem:
        """The linear problem tangent at theta: y = residual + B theta."""
        theta = self._check(theta)
        rows = []
        for group in self.reports:
            corrected = self._corrected(group, theta)
            where = (_fuse(group.sensors, corrected),) * len(group.sensors)
            part = self._rows(group, corrected, where)
            rows.append(_Rows(part.y + part.B @ theta, part.B, part.R))
        return self._stack(rows)

    def one_shot(self, at: Sequence[tuple[FloatArray, ...]] | None = None) -> LinearProblem:
        """The papers' linear form: plain conversion, B and R evaluated once, theta = 0.

        Parameters
        ----------
        at : sequence of tuple of ndarray, shape (n, d), optional
            For each group, the position at which each sensor's B and R are evaluated: the
            true one (to reproduce a paper), a smoothed one (`reports.smoothed_positions`).
            By default the raw reports themselves, the field's trap: errors in variables
            then bias the estimate.
        """
        raw = [group.positions(unbiased=False) for group in self.reports]
        where = raw if at is None else list(at)
        if len(where) != len(raw) or any(
            np.shape(a) != np.shape(b)
            for w, r in zip(where, raw, strict=True)
            for a, b in zip(w, r, strict=True)
        ):
            raise InvalidInputError("`at` needs one position a report, for every group and sensor.")
        groups = zip(self.reports, raw, where, strict=True)
        rows = [self._rows(group, z, w) for group, z, w in groups]
        # noise in raw evaluation points would hide a lost rank: judge it where B is smooth
        thin = ReportProblem(*(group.every(len(group) // 200 + 1) for group in self.reports))
        hidden = None if thin.observability().complete else self.observability()
        return self._stack(rows, None if hidden is None or hidden.complete else hidden)

    def whitened(self, theta: FloatArray | None = None) -> Whitened:
        """The linear problem at theta (by default zero), whitened."""
        return self.linearise(self.start if theta is None else theta).whitened()

    def observability(self, theta: FloatArray | None = None) -> Observability:
        """Singular values and unobservable combinations at theta (by default zero)."""
        return self.linearise(self.start if theta is None else theta).observability()

    # -- details -----------------------------------------------------------------------

    def _check(self, theta: FloatArray) -> FloatArray:
        return finite_array("theta", theta, (len(self.names),))

    def _corrected(self, group: AssociatedReports, theta: FloatArray) -> tuple[FloatArray, ...]:
        pairs = zip(group.sensors, group.values, strict=True)
        return tuple(s.to_cartesian(z - theta[self._columns[s.name]]) for s, z in pairs)

    def _rows(
        self, group: AssociatedReports, positions: Sequence[FloatArray], at: Sequence[FloatArray]
    ) -> _Rows:
        n, d, k = len(group), group.sensors[0].dim, len(group.sensors)
        p = len(self.names)
        B = np.zeros((n, k, d, p))
        R = np.zeros((n, k - 1, d, k - 1, d))
        for j, (sensor, where) in enumerate(zip(group.sensors, at, strict=True)):
            B[:, j, :, self._columns[sensor.name]] = sensor.sensitivity(where)
            own = sensor.covariance(where)
            # the j-th sensor enters contrast j with +1 and contrast j - 1 with -1
            if j < k - 1:
                R[:, j, :, j, :] += own
            if j > 0:
                R[:, j - 1, :, j - 1, :] += own
            if 0 < j < k - 1:
                R[:, j, :, j - 1, :] -= own
                R[:, j - 1, :, j, :] -= own
        m = (k - 1) * d
        contrasts = (B[:, :-1] - B[:, 1:]).reshape(n, m, p)
        return _Rows(_differences(positions), contrasts, R.reshape(n, m, m))

    def _stack(self, rows: list[_Rows], observed: Observability | None = None) -> LinearProblem:
        R = np.concatenate([self._pad(part.R, axes=2) for part in rows])
        blank = np.arange(R.shape[1]) >= self.size[:, None]
        R[:, np.arange(R.shape[1]), np.arange(R.shape[1])] += blank
        return LinearProblem(
            np.concatenate([self._pad(part.y, axes=1) for part in rows]),
            np.concatenate([self._pad(part.B, axes=1) for part in rows]),
            R,
            self.time,
            self.names,
            self.units,
            self.size,
            observed,
        )

    def _pad(self, array: FloatArray, axes: int) -> FloatArray:
        short = int(self.size.max()) - array.shape[1]
        widths = [(0, 0)] + [(0, short)] * axes + [(0, 0)] * (array.ndim - 1 - axes)
        return np.pad(array, widths) if short else array


def _ordered(group: AssociatedReports) -> AssociatedReports:
    """Three and more sensors in order of name: component-wise laws see the contrasts chosen."""
    if len(group.sensors) == 2:
        return group
    order = sorted(range(len(group.sensors)), key=lambda k: group.sensors[k].name)
    sensors = tuple(group.sensors[k] for k in order)
    tracks = None if group.tracks is None else group.tracks[:, order]
    return AssociatedReports(sensors, tuple(group.values[k] for k in order), group.time, tracks)


def _differences(positions: Sequence[FloatArray]) -> FloatArray:
    """Consecutive differences (n, (k - 1) d): a basis of the contrasts, the target eliminated."""
    stacked = np.stack(positions, axis=1)
    n, k, d = stacked.shape
    return (stacked[:, :-1] - stacked[:, 1:]).reshape(n, (k - 1) * d)


def _fuse(sensors: Sequence[PlacingSensor], positions: Sequence[FloatArray]) -> FloatArray:
    """Precision-weighted mean (n, d); the second pass takes the weights at the first mean."""
    stacked, at = np.stack(positions), positions
    for _ in range(2):
        covariances = np.stack([s.covariance(x) for s, x in zip(sensors, at, strict=True)])
        fused = precision_weighted_mean(covariances, stacked)
        bad = np.flatnonzero(~np.isfinite(fused).all(axis=1))
        if bad.size:
            raise InvalidInputError(
                f"the covariance of a report in row {bad[0]} is numerically singular. Check the "
                f"accuracies of the sensors {[s.name for s in sensors]}: metres and radians?"
            )
        at = (fused,) * len(sensors)
    return fused
