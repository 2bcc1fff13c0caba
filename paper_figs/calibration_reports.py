"""Calibration of the whole chain: polar reports, converted, re-linearised, sampled."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt

from paper_figs._bayes import draw_ecdf, verdict
from paper_figs._cases import load_cases
from paper_figs._style import WIDTH, footnote, save
from paper_figs._tables import save_table
from probreg.diagnostics import Ranks

REPORTS = (500, 50_000)


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw ECDF differences, one panel a law and number of reports, and a table of coverage."""
    figure, grid = plt.subplots(2, 2, figsize=(WIDTH, 4.4), sharex=True)
    rows: list[list[str]] = []
    p_values: list[float] = []
    for column, reports in zip(grid.T, REPORTS, strict=True):
        data, manifest = load_cases("calibration_reports", f"{profile},reports={reports}", results)
        runs = data.sizes["case"]
        for axes, law in zip(column, (str(s) for s in data["law"].values), strict=True):
            values = data["ranks"].sel(law=law).transpose("case", "quantity").values
            names = tuple(str(q) for q in data["quantity"].values)
            ranks = Ranks(values, int(manifest["config"]["keep"]), names)
            draw_ecdf(axes, ranks, "C0")
            axes.set_title(f"{law}, {reports} reports, {runs} runs")
            p_values += [float(p) for p in ranks.p_values]
            rows.append([f"{law}, {reports} reports, {runs} runs"])
            for k, name in enumerate(names):
                cells = []
                for nominal in (0.5, 0.9):
                    found = ranks.coverage(nominal)[k]
                    low, high = found.limits(1e-3)
                    cells.append(f"{found.value:.3f} ({low:.3f}-{high:.3f})")
                rows.append([f"  {name}", f"{ranks.p_values[k]:.3g}", *cells])
    for axes in grid[:, 0]:
        axes.set_ylabel("ECDF minus uniform")
    text = f"95 % bands; log-likelihood thick\n{verdict(p_values)}"
    footnote(figure, text)
    paths = save(figure, "calibration_reports", out)
    header = ["", "p", "50 % interval holds (limits)", "90 % interval holds (limits)"]
    title = "Calibration of the whole chain, limits at a false-alarm rate of 1e-3 each"
    note = "3-D radars of the RALAD scene, truth from the prior, 30 m and 0.3 deg"
    return paths + save_table("calibration_reports_table", title, header, rows, note, out)
