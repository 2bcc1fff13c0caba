"""A watch from a growing recording to a journal and a state, which an end at any time leaves whole.

After every slice a line goes to the journal, and then the state with how far the recording was
read and how long the journal is: going on takes both from there. Only while slices follow one
another at once is the state saved less often; those after it are done again.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import Recording, bias_model, growing
from probreg.recordings.growing import Buffer, Slice
from probreg.watch import clocks, journal
from probreg.watch.going import Going, only_one, resumed, save
from probreg.watch.history import History, with_line
from probreg.watch.task import Task

JOURNAL = "journal.jsonl"
POLL_S, SAID_S = 0.5, 10.0  # between looks; without anything new before it is said
SAVE_S = 2.0  # between states while slices follow one another at once
LIVE_S = 86_400.0  # times this near to those of the computer are POSIX time
AHEAD_S = 600.0  # of the others, beyond which the first report is not believed


class Step(NamedTuple):
    """A slice that is done.

    Attributes
    ----------
    line : dict
        As in the journal.
    past : History
    """

    line: dict[str, Any]
    past: History


def watch(task: Task) -> Iterator[Step]:
    """Watch a recording, from where a state in the folder says, until an end.

    Yields
    ------
    Step
        After each slice.

    Raises
    ------
    InvalidInputError
        Input that cannot be used, a state of another watch, another watch in the folder.
    """
    with only_one(task.folder):
        going, ended = resumed(task), False
        saved, since = going, task.clock.monotonic()
        try:
            while not _over(task, going):
                done = _slice(task, going, flush=ended)
                if done is not None:
                    going, line = done
                    if _due(task, going, since):
                        saved, since = _saved(task, going), task.clock.monotonic()
                    if line is not None:
                        yield Step(line, going.past)
                elif ended:
                    break
                else:
                    looked = _gather(task, going)
                    going, ended = (going, True) if looked is None else (looked, False)
        except (KeyboardInterrupt, GeneratorExit, InvalidInputError):
            # a stream cannot be read again: what came since the last slice is kept as well
            if going is not saved:
                _saved(task, going)
            raise
        if going is not saved:
            _saved(task, going)


def _due(task: Task, going: Going, since: float) -> bool:
    """Whether to save now: at once, unless the next slice is there already."""
    following = growing.complete(going.buffer, going.state.time + task.settings.slice_s)
    return not following or task.clock.monotonic() - since >= SAVE_S


def _saved(task: Task, going: Going) -> Going:
    if going.state is not None:
        save(task, going)
    return going


def _over(task: Task, going: Going) -> bool:
    """Whether the next slice would end after the end."""
    if going.state is None or task.ends.until is None:
        return False
    return bool(going.state.time + task.settings.slice_s > task.ends.until + 1e-6)


def _gather(task: Task, going: Going) -> Going | None:
    """Wait for something new; None once there will be nothing more."""
    since, quiet, clock = task.clock.monotonic(), True, task.clock
    while True:
        task.talk.asked()
        look = task.source.look(going.position, going.setup, fixed=going.state is not None)
        if look.position != going.position:
            going = replace(going, position=look.position)
            if look.arrivals is None:
                return going
            buffer = growing.arrive(going.buffer, look.arrivals)
            setup = going.setup if going.state is not None else look.arrivals.setup
            return replace(going, buffer=buffer, setup=setup)
        waited, patience = clock.monotonic() - since, task.ends.patience_s
        if task.source.ended or (patience is not None and waited >= patience):
            return None
        if _past(task, going):
            return None
        if waited >= SAID_S and quiet:
            task.talk.said("; ".join(look.waiting) or "nothing new; waiting")
            quiet = False
        clock.sleep(POLL_S)


def _past(task: Task, going: Going) -> bool:
    """Whether the clock of the computer has passed the end of a recording in POSIX time."""
    until, now = task.ends.until, task.clock.posix()
    live = abs(going.buffer.newest - now) < LIVE_S
    return until is not None and live and now > until + float(task.settings.delay_s)


def _slice(task: Task, going: Going, *, flush: bool) -> tuple[Going, dict[str, Any] | None] | None:
    """The next slice, done, and its line; None while it is not complete."""
    if going.state is None:
        return _begun(task, going, flush)
    until = going.state.time + task.settings.slice_s
    if not growing.complete(going.buffer, until) and not (flush and len(going.buffer)):
        return None
    found, buffer = growing.cut(going.buffer, going.setup, until)
    state, result = task.engine.advance(going.state, found.reports, until)
    late_s = task.settings.slice_s + task.settings.delay_s
    told = clocks.judge(found, going.setup, late_s, going.wrong)
    line = _line(result.to_json(), found, going, told)
    length = journal.append(task.folder / JOURNAL, going.journal, line)
    past = with_line(going.past, line)
    late_kinds = (*going.late_kinds, *_new_kinds(found, going))
    going = replace(going, state=state, buffer=buffer, journal=length, past=past,
                    wrong=told.wrong, late_kinds=late_kinds)  # fmt: skip
    return going, line


def _line(
    told: dict[str, Any], found: Slice, going: Going, of_clocks: clocks.Clocks
) -> dict[str, Any]:
    """What the journal says of a slice."""
    names = [sensor.name for sensor in going.setup.sensors]
    ahead = np.bincount(found.ahead.sensor, minlength=len(names)).tolist()
    left_out = {
        "ahead": {name: n for name, n in zip(names, ahead, strict=True) if n},
        "repeated": found.repeated,
    }
    line = {**told, "alarms": [*told["alarms"], *of_clocks.alarms], "left_out": left_out}
    if found.late_kinds:
        count = told["reports"].get("unplaced", 0) + sum(found.late_kinds.values())
        line["reports"] = {**told["reports"], "unplaced": count}
    notes = [
        f"reports of a {kind} have appeared, of which there were none in the first minutes: they "
        "are counted as unplaced. To use them, begin afresh with minutes that have some."
        for kind in _new_kinds(found, going)
    ]
    return {**line, "notes": notes} if notes else line


def _new_kinds(found: Slice, going: Going) -> list[str]:
    """Kinds of reports that appear for the first time."""
    return [kind for kind in found.late_kinds if kind not in going.late_kinds]


def _begun(task: Task, going: Going, flush: bool) -> tuple[Going, None] | None:
    """The batch at the start, once its reports are there."""
    if not len(going.buffer):
        if flush:
            raise InvalidInputError("the recording has no report; there is nothing to watch.")
        return None
    slices = max(round(task.start_s / task.settings.slice_s), 1)
    end = _end_of_start(going.buffer, slices * task.settings.slice_s)
    if end is None and not flush:
        return None
    found, buffer = growing.cut(going.buffer, going.setup, np.inf if end is None else end)
    assert found.reports is not None
    setup, reports, rest = growing.settled(task.setup, going.setup, found.reports, buffer.arrays)
    going, buffer = replace(going, setup=setup), replace(buffer, arrays=rest)
    growing.check_start(reports, trust_units=task.trust_units)
    rng = np.random.default_rng(task.seed)
    state = task.engine.begin(reports, setup, task.settings, rng)
    line = _first_line(state, reports, going)
    length = journal.append(task.folder / JOURNAL, 0, line)
    return replace(going, state=state, buffer=buffer, journal=length), None


def _first_line(state: Any, reports: Recording, going: Going) -> dict[str, Any]:
    """What the journal says of the batch at the start."""
    model = bias_model(going.setup)
    units = dict(zip(model.names, model.units, strict=True))
    numbers = zip(state.names, state.mean.tolist(), state.sd.tolist(), strict=True)
    return {
        "time": float(state.time),
        "start": {"time": float(reports.time[0]), "reports": len(reports)},
        "biases": {name: {"unit": units[name], "mean": m, "sd": s} for name, m, s in numbers},
    }


def _end_of_start(buffer: Buffer, length: float) -> float | None:
    """When the batch at the start ends; None while reports may still be of it.

    Raises
    ------
    InvalidInputError
        A first report whose time stamp is far ahead of the others.
    """
    time = buffer.arrays["time"]
    start = float(time[buffer.reached <= time[0] + length].min())
    if time[0] - start > AHEAD_S:
        raise InvalidInputError(
            f"the first report is of time {time[0]:.3f} s, {time[0] - start:.0f} s ahead of one "
            "that follows. Remove it, or correct its time."
        )
    return start + length if buffer.newest > time[0] + length else None
