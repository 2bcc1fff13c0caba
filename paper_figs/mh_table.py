"""Metropolis-Hastings paper: RMSE of the bias and coverage of every method."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from paper_figs.mh_common import FORM_TITLES, SOURCE, load
from paper_figs.tables import save_table

SETTLED_S = 60.0  # the paper's protocol is scored after this, when it has left its start


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Write the table."""
    rows: list[list[str]] = []
    for drifting in (True, False):
        data, manifest = load(drifting, profile, results)
        rows.append(["drifting bias" if drifting else "constant bias"])
        for method in (str(m) for m in data["estimator"].values):
            late = method.startswith("paper")
            cells = []
            for form in FORM_TITLES:
                chosen = data.sel(form=form, estimator=method)
                square = chosen["bias_square"].transpose("case", "time").values
                kept = square[:, data["time"].values > SETTLED_S] if late else square
                runs = kept.mean(axis=1)
                value = float(np.sqrt(runs.mean()))
                error = float(runs.std() / np.sqrt(len(runs)) / (2.0 * value))
                inside = chosen["held"].transpose("case", "time").values
                held = float(
                    (inside[:, data["time"].values > SETTLED_S] if late else inside).mean()
                )
                shown = "-" if np.isnan(held) else f"{held:.3f}"
                cells += [f"{value:.1f} ± {error:.1f}", shown]
            rows.append([f"  {method}{' (t > 60 s)' if late else ''}", *cells])
    header = ["RMSE of the bias (m)"]
    for title in FORM_TITLES.values():
        header += [title.split(":")[0], f"90 % holds, {title.split(':')[0]}"]
    config = manifest["config"]
    note = f"Data after {SOURCE}; {config['replicates'] * config['runs']} runs"
    return save_table(
        "mh_table", "The MH paper's scene: errors and coverage", header, rows, note, out
    )
