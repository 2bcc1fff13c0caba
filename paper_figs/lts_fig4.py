"""LTS paper, Figure 4: error of RLS against its rejection threshold, both readings."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from paper_figs.lts_common import (
    READINGS,
    SCORES,
    SHOWN,
    bound_score,
    label_panels,
    load,
    score,
    source,
    suffix,
)
from paper_figs.style import BOUND, LTS_COLOURS, WIDTH, footnote, save


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw one figure a reading."""
    paths = []
    for reading in READINGS:
        data, manifest = load("lts", reading, profile, results)
        errors = (data["sweep_theta"] - data["truth"]).transpose("parameter", "threshold", "case")
        wrong = data["sweep_wrong_share"].values
        thresholds = data["threshold"].values
        # the bound is linear in sigma, run by run: one noise level gives it at any other
        last = data["bound_sd"].isel(sigma=-1)
        sds = last * (manifest["config"]["sweep_sigma_m"] / float(last["sigma"]))
        figure, grid = plt.subplots(3, 4, figsize=(WIDTH, 6.2), sharex=True)
        best = []
        for row, name in zip(grid, SCORES, strict=True):
            curves = []
            for axes, parameter in zip(row, SHOWN, strict=True):
                _, factor, _ = SHOWN[parameter]
                each = errors.sel(parameter=parameter).values
                values = factor * np.array([score(name, e, wrong) for e in each])
                curves.append(values / values.min())
                axes.plot(thresholds, values, marker=".", color=LTS_COLOURS["RLS"])
                sd = sds.sel(parameter=parameter).values
                axes.axhline(factor * bound_score(name, sd, wrong), **BOUND)
                lowest = int(np.argmin(values))
                axes.plot(thresholds[lowest], values[lowest], "o", color="0.15", fillstyle="none")
            best.append(f"{thresholds[np.argmin(np.mean(curves, axis=0))]:.0f} ({SCORES[name]})")
        label_panels(grid, r"threshold $\rho'$")
        text = (
            "sigma = 100 m; circle: least error; dotted: bound, right pairs\n"
            f"Best over all parameters: {', '.join(best)}"
        )
        footnote(figure, source(manifest, text))
        paths += save(figure, f"lts_fig4{suffix(reading)}", out)
    return paths
