"""Metropolis-Hastings paper, Figure 3: RMSE of the drifting bias."""

from __future__ import annotations

from pathlib import Path

from paper_figs.mh_common import draw_errors


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_errors("mh_fig3", 3, True, "bias", profile, results, out)
