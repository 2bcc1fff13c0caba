"""A table of reports that no file gave: simulated ones, or those read from another format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from probreg.recordings._columns import OWN, of_reports
from probreg.recordings._heights import convergence, signed
from probreg.recordings._kinds import factor
from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.recordings.files import replacing
from probreg.recordings.table import table_format
from probreg.sensors.geometry import azimuth_from_north, wrap_angle


def create(path: str | Path, recording: Recording, setup: Setup) -> None:
    """Write a recording as a new table that `table.read` reads.

    Parameters
    ----------
    path : str or Path
        Ends with .csv or .parquet.
    recording : Recording
    setup : Setup
        With an origin, azimuths and headings of the table count from true north where the
        sensor stands, as `table.read` takes them.

    Raises
    ------
    InvalidInputError
        An ending not known, a folder that cannot be written.
    """
    path = Path(path)
    form = table_format(path)
    own = recording.own_position
    heading = None if recording.heading is None else azimuth_from_north(recording.heading)
    names = np.array([sensor.name for sensor in recording.sensors])
    columns = {"time_s": recording.time, "sensor": names[recording.sensor]}
    for k, sensor in enumerate(recording.sensors):
        rows = np.flatnonzero(recording.sensor == k)
        here = np.zeros((len(rows), sensor.dim)) if own is None else own[rows]
        turn = convergence(setup, sensor, here)
        for j, name in enumerate(of_reports(sensor)):
            cells = columns.setdefault(name, np.full(len(recording), np.nan))
            values = recording.values[rows, j]
            if j == sensor.azimuth_column:
                values = np.mod(values - signed(setup, sensor, turn), 2.0 * np.pi)
            cells[rows] = values / factor(name)
        if heading is not None:
            heading[rows] = heading[rows] - turn
    if recording.labels:
        columns["target"] = np.array([*recording.labels, ""])[recording.target]
    if own is not None:
        columns.update(zip(OWN, own.T, strict=False))
    if heading is not None:
        columns["heading_deg"] = np.rad2deg(wrap_angle(heading))
    with replacing(path) as part:
        form.create(part, pd.DataFrame(columns))
