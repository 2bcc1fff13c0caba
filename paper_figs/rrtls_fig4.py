"""Robust total-least-squares paper, Figure 4: relative distance error with outliers."""

from __future__ import annotations

from pathlib import Path

from paper_figs.rrtls_common import draw_errors


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_errors("rrtls_fig4", 4, "table", profile, results, out)
