"""Robust total-least-squares paper, Figure 2: relative distance error without outliers."""

from __future__ import annotations

from pathlib import Path

from paper_figs.rrtls_common import draw_errors


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_errors("rrtls_fig2", 2, "none", profile, results, out)
