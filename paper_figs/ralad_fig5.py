"""RALAD paper, Figure 5: estimates of the azimuth bias against the scan, case 2."""

from __future__ import annotations

from pathlib import Path

from paper_figs.ralad_common import draw_estimates


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_estimates("ralad_fig5", 2, "azimuth", profile, results, out)
