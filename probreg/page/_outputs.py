"""Files of numbers beside the page."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.page._drift import path_rows
from probreg.page._folder import MANIFEST
from probreg.page._noise import noise_kinds, target_spreads
from probreg.page._provenance import Provenance, checksum, versions
from probreg.page._units import SHOWN
from probreg.page._words import matters
from probreg.registration import RankedTerms, Registration

POSTERIOR, TRACKS, REPORTS = "posterior.nc", "tracks.parquet", "reports.parquet"
JSON_FORMAT = 2


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
    """Biases in engineers' units; the column `unit` says which.

    Of a bias that drifts the average first, its time empty; then its band, one row a time.
    """
    import pandas as pd

    rows = [_shown(row) for row in bias_rows(registration)]
    units = dict(zip(registration.names, registration.units, strict=True))
    for row in registration.paths().to_dict("records"):
        rows.append(_shown({**row, "unit": units[row["name"]]}))
    columns = ["name", "time", *(name for name in rows[0] if name != "name")]
    pd.DataFrame(rows, columns=columns).to_csv(path, index=False)


def _shown(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row in engineers' units."""
    shown = SHOWN[row["unit"]]
    in_units = ("mean", "sd", "low_50", "high_50", "low_90", "high_90", "limit")
    scaled = {
        name: None if row[name] is None else shown.factor * row[name]
        for name in in_units
        if name in row
    }
    return {**row, **scaled, "unit": shown.symbol}


def write_json(path: Path, registration: Registration, terms: Sequence[RankedTerms] = ()) -> None:
    """Biases and all that was found about them, SI units."""
    content = {
        "format": JSON_FORMAT,
        "units": "SI: metres, radians, seconds; report = truth + bias + noise",
        "biases": bias_rows(registration),
        "paths": path_rows(registration),
        "changes": [change._asdict() for change in registration.changes],
        "covariance": registration.covariance.tolist(),
        "correlation": registration.correlation.tolist(),
        "noise": noise(registration),
        "laws": [law._asdict() for law in registration.laws],
        "missing_terms": [term._asdict() for term in registration.missing],
        "bias_models": [one._asdict() for one in terms],
        "hidden": registration.determined.hidden,
        "weak": registration.determined.weak,
        "warnings": matters(registration),
        "remarks": list(registration.notes),
    }
    write_text(path, content)


def noise(registration: Registration) -> dict[str, Any]:
    """The law used, its parameters by sensor, how targets accelerate and err on their own."""
    sensors = [
        {"sensor": kind.name, "parameters": dict(kind.parameters), "wrong_identities": kind.wrong}
        for kind in noise_kinds(registration)
    ]
    return {
        "law": registration.law,
        "sensors": sensors,
        "acceleration_m_s2": float(np.sqrt(registration.fit.point.q)),
        "target_terms": {name: sd for name, _, _, sd in target_spreads(registration)},
    }


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
    """Draws as netCDF for ArviZ."""
    draws = registration.draws
    data = draws.to_arviz()
    for name, unit in zip(draws.names, draws.units, strict=True):
        data["posterior"][name.replace(" ", "_")].attrs["units"] = unit
    data.to_netcdf(str(path), engine="h5netcdf")


def write_tables(folder: Path, registration: Registration) -> None:
    """Reconstructed trajectories, and every report against them."""
    registration.tracks().to_parquet(folder / TRACKS, index=False)
    registration.reports().to_parquet(folder / REPORTS, index=False)


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
            "reports": len(registration.problem.rows),
            "tracks": len(registration.problem.owner),
            "reports_used": registration.used,
            "law": registration.law,
            "sampler": draws.sampler,
            "r_hat": float(np.max(found.r_hat)),
            "effective_draws": float(np.min([found.ess_bulk, found.ess_tail])),
            "sd_ratio": draws.facts.get("sd_ratio"),
            "shift": draws.facts.get("shift"),
            "warnings": matters(registration),
        },
    }
    write_summary(folder, provenance.command, content)


def write_summary(folder: Path, command: str, content: Mapping[str, Any]) -> None:
    """Write a manifest: the command, what it did, checksums of every other file in the folder."""
    outputs = {file.name: checksum(file) for file in sorted(folder.iterdir())}
    head = {"program": "probreg", "command": command, "versions": versions()}
    write_text(folder / MANIFEST, {**head, **content, "outputs": outputs})
