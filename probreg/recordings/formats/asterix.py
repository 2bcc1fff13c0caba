"""ASTERIX: plots of radars (category 48, 34), references from ADS-B (21) or a tracker (62).

Decoded by libasterix, an optional extra: of the kept decoders in the package index it has every
item and edition, writes as well as reads, and needs nothing else. (aviconv-asterix is ten times
as fast, but leaves the radar's place, I034/120, and the geometric height, I021/140, undecoded
and brings a dozen packages along.) Decoding takes about 0.2 s for a thousand plots: read a
recording once and keep it as a table.

A plot is slant range and azimuth from the radar's true north, with a flight level; the common
frame is a plane. Each plot is put on the ellipsoid by its three numbers, and from there into the
plane, as the range and azimuth in which a radar there would see the target. A bias of slant
range is therefore seen divided by the cosine of elevation. Flight levels are pressure heights.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import ClassVar

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import checks
from probreg.recordings._reading import Reading
from probreg.recordings._recording import UNKNOWN, Recording
from probreg.recordings._setup import Setup
from probreg.recordings._slant import site, target_places
from probreg.recordings.formats._asterix_items import Message, Survey, messages
from probreg.recordings.formats._format import RecordingFormat
from probreg.sensors import Sensor
from probreg.sensors.frame import LocalFrame
from probreg.typing import FloatArray, IntArray

NAUTICAL_MILE_M = 1_852.0
DAY_S = 86_400.0
FAR_OFF_M = 1_000.0  # of the place in the messages from that of the setup
PLOTS, POSITIONS = (48,), (21, 62)  # categories

Source = tuple[int, int]


class Asterix(RecordingFormat):
    """Blocks of ASTERIX one after another, of the sources that the setup names."""

    endings: ClassVar[tuple[str, ...]] = (".ast", ".asterix")

    def read(self, path: Path, setup: Setup, *, trust_units: bool = False) -> Reading:
        """Read a file; its units are fixed, so there is nothing to trust."""
        return Reading(path, *read(path, setup, setup.asterix, setup.heights_m))


def survey(path: str | Path) -> dict[Source, Survey]:
    """List the sources of a file, to write a setup for it.

    Raises
    ------
    InvalidInputError
        No decoder, a file that cannot be read or decoded.
    """
    return _survey(list(messages(Path(path))))


def _survey(every: list[Message]) -> dict[Source, Survey]:
    counts: dict[Source, Counter[int]] = {}
    places: dict[Source, tuple[float, float, float]] = {}
    for message in every:
        counts.setdefault(message.source, Counter())[message.category] += 1
        if message.category == 34 and message.values and message.height_m is not None:
            places[message.source] = (*message.values, message.height_m)
    return {s: Survey(dict(found), places.get(s)) for s, found in counts.items()}


def read(
    path: str | Path,
    setup: Setup,
    sources: Mapping[Source, str],
    heights_m: Mapping[str, float] | None = None,
) -> tuple[Recording, tuple[str, ...]]:
    """Read a file of ASTERIX blocks.

    Parameters
    ----------
    path : str or Path
    setup : Setup
        With an origin; radars are `Radar2D` from north, references two-dimensional.
    sources : mapping of (int, int) to str
        From area and identification code to the sensor's name; other sources are passed over.
    heights_m : mapping of str to float, optional
        Of radars above the ellipsoid, where their messages do not give it; else zero.

    Returns
    -------
    recording : Recording
        Targets are aircraft addresses, where given; times are seconds of the first day.
    notes : tuple of str
        How many messages were left out, and why; heights assumed; places that disagree.

    Raises
    ------
    InvalidInputError
        No decoder, files and blocks that cannot be read, sensors that cannot be meant, and what
        `checks.check` refuses.
    """
    sensors = {sensor.name: k for k, sensor in enumerate(setup.sensors)}
    frame = _check(setup, sources, sensors)
    every = list(messages(Path(path)))
    found = _survey(every)
    notes = [f"source {source} is not used" for source in sorted(set(found) - set(sources))]
    parts: list[tuple[FloatArray | IntArray, ...]] = []
    for source, name in sources.items():
        k, place = sensors[name], found.get(source, Survey({}, None)).place
        whole, lost = _usable(setup.sensors[k], [m for m in every if m.source == source])
        if not whole:
            raise InvalidInputError(f"{path} has no usable message of sensor {name!r} {source}.")
        height = place[2] if place else (heights_m or {}).get(name)
        reports, said = _reports(setup.sensors[k], frame, whole, place, height)
        notes += said
        notes += [f"{lost} of {name} lack place, time or height; left out"] if lost else []
        parts.append((np.full(len(reports[0]), k), *reports))
    recording = _join(setup, parts)
    checks.check(recording, setup.window_s)
    return recording, tuple(notes)


def _usable(sensor: Sensor, own: list[Message]) -> tuple[list[Message], int]:
    """Plots or positions of a source that are whole, and the number of those that are not."""
    used = POSITIONS if sensor.cartesian else PLOTS
    own = [m for m in own if m.category in used]
    whole = [m for m in own if m.values and m.time_s is not None and m.height_m is not None]
    return whole, len(own) - len(whole)


def _reports(
    sensor: Sensor,
    frame: LocalFrame,
    found: list[Message],
    place: tuple[float, float, float] | None,
    height: float | None,
) -> tuple[tuple[FloatArray, FloatArray, IntArray], list[str]]:
    """Times, values and addresses of one sensor's messages, and notes about them."""
    values, said = _values(sensor, frame, found, place, height)
    real = np.isfinite(values).all(axis=1)
    time = _unwrapped(np.array([m.time_s for m in found]))
    address = np.array([UNKNOWN if m.address is None else m.address for m in found])
    return (time[real], values[real], address[real]), said


def _check(setup: Setup, sources: Mapping[Source, str], sensors: dict[str, int]) -> LocalFrame:
    """Check that sensors and sources fit each other and the format; return the frame."""
    if setup.origin is None:
        raise InvalidInputError("ASTERIX needs places on the earth; give the setup an origin.")
    strange = set(sources.values()) ^ set(sensors)
    if strange or len(set(sources.values())) < len(sources):
        raise InvalidInputError(
            f"sources must name each sensor of the setup {list(sensors)} once; see {strange}."
        )
    for sensor in setup.sensors:
        plots = sensor.bias_names == ("range", "azimuth") and sensor.from_north
        if sensor.dim != 2 or not (plots or sensor.cartesian):
            raise InvalidInputError(
                f"sensor {sensor.name!r} must be a 2-D radar from north or a 2-D position sensor."
            )
    return LocalFrame(*setup.origin)


def _values(
    sensor: Sensor,
    frame: LocalFrame,
    found: list[Message],
    place: tuple[float, float, float] | None,
    height: float | None,
) -> tuple[FloatArray, list[str]]:
    """Reports (n, 2) of one sensor, NaN where there can be none, and notes about them."""
    given = np.array([[*m.values, m.height_m] for m in found])  # type: ignore[misc]
    if sensor.cartesian:
        return frame.from_geodetic(given)[:, : sensor.dim], []
    notes = []
    if height is None:
        notes.append(f"the height of {sensor.name} is not given and taken as 0 m")
    if place:
        off = np.linalg.norm(frame.from_geodetic(np.array(place))[:2] - np.asarray(sensor.position))
        if off > FAR_OFF_M:
            notes.append(f"{sensor.name} is {off:.0f} m from where its messages have it")
    values = _flat_polar(sensor, frame, given, height or 0.0)
    lost = int((~np.isfinite(values).all(axis=1)).sum())
    if lost:
        notes.append(f"{lost} of {sensor.name} have a range below their height; left out")
    return values, notes


def _flat_polar(
    sensor: Sensor, frame: LocalFrame, given: FloatArray, height_m: float
) -> FloatArray:
    """Range and azimuth (n, 2) in the plane of the frame, of plots (NM, degrees, height)."""
    radar = site(frame, np.asarray(sensor.position), height_m)
    slant, azimuth = NAUTICAL_MILE_M * given[:, 0], np.deg2rad(given[:, 1])
    places = target_places(radar, slant, azimuth, given[:, 2])
    values = np.full((len(given), 2), np.nan)
    real = np.isfinite(places).all(axis=1)
    values[real] = sensor.to_report(frame.from_geodetic(places[real])[:, :2])
    return values


def _unwrapped(time_of_day: FloatArray) -> FloatArray:
    """Count days on where the time of day falls by more than half a day; small falls stay."""
    days = np.cumsum(np.round(-np.diff(time_of_day, prepend=time_of_day[0]) / DAY_S))
    return time_of_day + DAY_S * days


def _join(setup: Setup, parts: Sequence[tuple[FloatArray | IntArray, ...]]) -> Recording:
    sensor, time, values, address = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(time, kind="stable")
    known, target = np.unique(address, return_inverse=True)
    blank = int(known[0] == UNKNOWN)
    labels = tuple(f"{number:06x}" for number in known[blank:].tolist())
    return Recording(
        setup.sensors, sensor[order], time[order], values[order], target[order] - blank, labels
    )
