"""Metropolis-Hastings paper, Figure 5: tracks before and after correction, constant bias."""

from __future__ import annotations

from pathlib import Path

from paper_figs.mh_common import draw_tracks


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_tracks("mh_fig5", 5, False, profile, results, out)
