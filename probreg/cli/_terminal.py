"""What the command `probreg` says on a terminal: errors in one line, and how far it is."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import typer

from probreg.errors import ProbregError

BAD_INPUT, WARNINGS, INTERRUPTED = 1, 3, 130
EXIT_CODES = (
    "Exit codes: 0 done. "
    f"{BAD_INPUT} input that cannot be used, said in one sentence; nothing written. "
    "2 wrong usage. "
    f"{WARNINGS} done, but with warnings that matter (a limit is exceeded, the data do not "
    "determine a bias, a term is missing, the draws have not converged, held-out targets got "
    "worse): read them before using the numbers. "
    f"{INTERRUPTED} interrupted; nothing written."
)

# what each step of a registration is called while it runs
DOING = {
    "read": "reading the recording",
    "associate": "associating reports",
    "laws": "comparing noise laws",
    "mode": "fitting biases and tracks",
    "draws": "sampling the posterior",
    "held out": "scoring targets held out",
    "observability": "checking what the data determine",
    "missing terms": "looking for missing terms",
    "verdicts": "judging limits",
    "terms": "comparing bias models",
    "report": "writing the report",
}


_asked: list[int] = []  # signals that asked to end


def end_on(number: int, frame: object) -> None:
    """Handler of signals that ask to end: remembered, as compiled code may swallow the error."""
    _asked.append(number)
    raise KeyboardInterrupt


def refuse_to_go_on() -> None:
    """End where that was asked for, though compiled code swallowed it."""
    if _asked:
        raise KeyboardInterrupt


@contextmanager
def plain_errors() -> Iterator[None]:
    """Bad input is one line on stderr, without a traceback."""
    try:
        yield
    except ProbregError as error:
        _fail(" ".join(str(error).split()), BAD_INPUT)
    except OSError as error:
        name = "" if error.filename is None else f"{error.filename}: "
        _fail(f"{name}{error.strerror or error}.", BAD_INPUT)
    except MemoryError:
        _fail("not enough memory; cut the recording into pieces of time.", BAD_INPUT)
    except KeyboardInterrupt:
        # CPython remembers one that passed through `exec` of a text, as modules of dataclasses
        # do when they load, and would end by the signal; the next `exec` forgets it
        exec("")
        _fail("interrupted; nothing was written.", INTERRUPTED)


def _fail(text: str, code: int) -> None:
    print(f"probreg: {text}", file=sys.stderr)
    raise typer.Exit(code) from None


@contextmanager
def progress(quiet: bool, compare: bool) -> Iterator[Callable[[str], None]]:
    """A bar on a terminal, one step after the other; silent elsewhere."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    shown = console.is_terminal and not quiet
    steps = [step for step in DOING if step != "terms" or compare]
    with Progress(*columns, console=console, disable=not shown, transient=True) as bar:
        task = bar.add_task(DOING[steps[0]], total=len(steps))

        def told(step: str) -> None:
            refuse_to_go_on()
            if step in steps:
                done = steps.index(step) + 1
                text = DOING[steps[min(done, len(steps) - 1)]]
                bar.update(task, completed=done, description=text)

        yield told
