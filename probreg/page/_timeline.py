"""Biases over time: one panel a bias, bands about the mean, limits, and when alarms were."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from scipy.special import ndtri

from probreg.page._style import AFTER, BEFORE, GRID, Panel, panel
from probreg.page._units import SHOWN
from probreg.typing import FloatArray

EPOCH_S = 1e8  # later times are POSIX time
SIZE = (5.2, 2.5)
DAY_S, TICKS = 86_400.0, 6.0
STEPS = (  # seconds between ticks
    *(1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1_800.0, 3_600.0),
    *(7_200.0, 10_800.0, 21_600.0, 43_200.0, *(DAY_S * days for days in (1, 2, 5, 10, 30))),
)
BANDS = "Dark bands hold a bias with probability 0.5, light ones with 0.9. Dashed lines are limits."
HALF, MOST = float(ndtri(0.75)), float(ndtri(0.95))  # standard deviations of 50 and 90 %


class Course(NamedTuple):
    """One bias over time, SI units.

    Attributes
    ----------
    name, unit : str
    time, mean, sd : ndarray, shape (n,)
    limit : float
        NaN where there is none.
    marks : sequence of float
        Times of alarms.
    common : tuple of float or None
        90 % interval of what all have in common.
    """

    name: str
    unit: str
    time: FloatArray
    mean: FloatArray
    sd: FloatArray
    limit: float = float("nan")
    marks: Sequence[float] = ()
    common: tuple[float, float] | None = None


def courses(found: Sequence[Course], *, joined: bool) -> list[Panel]:
    """Panels of biases, as bands where they are `joined`, else as points with bars."""
    return [_course(one, joined) for one in found]


def _course(one: Course, joined: bool) -> Panel:
    shown = SHOWN[one.unit]
    axis = _axis(one.time)
    x = axis.factor * one.time
    middle, wide = shown.factor * one.mean, shown.factor * one.sd

    def draw(axes: Axes) -> None:
        for number, spread in ((MOST, 0.2), (HALF, 0.4)):
            if joined:
                ends = middle - number * wide, middle + number * wide
                axes.fill_between(x, *ends, color=AFTER, alpha=spread, lw=0)
            else:
                width = 1.2 if number == MOST else 4.0
                axes.vlines(x, middle - number * wide, middle + number * wide, AFTER, lw=width)
        axes.plot(x, middle, "-" if joined else "o", color=AFTER, ms=3.0, lw=1.2)
        if one.common is not None:
            low, high = (shown.factor * end for end in one.common)
            axes.axhspan(low, high, color=BEFORE, alpha=0.15, lw=0)
        _lines(axes, shown.factor * one.limit)
        for mark in one.marks:
            axes.axvline(axis.factor * mark, color=BEFORE, lw=1.0)
        axes.set(title=one.name, ylabel=shown.symbol, xlabel=axis.label)
        if axis.dated:
            axes.set_xticks(*_calendar(x))

    words = (
        f"{one.name} over time: last {middle[-1]:.6g} {shown.symbol}, give or take "
        f"{MOST * wide[-1]:.3g} with probability 0.9; {len(one.marks)} alarms."
    )
    return panel(draw, words, size=SIZE)


def _lines(axes: Axes, limit: float) -> None:
    """Zero and the limits, where they are near enough not to flatten the panel."""
    low, high = axes.get_ylim()
    reach = high - low
    for line in (0.0, -limit, limit):
        if low - reach < line < high + reach:
            style = ("-", GRID) if line == 0.0 else ("--", BEFORE)
            axes.axhline(line, ls=style[0], color=style[1], lw=1.2)


class _Axis(NamedTuple):
    """How times stand on a page."""

    factor: float
    label: str
    dated: bool = False


def _axis(time: FloatArray) -> _Axis:
    if len(time) and time[0] > EPOCH_S:
        return _Axis(1.0, "UTC", True)
    if (time == np.arange(1.0, len(time) + 1.0)).all():
        return _Axis(1.0, "recording")
    return _Axis(1.0 / 60.0, "min")


def _calendar(time: FloatArray) -> tuple[FloatArray, list[str]]:
    """A few round times of POSIX time, and what they are called."""
    start, end = float(time[0]), float(time[-1])
    step = next((s for s in STEPS if (end - start) / s < TICKS), None)
    step = STEPS[-1] * np.ceil((end - start) / STEPS[-1] / TICKS) if step is None else step
    ticks = step * np.arange(np.ceil(start / step), np.floor(end / step) + 1.0)
    form = "%H:%M:%S" if step < 60.0 else "%H:%M" if step < DAY_S else "%d %b"
    stamps = (datetime.datetime.fromtimestamp(tick, datetime.UTC) for tick in ticks.tolist())
    return ticks, [stamp.strftime(form) for stamp in stamps]
