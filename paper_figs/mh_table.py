"""Metropolis-Hastings paper: RMSE of the bias and coverage of every method."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from paper_figs._cases import runs_of
from paper_figs._errors import rmse
from paper_figs._mh import FORM_TITLES, SOURCE, load
from paper_figs._tables import save_table

SETTLED_S = 60.0  # the paper's protocol is scored after this, when it has left its start


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Write the table."""
    rows: list[list[str]] = []
    for drifting in (True, False):
        data, manifest = load(drifting, profile, results)
        rows.append(["drifting bias" if drifting else "constant bias"])
        for method in (str(m) for m in data["estimator"].values):
            late = method.startswith("paper")
            kept = data.sel(time=data["time"] > SETTLED_S) if late else data
            cells = []
            for form in FORM_TITLES:
                chosen = kept.sel(form=form, estimator=method)
                value, error = rmse(chosen["bias_square"])
                held = float(chosen["held"].transpose("case", "time").values.mean())
                cells += [f"{value:.1f} ± {error:.1f}", "-" if np.isnan(held) else f"{held:.3f}"]
            rows.append([f"  {method}{' (t > 60 s)' if late else ''}", *cells])
    header = ["RMSE of the bias (m)"]
    for title in FORM_TITLES.values():
        header += [title.split(":")[0], f"90 % holds, {title.split(':')[0]}"]
    note = f"Data after {SOURCE}; {runs_of(manifest)} runs"
    return save_table(
        "mh_table", "The MH paper's scene: errors and coverage", header, rows, note, out
    )
