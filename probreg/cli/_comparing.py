"""The commands `probreg check` and `probreg history`, on results of `probreg register`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from probreg.cli._options import OutFolder, Overwrite, Quiet, Seed
from probreg.cli._terminal import WARNINGS, plain_errors
from probreg.errors import InvalidInputError

Result = Annotated[Path, typer.Argument(help="Folder of a result of `probreg register`.")]


def check(
    old: Result,
    new: Result,
    limit: Annotated[
        list[str] | None,
        typer.Option(
            help="Largest acceptable change, such as azimuth=0.1 or west.range=20, in degrees, "
            "metres, seconds, m/km; may be repeated. Default: the limits of the setup."
        ),
    ] = None,
    json_file: Annotated[
        Path | None, typer.Option("--json", help="File for the numbers, SI units.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Say with which probability two calibrations of the same sensors differ, and by how much.

    Exit code 3: a change exceeds its limit, or there probably is one where there is no limit.
    """
    with plain_errors():
        from probreg import page
        from probreg.registration import differences, saved

        one, two = saved.read(old), saved.read(new)
        found = differences.compare(one, two, _limits(limit or [], one.names, one.units))
        warnings = page.changes(found)
        if json_file is not None:
            page.write_changes(json_file, found)
        if not quiet:
            print(page.changes_text(found))
            for text in warnings:
                print(f"warning: {text}", file=sys.stderr)
    raise typer.Exit(WARNINGS if warnings else 0)


def _limits(given: list[str], names: tuple[str, ...], units: tuple[str, ...]) -> dict[str, float]:
    """Limits by bias or term, from engineers' units."""
    from probreg.page import in_si

    by_name: dict[str, str] = dict(zip(names, units, strict=True))
    for name, unit in zip(names, units, strict=True):
        by_name.setdefault(name.split(".", 1)[1], unit)
    found = {}
    for text in given:
        name, _, number = text.partition("=")
        try:
            value = float(number)
        except ValueError:
            value = -1.0
        if not value > 0.0 or name not in by_name:
            raise InvalidInputError(
                f"--limit {text!r} is not NAME=NUMBER with a number above zero and a name of "
                f"{', '.join(by_name)}."
            )
        found[name] = in_si(value, by_name[name])
    return found


def history(
    folder: Annotated[Path, typer.Argument(help="Holds folders of results, one a recording.")],
    out: OutFolder,
    seed: Seed = 0,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
) -> None:
    """Show the biases of many registrations over time, and what they have in common.

    Writes history.html, history.json, history.csv, pooled.csv and manifest.json.
    """
    with plain_errors():
        import numpy as np

        from probreg import page
        from probreg.registration import days

        results = days.read_days(folder)
        found = days.pool_days(results, np.random.default_rng(seed))
        with page.result_folder(out, "history", overwrite=overwrite) as part:
            warnings = page.fill_days(found, part)
            settings: dict[str, Any] = {"seed": seed, "results": [one.name for one in results]}
            page.write_summary(part, "history", settings)
        if not quiet:
            print(f"{len(results)} recordings: {out / 'history.html'}")
            for text in warnings:
                print(f"warning: {text}", file=sys.stderr)
    raise typer.Exit(WARNINGS if warnings else 0)
