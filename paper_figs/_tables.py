"""Tables as CSV, Markdown and a rendered picture, from one list of rows."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from itertools import accumulate
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from paper_figs._style import WIDTH, save, write_text


def save_table(
    name: str,
    title: str,
    header: Sequence[str],
    rows: Sequence[Sequence[str]],
    note: str,
    out: Path,
) -> list[Path]:
    """Write one table in its three forms.

    Parameters
    ----------
    name : str
        File name without ending.
    title, note : str
        Above and below the table.
    header : sequence of str
    rows : sequence of sequence of str
        Cells as they are shown; a row of one cell is a heading.
    out : Path

    Returns
    -------
    list of Path
    """
    width = len(header)
    full = [[*row, *[""] * (width - len(row))] for row in rows]
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows([header, *full])
    lines = [f"**{title}**", "", "| " + " | ".join(header) + " |", "|" + "---|" * width]
    lines += ["| " + " | ".join(row) + " |" for row in full]
    paths = [
        write_text(buffer.getvalue(), f"{name}.csv", out),
        write_text("\n".join([*lines, "", note, ""]), f"{name}.md", out),
    ]
    return paths + save(_render(title, header, rows, note), name, out)


def _render(title: str, header: Sequence[str], rows: Sequence[Sequence[str]], note: str) -> Figure:
    line = 0.19
    notes = note.count("\n") + 1
    height = line * (len(rows) + 2.6 + 0.8 * notes)
    figure, axes = plt.subplots(figsize=(WIDTH, height), layout="none")
    figure.subplots_adjust(0.01, 0.01, 0.99, 0.99)
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(-(len(rows) + 1.6 + 0.8 * notes), 1.0)
    edges, length = _right_edges(header, rows)
    size = min(7.5, 7.5 * 112.0 / length)  # so many characters fit the width at 7.5 points
    axes.text(0.0, 0.35, title, weight="bold", va="center", fontsize=8.5)
    axes.hlines([-0.2, -1.2], 0.0, 1.0, color="0.2", linewidth=[1.0, 0.6])
    for y, row in enumerate([header, *rows]):
        style: dict[str, Any] = {
            "va": "center",
            "fontsize": size,
            "weight": "bold" if y == 0 else "normal",
        }
        axes.text(0.0, -y - 0.7, row[0], style="italic" if len(row) == 1 else "normal", **style)
        for cell, edge in zip(row[1:], edges, strict=False):
            axes.text(edge, -y - 0.7, cell, ha="right", **style)
    axes.hlines(-len(rows) - 1.25, 0.0, 1.0, color="0.2", linewidth=1.0)
    axes.text(0.0, -len(rows) - 1.5, note, va="top", fontsize=6.5, color="0.35")
    return figure


def _right_edges(header: Sequence[str], rows: Sequence[Sequence[str]]) -> tuple[list[float], float]:
    """Right edges of the columns after the first, by what they hold, and the characters in all."""
    table = [header, *(row for row in rows if len(row) > 1)]
    # mathematics is set in fewer characters than it is written in
    lengths = [
        max(len(row[k]) * (0.55 if "$" in row[k] else 1.0) for row in table)
        for k in range(len(header))
    ]
    widths = [length + 2.0 for length in lengths]
    total = sum(widths)
    return list(accumulate(width / total for width in widths))[1:], total
