"""Command line: draw the named figures and tables, by default all of them."""

from __future__ import annotations

import importlib
import os
import pkgutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

import paper_figs
from experiments.results import ROOT
from experiments.study import StudyError, nearest
from paper_figs._style import OUT, look


class Figure(NamedTuple):
    """A figure or table.

    Attributes
    ----------
    draw : callable
        (profile, results folder, output folder) -> files written.
    needs : str
        Environment variable that must name the data, if any.
    """

    draw: Callable[[str, Path, Path], list[Path]]
    needs: str


def figures() -> dict[str, Figure]:
    """All figures and tables by name, found in the public modules of the package.

    A module is a figure of its own name with a function `draw`, or holds a table `FIGURES` of
    names and such functions.
    """
    found: dict[str, Figure] = {}
    for name in sorted(module.name for module in pkgutil.iter_modules(paper_figs.__path__)):
        if not name.startswith("_"):
            module = importlib.import_module(f"paper_figs.{name}")
            held = module.FIGURES if hasattr(module, "FIGURES") else {name: module.draw}
            if twice := found.keys() & held.keys():
                raise ValueError(f"{sorted(twice)} in {module.__file__} and in another module.")
            needs = getattr(module, "NEEDS", "")
            found |= {name: Figure(draw, needs) for name, draw in held.items()}
    return dict(sorted(found.items()))


def main(
    wanted: Annotated[list[str] | None, typer.Argument(metavar="[NAME]...")] = None,
    profile: Annotated[str, typer.Option(help="Results to draw from: quick or paper.")] = "quick",
    results: Annotated[Path, typer.Option(help="Results folder.")] = ROOT,
    out: Annotated[Path, typer.Option(help="Where figures go.")] = OUT,
) -> None:
    """Draw figures and tables from saved results; a missing result names its command."""
    known = figures()
    try:
        for name in wanted or []:
            if name not in known:
                raise StudyError(f"no figure or table {name!r}. {nearest(name, known)}")
        with look():
            for name in wanted or known:
                figure = known[name]
                if not wanted and figure.needs and figure.needs not in os.environ:
                    print(f"{name} left out: {figure.needs} names no data", file=sys.stderr)
                    continue
                for path in figure.draw(profile, results, out):
                    print(path)
    except StudyError as error:
        print(f"error: {error}", file=sys.stderr)
        raise typer.Exit(1) from None
    except OSError as error:
        print(f"error: cannot write {error.filename}: {error.strerror}", file=sys.stderr)
        raise typer.Exit(1) from None


if __name__ == "__main__":
    typer.run(main)
