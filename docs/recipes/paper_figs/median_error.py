"""Error of the median beside that of the mean."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt

from experiments.results import load_result
from paper_figs._style import WIDTH, save


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """One box a method and sample size."""
    figure, axes = plt.subplots(figsize=(WIDTH, 2.4))
    errors, labels = [], []
    for size in (11, 101):
        data, _ = load_result("median_error", f"{profile},size={size}", results)
        for method in data["method"].values.tolist():
            errors.append(data["error"].sel(method=method).values.ravel())
            labels.append(f"{method} of {size}")
    axes.boxplot(errors, tick_labels=labels)
    axes.set_ylabel("error")
    return save(figure, "median_error", out)
