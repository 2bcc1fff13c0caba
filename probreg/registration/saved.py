"""Results of `probreg register` read back from their folders."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray
from probreg.validation import finite_array

BIASES, TRACKS = "biases.json", "tracks.parquet"


@dataclass(frozen=True, eq=False)
class SavedResult:
    """The biases of one registration, SI units.

    Attributes
    ----------
    name : str
        Of the folder.
    names, units : tuple of str
    mean, sd : ndarray, shape (p,)
    covariance : ndarray, shape (p, p)
    share : ndarray, shape (p,)
        What the data determine of each.
    limits : ndarray, shape (p,)
        NaN where there is none.
    start : float
        First time of the recording; NaN where the folder does not say.
    """

    name: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    mean: FloatArray
    sd: FloatArray
    covariance: FloatArray
    share: FloatArray
    limits: FloatArray
    start: float


def read(folder: str | Path) -> SavedResult:
    """The result in a folder.

    Raises
    ------
    InvalidInputError
        No result of `probreg register`.
    """
    folder = Path(folder)
    path = folder / BIASES
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        rows = content["biases"]
        names, units = (tuple(str(row[key]) for row in rows) for key in ("name", "unit"))
        mean, sd, share = (
            finite_array(key, [row[key] for row in rows], (None,))
            for key in ("mean", "sd", "determined_by_data")
        )
        limits = np.array([row["limit"] for row in rows], dtype=float)
        p = len(names)
        covariance = finite_array("covariance", content["covariance"], (p, p))
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror}.") from None
    except (ValueError, KeyError, TypeError, InvalidInputError):
        raise InvalidInputError(f"{path} is no biases.json of `probreg register`.") from None
    start = _start(folder / TRACKS)
    return SavedResult(folder.name, names, units, mean, sd, covariance, share, limits, start)


def _start(path: Path) -> float:
    """First time of the tracks, from what the file says of its columns."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        told: Any = pq.ParquetFile(path).metadata
        columns = [told.schema.column(k).name for k in range(told.num_columns)]
        at = columns.index("time")
        groups = [told.row_group(k).column(at).statistics for k in range(told.num_row_groups)]
        return float(min(group.min for group in groups))
    except (OSError, ValueError, AttributeError, pa.ArrowException):
        return float("nan")


def refuse_others(results: Sequence[SavedResult]) -> None:
    """Refuse results of other sensors or terms than those of the first.

    Raises
    ------
    InvalidInputError
        With what differs.
    """
    first = results[0]
    for other in results[1:]:
        lacking = sorted(set(first.names) - set(other.names))
        new = sorted(set(other.names) - set(first.names))
        if lacking or new:
            said = [f"lacks {', '.join(lacking)}"] * bool(lacking)
            said += [f"has {', '.join(new)} more"] * bool(new)
            raise InvalidInputError(
                f"{other.name} {' and '.join(said)}, compared with {first.name}; only results of "
                "the same sensors and terms can be compared."
            )
        own = dict(zip(other.names, other.units, strict=True))
        for name, unit in zip(first.names, first.units, strict=True):
            if own[name] != unit:
                raise InvalidInputError(
                    f"{name} is in {unit} in {first.name}, and in {own[name]} in {other.name}."
                )


def ordered(result: SavedResult, names: Sequence[str]) -> SavedResult:
    """A result with its biases in another order."""
    at = np.array([result.names.index(name) for name in names])
    return SavedResult(
        result.name,
        tuple(names),
        tuple(result.units[k] for k in at),
        result.mean[at],
        result.sd[at],
        result.covariance[np.ix_(at, at)],
        result.share[at],
        result.limits[at],
        result.start,
    )
