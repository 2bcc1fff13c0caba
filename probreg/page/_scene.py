"""Figures of the reports themselves: residuals against what may explain them, and maps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from probreg.page._style import AFTER, BEFORE, LETTER, MARKERS, SENSORS, Panel, Room, panel
from probreg.page._units import SHOWN
from probreg.recordings import Recording
from probreg.registration.residuals import Component, Residuals
from probreg.sensors import Sensor
from probreg.typing import BoolArray, FloatArray, IntArray

DOTS = 500  # reports in a scatter
BINS = 16
MOST = 50_000  # reports of a component that medians in bins are of
FEW = 5  # reports in a bin below which no median is drawn
COMPONENTS = 6  # drawn, those with the largest change
PIECES = 3
PIECE_S = 30.0
OVERVIEW = 3_000  # reports on the map


def some(rows: IntArray, most: int) -> IntArray:
    """At most so many of the rows, evenly spread."""
    return rows[np.unique(np.linspace(0, len(rows) - 1, min(len(rows), most)).astype(int))]


def most_changed(found: Sequence[Component]) -> list[Component]:
    """Components whose residuals change most, in terms of their spread; in the given order."""

    def change(one: Component) -> float:
        scale = float(np.median(np.abs(one.after))) or 1.0
        return abs(float(np.median(one.before - one.after))) / scale

    kept = sorted(found, key=change, reverse=True)[:COMPONENTS]
    return [one for one in found if one in kept]


def against(
    recording: Recording, after: Residuals, found: Sequence[Component]
) -> list[tuple[str, list[Panel]]]:
    """Residuals of each component against the sensor's own components and time."""
    sensors = {sensor.name: sensor for sensor in recording.sensors}
    out = []
    for one in most_changed(found):
        panels = [
            _scatter(one, label, across)
            for label, across in _explanations(sensors[one.sensor], after, one.rows)
        ]
        out.append((f"{one.sensor}: {one.name}", panels))
    return out


def _explanations(
    sensor: Sensor, after: Residuals, rows: IntArray
) -> Iterator[tuple[str, FloatArray]]:
    """What residuals of some reports may depend on: what the sensor reports, and time."""
    for j, name in enumerate(sensor.bias_names[:2]):
        values = after.values[rows, j]
        if sensor.bias_units[j] == "m":
            yield f"{name}, km", 1e-3 * values
        else:
            yield f"{name}, deg", np.mod(np.rad2deg(values), 360.0)
    yield "time, s", after.time[rows]


def _scatter(one: Component, label: str, across: FloatArray) -> Panel:
    shown = SHOWN[one.unit]
    kept = some(np.arange(len(across)), MOST)
    across, pick = across[kept], some(np.arange(len(kept)), DOTS)
    before, after = shown.factor * one.before[kept], shown.factor * one.after[kept]
    # wild reports would flatten the rest
    low, high = np.quantile(np.concatenate([before, after]), [0.02, 0.98])
    margin = 0.25 * float(high - low) or 1.0

    def draw(axes: Axes) -> None:
        for values, colour, when in ((before, BEFORE, "before"), (after, AFTER, "after")):
            dots: Any = {"ms": 2.2, "mew": 0, "color": colour, "alpha": 0.4, "rasterized": True}
            axes.plot(across[pick], values[pick], "o", **dots)
            axes.plot(*binned(across, values), "-", color=colour, lw=2.2, label=when)
        axes.set(xlabel=label, ylabel=f"residual, {shown.symbol}")
        axes.set_ylim(low - margin, high + margin)
        axes.legend(loc="upper right", ncols=2, handlelength=1.2)

    medians = [f"{shown.factor * when.median:.3g}" for when in one.spreads]
    words = (
        f"Residual {one.name} of {one.sensor} against {label}: median {medians[0]} before, "
        f"{medians[1]} {shown.symbol} after."
    )
    return panel(draw, words)


def binned(across: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Medians of values in bins of equal width, at the bins' centres; gaps where few."""
    edges = np.linspace(across.min(), across.max(), BINS + 1)
    bins = np.clip(np.searchsorted(edges, across, side="right") - 1, 0, BINS - 1)
    medians = np.full(BINS, np.nan)
    for k in range(BINS):
        own = values[bins == k]
        if len(own) >= FEW:
            medians[k] = np.median(own)
    return 0.5 * (edges[1:] + edges[:-1]), medians


def overview(recording: Recording, target: IntArray, after: Residuals) -> Panel:
    """Where the reports and the sensors are."""
    known = some(np.flatnonzero(_placed(target, after)), OVERVIEW)
    names = [sensor.name for sensor in recording.sensors]

    def draw(axes: Axes) -> None:
        for k, sensor in enumerate(recording.sensors):
            rows = known[recording.sensor[known] == k]
            colour = SENSORS[k % len(SENSORS)]
            style: Any = {"ms": 2.0, "mew": 0, "color": colour, "alpha": 0.5, "rasterized": True}
            axes.plot(*(1e-3 * after.where[rows, :2].T), "o", **style)
            place = sensor.position
            here = (np.nan, np.nan) if place is None else 1e-3 * np.asarray(place[:2])
            axes.plot(*here, "^", ms=9, mec="white", color=colour, label=sensor.name)
        axes.locator_params(nbins=6)
        axes.set(xlabel="east, km", ylabel="north, km", aspect="equal")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))

    words = (
        f"Map of {len(known)} corrected reports of {', '.join(names)}, with the places of the "
        "sensors that stand still as triangles."
    )
    beside = LETTER * (4 + max(map(len, names)))
    return panel(draw, words, size=(5.6, 4.6), room=Room(right=beside))


def _placed(target: IntArray, after: Residuals) -> BoolArray:
    return (target >= 0) & np.isfinite(after.where[:, 0])


def pieces(recording: Recording, target: IntArray, after: Residuals) -> list[IntArray]:
    """Reports of the best covered half minutes of some targets, in order of time."""
    known = np.flatnonzero(_placed(target, after))
    piece = ((recording.time[known] - recording.time[0]) // PIECE_S).astype(np.int64)
    key = target[known] * (piece.max(initial=0) + 1) + piece
    label, group = np.unique(key, return_inverse=True)
    counts = np.zeros((len(label), len(recording.sensors)), dtype=np.int64)
    np.add.at(counts, (group, recording.sensor[known]), 1)
    seen = (counts > 0).sum(axis=1)
    order = np.lexsort((-counts.sum(axis=1), -seen))
    chosen: dict[int, int] = {}
    for k in order.tolist():
        if len(chosen) == PIECES or seen[k] < 2:
            break
        chosen.setdefault(int(label[k] // (piece.max() + 1)), k)
    return [known[group == k] for k in chosen.values()]


def maps(
    recording: Recording,
    target: IntArray,
    before: FloatArray,
    after: Residuals,
    name: Callable[[int], str],
) -> list[tuple[str, list[Panel]]]:
    """Half a minute of some targets before and after correction, on equal scales.

    `target` is whose each report (n,) is believed to be, -1 for none; `before` are the places
    (n, d) of the reports as they came.
    """
    out = []
    for rows in pieces(recording, target, after):
        title = f"target {name(int(target[rows[0]]))}"
        both = 1e-3 * np.concatenate([before[rows, :2], after.where[rows, :2]])
        # wild reports would shrink the rest
        low, high = np.quantile(both, [0.03, 0.97], axis=0)
        half = 0.58 * float((high - low).max()) or 1.0
        centre = 0.5 * (low + high)
        panels = [
            _piece(recording, rows, where, centre, half, when, title)
            for where, when in ((before, "before"), (after.where, "after"))
        ]
        out.append((title, panels))
    return out


def _piece(
    recording: Recording,
    rows: IntArray,
    where: FloatArray,
    centre: FloatArray,
    half: float,
    when: str,
    title: str,
) -> Panel:
    def draw(axes: Axes) -> None:
        for k, sensor in enumerate(recording.sensors):
            own = rows[recording.sensor[rows] == k]
            if own.size:
                colour, marker = SENSORS[k % len(SENSORS)], MARKERS[k % len(MARKERS)]
                line: Any = {"ms": 4.5, "mew": 0, "color": colour, "lw": 0.9, "label": sensor.name}
                axes.plot(*(1e-3 * where[own, :2].T), marker=marker, **line)
        axes.set(title=when, xlabel="east, km", ylabel="north, km", aspect="equal")
        axes.set_xlim(centre[0] - half, centre[0] + half)
        axes.set_ylim(centre[1] - half, centre[1] + half)
        axes.locator_params(nbins=4)
        axes.legend(loc="best")

    words = f"Map of {len(rows)} reports of {title} in half a minute, {when} correction."
    return panel(draw, words, size=(3.9, 3.5))
