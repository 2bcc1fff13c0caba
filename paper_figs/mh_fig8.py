"""Metropolis-Hastings paper, Figure 8: RMSE of the corrected position, constant bias."""

from __future__ import annotations

from pathlib import Path

from paper_figs.mh_common import draw_errors


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_errors("mh_fig8", 8, False, "position", profile, results, out)
