"""Metropolis-Hastings paper, Figure 2: the drifting bias and its estimate."""

from __future__ import annotations

from pathlib import Path

from paper_figs.mh_common import draw_bias


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_bias("mh_fig2", 2, True, profile, results, out)
