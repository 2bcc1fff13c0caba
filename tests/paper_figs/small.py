"""A few runs of the studies, and the command that draws figures of them."""

from __future__ import annotations

import dataclasses
import io
import subprocess
import sys
from pathlib import Path

from rich.console import Console

from experiments.runner import run_study
from experiments.study import configurations, load_study

ROOT = Path(__file__).parents[2]
# settings of studies that have them
FEW = {"replicates": 2, "runs": 4, "keep": 19, "minutes": 5.5, "aircraft": 12}


def run_small(studies, folder):
    """A few runs of each study, stored under the labels that figures ask for."""
    for name in studies:
        study = load_study(name)
        for label, config in configurations(study, "quick", []):
            own = {name: value for name, value in FEW.items() if hasattr(config, name)}
            few = {name: min(value, getattr(config, name)) for name, value in own.items()}
            small = dataclasses.replace(config, **few)
            run_study(study, label, small, folder, 1, Console(file=io.StringIO()))
    return folder


def draw(*words):
    return subprocess.run(
        [sys.executable, "-m", "paper_figs", *map(str, words)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )


def draw_all(figures, results, out):
    done = draw(*figures, "--results", results, "--out", out)
    assert done.returncode == 0, done.stderr
    return out, done


STARTS = {"pdf": b"%PDF", "png": b"\x89PNG"}


def missing(files, drawn):
    """Files that are not there whole as vector and as picture, or that the command did not name."""
    out, done = drawn
    paths = [out / f"{name}.{ending}" for name in files for ending in STARTS]
    return [
        path.name
        for path in paths
        if not path.exists()
        or not path.read_bytes().startswith(STARTS[path.suffix[1:]])
        or str(path) not in done.stdout
    ]
