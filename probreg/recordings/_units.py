"""Wrong units by the look of the numbers: radians for degrees, kilometres for metres."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings._kinds import factor
from probreg.recordings._recording import Recording
from probreg.typing import FloatArray

ENOUGH = 20  # reports, to speak of a spread
TRUST = "say that they are right with --trust-units (in Python trust_units=True)"
LATEST_S = 1e11  # POSIX seconds are below for three thousand years
LONGEST_SCAN_S = 1_000.0  # between reports of one target by one sensor
NO_AIRLINER_M = 20_000.0
HIGHEST_LEVEL_M = 16_000.0
STEP_FT = 25.0
NEARLY_A_TURN = 5.5  # of the 6.28 that radians can spread over
FEW_SIGMAS = 10.0  # no radar's longest range is so few of its standard deviations


def refuse_radians(azimuths_deg: FloatArray) -> None:
    """Refuse a column of degrees that spreads over all that radians can, and no further.

    Sensors that look into one narrow sector may spread over a few degrees only; that they end
    where radians end as well is no accident when the spread is nearly a turn of them.
    """
    if len(azimuths_deg) < ENOUGH:
        return
    low, high = float(azimuths_deg.min()), float(azimuths_deg.max())
    bounds = ((-np.pi, np.pi), (0.0, 2.0 * np.pi))
    fits = any(low >= start - 1e-3 and high <= end + 1e-3 for start, end in bounds)
    if fits and high - low > NEARLY_A_TURN:
        raise InvalidInputError(
            f"column 'azimuth_deg' runs from {low:.3f} to {high:.3f} and no further: these look "
            f"like radians. Convert them to degrees, or {TRUST}."
        )


def refuse_milliseconds(recording: Recording) -> None:
    """Refuse times far in the future, and reports too far apart for any track."""
    columns = (recording.time, recording.target, recording.sensor)
    order = np.lexsort(columns)
    time, target, sensor = (column[order] for column in columns)
    same = (np.diff(target) == 0) & (np.diff(sensor) == 0)
    gap = float(np.median(np.diff(time)[same])) if same.any() else 0.0
    latest = float(np.abs(time).max(initial=0.0))
    if latest <= LATEST_S and gap <= LONGEST_SCAN_S:
        return
    reason = (
        f"times are as late as {latest:g} s"
        if latest > LATEST_S
        else f"reports of one sensor and target are typically {gap:g} s apart"
    )
    raise InvalidInputError(
        f"{reason}: these look like milliseconds. Convert the times to seconds, or {TRUST}."
    )


def refuse_feet(column: str, heights: FloatArray) -> tuple[str, ...]:
    """Refuse heights (n,) that only feet can be, and say which may be.

    Aircraft report in steps of 25 or 100 feet. Metres that are whole multiples of these numbers
    are those of a metric flight level, or of a column that was not converted.
    """
    if heights.size < ENOUGH or factor(column) != 1.0:
        return ()
    stepped = bool((heights == STEP_FT * np.rint(heights / STEP_FT)).all())
    if np.median(heights) > NO_AIRLINER_M or (stepped and heights.max() > HIGHEST_LEVEL_M):
        raise InvalidInputError(
            f"column {column!r} runs to {heights.max():g}, most above {np.median(heights):.0f}: "
            f"these look like feet. Multiply them by 0.3048, or {TRUST}."
        )
    if not stepped or np.ptp(heights) == 0.0:
        return ()
    return (
        f"every {column} is a whole multiple of {STEP_FT:g}: if these are feet, multiply them by "
        "0.3048",
    )


def refuse_kilometres(recording: Recording) -> None:
    """Refuse ranges too short for the radar's accuracy or for the distance to the others.

    Radars share targets only if their ranges together reach from one to the other.
    """
    placed, reach, sigmas = {}, {}, {}
    for k, sensor in enumerate(recording.sensors):
        if sensor.position is not None and "range" in sensor.bias_names:
            j = sensor.bias_names.index("range")
            placed[k], sigmas[k] = np.asarray(sensor.position[:2]), float(sensor.sigmas[j])
            reach[k] = float(recording.values[recording.sensor == k, j].max())
    for k, place in placed.items():
        sensor = recording.sensors[k]
        apart = [
            np.linalg.norm(place - other) - reach[j] - reach[k]
            for j, other in placed.items()
            if j != k
        ]
        short = reach[k] < FEW_SIGMAS * sigmas[k]
        if short or (recording.own_position is None and apart and min(apart) > 0.0):
            reason = (
                f"its standard deviation is {sigmas[k]:g} m"
                if short
                else f"the ranges of the nearest radar leave a gap of {min(apart):.0f} m to it"
            )
            raise InvalidInputError(
                f"range_m of sensor {sensor.name!r} is {reach[k]:g} at most, but {reason}: these "
                "look like kilometres or miles. Convert them to metres, correct the sensor's "
                f"place, or {TRUST}."
            )
