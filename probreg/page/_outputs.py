"""Files of numbers beside the page."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.page._folder import MANIFEST
from probreg.page._provenance import Provenance, checksum, versions
from probreg.page._units import SHOWN
from probreg.page._words import matters
from probreg.registration import RankedTerms, Registration

MOST_LIKELIHOODS = 5_000_000  # rows times draws kept in posterior.nc
POSTERIOR = "posterior.nc"
JSON_FORMAT = 1


def bias_rows(registration: Registration) -> list[dict[str, Any]]:
    """One mapping a bias, SI units."""
    half, most = registration.interval(0.5), registration.interval(0.9)
    numbers = registration.problem.model.numbers
    verdicts = {numbers[verdict.name]: verdict for verdict in registration.verdicts}
    rows = []
    for k, name in enumerate(registration.names):
        verdict = verdicts.get(k)
        rows.append(
            {
                "name": name,
                "unit": registration.units[k],
                "mean": float(registration.mean[k]),
                "sd": float(registration.sd[k]),
                "low_50": float(half[k, 0]),
                "high_50": float(half[k, 1]),
                "low_90": float(most[k, 0]),
                "high_90": float(most[k, 1]),
                "determined_by_data": float(registration.determined.share[k]),
                "limit": None if verdict is None else verdict.limit,
                "exceeds_limit": None if verdict is None else verdict.probability,
            }
        )
    return rows


def write_csv(path: Path, registration: Registration) -> None:
    """Biases in engineers' units; the column `unit` says which."""
    import pandas as pd

    rows = []
    for row in bias_rows(registration):
        shown = SHOWN[row["unit"]]
        in_units = ("mean", "sd", "low_50", "high_50", "low_90", "high_90", "limit")
        scaled = {
            name: None if row[name] is None else shown.factor * row[name] for name in in_units
        }
        rows.append({**row, **scaled, "unit": shown.symbol})
    pd.DataFrame(rows).to_csv(path, index=False)


def write_json(path: Path, registration: Registration, terms: Sequence[RankedTerms] = ()) -> None:
    """Biases and all that was found about them, SI units."""
    draws, first = registration.draws, len(registration.names)
    interval = draws.interval(0.9)
    content = {
        "format": JSON_FORMAT,
        "units": "SI: metres, radians, seconds; report = truth + bias + noise",
        "biases": bias_rows(registration),
        "covariance": registration.covariance.tolist(),
        "correlation": registration.correlation.tolist(),
        "noise": {
            "law": registration.laws[0].name,
            "parameters": {
                draws.names[k]: {
                    "mean": float(draws.mean[k]),
                    "low_90": float(interval[k, 0]),
                    "high_90": float(interval[k, 1]),
                }
                for k in range(first, len(draws.names))
            },
        },
        "laws": [law._asdict() for law in registration.laws],
        "bias_models": [one._asdict() for one in terms],
        "hidden": registration.determined.hidden,
        "weak": registration.determined.weak,
        "warnings": matters(registration),
        "remarks": list(registration.notes),
    }
    write_text(path, content)


def write_text(path: Path, content: Any) -> None:
    """JSON whose numbers JSON knows: what is not finite becomes null."""
    text = json.dumps(_finite(content), indent=1, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(one) for one in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value


def check_writable(folder: Path) -> None:
    """Check that the draws can be written into a folder, by writing an empty netCDF file there.

    Raises
    ------
    InvalidInputError
        h5netcdf or h5py do not load, or the file system refuses the file.
    """
    trial = folder / POSTERIOR
    try:
        import h5netcdf

        with h5netcdf.File(trial, "w"):
            pass
        trial.unlink()
    except ImportError as error:
        raise InvalidInputError(
            f"{POSTERIOR} could not be written ({error}): pip install h5netcdf h5py."
        ) from None
    except OSError as error:
        raise InvalidInputError(f"{POSTERIOR} could not be written: {error}.") from None


def write_posterior(path: Path, registration: Registration) -> None:
    """Draws as netCDF for ArviZ; the likelihood of every row where it is not too large."""
    draws = registration.draws
    size = len(draws.flat) * len(registration.problem.plan)
    data = draws.to_arviz(log_likelihood=size <= MOST_LIKELIHOODS)
    for name, unit in zip(draws.names, draws.units, strict=True):
        data["posterior"][name.replace(" ", "_")].attrs["units"] = unit
    data.to_netcdf(str(path), engine="h5netcdf")


def write_manifest(
    folder: Path, registration: Registration, provenance: Provenance, report_s: float
) -> None:
    """What was done, with what, and the checksums of every other file in the folder."""
    draws = registration.draws
    found = draws.convergence
    content = {
        **dataclasses.asdict(provenance),
        "seconds": {**registration.seconds, "report": report_s},
        "checks": {
            "rows": len(registration.problem.plan),
            "reports_used": registration.used,
            "law": registration.laws[0].name,
            "sampler": draws.sampler,
            "r_hat": float(np.max(found.r_hat)),
            "effective_draws": float(np.min([found.ess_bulk, found.ess_tail])),
            "pareto_k": draws.facts.get("pareto_k"),
            "warnings": matters(registration),
        },
    }
    write_summary(folder, provenance.command, content)


def write_summary(folder: Path, command: str, content: Mapping[str, Any]) -> None:
    """Write a manifest: the command, what it did, checksums of every other file in the folder."""
    outputs = {file.name: checksum(file) for file in sorted(folder.iterdir())}
    head = {"program": "probreg", "command": command, "versions": versions()}
    write_text(folder / MANIFEST, {**head, **content, "outputs": outputs})
