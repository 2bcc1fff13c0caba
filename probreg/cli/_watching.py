"""The command `probreg watch`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from probreg.cli._options import Quiet, Seed, SensorsPath, TrustUnits, flat
from probreg.cli._terminal import (
    BAD_INPUT,
    INTERRUPTED,
    WARNINGS,
    plain_errors,
    refuse_to_go_on,
)
from probreg.errors import InvalidInputError

if TYPE_CHECKING:
    from probreg.recordings import Setup
    from probreg.watch import WatchSettings
    from probreg.watch.run import Step
    from probreg.watch.task import Task

EXIT_CODES = (
    "Exit codes: 0 done. "
    f"{BAD_INPUT} input that cannot be used, said in one sentence; the state before stays. "
    "2 wrong usage. "
    f"{WARNINGS} done, and there were alarms. "
    f"{INTERRUPTED} interrupted before there was a state; an interrupt later is an end as others."
)
PAGE = "watch.html"
LAG_S = 60.0  # reports are open at least so long


class WatchRequest(NamedTuple):
    """What `watch` is asked to do."""

    recording: Annotated[
        str,
        typer.Argument(
            help="A file that grows (.csv, .ast), a folder that gets files (.parquet too), or - "
            "for a CSV table from standard input."
        ),
    ]
    sensors: SensorsPath
    out: Annotated[Path, typer.Option("--out", help="Folder of the watch; it goes on from there.")]
    until: Annotated[
        str | None,
        typer.Option(help="End at this time of the recording: seconds, or ISO 8601."),
    ] = None
    patience: Annotated[
        float | None,
        typer.Option(min=0.0, help="End after so many seconds without anything new; 0: at once."),
    ] = None
    slice_s: Annotated[float, typer.Option("--slice", help="Length of a slice, seconds.")] = 10.0
    delay: Annotated[float, typer.Option(help="Reports so late are used, seconds.")] = 20.0
    start: Annotated[float, typer.Option(help="Length of the batch at the start, seconds.")] = 300.0
    false_alarms_per_day: Annotated[float, typer.Option(help="While nothing is wrong.")] = 1.0
    page_every: Annotated[int, typer.Option(min=1, help="Slices between pages.")] = 6
    seed: Seed = 0
    trust_units: TrustUnits = False
    quiet: Quiet = False


@flat
def watch(request: WatchRequest) -> None:
    """Watch the biases of sensors while their recording grows.

    Keeps state.npz, journal.jsonl, watch.html and manifest.json in a folder. Ends by --until,
    --patience, the end of standard input, or an interrupt; whatever ended it, the same command
    goes on from there.
    """
    with plain_errors():
        alarms = _watch(request)
    raise typer.Exit(WARNINGS if alarms else 0)


def _watch(request: WatchRequest) -> int:
    """Run to an end; the number of alarms."""
    from probreg import page
    from probreg.watch import run

    task, alarms, last = _task(request), 0, None
    with _interrupted(task, request.quiet):
        for count, step in enumerate(run.watch(task), start=1):
            refuse_to_go_on()
            alarms, last = alarms + _say(step, request.quiet), step
            if count % request.page_every == 0 or step.line["alarms"]:
                _page(request, task.setup, step, running=True)
    if last is None:
        if not request.quiet:
            print("no slice was completed.")
        return alarms
    _page(request, task.setup, last, running=False)
    if not request.quiet:
        print(f"until {page.when(last.line['time'])}: {request.out / PAGE}")
    return alarms


@contextmanager
def _interrupted(task: Task, quiet: bool) -> Iterator[None]:
    """An interrupt is how most watches end: no error once there is a state."""
    from probreg.watch.going import STATE

    try:
        yield
    except KeyboardInterrupt:
        if not (task.folder / STATE).exists():
            raise
        if not quiet:
            print("interrupted; the state is saved, the same command goes on.")


def _task(request: WatchRequest) -> Task:
    import probreg.watch as engine
    from probreg import page
    from probreg.recordings import growing, setup_file
    from probreg.watch.task import Ends, Talk, Task

    settings, setup = _settings(request), setup_file.read(request.sensors)
    ends = Ends(None if request.until is None else _seconds(request.until), request.patience)
    folder = page.own_folder(request.out, "watch")
    if not (folder / "manifest.json").exists():
        asked = {key: str(v) if isinstance(v, Path) else v for key, v in request._asdict().items()}
        page.write_summary(folder, "watch", {"settings": asked})

    def said(text: str) -> None:
        if not request.quiet:
            print(text, flush=True)

    return Task(
        growing.follow(request.recording),
        setup,
        folder,
        engine,
        settings,
        start_s=request.start,
        seed=request.seed,
        trust_units=request.trust_units,
        ends=ends,
        talk=Talk(said, refuse_to_go_on),
    )


def _settings(request: WatchRequest) -> WatchSettings:
    from probreg.validation import positive_number
    from probreg.watch import WatchSettings

    length = positive_number("--slice", request.slice_s)
    delay = positive_number("--delay", request.delay, zero=True)
    positive_number("--start", request.start)
    slices = max(2, ceil(LAG_S / length), ceil(delay / length) + 1)
    return WatchSettings(
        slice_s=length,
        lag_s=slices * length,
        window=slices + 2,
        delay_s=delay,
        false_alarms_per_day=request.false_alarms_per_day,
    )


def _seconds(text: str) -> float:
    """A time of a recording, as its time column may have it."""
    import datetime

    try:
        return float(text)
    except ValueError:
        pass
    try:
        stamp = datetime.datetime.fromisoformat(text)
    except ValueError:
        raise InvalidInputError(
            f"--until {text!r} is neither seconds nor ISO 8601 such as 2024-05-01T12:00:00Z."
        ) from None
    zoned = stamp if stamp.tzinfo else stamp.replace(tzinfo=datetime.UTC)
    return zoned.timestamp()


def _say(step: Step, quiet: bool) -> int:
    """Print the alarms of a slice."""
    import sys

    from probreg import page

    biases: Mapping[str, Any] = step.line["biases"]
    units = {name: row["unit"] for name, row in biases.items()}
    alarms = step.line["alarms"]
    for alarm in alarms if not quiet else ():
        print(f"alarm: {page.alarm_text(alarm, units)}", file=sys.stderr, flush=True)
    return len(alarms)


def _page(request: WatchRequest, setup: Setup, step: Step, *, running: bool) -> None:
    from probreg import page

    every = max(5, round(request.slice_s * request.page_every))
    refresh_s = every if running else None
    page.write_watch(request.out / PAGE, step.past, setup.limits, refresh_s=refresh_s)
