"""Command line: `python -m experiments list` and `python -m experiments run STUDY`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from experiments.results import ROOT
from experiments.runner import run_study
from experiments.study import StudyError, configurations, load_study, study_names

app = typer.Typer(add_completion=False, help="Run the studies behind the figures.")


@contextmanager
def _plain_errors(console: Console) -> Iterator[None]:
    """Our errors are one message; an interrupt says how to go on."""
    try:
        yield
    except StudyError as error:
        console.print(f"error: {error}", style="bold red", markup=False, soft_wrap=True)
        raise typer.Exit(1) from None
    except KeyboardInterrupt:
        console.print("interrupted; finished replicates are kept, the same command goes on")
        raise typer.Exit(130) from None


@app.command("list")
def list_studies() -> None:
    """List the studies with their profiles and grids."""
    for name in study_names():
        study = load_study(name)
        grid = ", ".join(f"{k} in {v}" for k, v in study.grid.items())
        print(f"{name:<16} {study.summary}")
        print(f"{'':<16} profiles: {', '.join(study.profiles)}" + (f"; {grid}" if grid else ""))


@app.command()
def run(
    study: Annotated[str | None, typer.Argument(help="Study to run.")] = None,
    every: Annotated[bool, typer.Option("--all", help="Run every study.")] = False,
    profile: Annotated[str, typer.Option(help="quick or paper.")] = "quick",
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="key=value, may be repeated.")
    ] = None,
    jobs: Annotated[int, typer.Option(help="Worker processes; 0 takes every core.")] = 0,
    results: Annotated[Path, typer.Option(help="Results folder.")] = ROOT,
) -> None:
    """Run a study over its grid; what is there already is not computed again."""
    console = Console(stderr=True)
    with _plain_errors(console):
        if (study is None) != every:
            raise StudyError(f"name one study or give --all. Known: {', '.join(study_names())}.")
        if every and settings:
            raise StudyError("--set goes with one study, not with --all.")
        for name in study_names() if study is None else [study]:
            found = load_study(name)
            if found.missing() and every:
                console.print(f"{name} left out: {found.missing()}", markup=False, soft_wrap=True)
                continue
            if found.missing():
                raise StudyError(f"{name} cannot run: {found.missing()}")
            for label, config in configurations(found, profile, settings or []):
                print(run_study(found, label, config, results, jobs, console))


if __name__ == "__main__":
    app()
