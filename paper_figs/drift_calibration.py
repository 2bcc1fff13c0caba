"""Simulation-based calibration of the samplers of whole paths."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt

from paper_figs._bayes import draw_ecdf, pooled, ranks_of, verdict
from paper_figs._cases import load_cases
from paper_figs._style import WIDTH, footnote, save
from paper_figs._tables import save_table


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw one panel a sampler: ECDF differences of every quantity; and write the table."""
    data, manifest = load_cases("drift_calibration", profile, results)
    samplers, keep = [str(s) for s in data["sampler"].values], int(manifest["config"]["keep"])
    figure, panels = plt.subplots(1, len(samplers), figsize=(WIDTH, 2.3), sharey=True)
    p_values: list[float] = []
    rows = []
    for k, (axes, sampler) in enumerate(zip(panels, samplers, strict=True)):
        values = data["ranks"].sel(sampler=sampler).transpose("case", "quantity").values
        values = values[(values >= 0).any(axis=1)]  # NUTS is not run every time
        ranks = ranks_of(values, keep)
        assert ranks is not None
        draw_ecdf(axes, ranks, f"C{k}")
        shown = sampler.replace(", ", ",\n")
        axes.set_title(f"{shown}\n{len(values)} runs", fontsize=7)
        p_values += [float(p) for p in ranks.p_values]
        # ranks among 49 draws give intervals of 48 and 92 % rather than 50 and 90
        found = [ranks.coverage(p) for p in (0.5, 0.9)]
        cells = [f"{pooled(own):.3f} of {own[0].nominal:.2f}" for own in found]
        rows.append([sampler, str(len(values)), f"{ranks.p_values.min():.3g}", *cells])
    text = f"Target and drifting bias, 20 scans, Student-t noise; 95 % bands\n{verdict(p_values)}"
    footnote(figure, text)
    paths = save(figure, "drift_calibration", out)
    header = ["", "runs", "least p", "narrow interval holds", "wide interval holds"]
    title = "Calibration of the samplers of paths"
    return paths + save_table("drift_calibration_table", title, header, rows, text, out)
