"""Metropolis-Hastings paper, Figure 1: tracks before and after correction, drifting bias."""

from __future__ import annotations

from pathlib import Path

from paper_figs.mh_common import draw_tracks


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_tracks("mh_fig1", 1, True, profile, results, out)
