"""ASTERIX: plots of radars (category 48, 34), references from ADS-B (21) or a tracker (62).

Decoded by libasterix, an optional extra: of the kept decoders in the package index it has every
item and edition, writes as well as reads, and needs nothing else. (aviconv-asterix is ten times
as fast, but leaves the radar's place, I034/120, and the geometric height, I021/140, undecoded
and brings a dozen packages along.) Decoding takes about 0.2 s for a thousand plots: read a
recording once and keep it as a table.

A plot is slant range and azimuth from the radar's true north. Flight levels become reports of a
barometer, of plots and positions alike; the geometric height of ADS-B stays with its position.
A radar that the setup does not place on the earth stands where its own messages have it.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import checks
from probreg.recordings._arrivals import Arrivals, Piece, chosen, in_time
from probreg.recordings._heights import add_beside, against_prior, heights_assumed, in_order
from probreg.recordings._kinds import factor
from probreg.recordings._north import geodetic_axes
from probreg.recordings._reading import Reading
from probreg.recordings._recording import UNKNOWN, Recording
from probreg.recordings._setup import Setup
from probreg.recordings.formats._asterix_items import Message, Survey, blocks, decoded, messages
from probreg.recordings.formats._in_pieces import InPieces
from probreg.sensors import Sensor
from probreg.sensors.frame import LocalFrame
from probreg.sensors.geometry import wrap_angle
from probreg.typing import FloatArray, IntArray

NAUTICAL_MILE_M = 1_852.0
DAY_S = 86_400.0
FAR_OFF_M = 1_000.0  # of the place in the messages from that of the setup
PLOTS, POSITIONS = (48,), (21, 62)  # categories

Source = tuple[int, int]


class Asterix(InPieces):
    """Blocks of ASTERIX one after another, of the sources that the setup names."""

    endings: ClassVar[tuple[str, ...]] = (".ast", ".asterix")
    piece_bytes: ClassVar[int | None] = 1 << 18  # some seconds of decoding

    def read(self, path: Path, setup: Setup, *, trust_units: bool = False) -> Reading:
        """Read a file; its units are fixed, so there is nothing to trust."""
        return read(path, setup, setup.asterix)

    def complete_length(self, body: bytes) -> int:
        """Bytes of the blocks that are complete."""
        try:
            return max((end for _, end in blocks(body, Path())), default=0)
        except InvalidInputError:  # said with the place in the file when it is decoded
            return len(body)

    def arrivals(self, piece: Piece, setup: Setup, *, fixed: bool) -> Arrivals | None:
        """Reports of some blocks; times of day count on from the last one."""
        return read_piece(piece, setup, fixed=fixed)


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


def read(path: str | Path, setup: Setup, sources: Mapping[Source, str]) -> Reading:
    """Read a file of ASTERIX blocks.

    Parameters
    ----------
    path : str or Path
    setup : Setup
        With an origin; radars are `Radar2D` from north, references position sensors.
    sources : mapping of (int, int) to str
        From area and identification code to the sensor's name; other sources are passed over.

    Returns
    -------
    Reading
        Targets are aircraft addresses, where given; times are seconds of the first day. Notes
        say how many messages were left out, and why; heights assumed; places that disagree.

    Raises
    ------
    InvalidInputError
        No decoder, files and blocks that cannot be read, sensors that cannot be meant, and what
        `checks.check` refuses.
    """
    path = Path(path)
    _check(setup, sources)
    every = list(messages(path))
    placed, notes = _by_messages(setup, sources, every)
    arrays, cells, labels, said = _joined(placed, sources, every)
    for source, name in sources.items():
        if not (arrays["sensor"] == [sensor.name for sensor in setup.sensors].index(name)).any():
            raise InvalidInputError(f"{path} has no usable message of sensor {name!r} {source}.")
    del arrays["number"]
    joined = add_beside(placed, arrays, cells)
    order = np.argsort(joined.arrays["time"], kind="stable")
    recording = Recording(joined.setup.sensors, labels=labels, **in_order(joined.arrays, order))
    checks.check(recording)
    heights = [factor(name) * column[np.isfinite(column)] for name, column in cells.items()]
    notes = [*setup.notes, *notes, *said, *joined.notes]
    notes += against_prior(joined.setup, np.concatenate(heights))
    notes += heights_assumed(joined.setup, joined.arrays)
    return Reading(path, recording, joined.setup, tuple(notes))


def read_piece(piece: Piece, setup: Setup, *, fixed: bool) -> Arrivals | None:
    """Read some blocks, see `InPieces.arrivals`; sources may be silent."""
    _check(setup, setup.asterix)
    every = list(decoded(piece.body, piece.path, piece.start))
    placed, notes = (setup, []) if fixed else _by_messages(setup, setup.asterix, every)
    if not any(_usable(setup, name, source, every)[0] for source, name in setup.asterix.items()):
        return None
    arrays, cells, labels, said = _joined(placed, setup.asterix, every)
    order = np.argsort(arrays.pop("number"))
    arrays, cells = in_order(arrays, order), in_order(cells, order)
    day = np.mod(arrays["time"], DAY_S)
    arrays["time"] = _unwrapped(day, day[0] if piece.after is None else piece.after)
    joined = add_beside(placed, arrays, cells)
    arrays = joined.arrays
    arrays.setdefault("beside", np.arange(len(arrays["time"])))
    arrays = chosen(arrays, np.argsort(joined.rows, kind="stable"))
    in_time(joined.setup, arrays)
    return Arrivals(joined.setup, arrays, labels, (), (*notes, *said, *joined.notes))


def _by_messages(
    setup: Setup, sources: Mapping[Source, str], every: list[Message]
) -> tuple[Setup, list[str]]:
    """The setup with radars where their own messages have them, and notes on sources."""
    found = _survey(every)
    stations = {name: found[s].place for s, name in sources.items() if s in found}
    placed, notes = _placed(setup, stations)
    unused = [f"source {source} is not used" for source in sorted(set(found) - set(sources))]
    return placed, [*unused, *notes]


def _usable(setup: Setup, name: str, source: Source, every: list[Message]) -> tuple[list[int], int]:
    """Numbers of a source's plots or positions that are whole, and how many are not."""
    sensor = next(sensor for sensor in setup.sensors if sensor.name == name)
    used = POSITIONS if sensor.cartesian else PLOTS
    own = [k for k, m in enumerate(every) if m.source == source and m.category in used]
    whole = [k for k in own if every[k].values and every[k].time_s is not None]
    return whole, len(own) - len(whole)


def _check(setup: Setup, sources: Mapping[Source, str]) -> None:
    """Check that sensors and sources fit each other and the format."""
    if setup.origin is None:
        raise InvalidInputError("ASTERIX needs places on the earth; give the setup an origin.")
    own = [sensor for sensor in setup.sensors if sensor.kind.beside is None]
    strange = set(sources.values()) ^ {sensor.name for sensor in own}
    if strange or len(set(sources.values())) < len(sources):
        raise InvalidInputError(
            f"sources must name each sensor of the setup {[s.name for s in own]} once; see "
            f"{strange}."
        )
    for sensor in own:
        plots = sensor.bias_names == ("range", "azimuth") and sensor.from_north
        if not (plots or sensor.cartesian):
            raise InvalidInputError(
                f"sensor {sensor.name!r} must be a 2-D radar from north or a position sensor."
            )


def _placed(
    setup: Setup, stations: Mapping[str, tuple[float, float, float] | None]
) -> tuple[Setup, list[str]]:
    """The setup with radars where their messages have them, and notes of those that disagree."""
    assert setup.origin is not None
    frame, notes, places = LocalFrame(*setup.origin), [], dict(setup.places)
    for sensor in setup.sensors:
        place = stations.get(sensor.name)
        if place is None or sensor.position is None:
            continue
        there = frame.from_geodetic(np.array(place))
        off = float(np.linalg.norm(there[:2] - np.asarray(sensor.position[:2])))
        if off > FAR_OFF_M:
            notes.append(f"{sensor.name} is {off:.0f} m from where its messages have it")
        else:
            places.setdefault(sensor.name, place)
    geodetic = frozenset(sensor.name for sensor in setup.sensors if sensor.cartesian)
    return dataclasses.replace(setup, places=places, geodetic=geodetic), notes


def _joined(
    setup: Setup, sources: Mapping[Source, str], every: list[Message]
) -> tuple[dict[str, Any], dict[str, FloatArray], tuple[str, ...], list[str]]:
    """Arrays of a recording with the number of each report's message, by source.

    Then heights beside its reports, names of its targets, and notes.
    """
    numbers = {sensor.name: k for k, sensor in enumerate(setup.sensors)}
    notes: list[str] = []
    parts: list[tuple[FloatArray | IntArray, ...]] = []
    for source, name in sources.items():
        whole, lost = _usable(setup, name, source, every)
        notes += [f"{lost} of {name} lack place or time; left out"] if lost else []
        found = [every[k] for k in whole]
        own = setup.sensors[numbers[name]]
        columns = _reports(setup, own, found)
        parts.append((np.array(whole, dtype=int), np.full(len(whole), numbers[name]), *columns))
    number, sensor, time, values, level, height, address = (
        np.concatenate(column) for column in zip(*parts, strict=True)
    )
    known, target = np.unique(address, return_inverse=True)
    blank = int(UNKNOWN in known)
    labels = tuple(f"{number:06x}" for number in known[blank:].tolist())
    arrays = {"number": number, "sensor": sensor, "time": time, "values": values}
    arrays["target"] = target - blank
    return arrays, {"flight_level": level, "height_m": height}, labels, notes


def _reports(
    setup: Setup, sensor: Sensor, found: list[Message]
) -> tuple[FloatArray | IntArray, ...]:
    """Times, values, flight levels, heights that the values lack, addresses of the messages."""
    given = np.array([m.values for m in found], dtype=float).reshape(len(found), 2)
    level, height = (
        np.array([getattr(m, name) for m in found], dtype=float)
        for name in ("flight_level", "height_m")
    )
    values = np.full((len(found), max(len(s.bias_names) for s in setup.sensors)), np.nan)
    if sensor.cartesian:
        places = np.column_stack([given, height])
        values[:, : sensor.dim] = geodetic_axes(setup, sensor).values(places)[:, : sensor.dim]
        height = height if sensor.dim == 2 else np.full(len(found), np.nan)
    else:
        azimuth = wrap_angle(np.deg2rad(given[:, 1]))
        values[:, :2] = np.column_stack([NAUTICAL_MILE_M * given[:, 0], azimuth])
    time = np.array([m.time_s for m in found], dtype=float)
    time = _unwrapped(time, time[0]) if len(time) else time
    address = np.array([UNKNOWN if m.address is None else m.address for m in found], dtype=int)
    return time, values, level, height, address


def _unwrapped(time_of_day: FloatArray, after: float) -> FloatArray:
    """Count days on where the time of day falls by more than half a day; small falls stay.

    The first time is the one nearest to another that came before.
    """
    days = np.cumsum(np.round(-np.diff(time_of_day, prepend=after) / DAY_S))
    return time_of_day + DAY_S * days
