"""RALAD paper, Figure 8: condition numbers of Huber against RALAD, case 2."""

from __future__ import annotations

from pathlib import Path

from paper_figs.ralad_common import draw_conditions


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_conditions("ralad_fig8", 2, profile, results, out)
