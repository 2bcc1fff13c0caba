"""One look for all figures: sizes, fonts, a colour a method, and how files are written."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.results import write_whole

OUT = Path(__file__).parent / "out"
WIDTH = 7.0  # inches, a text width

TRUTH: dict[str, Any] = {"color": "0.15", "linewidth": 1.0, "linestyle": (0, (5, 2))}
BOUND: dict[str, Any] = {"color": "0.15", "linewidth": 1.2, "linestyle": ":"}

# Okabe-Ito, told apart by colour-blind readers; a method keeps its colour in every figure
COLOURS = {
    "RLS": "#0072B2",
    "Huber": "#E69F00",
    "RALAD": "#D55E00",
    "RALAD (42)": "#8C5A3C",
    "LMedS": "#009E73",
    "LMedS raw": "#7FBFA8",
    "batch LAD": "#CC79A7",
    "Student-t, recursive": "#56B4E9",
    "Student-t, batch": "#1F78B4",
    "contaminated, recursive": "#B2A100",
    "contaminated, batch": "#6A6100",
    "least squares, clean rows only": "#444444",
}

# the LTS paper means something else by RLS, hence colours of its own
LTS_COLOURS = {
    "LS": "#0072B2",
    "LMS": "#009E73",
    "LTS": "#E69F00",
    "RLS": "#D55E00",
    "RLS, threshold 7": "#CC79A7",
}

# bearings only: both papers, and what lies beyond them
PASSIVE_COLOURS = {
    "LS": "#0072B2",
    "RLS": "#0072B2",
    "EKF": "#009E73",
    "RTLS": "#009E73",
    "REKF": "#E69F00",
    "XRTLS": "#E69F00",
    "chi2-REKF": "#D55E00",
    "RRTLS": "#D55E00",
    "EKF, start reused": "#CC79A7",
    "RRTLS, robust start": "#CC79A7",
    "Gaussian ML": "#444444",
    "Student-t ML": "#1F78B4",
    "contaminated ML": "#6A6100",
    "Student-t ML, bias unknown": "#56B4E9",
    "contaminated ML, bias unknown": "#B2A100",
}


@contextmanager
def look() -> Iterator[None]:
    """Apply the style without touching the user's settings."""
    settings: Any = {
        "figure.dpi": 100,
        "savefig.dpi": 200,
        "font.size": 8.5,
        "axes.titlesize": 9,
        "axes.labelsize": 8.5,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "0.9",
        "grid.linewidth": 0.6,
        "legend.frameon": False,
        "legend.fontsize": 8,
        "lines.linewidth": 1.3,
        "pdf.fonttype": 42,
        "svg.hashsalt": "probreg",
        "figure.constrained_layout.use": True,
    }
    with mpl.rc_context(settings):
        mpl.use("agg")
        logging.getLogger("fontTools").setLevel(logging.ERROR)  # remarks on font time stamps
        yield


def save(figure: Figure, name: str, out: Path) -> list[Path]:
    """Write a figure as PDF and PNG, each whole or not at all, and close it."""
    out.mkdir(parents=True, exist_ok=True)
    paths = []
    for kind, metadata in (("pdf", {"CreationDate": None}), ("png", {"Software": None})):
        path = out / f"{name}.{kind}"

        def write(temporary: Path, kind: str = kind, metadata: dict = metadata) -> None:
            figure.savefig(temporary, format=kind, metadata=metadata)

        write_whole(path, write)
        paths.append(path)
    plt.close(figure)
    return paths


def write_text(text: str, name: str, out: Path) -> Path:
    """Write a text file, whole or not at all."""
    out.mkdir(parents=True, exist_ok=True)
    path = out / name

    def write(temporary: Path) -> None:
        temporary.write_text(text)

    write_whole(path, write)
    return path


def shared_legend(figure: Figure, axes: Axes, columns: int, **style: Any) -> None:
    """One legend above all panels, of what one of them shows."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=columns, **style)


def label_outer(grid: np.ndarray, xlabel: str, ylabel: str, count: int | None = None) -> None:
    """Label the lowest panel of each column and the first of each row, the first `count` used."""
    count = grid.size if count is None else count
    for k, axes in enumerate(grid.ravel()):
        if k >= count:
            axes.set_axis_off()
        elif k + grid.shape[1] >= count:
            axes.set_xlabel(xlabel)
            axes.tick_params(labelbottom=True)
    for axes in grid[:, 0]:
        axes.set_ylabel(ylabel)


def name_rows(axes: Axes, names: Sequence[str]) -> None:
    """One name a unit of the y axis, the first on top."""
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.yaxis.set_inverted(True)


def footnote(figure: Figure, text: str) -> None:
    """Say below the axes where the numbers come from."""
    figure.supxlabel(text, fontsize=6.5, color="0.35", x=0.01, ha="left")
