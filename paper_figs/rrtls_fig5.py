"""Robust total-least-squares paper, Figure 5: standardised residuals with outliers."""

from __future__ import annotations

from pathlib import Path

from paper_figs.rrtls_common import draw_residuals


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_residuals("rrtls_fig5", 5, "table", profile, results, out)
