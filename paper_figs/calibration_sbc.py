"""Simulation-based calibration of every sampler under every law, two geometries."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from paper_figs._bayes import draw_ecdf, pooled, ranks_of, verdict
from paper_figs._cases import load_cases
from paper_figs._style import WIDTH, footnote, save
from paper_figs._tables import save_table
from probreg.diagnostics import Ranks

TITLES = {"pair_2d": "pair of 2-D radars", "pair_3d": "pair of 3-D radars of the RALAD scene"}


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw one figure of ECDF differences and one of rank histograms a geometry; one table."""
    paths: list[Path] = []
    rows: list[list[str]] = []
    everything: list[float] = []
    for geometry, title in TITLES.items():
        found, runs = load(profile, geometry, results)
        p_values = [float(p) for ranks in found.values() for p in ranks.p_values]
        everything += p_values
        note = (
            f"{title}, 100 rows; {runs['many']} runs (NUTS {runs['nuts']}), truth ranked among 99 "
            f"draws ({runs['kept']} for NUTS)\n{verdict(p_values)}"
        )
        paths += panels(f"calibration_sbc_{geometry}", found, note, out, histogram=False)
        paths += panels(f"calibration_ranks_{geometry}", found, note, out, histogram=True)
        rows.append([title])
        for (sampler, law), ranks in found.items():
            cells = [f"{ranks.p_values.min():.3g}", f"{ranks.p_values[-1]:.3g}"]
            cells += [f"{pooled(ranks.coverage(p)[:-1]):.3f}" for p in (0.5, 0.9)]
            rows.append([f"  {sampler}: {law}", *cells])
    header = ["", "least p", "p of log-likelihood", "50 % interval holds", "90 % interval holds"]
    title = "Calibration of every sampler under every law"
    return paths + save_table("calibration_table", title, header, rows, verdict(everything), out)


def load(
    profile: str, geometry: str, results: Path
) -> tuple[dict[tuple[str, str], Ranks], dict[str, int]]:
    """Ranks of every combination that was run, and how many runs and draws there were."""
    found = {}
    runs = {}
    for study, name in (("calibration", "many"), ("calibration_nuts", "nuts")):
        data, manifest = load_cases(study, f"{profile},geometry={geometry}", results)
        keep = int(manifest["config"]["keep"])
        runs[name] = data.sizes["case"]
        runs["kept"] = keep
        for sampler in (str(s) for s in data["sampler"].values):
            for law in (str(s) for s in data["law"].values):
                chosen = data["ranks"].sel(sampler=sampler, law=law)
                ranks = ranks_of(chosen.transpose("case", "quantity").values, keep)
                if ranks is not None:
                    found[sampler, law] = ranks
    return found, runs


def panels(
    name: str, found: dict[tuple[str, str], Ranks], note: str, out: Path, *, histogram: bool
) -> list[Path]:
    """One panel a combination: samplers down, laws across."""
    samplers = list(dict.fromkeys(key[0] for key in found))
    laws = list(dict.fromkeys(key[1] for key in found))
    figure, grid = plt.subplots(
        len(samplers), len(laws), figsize=(1.35 * WIDTH, 1.05 * len(samplers) + 0.9), sharex=True
    )
    for r, sampler in enumerate(samplers):
        for c, law in enumerate(laws):
            axes = grid[r, c]
            if (sampler, law) not in found:
                axes.set_axis_off()
            else:
                ranks = found[sampler, law]
                if histogram:
                    draw_histogram(axes, ranks)
                else:
                    draw_ecdf(axes, ranks, f"C{r}")
            if r == 0:
                axes.set_title(law.replace(", ", ",\n"), fontsize=6.5)
            axes.set_yticks([])
        grid[r, 0].set_axis_on()
        grid[r, 0].set_ylabel(sampler.replace(", ", ",\n"), fontsize=7)
    what = "counts of ranks" if histogram else "ECDF minus uniform, 95 % band; log-likelihood thick"
    footnote(figure, f"{what}; {note}")
    return save(figure, name, out)


def draw_histogram(axes: plt.Axes, ranks: Ranks) -> None:
    """Counts of the ranks of all unknowns together, with the range of a right sampler."""
    bins = 11
    counts = np.sum([ranks.histogram(name, bins)[1] for name in ranks.names], axis=0)
    edges = ranks.histogram(ranks.names[0], bins)[0]
    axes.stairs(counts, edges, fill=True, color="C0", alpha=0.6)
    expected = counts.sum() / bins
    # unknowns of one run are not independent: the range is that of one unknown, scaled
    spread = np.sqrt(len(ranks.names) * expected * (1.0 - 1.0 / bins))
    axes.axhspan(expected - 2.0 * spread, expected + 2.0 * spread, color="0.85", zorder=0)
    axes.set_xticks([0.0, 1.0])
    axes.tick_params(labelsize=6)
