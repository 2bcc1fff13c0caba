"""What must hold of the first minutes of a recording that grows."""

from __future__ import annotations

import numpy as np

from probreg.recordings import checks
from probreg.recordings._kinds import factor
from probreg.recordings._recording import Recording
from probreg.recordings._units import (
    refuse_feet,
    refuse_kilometres,
    refuse_milliseconds,
    refuse_radians,
)


def check_start(recording: Recording, *, trust_units: bool = False) -> None:
    """Check the first minutes as a whole recording is checked.

    Parameters
    ----------
    recording : Recording
    trust_units : bool
        Whether to leave out the checks by the look of the numbers.

    Raises
    ------
    InvalidInputError
        A sensor without reports, clocks that do not overlap, wrong units.
    """
    checks.check(recording)
    if trust_units:
        return
    for k, sensor in enumerate(recording.sensors):
        values = recording.values[recording.sensor == k]
        if sensor.azimuth_column is not None:
            refuse_radians(np.rad2deg(values[:, sensor.azimuth_column]))
        column = sensor.kind.columns[0]
        if sensor.kind.beside is not None and factor(column) == 1.0:
            refuse_feet(column, values[:, 0])
    refuse_milliseconds(recording)
    refuse_kilometres(recording)
