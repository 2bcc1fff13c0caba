"""Metropolis-Hastings paper, Figure 6: the constant bias and its estimate."""

from __future__ import annotations

from pathlib import Path

from paper_figs.mh_common import draw_bias


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_bias("mh_fig6", 6, False, profile, results, out)
