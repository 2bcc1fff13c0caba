"""Page and tables of many registrations of the same sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from probreg.page._outputs import write_text
from probreg.page._tables import Cell, Table
from probreg.page._template import filled
from probreg.page._timeline import BANDS, Course, courses
from probreg.page._units import SHOWN, decimals, number
from probreg.recordings.files import replacing
from probreg.registration.days import LEAST_SHARE, SPREAD, Days

ENOUGH, APART = 5, 5.0  # recordings, and standard deviations of one from their median


def fill_days(days: Days, folder: Path) -> list[str]:
    """Write the page and the tables of many registrations into a folder.

    Parameters
    ----------
    days : Days
    folder : Path
        It is there.

    Returns
    -------
    list of str
        What must be read before they are used.
    """
    import pandas as pd

    rows, alarms = day_rows(days), _unlike(days)
    write_text(folder / "history.json", {"units": "SI", **rows, "warnings": alarms})
    pd.DataFrame(_csv(rows["days"])).to_csv(folder / "history.csv", index=False)
    pd.DataFrame(_csv(rows["pooled"])).to_csv(folder / "pooled.csv", index=False)
    content = {
        "title": "Biases over " + f"{len(days.results)} recordings",
        "facts": f"From {days.results[0].name} to {days.results[-1].name}.",
        "refresh_s": None,
        "alarms": alarms,
        "alarm_title": "Read this before you use the numbers",
        "fine": "No recording stands apart from the others.",
        "reading": BANDS + " The band across holds what all recordings have in common.",
        "figures": courses(_of_days(days), joined=False),
        "tables": [_pooled(days)],
        "notes": [
            "Each bias of a recording is taken as normal, its prior taken out. Common value: "
            "normal about zero with the prior's spread; spread between recordings: half-normal, "
            f"of scale {SPREAD:g} times that. Recordings that determine less than "
            f"{LEAST_SHARE:.0%} of a bias are left out of its pool."
        ],
    }
    with replacing(folder / "history.html") as part:
        part.write_text(filled("history.html", content), encoding="utf-8")
    return alarms


def day_rows(days: Days) -> dict[str, list[dict[str, Any]]]:
    """What each recording says of each bias, and what they say together; SI units."""
    each, pooled = [], []
    for k, (name, unit) in enumerate(zip(days.names, days.units, strict=True)):
        found, shrunk = days.pooled[k], iter(range(len(days.results)))
        for j, result in enumerate(days.results):
            row = {"recording": result.name, "start": result.start, "name": name, "unit": unit}
            row |= {"mean": result.mean[k], "sd": result.sd[k], "used": bool(days.used[j, k])}
            if found is not None and days.used[j, k]:
                draws = found.each[:, next(shrunk)]
                row |= {"pooled_mean": draws.mean(), "pooled_sd": draws.std(ddof=1)}
            each.append(row)
        if found is None:
            continue
        ends = found.interval(0.9)
        row = {"name": name, "unit": unit, "recordings": int(days.used[:, k].sum())}
        for at, key in enumerate(("common", "spread", "new")):
            draws = getattr(found, key)
            row |= {f"{key}_mean": draws.mean(), f"{key}_sd": draws.std(ddof=1)}
            row |= {f"{key}_low_90": ends[at, 0], f"{key}_high_90": ends[at, 1]}
        pooled.append(row)
    return {"days": each, "pooled": pooled}


NUMBERS = ("mean", "sd", "low_90", "high_90")


def _csv(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Rows in engineers' units."""
    found = []
    for row in rows:
        shown = SHOWN[row["unit"]]
        own = {
            key: shown.factor * value if key.endswith(NUMBERS) else value
            for key, value in row.items()
        }
        found.append({**own, "unit": shown.symbol})
    return found


def _unlike(days: Days) -> list[str]:
    """Biases that are not pooled, and recordings that stand apart from the others."""
    said = []
    for k, name in enumerate(days.names):
        rows = np.flatnonzero(days.used[:, k])
        if days.pooled[k] is None:
            said.append(f"{name}: fewer than two recordings determine it; it is not pooled.")
        if len(rows) < ENOUGH:
            continue
        mean, sd = days.mean[rows, k], days.sd[rows, k]
        # by medians, which the recording in question hardly moves
        centre = np.median(mean)
        usual = np.maximum(1.4826 * np.median(np.abs(mean - centre)), sd)
        off = np.abs(mean - centre) / usual
        said += [
            f"{days.results[rows[j]].name}: {name} is {off[j]:.1f} standard deviations from the "
            "median of the recordings."
            for j in np.flatnonzero(off > APART)
        ]
    return said


def _of_days(days: Days) -> list[Course]:
    found = []
    for k, (name, unit) in enumerate(zip(days.names, days.units, strict=True)):
        pooled, limits = days.pooled[k], [result.limits[k] for result in days.results]
        low, high = (None, None) if pooled is None else pooled.interval(0.9)[0].tolist()
        common = None if low is None or high is None else (low, high)
        found.append(
            Course(
                *(name, unit, days.times, days.mean[:, k], days.sd[:, k]),
                limit=limits[-1],
                common=common,
            )
        )
    return found


def _pooled(days: Days) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for k, (name, unit) in enumerate(zip(days.names, days.units, strict=True)):
        pooled, shown = days.pooled[k], SHOWN[unit]
        if pooled is None:
            continue
        ends = shown.factor * pooled.interval(0.9)
        places = decimals(shown.factor * float(pooled.common.std()))
        middle = [
            shown.factor * float(np.median(getattr(pooled, key))) for key in ("common", "spread")
        ]
        cells = (middle[0], *ends[0], middle[1], *ends[1], *ends[2])
        rows.append((name, shown.symbol, *(number(float(value), places) for value in cells)))
    columns = (
        *("bias", "unit", "common", "90 % from", "90 % to", "spread", "90 % from", "90 % to"),
        *("next from", "next to"),
    )
    caption = (
        "What recordings have in common, how far single ones are from it (one standard deviation), "
        "and where the bias of the next one lies with probability 0.9."
    )
    return Table("pooled-table", caption, columns, rows)
