"""Metropolis-Hastings paper, Figure 7: RMSE of the constant bias."""

from __future__ import annotations

from pathlib import Path

from paper_figs.mh_common import draw_errors


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_errors("mh_fig7", 7, False, "bias", profile, results, out)
