"""What is taken from ASTERIX messages: plots, positions and stations, in the units of the items."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from probreg import extras
from probreg.errors import InvalidInputError
from probreg.sensors.heights import FOOT_M

EDITIONS = {21: "2_7", 34: "1_29", 48: "1_32", 62: "1_20"}
HEADER_BYTES = 3


@dataclass(frozen=True)
class Message:
    """One record of a category that is used.

    Attributes
    ----------
    category : int
    source : tuple of int
        System area and identification code.
    time_s : float or None
        Of day.
    values : tuple of float or None
        Slant range (NM) and azimuth (degrees) of a plot; latitude and longitude (degrees) of a
        position or a station. None where the record gives none.
    height_m : float or None
        Above the ellipsoid.
    flight_level : float or None
        By pressure, hundreds of feet.
    address : int or None
        Of the aircraft.
    """

    category: int
    source: tuple[int, int]
    time_s: float | None
    values: tuple[float, float] | None
    height_m: float | None = None
    flight_level: float | None = None
    address: int | None = None


@dataclass(frozen=True)
class Survey:
    """What a source sends.

    Attributes
    ----------
    counts : dict of int to int
        Messages by category.
    place : tuple of float or None
        Latitude and longitude (degrees) and height (metres) by its own messages (I034/120).
    """

    counts: dict[int, int]
    place: tuple[float, float, float] | None


def _number(record: Any, item: str, part: str | None = None) -> float | None:
    """Quantity of an item, or of a part of it, in the unit of the item; None if not there."""
    found = record.get_item(item)
    if found is None:
        return None
    variation = found.variation
    if part is not None:
        variation = variation.get_item(part).variation
    return float(variation.content.as_quantity())


def _pair(record: Any, item: str, first: str, second: str) -> tuple[float, float] | None:
    one, two = _number(record, item, first), _number(record, item, second)
    return None if one is None or two is None else (one, two)


def _first(*found: Any) -> Any:
    return next((one for one in found if one is not None), None)


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else factor * value


def _source(record: Any) -> tuple[int, int]:
    item = record.get_item("010")
    if item is None:
        raise ValueError("item 010 (source) is missing")
    return divmod(item.as_uint(), 256)


def _address(item: Any) -> int | None:
    return None if item is None else item.as_uint()


def _plot(record: Any) -> Message:
    level = _number(record, "090", "FL")
    address = _address(record.get_item("220"))
    polar = _pair(record, "040", "RHO", "THETA")
    return Message(48, _source(record), _number(record, "140"), polar, None, level, address)


def _station(record: Any) -> Message:
    place = _pair(record, "120", "LAT", "LON")
    height = _number(record, "120", "HGT")
    return Message(34, _source(record), _number(record, "030"), place, height)


def _adsb(record: Any) -> Message:
    place = _first(_pair(record, "131", "LAT", "LON"), _pair(record, "130", "LAT", "LON"))
    time = _first(_number(record, "071"), _number(record, "073"))
    height, level = _scaled(_number(record, "140"), FOOT_M), _number(record, "145")
    address = _address(record.get_item("080"))
    return Message(21, _source(record), time, place, height, level, address)


def _track(record: Any) -> Message:
    place = _pair(record, "105", "LAT", "LON")
    derived = record.get_item("380")
    address = None if derived is None else _address(derived.variation.get_item("ADR"))
    level = _number(record, "136")
    return Message(62, _source(record), _number(record, "070"), place, None, level, address)


TAKE: dict[int, Callable[[Any], Message]] = {21: _adsb, 34: _station, 48: _plot, 62: _track}


def messages(path: Path) -> Iterator[Message]:
    """Decode a file of data blocks one after another; other categories are passed over.

    Raises
    ------
    InvalidInputError
        No decoder, no such file, blocks that are cut off or do not decode, with the byte.
    """
    extras.require("asterix", "ASTERIX")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror}.") from None
    if not content:
        raise InvalidInputError(f"{path} is empty.")
    yield from decoded(content, path)


def blocks(content: bytes, path: Path, first: int = 0) -> Iterator[tuple[int, int]]:
    """First and last byte, exclusive, of each block that is complete.

    Raises
    ------
    InvalidInputError
        What can be no block.
    """
    start = 0
    while start + HEADER_BYTES <= len(content):
        length = int.from_bytes(content[start + 1 : start + HEADER_BYTES], "big")
        if length < HEADER_BYTES:
            raise _no_block(content, start, path, first)
        if start + length > len(content):
            return
        yield start, start + length
        start += length


def decoded(content: bytes, path: Path, first: int = 0) -> Iterator[Message]:
    """Decode data blocks that begin at some byte of a file.

    Raises
    ------
    InvalidInputError
        No decoder, blocks that are cut off or do not decode, with the byte.
    """
    extras.require("asterix", "ASTERIX")
    import asterix.generated as generated
    from asterix.base import Bits

    specs = {c: getattr(generated, f"Cat_{c:03d}_{edition}") for c, edition in EDITIONS.items()}
    end = 0
    for start, end in blocks(content, path, first):
        category = content[start]
        if category not in TAKE:
            continue
        records = specs[category].cv_uap.parse(Bits.from_bytes(content[start + 3 : end]))
        try:
            if isinstance(records, ValueError):
                raise records
            yield from (TAKE[category](record) for record in records)
        except ValueError as error:
            raise InvalidInputError(
                f"{path}, byte {first + start}: block of category {category} does not decode as "
                f"edition {EDITIONS[category].replace('_', '.')} ({error})."
            ) from None
    if end < len(content):
        raise _no_block(content, end, path, first)


def _no_block(content: bytes, start: int, path: Path, first: int) -> InvalidInputError:
    length = int.from_bytes(content[start + 1 : start + HEADER_BYTES], "big")
    return InvalidInputError(
        f"{path}, byte {first + start}: a block of category {content[start]} says {length} bytes, "
        f"{len(content) - start} are left. The file is cut off, or no plain sequence of "
        "ASTERIX blocks (captures of a network must be unpacked first)."
    )
