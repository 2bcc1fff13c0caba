"""Robust total-least-squares paper, section 2.3: influence functions, drawn and computed."""

from __future__ import annotations

from pathlib import Path

from experiments.results import load_result
from paper_figs._passive import TOTAL_SOURCE, grid
from paper_figs._style import PASSIVE_COLOURS, TRUTH, footnote, label_outer, save


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw one panel an estimator: each noise thin, their mean thick, the theory dashed."""
    data, manifest = load_result("rrtls_influence", profile, results)
    names = [str(name) for name in data["estimator"].values]
    figure, panels = grid(2, 3, 4.6)
    shift = data["shift"].isel(replicate=0) if "replicate" in data["shift"].dims else data["shift"]
    for axes, name in zip(panels.ravel(), names, strict=False):
        moved = data["empirical"].sel(estimator=name).transpose("replicate", "shift").values
        colour = PASSIVE_COLOURS[name]
        axes.plot(shift, moved.T, color=colour, linewidth=0.4, alpha=0.3)
        axes.plot(shift, moved.mean(axis=0), color=colour, label="empirical, mean")
        theory = data["theory"].sel(estimator=name).mean("replicate").values
        axes.plot(shift, theory, **TRUTH, label="theory, first order")
        axes.set_title(name)
        axes.set_ylim((-1.1, 0.6) if name in ("RLS", "RTLS") else (-0.2, 0.2))
        axes.legend(fontsize=6.5, loc="lower left")
    label_outer(panels, "error of the bearing (sigma)", "change along sight (%)", len(names))
    config = manifest["config"]
    text = (
        f"After section 2.3 of {TOTAL_SOURCE}\nThe bearing of point {config['point']} moves, the "
        f"estimate after point 200 follows; {config['replicates']} noises; percent of 180 km"
    )
    footnote(figure, text)
    return save(figure, "rrtls_influence", out)
