"""Figures of a report: lists of small panels of one kind."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

from probreg.page._style import AFTER, BEFORE, GRID, LETTER, TEXT, Panel, Room, panel
from probreg.page._units import SHOWN, number
from probreg.registration import HeldOut, Registration
from probreg.typing import FloatArray

PAIRS = 4  # unknowns whose pairs are drawn
DOTS = 500  # draws in a scatter
BINS = 40


def marginals(registration: Registration) -> list[Panel]:
    """Posterior of each bias with its intervals, one panel a bias."""
    half, most = registration.interval(0.5), registration.interval(0.9)
    medians = registration.median
    numbers = registration.problem.model.numbers
    limits = {numbers[verdict.name]: verdict.limit for verdict in registration.verdicts}
    found = []
    for k, (name, unit) in enumerate(zip(registration.names, registration.units, strict=True)):
        shown = SHOWN[unit]
        draws = shown.factor * registration.bias_draws[:, k]
        bands = (shown.factor * most[k], shown.factor * half[k])
        limit = shown.factor * limits[k] if k in limits else None

        def draw(
            axes: Axes,
            draws: FloatArray = draws,
            bands: tuple[FloatArray, FloatArray] = bands,
            limit: float | None = limit,
            title: str = name,
            label: str = shown.symbol,
        ) -> None:
            low, high = np.quantile(draws, [0.001, 0.999])
            counts, edges = np.histogram(draws, BINS, range=(low, high), density=True)
            axes.stairs(counts, edges, fill=True, color=AFTER, alpha=0.35)
            for band, width in zip(bands, (2.0, 6.0), strict=True):
                axes.plot(band, [0.0, 0.0], color=AFTER, lw=width, solid_capstyle="butt")
            spread = high - low
            for line in () if limit is None else (-limit, limit):
                if low - spread < line < high + spread:
                    axes.axvline(line, color=BEFORE, ls="--", lw=1.2)
            axes.set(title=title, xlabel=label, yticks=[])
            axes.set_ylim(-0.06 * counts.max(), 1.05 * counts.max())
            axes.grid(axis="y", visible=False)
            axes.locator_params(axis="x", nbins=4)

        low, high = bands[0]
        words = (
            f"Posterior of {name}: 90 % between {low:.6g} and {high:.6g} {shown.symbol}, median "
            f"{shown.factor * medians[k]:.6g} {shown.symbol}."
        )
        found.append(panel(draw, words))
    return found


def strongest(registration: Registration) -> list[int]:
    """Numbers of the biases with the strongest correlations, at most `PAIRS`."""
    size = np.abs(np.nan_to_num(registration.correlation)) - np.eye(len(registration.names))
    order = np.argsort(-size.max(axis=1), kind="stable")[:PAIRS]
    return sorted(order.tolist())


def pairs(registration: Registration) -> list[Panel]:
    """Draws of pairs of biases."""
    draws = registration.bias_draws
    some = draws[np.unique(np.linspace(0, len(draws) - 1, DOTS).astype(int))]
    found = []
    for i, j in combinations(strongest(registration), 2):
        names, r = (registration.names[i], registration.names[j]), registration.correlation[i, j]
        units = [SHOWN[registration.units[k]] for k in (i, j)]
        points = some[:, [i, j]] * [unit.factor for unit in units]

        def draw(
            axes: Axes,
            points: FloatArray = points,
            names: tuple[str, str] = names,
            symbols: Sequence[str] = tuple(unit.symbol for unit in units),
            r: float = float(r),
        ) -> None:
            axes.plot(*points.T, "o", ms=2.2, mew=0, color=AFTER, alpha=0.45, rasterized=True)
            axes.set(
                title=f"correlation {number(r, 2)}",
                xlabel=f"{names[0]}, {symbols[0]}",
                ylabel=f"{names[1]}, {symbols[1]}",
            )
            axes.locator_params(nbins=4)

        words = f"Draws of {names[0]} against {names[1]}: correlation {r:+.2f}."
        found.append(panel(draw, words))
    return found


def held_out(scored: HeldOut) -> list[Panel]:
    """Histograms of the residuals of targets held out, in metres and standard deviations."""
    kinds = (
        ("m", "metres", scored.before_m, scored.after_m),
        ("sd", "standard deviations", scored.before_sd, scored.after_sd),
    )
    found = []
    for symbol, unit, *pair in kinds:
        before, after = (values[np.isfinite(values)] for values in pair)
        if not before.size:
            continue
        both = np.concatenate([before, after])
        low, high = np.quantile(both[both > 0.0], [0.002, 0.998])
        edges = np.geomspace(low, high, int(np.clip(2.0 * np.sqrt(len(after)), 8, BINS)))

        def draw(
            axes: Axes,
            before: FloatArray = before,
            after: FloatArray = after,
            edges: FloatArray = edges,
            unit: str = unit,
            wide: float = float(high / low),
        ) -> None:
            for values, colour, label in ((before, BEFORE, "before"), (after, AFTER, "after")):
                counts, _ = np.histogram(values, edges)
                axes.stairs(counts, edges, fill=True, color=colour, alpha=0.3)
                axes.stairs(counts, edges, color=colour, lw=1.3, label=label)
            axes.set(xscale="log", xlabel=f"residual of a report, {unit}", ylabel="reports")
            axes.xaxis.set_major_locator(
                LogLocator(subs=(1.0, 2.0, 5.0) if wide < 300.0 else (1.0,))
            )
            axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.legend()

        words = (
            f"Histogram of residuals of targets held out, in {unit}: median "
            f"{np.median(before):.3g} {symbol} before and {np.median(after):.3g} after correction."
        )
        found.append(panel(draw, words, size=(4.6, 2.6)))
    return found


def heat_map(registration: Registration) -> Panel:
    """Posterior correlation of the biases."""
    names, values = registration.names, registration.correlation
    n = len(names)

    def draw(axes: Axes) -> None:
        axes.imshow(values, cmap="RdBu_r", vmin=-1.0, vmax=1.0)
        axes.set_xticks(range(n), names, rotation=60, ha="right", rotation_mode="anchor")
        axes.set_yticks(range(n), names)
        axes.grid(visible=False)
        for i in range(n) if n <= 12 else ():
            for j in range(n):
                dark = abs(values[i, j]) > 0.6
                colour = "white" if dark else "black"
                text = number(float(values[i, j]), 2).text
                axes.text(j, i, text, ha="center", va="center", color=colour)
        for spine in axes.spines.values():
            spine.set_color(GRID)
        axes.tick_params(length=0.0, labelcolor=TEXT)

    off = np.abs(values - np.eye(n))
    i, j = np.unravel_index(int(np.argmax(off)), off.shape)
    words = "Correlation of the biases."
    if n > 1:
        words += f" The strongest is {values[i, j]:+.2f}, of {names[i]} and {names[j]}."
    side = float(np.clip(1.8 + 0.5 * n, 3.2, 9.0))
    aside = LETTER * max(map(len, names)) + 0.2
    return panel(draw, words, size=(side, side), room=Room(left=aside, bottom=0.87 * aside))
