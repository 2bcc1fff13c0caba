"""Batches of a table's cells into arrays of a recording."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from probreg.errors import InvalidInputError
from probreg.recordings import _columns as columns
from probreg.recordings._heights import beside_kinds
from probreg.recordings._kinds import factor
from probreg.recordings._north import convergence, geodetic_axes
from probreg.recordings._setup import Setup
from probreg.recordings._stream import Batches
from probreg.sensors import Sensor
from probreg.sensors.geometry import azimuth_from_north, wrap_angle
from probreg.typing import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Rows:
    """A table that is read batch by batch.

    Attributes
    ----------
    stream : Batches
    path : Path
    setup : Setup
    labels : dict of str to int
        Numbers of the targets met so far.
    others, names : list of str
        Columns that are none of ours, and all; filled at the first batch.
    """

    stream: Batches
    path: Path
    setup: Setup
    labels: dict[str, int] = field(default_factory=dict)
    others: list[str] = field(default_factory=list)
    names: list[str] = field(default_factory=list)

    @property
    def geodetic(self) -> frozenset[str]:
        """Position sensors that report in latitude and longitude; once read."""
        sensors = self.setup.sensors
        return frozenset(s.name for s in sensors if columns.is_geodetic(s, self.names))

    def beside(self, arrays: dict[str, Any], column: str) -> FloatArray:
        """Cells (n,) of a column where they are no component of the row's own report."""
        cells: FloatArray = arrays[column].copy()
        for k, sensor in enumerate(self.setup.sensors):
            if column in columns.columns_of(sensor, self.names):
                cells[arrays["sensor"] == k] = np.nan
        return cells

    def where(self, row: int) -> str:
        """Name a row, counted from 0, for an error."""
        return self.stream.row_names(self.path)(row)

    def read(self, limit: int) -> dict[str, Any]:
        """Read every batch and put the arrays together, in the order of the file."""
        parts = list(self._parts(limit))
        if not sum(len(part["time"]) for part in parts):
            raise InvalidInputError("no rows below the names of the columns.")
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    def _parts(self, limit: int) -> Iterator[dict[str, Any]]:
        start = 0
        for batch in self.stream.batches(self.path):
            if start == 0:
                self.names[:] = batch.schema.names
                self.others[:] = columns.check_names(batch.schema.names, self.setup)
            if start + len(batch) > limit:
                raise InvalidInputError(
                    f"more than row_limit = {limit} rows, about {limit / 4e6:.2g} GB in memory. "
                    "Cut the recording into pieces of time, or raise row_limit."
                )
            yield self.arrays(batch, start)
            start += len(batch)

    def arrays(self, batch: pa.RecordBatch, start: int) -> dict[str, Any]:
        """Arrays of a recording from one batch that starts at row `start` of the file."""

        def where(row: int) -> str:
            return self.where(start + row)

        sensors = self.setup.sensors
        known = {sensor.name: k for k, sensor in enumerate(sensors)}
        sensor, strange = columns.codes(batch.column("sensor"), known, grow=False)
        if (sensor < 0).any():
            row = int(np.argmax(sensor < 0))
            said = repr(strange[0]) if strange else "empty"
            raise InvalidInputError(
                f"{where(row)}: sensor is {said}, which the setup lacks; it has {list(known)}."
            )
        cells = {
            name: columns.numbers(batch.column(name), name, where)
            for name in batch.schema.names
            if name in columns.LIMITS
        }
        clock = next(name for name in columns.TIMES if name in batch.schema.names)
        time = columns.seconds(batch.column(clock), clock, where)
        lost = np.flatnonzero(~np.isfinite(time))
        if lost.size:
            raise InvalidInputError(f"{where(int(lost[0]))}: {clock} is empty; fill it in.")
        out: dict[str, Any] = {"sensor": sensor, "time": time}
        out["target"] = np.full(len(batch), -1, dtype=np.int32)
        if "target" in batch.schema.names:
            out["target"], _ = columns.codes(batch.column("target"), self.labels, grow=True)
        out["values"] = np.full((len(batch), max(len(s.bias_names) for s in sensors)), np.nan)
        out["azimuth_deg"] = cells.get("azimuth_deg", np.full(len(batch), np.nan))
        moving = columns.OWN[0] in cells or columns.OWN[1] in cells
        if moving:
            out["own_position"] = np.zeros((len(batch), 3))
        if "heading_deg" in cells:
            out["heading"] = np.full(len(batch), np.nan)
        for name in beside_kinds().keys() & cells.keys():
            given = np.flatnonzero(~np.isnan(cells[name]))
            columns.inside(cells[name][given], name, given, where)
            out[name] = cells[name]
        for k, own in enumerate(sensors):
            rows = np.flatnonzero(sensor == k)
            self._fill(out, own, rows, cells, where)
        return out

    def _fill(
        self,
        out: dict[str, Any],
        sensor: Sensor,
        rows: IntArray,
        cells: dict[str, FloatArray],
        where: columns.Where,
    ) -> None:
        """Write one sensor's rows into the arrays."""
        for name in columns.needed(sensor, self.setup, cells):
            columns.inside(cells[name][rows], name, rows, where)
        reported = columns.columns_of(sensor, cells)
        missing = np.full(len(rows), np.nan)
        given = [cells[name][rows] if name in cells else missing for name in reported]
        if columns.is_geodetic(sensor, cells):
            places = np.stack([*given, missing][:3], axis=1)
            values = geodetic_axes(self.setup, sensor).values(places)
            out["values"][rows, : sensor.dim] = values[:, : sensor.dim]
            return
        own: FloatArray = np.zeros((len(rows), 3))
        # a position sensor reports in the common frame whatever carries it
        if "own_position" in out and not sensor.cartesian:
            own = self._own(cells, rows, where)
            out["own_position"][rows] = own
        for j, column in enumerate(reported):
            value = factor(column) * given[j]
            out["values"][rows, j] = wrap_angle(value) if j == sensor.azimuth_column else value
        if "heading" in out:
            turn = convergence(self.setup, sensor, own)
            heading = cells["heading_deg"][rows]
            there = np.flatnonzero(np.isfinite(heading))
            columns.inside(heading[there], "heading_deg", rows[there], where)
            out["heading"][rows] = azimuth_from_north(np.deg2rad(heading) + turn)

    def _own(
        self, cells: dict[str, FloatArray], rows: IntArray, where: columns.Where
    ) -> FloatArray:
        """Own positions (m, 3); rows that give none at all do not move."""
        names = [name for name in columns.OWN if name in cells]
        given = np.stack([cells[name][rows] for name in names], axis=1)
        moving = np.isfinite(given).any(axis=1)
        own = np.zeros((len(rows), 3))
        for j, name in enumerate(names):
            values = columns.inside(given[moving, j], name, rows[moving], where)
            own[moving, columns.OWN.index(name)] = values
        return own
