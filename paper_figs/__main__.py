"""Command line: draw the named figures and tables, by default all of them."""

from __future__ import annotations

import importlib
import os
import pkgutil
import sys
from pathlib import Path
from typing import Annotated

import typer

import paper_figs
from experiments.results import ROOT
from experiments.study import StudyError, nearest
from paper_figs.style import OUT, look

COMMON = (
    "ralad_common",
    "lts_common",
    "passive_common",
    "rrtls_common",
    "bayes_common",
    "mh_common",
    "drift_common",
)
HELPERS = ("style", "tables", *COMMON, "__main__")


def names() -> list[str]:
    """Names of all figures and tables: the modules that have a `draw`."""
    found = pkgutil.iter_modules(paper_figs.__path__)
    return sorted(module.name for module in found if module.name not in HELPERS)


def main(
    wanted: Annotated[list[str] | None, typer.Argument(metavar="[NAME]...")] = None,
    profile: Annotated[str, typer.Option(help="Results to draw from: quick or paper.")] = "quick",
    results: Annotated[Path, typer.Option(help="Results folder.")] = ROOT,
    out: Annotated[Path, typer.Option(help="Where figures go.")] = OUT,
) -> None:
    """Draw figures and tables from saved results; a missing result names its command."""
    try:
        for name in wanted or names():
            if name not in names():
                raise StudyError(f"no figure or table {name!r}. {nearest(name, names())}")
        with look():
            for name in wanted or names():
                module = importlib.import_module(f"paper_figs.{name}")
                needs = getattr(module, "NEEDS", "")
                if not wanted and needs and needs not in os.environ:
                    print(f"{name} left out: {needs} names no data", file=sys.stderr)
                    continue
                for path in module.draw(profile, results, out):
                    print(path)
    except StudyError as error:
        print(f"error: {error}", file=sys.stderr)
        raise typer.Exit(1) from None
    except OSError as error:
        print(f"error: cannot write {error.filename}: {error.strerror}", file=sys.stderr)
        raise typer.Exit(1) from None


if __name__ == "__main__":
    typer.run(main)
