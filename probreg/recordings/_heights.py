"""Reports on the round earth that tell a height: into values in the common frame, and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import _columns as columns
from probreg.recordings._setup import Setup
from probreg.recordings._slant import raised, site, target_places
from probreg.sensors import Sensor, sense
from probreg.sensors.frame import LocalFrame
from probreg.sensors.geometry import wrap_angle
from probreg.typing import FloatArray, IntArray


def convergence(setup: Setup, sensor: Sensor, own: FloatArray) -> FloatArray:
    """Clockwise angles (m,) from the frame's north to true north where a sensor stands.

    Own positions (m, d) add to the sensor's; without an origin north is the frame's.
    """
    place = own[:, : sensor.dim] + (0.0 if sensor.position is None else sensor.position)
    if setup.origin is None or not len(place):
        return np.zeros(len(place))
    if (place == place[0]).all():
        return np.full(len(place), LocalFrame(*setup.origin).convergence(place[0]))
    return LocalFrame(*setup.origin).convergence(place)


def signed(setup: Setup, sensor: Sensor, turn: FloatArray) -> FloatArray:
    """What the turn of north adds to an azimuth: nothing to one from the heading."""
    if sensor.name in setup.body_frame:
        return np.zeros_like(turn)
    return -sense(sensor) * turn


def positions(setup: Setup, sensor: Sensor, places: FloatArray) -> FloatArray:
    """Values (m, d) of a position sensor from latitude, longitude and height (m, 3)."""
    return LocalFrame(*setup.origin).from_geodetic(places)[:, : sensor.dim]  # type: ignore[misc]


def places(setup: Setup, values: FloatArray, height_m: FloatArray) -> FloatArray:
    """Inverse of `positions`; two-dimensional values (m, 2) take their heights (m,)."""
    frame = LocalFrame(*setup.origin)  # type: ignore[misc]
    if values.shape[1] == 3:
        return frame.to_geodetic(values)
    return raised(frame, values, height_m)


def flattened(setup: Setup, sensor: Sensor, slant: FloatArray, height_m: FloatArray) -> FloatArray:
    """Range and azimuth (m, 2) in the plane from those of slant range and heights (m,).

    Azimuths are those of the table turned by `convergence`. NaN where no target can be.
    """
    out = slant.copy()
    height = setup.heights_m.get(sensor.name, 0.0)
    if setup.origin is None:
        with np.errstate(invalid="ignore"):
            out[:, 0] = np.sqrt(slant[:, 0] ** 2 - (height_m - height) ** 2)
        return out
    frame = LocalFrame(*setup.origin)
    radar = site(frame, np.asarray(sensor.position), height)
    compass = _compass(sensor, slant[:, 1] - _turn(setup, sensor))
    found = target_places(radar, slant[:, 0], compass, height_m)
    real = np.isfinite(found).all(axis=1)
    out[~real] = np.nan
    out[real] = sensor.to_report(frame.from_geodetic(found[real])[:, :2])
    return out


def slanted(setup: Setup, sensor: Sensor, values: FloatArray, height_m: FloatArray) -> FloatArray:
    """Inverse of `flattened`."""
    out = values.copy()
    height = setup.heights_m.get(sensor.name, 0.0)
    if setup.origin is None:
        out[:, 0] = np.hypot(values[:, 0], height_m - height)
        return out
    frame = LocalFrame(*setup.origin)
    radar = site(frame, np.asarray(sensor.position), height)
    # not `to_cartesian`, which allows for noise
    north = _compass(sensor, values[:, 1])
    away = values[:, :1] * np.stack([np.sin(north), np.cos(north)], axis=1)
    local = radar.from_geodetic(raised(frame, sensor.position + away, height_m))
    out[:, 0] = np.linalg.norm(local, axis=1)
    compass = np.arctan2(local[:, 0], local[:, 1])
    out[:, 1] = wrap_angle(_compass(sensor, compass) + _turn(setup, sensor))
    return out


def _turn(setup: Setup, sensor: Sensor) -> float:
    return float(signed(setup, sensor, convergence(setup, sensor, np.zeros((1, 2))))[0])


def _compass(sensor: Sensor, azimuth: FloatArray) -> FloatArray:
    """From the sensor's azimuth to one from north clockwise, and back: its own inverse."""
    return azimuth if sensor.from_north else 0.5 * np.pi - azimuth


def bring_down(
    setup: Setup, arrays: dict[str, Any], where: columns.Where
) -> tuple[FloatArray | None, tuple[str, ...]]:
    """Turn slant ranges in `arrays`, in the order of the file, into ranges in the plane.

    Returns
    -------
    height_m : ndarray, shape (n,), or None
        Heights that were used, NaN where none was; None when the table has none.
    notes : tuple of str

    Raises
    ------
    InvalidInputError
        A radar whose reports give a height only in part, or one above the range; with the row.
    """
    given = arrays.pop("height_m", None)
    height, notes = None if given is None else given.copy(), []
    for k, sensor in enumerate(setup.sensors):
        rows = np.flatnonzero(arrays["sensor"] == k)
        if not columns.is_slant(sensor) or not len(rows):
            continue
        own = arrays.get("own_position")
        moving = sensor.name in setup.body_frame or (own is not None and bool(own[rows].any()))
        there = np.zeros(len(rows), dtype=bool) if given is None else np.isfinite(given[rows])
        if not there.any() or moving:
            if height is not None:
                height[rows] = np.nan
            if setup.origin is not None or there.any():
                notes.append(_ground(sensor, bool(there.any())))
            continue
        _bring_down(setup, k, rows, there, arrays["values"], height, where)
        if sensor.name not in setup.heights_m:
            notes.append(f"the height of {sensor.name} is not given and taken as 0 m")
    return height, tuple(notes)


def _ground(sensor: Sensor, moving: bool) -> str:
    why = "it moves, and heights are not used" if moving else "there is no height_m"
    return (
        f"ranges of {sensor.name} are taken as ground ranges ({why}): those of aircraft are slant "
        "ranges, too long by the height squared over twice the range"
    )


def _bring_down(
    setup: Setup,
    k: int,
    rows: IntArray,
    there: Any,
    values: FloatArray,
    height: Any,
    where: columns.Where,
) -> None:
    """Rows of one radar, all of which must have a height that can be."""
    sensor = setup.sensors[k]
    if not there.all():
        lost = np.flatnonzero(~there)
        raise InvalidInputError(
            f"{where(int(rows[lost[0]]))}: height_m is empty, and other reports of sensor "
            f"{sensor.name!r} have one ({lost.size} of {len(rows)} lack it). Fill it in, or remove "
            "the rows: slant and ground ranges do not mix."
        )
    columns.inside(height[rows], "height_m", rows, where)
    flat = flattened(setup, sensor, values[rows, :2], height[rows])
    bad = np.flatnonzero(~np.isfinite(flat).all(axis=1))
    if bad.size:
        row = int(rows[bad[0]])
        raise InvalidInputError(
            f"{where(row)}: no target can be {values[row, 0]:.0f} m from sensor {sensor.name!r} "
            f"and {height[row]:.0f} m high ({bad.size} such). Correct the height (metres, not "
            "feet) or that of the sensor, or remove the row."
        )
    values[rows, :2] = flat
