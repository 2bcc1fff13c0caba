"""RALAD paper, Figure 3: estimates of the elevation bias against the scan, case 1."""

from __future__ import annotations

from pathlib import Path

from paper_figs.ralad_common import draw_estimates


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure."""
    return draw_estimates("ralad_fig3", 1, "elevation", profile, results, out)
