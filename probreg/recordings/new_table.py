"""A table of reports that no file gave: simulated ones, or those read from another format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from probreg.recordings._columns import GEODETIC, OWN, of_reports
from probreg.recordings._kinds import factor
from probreg.recordings._north import convergence, geodetic_axes
from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.recordings.files import replacing
from probreg.recordings.table import table_format
from probreg.sensors import Sensor
from probreg.sensors.geometry import azimuth_from_north, wrap_angle
from probreg.typing import FloatArray


def create(path: str | Path, recording: Recording, setup: Setup) -> None:
    """Write a recording as a new table that `table.read` reads.

    Parameters
    ----------
    path : str or Path
        Ends with .csv or .parquet.
    recording : Recording
    setup : Setup
        With an origin, headings of the table count from true north where the platform is, as
        `table.read` takes them.

    Raises
    ------
    InvalidInputError
        An ending not known, a folder that cannot be written.
    """
    path = Path(path)
    form = table_format(path)
    rows = np.cumsum(recording.alone) - 1  # of each report, or of the one that it stands beside
    if recording.beside is not None:
        rows = rows[recording.beside]
    own, count = recording.own_position, int(rows.max(initial=-1)) + 1
    names = np.array([sensor.name for sensor in recording.sensors])
    columns = {"time_s": recording.time[recording.alone]}
    columns["sensor"] = names[recording.sensor[recording.alone]]
    heading = None if recording.heading is None else azimuth_from_north(recording.heading)
    for k, sensor in enumerate(recording.sensors):
        mine = np.flatnonzero(recording.sensor == k)
        for name, cells in _cells(setup, sensor, recording.values[mine]).items():
            columns.setdefault(name, np.full(count, np.nan))[rows[mine]] = cells
        if heading is not None:
            here = np.zeros((len(mine), 2)) if own is None else own[mine]
            heading[mine] = heading[mine] - convergence(setup, sensor, here)
    if recording.labels:
        columns["target"] = np.array([*recording.labels, ""])[recording.target[recording.alone]]
    if own is not None:
        columns.update(zip(OWN, own[recording.alone].T, strict=False))
    if heading is not None:
        columns["heading_deg"] = np.rad2deg(wrap_angle(heading[recording.alone]))
    with replacing(path) as part:
        form.create(part, pd.DataFrame(columns))


def _cells(setup: Setup, sensor: Sensor, values: FloatArray) -> dict[str, FloatArray]:
    """Values of one sensor by column."""
    if sensor.name in setup.geodetic:
        found = geodetic_axes(setup, sensor).places(values[:, : sensor.dim])
        return dict(zip(GEODETIC[: sensor.dim], found.T, strict=False))
    cells = {}
    for j, name in enumerate(of_reports(sensor)):
        own = np.mod(values[:, j], 2.0 * np.pi) if j == sensor.azimuth_column else values[:, j]
        cells[name] = own / factor(name)
    return cells
