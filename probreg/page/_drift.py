"""Biases that drift: bands over time, how far they move, and where they step."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from probreg.page._style import AFTER, BEFORE, Panel, panel
from probreg.page._tables import Cell, Table
from probreg.page._units import SHOWN, decimals, number, percent
from probreg.registration import Registration
from probreg.samplers.tracks import BiasPathDraws
from probreg.typing import FloatArray

MINUTE_S = 60.0
BANDS = ("low_50", "high_50", "low_90", "high_90")


def drifting(registration: Registration) -> dict[str, Any]:
    """What the page's section is made of; nothing drifts where it has no panels."""
    paths = registration.draws.paths
    if paths is None:
        return {"drift": None, "drift_panels": [], "changes": None, "spacing": ""}
    return {
        "drift": spreads(registration, paths),
        "drift_panels": bands(registration, paths),
        "changes": changes(registration),
        "spacing": f"{np.diff(paths.time).max():.3g}",
    }


def path_rows(registration: Registration) -> list[dict[str, Any]]:
    """One mapping a drifting bias: how it moves, and its band over time, SI units."""
    paths = registration.draws.paths
    if paths is None:
        return []
    table, found = registration.paths(), []
    for j, k in enumerate(paths.number):
        own = table[table["name"] == registration.names[k]]
        spread = paths.spread[..., j]
        found.append(
            {
                "name": registration.names[k],
                "unit": registration.units[k],
                "drift": paths.kinds[j].name,
                "constant": float(paths.constant[j]),
                "spread": float(np.median(spread)),
                **{key: own[key].tolist() for key in ("time", "mean", "sd", *BANDS)},
            }
        )
    return found


def bands(registration: Registration, paths: BiasPathDraws) -> list[Panel]:
    """Mean, 50 % and 90 % of every drifting bias over time, its steps as lines."""
    table, found = registration.paths(), []
    start = float(registration.recording.time.min())
    for k in paths.number:
        name, shown = registration.names[k], SHOWN[registration.units[k]]
        own = table[table["name"] == name]
        minutes = (own["time"].to_numpy() - start) / MINUTE_S
        mean = shown.factor * own["mean"].to_numpy()
        edges = [shown.factor * own[band].to_numpy() for band in BANDS]
        steps = [(c.time - start) / MINUTE_S for c in registration.changes if c.name == name]

        def draw(
            axes: Axes,
            minutes: FloatArray = minutes,
            mean: FloatArray = mean,
            edges: list[FloatArray] = edges,
            steps: list[float] = steps,
            title: str = name,
            label: str = shown.symbol,
        ) -> None:
            axes.fill_between(minutes, edges[2], edges[3], color=AFTER, alpha=0.2, lw=0.0)
            axes.fill_between(minutes, edges[0], edges[1], color=AFTER, alpha=0.35, lw=0.0)
            axes.plot(minutes, mean, color=AFTER, lw=1.3)
            for step in steps:
                axes.axvline(step, color=BEFORE, ls="--", lw=1.2)
            axes.set(title=title, xlabel="minutes", ylabel=label)

        words = (
            f"{name} over time: mean between {mean.min():.4g} and {mean.max():.4g} {shown.symbol}, "
            f"{len(steps)} steps."
        )
        found.append(panel(draw, words, size=(4.6, 2.6)))
    return found


def spreads(registration: Registration, paths: BiasPathDraws) -> Table:
    """How far each drifting bias moves, and whether it does."""
    rows: list[tuple[Cell, ...]] = []
    scales = registration.problem.model.drifts
    for j, k in enumerate(paths.number):
        shown, kind = SHOWN[registration.units[k]], paths.kinds[j]
        spread = shown.factor * paths.spread[..., j].ravel()
        low, high = np.quantile(spread, [0.05, 0.95])
        places = decimals(float(spread.std()))
        mean = shown.factor * paths.flat[..., j].mean(axis=0)
        around = decimals(float(shown.factor * paths.flat[..., j].std(axis=0).mean()))
        rows.append(
            (
                registration.names[k],
                kind.name,
                percent(float(paths.constant[j])),
                shown.symbol,
                f"about {shown.factor * scales[k][1]:.3g}",
                *(number(float(value), places) for value in (np.median(spread), low, high)),
                *(number(float(value), around) for value in (mean.min(), mean.max())),
                kind.meaning,
            )
        )
    found = ("median", "90 % from", "90 % to", "path from", "path to")
    first = ("bias", "drift", "probability of none", "unit", "spread, prior")
    columns = (*first, *found, "the spread is the")
    return Table("drift-table", "Biases that drift.", columns, rows)


def changes(registration: Registration) -> Table | None:
    """Steps in order of time; None where there are none."""
    start, rows = float(registration.recording.time.min()), []
    for change in registration.changes:
        shown = SHOWN[registration.units[registration.names.index(change.name)]]
        places = decimals(shown.factor * change.size_sd)
        row: tuple[Cell, ...] = (
            change.name,
            number(change.time - start, decimals(change.time_sd)),
            number(change.time_sd, decimals(change.time_sd)),
            number(shown.factor * change.size, places),
            number(shown.factor * change.size_sd, places),
            shown.symbol,
            percent(change.probability),
        )
        rows.append(row)
    columns = ("bias", "seconds from the start", "sd", "size", "sd of it", "unit", "probability")
    return Table("change-table", "Steps.", columns, rows) if rows else None
