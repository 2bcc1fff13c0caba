"""Metropolis-Hastings paper, Figure 4: RMSE of the corrected position, drifting bias."""

from __future__ import annotations

from pathlib import Path

from paper_figs.mh_common import draw_errors


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_errors("mh_fig4", 4, True, "position", profile, results, out)
