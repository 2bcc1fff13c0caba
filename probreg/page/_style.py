"""One look for the figures of a report, and their form: SVG that stands in the page's own text.

Text and axes take the page's colours, so that one figure serves paper and dark mode.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from html import escape
from typing import Any, NamedTuple

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

# Okabe-Ito, told apart by colour-blind readers
BEFORE, AFTER = "#D55E00", "#0072B2"
# blue and vermilion a shade off those above: the page lightens each by itself in dark mode
SENSORS = ("#0072B3", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E01")
MARKERS = ("o", "s", "^", "D", "v", "P")
# stand in for colours of the page, which matplotlib cannot name
TEXT, GRID = "#010203", "#040506"
SIZE = (3.5, 2.35)  # inches: three a row on a desk, one on a telephone

_SETTINGS: dict[str, Any] = {
    "svg.fonttype": "none",
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.edgecolor": TEXT,
    "axes.labelcolor": TEXT,
    "axes.titlecolor": TEXT,
    "xtick.color": TEXT,
    "ytick.color": TEXT,
    "text.color": TEXT,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "axes.linewidth": 0.7,
    "axes.formatter.useoffset": False,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "figure.dpi": 120,  # of the dots, which are a picture in the drawing
}
LETTER, LINE, EDGE = 0.072, 0.2, 0.08  # inches: mean width of a letter, height of a line, rim
_NO_METADATA = {"Creator": None, "Date": None, "Format": None, "Type": None}
_PAGE = (
    (TEXT, "currentColor"),
    (GRID, "var(--grid)"),
    (BEFORE.lower(), "var(--figure-before)"),
    (AFTER.lower(), "var(--figure-after)"),
    (SENSORS[0].lower(), "var(--figure-blue)"),
    ("xlink:href", "href"),
)


class Panel(NamedTuple):
    """A small figure: SVG markup, and what it shows in words."""

    svg: str
    words: str


class Room(NamedTuple):
    """Inches beside the axes that hold more than ticks and labels: rotated names, a legend."""

    left: float = 0.0
    right: float = 0.0
    bottom: float = 0.0


def panel(
    draw: Callable[[Axes], None],
    words: str,
    size: tuple[float, float] = SIZE,
    room: Room = Room(),  # noqa: B008 (a constant)
) -> Panel:
    """Draw one pair of axes."""
    # ids are made of the salt: those of two figures on one page differ
    settings: Any = {**_SETTINGS, "svg.hashsalt": words}
    with mpl.rc_context(settings):
        figure = Figure(figsize=size)
        axes = figure.add_subplot()
        draw(axes)
        _place(axes, size, room)
        buffer = io.StringIO()
        FigureCanvasSVG(figure).print_svg(buffer, metadata=_NO_METADATA)
    return Panel(_inline(buffer.getvalue(), words), words)


def _place(axes: Axes, size: tuple[float, float], room: Room) -> None:
    """Leave room for labels by the number of their letters: to draw and measure them costs half."""
    ticks = axes.yaxis.get_majorticklocs()
    low, high = sorted(axes.get_ylim())
    shown = [y for y in ticks if low <= y <= high]
    longest = max(map(len, axes.yaxis.get_major_formatter().format_ticks(shown)), default=0)
    left = EDGE + LETTER * longest + LINE * bool(axes.get_ylabel()) + EDGE * bool(shown)
    bottom = EDGE + LINE + LINE * bool(axes.get_xlabel())
    top = EDGE + LINE * bool(axes.get_title(loc="left"))
    width, height = size
    left, right = room.left or left, room.right or 2.0 * EDGE
    bottom = room.bottom or bottom
    axes.set_position(
        (
            left / width,
            bottom / height,
            (width - left - right) / width,
            (height - bottom - top) / height,
        )
    )


def _inline(svg: str, words: str) -> str:
    """SVG as a part of HTML: no prologue, no metadata, the page's colours and letters."""
    body = svg[svg.index("<svg") :]
    opening, rest = body.split(">", 1)
    view = re.search(r'viewBox="[^"]*"', opening)
    assert view is not None
    rest = re.sub(r"<metadata>.*?</metadata>", "", rest, flags=re.DOTALL)
    rest = re.sub(r'<g id="[^"]*"', "<g", rest)
    rest = re.sub(r"'DejaVu Sans'[^;\"]*", "system-ui, sans-serif", rest)
    for inside, outside in _PAGE:
        rest = rest.replace(inside, outside)
    return f'<svg {view.group()} role="img" aria-label="{escape(words)}">{rest}'.strip()
