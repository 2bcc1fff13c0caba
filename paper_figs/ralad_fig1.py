"""RALAD paper, Figure 1: estimates of the range bias against the scan, case 1."""

from __future__ import annotations

from pathlib import Path

from paper_figs.ralad_common import draw_estimates


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_estimates("ralad_fig1", 1, "range", profile, results, out)
