"""The page of a watch: biases over time, and alarms in words."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from probreg.page._tables import Cell, Table
from probreg.page._template import filled
from probreg.page._timeline import BANDS, EPOCH_S, Course, courses
from probreg.page._units import SHOWN, decimals, number, percent
from probreg.recordings.files import replacing
from probreg.watch.history import History

SHOWN_ALARMS = 20


def when(time: float) -> str:
    """A time as the recording has it: a date of POSIX time, else seconds."""
    if time < EPOCH_S:
        return f"{time:.1f} s"
    stamp = datetime.datetime.fromtimestamp(time, datetime.UTC)
    return stamp.isoformat(sep=" ", timespec="seconds").removesuffix("+00:00") + " UTC"


def alarm_text(alarm: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """An alarm in one sentence.

    Parameters
    ----------
    alarm : mapping
        As in the journal of a watch.
    units : mapping of str to str
        SI unit of each bias, by name.
    """
    sensor, kind, at = alarm["sensor"], alarm["kind"], when(alarm["time"])
    name = f"{sensor}.{alarm['term']}" if alarm["term"] else sensor
    size = alarm["size"]
    if kind == "silence":
        return f"{sensor} is silent since {at}."
    if kind == "clock":
        way = "ahead" if size > 0.0 else "behind"
        return f"The clock of {sensor} is {abs(size):.6g} s {way} since {at}."
    if kind == "noise":
        return f"The noise of {name} is {size:.2g} times what it was, since {at}."
    per = "/h" if kind == "ramp" else ""
    shown = SHOWN[units.get(name, "")]
    factor = shown.factor * (3_600.0 if per else 1.0)
    spread = alarm["sd"] or float("nan")
    places = decimals(factor * spread)
    amount, give = (number(factor * v, places).text for v in (size, spread))
    what = "drifts by" if per else "changed by"
    return f"{name} {what} {amount} {shown.symbol}{per} (sd {give}) since {at}."


def write_watch(
    path: Path, past: History, limits: Mapping[str, float], *, refresh_s: int | None
) -> None:
    """Write the page of a watch, which browsers load again by themselves.

    Parameters
    ----------
    path : Path
    past : History
        With one slice at least.
    limits : mapping of str to float
        By name, SI units.
    refresh_s : int or None
        None once the watch has ended.

    Raises
    ------
    InvalidInputError
        A path that cannot be written.
    """
    units = dict(zip(past.names, past.units, strict=True))
    alarms = [alarm_text(alarm, units) for alarm in reversed(past.alarms)][:SHOWN_ALARMS]
    content = {
        "title": "Watch of " + ", ".join(dict.fromkeys(n.split(".")[0] for n in past.names)),
        "facts": f"From {when(past.time[0])} to {when(past.time[-1])}.",
        "refresh_s": refresh_s,
        "alarms": alarms,
        "alarm_title": "Alarms, the latest first",
        "fine": "No alarm so far.",
        "reading": BANDS + " Upright lines are alarms.",
        "figures": courses(_of_watch(past, limits), joined=True),
        "tables": [_now(past, limits)],
        "notes": ["Older slices are thinned; journal.jsonl has every one."],
    }
    with replacing(path) as part:
        part.write_text(filled("history.html", content), encoding="utf-8")


def _of_watch(past: History, limits: Mapping[str, float]) -> list[Course]:
    found = []
    for k, (name, unit) in enumerate(zip(past.names, past.units, strict=True)):
        own = (a["time"] for a in past.alarms if f"{a['sensor']}.{a['term']}" == name)
        marks = [time for time in own if time >= past.time[0]]
        limit = limits.get(name, float("nan"))
        found.append(Course(name, unit, past.time, past.mean[:, k], past.sd[:, k], limit, marks))
    return found


def _now(past: History, limits: Mapping[str, float]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for k, (name, unit) in enumerate(zip(past.names, past.units, strict=True)):
        shown = SHOWN[unit]
        mean, sd = (shown.factor * float(v) for v in (past.mean[-1, k], past.sd[-1, k]))
        places, limit = decimals(sd), limits.get(name)
        row: list[Cell] = [name, shown.symbol, number(mean, places), number(sd, places)]
        row.append("" if limit is None else f"{shown.factor * limit:.6g}")
        row.append("" if limit is None else percent(float(past.exceeded[-1, k])))
        rows.append(tuple(row))
    columns = ("bias", "unit", "mean", "sd", "limit", "probability that it is exceeded")
    return Table("now-table", f"Biases at {when(past.time[-1])}.", columns, rows)
