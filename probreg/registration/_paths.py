"""Biases that drift, over time: draws, bands, and where they change in steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.numerics.intervals import equal_tailed
from probreg.samplers.tracks import BiasDraws, BiasPathDraws
from probreg.typing import FloatArray
from probreg.validation import finite_array

if TYPE_CHECKING:
    import pandas as pd

SEED = 0  # of what paths do between knots: asked twice, the answer is the same
LEAST_SDS, LEAST_PROBABILITY = 2.0, 0.5  # of a step: in standard deviations of the path
REACH = 3  # intervals without a step that still belong to one


class Change(NamedTuple):
    """A step of a bias.

    Attributes
    ----------
    name : str
    time, time_sd : float
        Stamp of reports, seconds.
    size, size_sd : float
        SI units.
    probability : float
        That there is a step there.
    """

    name: str
    time: float
    time_sd: float
    size: float
    size_sd: float
    probability: float


def path_draws(draws: BiasDraws, name: str, time: FloatArray | None = None) -> FloatArray:
    """See `Registration.path_draws`."""
    if name not in draws.names:
        raise InvalidInputError(f"no bias {name!r}; there are {', '.join(draws.names)}.")
    paths, number = draws.paths, draws.names.index(name)
    stamp = None if time is None else finite_array("time", time, (None,))
    if paths is None or number not in paths.number:
        if stamp is None:
            raise InvalidInputError(f"{name} does not drift; say at which times it is wanted.")
        return np.repeat(draws.flat[:, number, None], len(stamp), axis=1)
    return _drawn(paths, stamp)[..., paths.number.index(number)]


def _drawn(paths: BiasPathDraws, stamp: FloatArray | None) -> FloatArray:
    return paths.flat if stamp is None else paths.at(stamp, np.random.default_rng(SEED))


def paths_table(draws: BiasDraws, time: FloatArray | None = None) -> pd.DataFrame:
    """One row a drifting bias and time, SI units; empty where none drifts.

    Columns `name`, `time`, `mean`, `sd`, `low_50`, `high_50`, `low_90`, `high_90`.
    """
    import pandas as pd

    columns = ("name", "time", "mean", "sd", "low_50", "high_50", "low_90", "high_90")
    paths = draws.paths
    if paths is None:
        return pd.DataFrame(columns=columns)
    stamp = paths.time if time is None else finite_array("time", time, (None,))
    drawn = _drawn(paths, None if time is None else stamp)
    bands = [equal_tailed(drawn, probability, (0,)) for probability in (0.5, 0.9)]
    parts = []
    for j, number in enumerate(paths.number):
        ends = [band[:, j, side] for band in bands for side in (0, 1)]
        own = drawn[..., j]
        values = (draws.names[number], stamp, own.mean(axis=0), own.std(axis=0, ddof=1), *ends)
        parts.append(pd.DataFrame(dict(zip(columns, values, strict=True))))
    return pd.concat(parts, ignore_index=True)


def changes(draws: BiasDraws) -> tuple[Change, ...]:
    """Steps that are more likely than not, of biases that drift by steps, in order of time."""
    paths, found = draws.paths, []
    if paths is None:
        return ()
    for j, (number, kind) in enumerate(zip(paths.number, paths.kinds, strict=True)):
        if np.isfinite(kind.freedom):
            found += _steps(draws.names[number], paths.time, paths.flat[..., j])
    return tuple(sorted(found, key=lambda change: change.time))


def _steps(name: str, time: FloatArray, path: FloatArray) -> list[Change]:
    """Of draws (k, T) of one path: intervals in which some have a step, neighbours together."""
    step = np.diff(path, axis=1)
    large = np.abs(step) > LEAST_SDS * np.median(path.std(axis=0))
    some = np.flatnonzero(large.mean(axis=0) > 0.05)
    found = []
    for group in np.split(some, np.flatnonzero(np.diff(some) > REACH) + 1):
        if not len(group):
            continue
        rows, which = np.nonzero(large[:, group])
        probability = len(np.unique(rows)) / len(path)
        if probability < LEAST_PROBABILITY:
            continue
        # a step may be anywhere in its interval
        interval = group[which]
        width = time[interval + 1] - time[interval]
        middle = 0.5 * (time[interval + 1] + time[interval])
        low, high = max(group[0] - 1, 0), min(group[-1] + 2, path.shape[1] - 1)
        size = path[:, high] - path[:, low]
        found.append(
            Change(
                name,
                float(middle.mean()),
                float(np.sqrt(middle.var() + (width**2).mean() / 12.0)),
                float(size.mean()),
                float(size.std()),
                float(probability),
            )
        )
    return found
