"""Reports found beside those of other sensors, such as heights beside plots."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings._kinds import default_terms, factor
from probreg.recordings._setup import Setup
from probreg.sensors import Sensor, known_kinds
from probreg.typing import FloatArray, IntArray

FAR_SIGMAS = 4.0  # of a height prior, beyond which a report contradicts it
FEW = 0.02  # of the reports
VERTICAL = ("height", "z", "elevation")  # components


class Beside(NamedTuple):
    """A setup with every sensor of a recording, and arrays with every report.

    Attributes
    ----------
    setup : Setup
    arrays : dict of str to ndarray
        Of a `Recording`, `beside` among them where there is any.
    rows : ndarray of int, shape (n,)
        Row of the file that each report was in.
    notes : tuple of str
    """

    setup: Setup
    arrays: dict[str, Any]
    rows: IntArray
    notes: tuple[str, ...]


def beside_kinds() -> dict[str, type[Sensor]]:
    """Kinds whose reports stand beside others', by each of their columns."""
    kinds = [owner for owner in known_kinds().values() if owner.kind.beside is not None]
    return {name: owner for owner in kinds for name in owner.kind.every_column}


def add_beside(setup: Setup, arrays: dict[str, Any], cells: Mapping[str, FloatArray]) -> Beside:
    """Give every height a report of its own, after those of the rows; complete the setup.

    Parameters
    ----------
    setup : Setup
    arrays : dict of str to ndarray
        Of the rows of a file, in its order.
    cells : mapping of str to ndarray, shape (n,)
        By column, in the unit of the column; NaN where there is none, or where it is a
        component of the row's own report.

    Raises
    ------
    InvalidInputError
        Several sensors that they could be of.
    """
    rows, notes = [np.arange(len(arrays["time"]))], []
    for column, owner in beside_kinds().items():
        given = np.flatnonzero(np.isfinite(cells[column])) if column in cells else rows[0][:0]
        if not given.size:
            continue
        if setup.targets == "surface":
            notes.append(f"column {column!r} is not used: targets are on the surface")
            continue
        setup, number = with_kind(setup, owner, column)
        arrays = _appended(arrays, number, given, factor(column) * cells[column][given])
        rows.append(given)
    every = np.concatenate(rows)
    if len(rows) > 1:
        arrays["beside"] = every.copy()
    return Beside(setup, arrays, every, tuple(notes))


def with_kind(setup: Setup, owner: type[Sensor], column: str) -> tuple[Setup, int]:
    """Number of the sensor whose reports a column has, in a setup that has it."""
    kind = owner.kind
    found = [k for k, s in enumerate(setup.sensors) if s.kind.name == kind.name]
    if len(found) > 1:
        names = [setup.sensors[k].name for k in found]
        raise InvalidInputError(
            f"{column} stands beside the reports of others, and of the sensors {names} either "
            "may have made it; give the setup one of them."
        )
    if found:
        return setup, found[0]
    if any(sensor.name == kind.name for sensor in setup.sensors):
        raise InvalidInputError(
            f"{column} needs a sensor of kind {kind.name!r}, and another sensor has that name; add "
            f"a [[sensor]] of this kind under another name to the setup."
        )
    sigmas = dict.fromkeys(kind.sigmas, kind.beside)
    added: Sensor = kind.make(owner, sigmas, name=kind.name)
    biases = {**setup.biases, added.name: default_terms(added)}
    completed = dataclasses.replace(setup, sensors=(*setup.sensors, added), biases=biases)
    return completed, len(setup.sensors)


def _appended(
    arrays: dict[str, Any], sensor: int, rows: IntArray, values: FloatArray
) -> dict[str, Any]:
    """Arrays with reports of one component after the others."""
    n = len(rows)
    more = {name: array[rows] for name, array in arrays.items()}
    more["sensor"] = np.full(n, sensor, dtype=arrays["sensor"].dtype)
    more["values"] = np.full((n, arrays["values"].shape[1]), np.nan)
    more["values"][:, 0] = values
    if "own_position" in arrays:
        more["own_position"] = np.zeros((n, arrays["own_position"].shape[1]))
    if "heading" in arrays:
        more["heading"] = np.full(n, np.nan)
    return {name: np.concatenate([array, more[name]]) for name, array in arrays.items()}


def in_order(arrays: dict[str, Any], order: IntArray) -> dict[str, Any]:
    """Arrays of a recording in another order."""
    moved = {name: array[order] for name, array in arrays.items()}
    if "beside" in arrays:
        number = np.empty_like(order)
        number[order] = np.arange(len(order))
        moved["beside"] = number[moved["beside"]]
    return moved


def against_prior(setup: Setup, heights: FloatArray) -> tuple[str, ...]:
    """Say, or refuse, that reported heights (n,) contradict the prior on those of targets.

    Raises
    ------
    InvalidInputError
        Half of them do.
    """
    if setup.target_height is None or not heights.size:
        return ()
    mean, sd = setup.target_height
    far = np.abs(heights - mean) > FAR_SIGMAS * sd
    if far.mean() > 0.5:
        raise InvalidInputError(
            f"target_height is {mean:g} m, give or take {sd:g} m, and {far.mean():.0%} of the "
            f"reported heights are more than {FAR_SIGMAS:g} standard deviations away (their "
            f"median is {np.median(heights):.0f} m). Correct the prior, or the unit of heights."
        )
    if far.mean() <= FEW:
        return ()
    return (
        f"{far.mean():.0%} of the reported heights are more than {FAR_SIGMAS:g} standard "
        f"deviations from target_height ({mean:g} m, give or take {sd:g} m): widen it",
    )


def heights_assumed(setup: Setup, arrays: Mapping[str, Any]) -> tuple[str, ...]:
    """Say which sensors of two dimensions, that do not move, and which targets have no height."""
    if setup.dim == 2:
        return ()
    own = arrays.get("own_position")
    moving = set() if own is None else set(np.unique(arrays["sensor"][own.any(axis=1)]).tolist())
    said = [
        f"the height of {sensor.name} is not given and taken as 0 m"
        for k, sensor in enumerate(setup.sensors)
        if sensor.position is not None
        and len(sensor.position) == 2
        and sensor.name not in setup.places
        and k not in moving
    ]
    if setup.target_height is None and not _tells_heights(setup, arrays):
        said.append(
            "no report tells a height, and targets are in the air: give a target_height in the "
            'setup, or targets = "surface" for ships and vehicles'
        )
    return tuple(said)


def _tells_heights(setup: Setup, arrays: Mapping[str, Any]) -> bool:
    """Whether any report has a component that depends on the height at first order."""
    return any(
        bool(np.isfinite(arrays["values"][arrays["sensor"] == k, j]).any())
        for k, sensor in enumerate(setup.sensors)
        for j, name in enumerate(sensor.bias_names)
        if name in VERTICAL
    )
