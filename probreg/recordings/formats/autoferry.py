"""The public Autoferry benchmark: a small ferry with radar, lidar and cameras in a harbour.

Published with *Heterogeneous multi-sensor tracking for an autonomous surface vehicle in a
littoral environment*, Ocean Engineering (2022); two vessels among the targets carry GNSS. Each
scenario has a folder `scenarioN` with `scenarioN_detections.json`, a list of
`{sensorID, time, ownshipPosition: [north, east], measurement}`, and
`scenarioN_groundTruth.json`, a list of lists of `{targetID, time, position: [north, east, down]}`.

A lidar or radar `measurement` holds north and east relative to the own ship: one row of all
norths and one of all easts, or just the two numbers of a single detection. That of a camera
holds bearings from north, clockwise, radians. Either may be empty. A bearing that is twice in
one image (some are) is one report.

Detections are centroids of what a sensor saw; they are turned into range and azimuth because
that is what these sensors measure and are biased in. Heading was not recorded, so a bias of
heading and one of azimuth cannot be told apart.
"""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings._reading import Reading
from probreg.recordings._recording import UNKNOWN, Recording
from probreg.recordings._setup import Setup
from probreg.recordings.formats._format import RecordingFormat
from probreg.sensors import BearingSensor, PositionSensor, Radar2D, Sensor
from probreg.sensors.geometry import azimuth_from_north, cartesian_to_polar
from probreg.typing import FloatArray, IntArray

TARGETS = ("1", "2")
# robust spread of detections about the vessels' antennas, middle of the scenarios: the extent
# of a hull is in it, which is more than the sensors' own errors
RADAR_SIGMA = (4.0, np.deg2rad(2.0))
LIDAR_SIGMA = (2.0, np.deg2rad(1.5))
CAMERA_SIGMA = np.deg2rad(2.0)
GNSS_SIGMA_M = 1.0
SENSOR_NUMBERS = {1: "lidar", 2: "radar", 3: "infrared", 4: "electro_optical"}
GNSS = "gnss"


class Autoferry(RecordingFormat):
    """The folder of a scenario; the setup has the benchmark's sensors, see `setup`."""

    def recognises(self, path: Path) -> bool:
        """A folder that holds its detections."""
        return (path / f"{path.name}_detections.json").is_file()

    def read(self, path: Path, setup: Setup, *, trust_units: bool = False) -> Reading:
        """Read a scenario; its units are fixed, so there is nothing to trust."""
        names = [sensor.name for sensor in sensors()]
        if [sensor.name for sensor in setup.sensors] != names:
            raise InvalidInputError(f"{path}: the sensors of the setup must be {names}.")
        found = read(path.parent, int(path.name.removeprefix("scenario")))
        return Reading(path, dataclasses.replace(found, sensors=setup.sensors), setup)


def sensors() -> tuple[Sensor, ...]:
    """Lidar, radar, infrared and electro-optical camera, and GNSS, by these names."""
    here = (0.0, 0.0)
    return (
        Radar2D(here, *LIDAR_SIGMA, "lidar", from_north=True),
        Radar2D(here, *RADAR_SIGMA, "radar", from_north=True),
        BearingSensor(CAMERA_SIGMA, "infrared", from_north=True),
        BearingSensor(CAMERA_SIGMA, "electro_optical", from_north=True),
        PositionSensor(((GNSS_SIGMA_M**2, 0.0), (0.0, GNSS_SIGMA_M**2)), GNSS),
    )


def setup() -> Setup:
    """Every bias of the ferry's sensors, with GNSS as the reference; numbers for small vessels."""
    every = sensors()
    return Setup(
        every,
        {s.name: () if s.name == GNSS else s.bias_names for s in every},
        acceleration_m_s2=0.5,
        gate_m=30.0,
        targets="surface",
    )


@dataclass(frozen=True, eq=False)
class _Part:
    """Reports of one entry: all of one sensor at one time."""

    sensor: int
    time: float
    values: FloatArray
    target: IntArray
    own: FloatArray


def read(folder: str | Path, scenario: int) -> Recording:
    """Read one scenario.

    Parameters
    ----------
    folder : str or Path
        Holds the folders `scenario2`, `scenario3`, ...
    scenario : int

    Returns
    -------
    Recording
        In order of time (detections of some scenarios are not). Detections have no identity;
        those of GNSS have "1" and "2". Positions are metres east and north of the benchmark's
        origin (63.4389029 N, 10.3990828 E), in its plane: azimuths count from its north.

    Raises
    ------
    InvalidInputError
        No such folder or scenario, files that are no JSON or not of this form, with the entry.
    """
    folder = Path(folder)
    place = folder / f"scenario{scenario}"
    if not place.is_dir():
        there = sorted(int(p.name[8:]) for p in folder.glob("scenario*") if p.name[8:].isdigit())
        raise InvalidInputError(f"{folder} has no scenario {scenario}; there are {there}.")
    paths = [place / f"scenario{scenario}_{name}.json" for name in ("detections", "groundTruth")]
    detections, truth = (_load(path) for path in paths)
    parts = []
    for number, entry in enumerate(detections):
        try:
            parts.append(_detections(entry))
        except (KeyError, TypeError, ValueError) as error:
            raise _bad_entry(paths[0], number, error) from None
    known: set[tuple[str, float]] = set()
    for number, entry in enumerate(truth):
        try:
            parts += _positions(entry, known)
        except (KeyError, TypeError, ValueError) as error:
            raise _bad_entry(paths[1], number, error) from None
    return _join(parts)


def _bad_entry(path: Path, number: int, error: Exception) -> InvalidInputError:
    what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
    return InvalidInputError(f"{path}, entry {number}: {what}. Compare with the published file.")


def _load(path: Path) -> list[Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror}.") from None
    except json.JSONDecodeError as error:
        raise InvalidInputError(
            f"{path}, line {error.lineno}, column {error.colno}: no JSON ({error.msg}); "
            "the file is cut off or damaged."
        ) from None
    except UnicodeDecodeError as error:
        raise InvalidInputError(f"{path} is not UTF-8 at byte {error.start}.") from None
    if not isinstance(content, list) or not content:
        raise InvalidInputError(f"{path} must hold a list of entries.")
    return content


def _numbers(value: Any, name: str, size: int | None = None) -> FloatArray:
    array = np.asarray(value, dtype=float)
    if not np.isfinite(array).all() or (size is not None and array.shape != (size,)):
        raise ValueError(f"{name} is {value!r:.80}")
    return array


def _detections(entry: dict[str, Any]) -> _Part:
    number = entry["sensorID"]
    if number not in SENSOR_NUMBERS:
        raise ValueError(f"sensorID is {number!r}, not one of {sorted(SENSOR_NUMBERS)}")
    names = [sensor.name for sensor in sensors()]
    index = names.index(SENSOR_NUMBERS[number])
    own = _numbers(entry["ownshipPosition"], "ownshipPosition", 2)[::-1]
    measured = _numbers(entry["measurement"], "measurement")
    if not sensors()[index].gives_position:
        bearings = list(dict.fromkeys(measured.ravel().tolist()))
        values = np.column_stack([bearings, np.full(len(bearings), np.nan)])
    else:
        values = _polar(measured)
    n = len(values)
    time = float(_numbers(entry["time"], "time"))
    return _Part(index, time, values, np.full(n, UNKNOWN), np.tile(own, (n, 1)))


def _polar(measured: FloatArray) -> FloatArray:
    """Range and azimuth from north (n, 2) of detections given as rows of norths and easts."""
    if measured.size == 0:
        return np.zeros((0, 2))
    if measured.ndim not in (1, 2) or len(measured) != 2:
        raise ValueError(f"measurement has shape {measured.shape}, not norths and easts")
    north, east = measured.reshape(2, -1)
    polar = cartesian_to_polar(np.stack([east, north], axis=-1))
    polar[:, 1] = azimuth_from_north(polar[:, 1])
    return polar


def _positions(entry: list[dict[str, Any]], known: set[tuple[str, float]]) -> list[_Part]:
    """GNSS positions that no earlier entry gave: each is repeated until the next is there."""
    parts = []
    for one in entry:
        target, time = str(one["targetID"]), float(_numbers(one["time"], "time"))
        if target not in TARGETS:
            raise ValueError(f"targetID is {target}, not one of {TARGETS}")
        if (target, time) in known:
            continue
        known.add((target, time))
        north, east, _ = _numbers(one["position"], "position", 3)
        number = np.array([TARGETS.index(target)])
        index = len(SENSOR_NUMBERS)
        parts.append(_Part(index, time, np.array([[east, north]]), number, np.zeros((1, 2))))
    return parts


def _join(parts: list[_Part]) -> Recording:
    counts = [len(part.values) for part in parts]
    time = np.repeat([part.time for part in parts], counts)
    order = np.argsort(time, kind="stable")
    return Recording(
        sensors(),
        np.repeat([part.sensor for part in parts], counts)[order],
        time[order],
        np.concatenate([part.values for part in parts])[order],
        np.concatenate([part.target for part in parts])[order],
        TARGETS,
        np.concatenate([part.own for part in parts])[order],
    )
