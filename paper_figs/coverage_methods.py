"""Coverage of the intervals that each method claims, on RALAD and LTS data."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt

from paper_figs._cases import load_cases
from paper_figs._errors import mean_and_error
from paper_figs._style import WIDTH, footnote, name_rows, save

TITLES = {
    "ralad": "RALAD, case 1",
    "lts": "LTS, symmetric reading",
}


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw one panel a data set: share of 50 and 90 % intervals that hold the truth."""
    figure, panels = plt.subplots(1, 2, figsize=(WIDTH, 3.8), sharey=True)
    said = []
    for axes, (name, title) in zip(panels, TITLES.items(), strict=True):
        data, _ = load_cases("coverage_methods", f"{profile},data={name}", results)
        methods = [str(m) for m in data["method_name"].values]
        for k, probability in enumerate(float(p) for p in data["probability"].values):
            for y, method in enumerate(methods):
                chosen = data["held"].sel(method_name=method, probability=probability)
                # biases of one run are not independent: bars from the spread between runs
                share, error = mean_and_error(chosen)
                axes.errorbar(share, y, xerr=2.0 * error, fmt="o", color=f"C{k}", markersize=4,
                              capsize=2)  # fmt: skip
            axes.axvline(probability, color=f"C{k}", linewidth=0.9)
        axes.set_title(title)
        axes.set_xlim(0.0, 1.02)
        axes.set_xlabel("share of intervals that hold the truth")
        said.append(f"{data.sizes['case']} {name.upper()} runs")
    name_rows(panels[0], methods)
    text = (
        f"{', '.join(said)} (a tenth of the scans; 100 m), all biases together\n"
        "Lines: what is claimed (50 and 90 %); bars: two standard errors"
    )
    footnote(figure, text)
    return save(figure, "coverage_methods", out)
