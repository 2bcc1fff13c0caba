"""Result folders: where they are, how they are written whole or not at all, how they are read."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import xarray as xr

from experiments.study import StudyError

ROOT = Path(__file__).parent / "results"
PACKAGES = ("probreg", "numpy", "scipy", "numba", "xarray")


def write_whole(path: Path, write: Callable[[Path], None]) -> None:
    """Write through a temporary name, flush to disk, then rename: whole or not at all."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        write(temporary)
        with temporary.open("rb") as handle:
            os.fsync(handle.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_dataset(path: Path, data: xr.Dataset) -> None:
    """Save a dataset as netCDF, whole or not at all."""
    write_whole(path, lambda temporary: data.to_netcdf(temporary, engine="h5netcdf"))


def write_json(path: Path, content: Any) -> None:
    """Save JSON, whole or not at all."""
    text = json.dumps(content, indent=2, sort_keys=True)

    def write(temporary: Path) -> None:
        temporary.write_text(text + "\n")

    write_whole(path, write)


def prepare_folder(folder: Path) -> None:
    """Make a results folder and check that it can be written.

    Raises
    ------
    StudyError
        It cannot; names the folder.
    """
    try:
        (folder / "parts").mkdir(parents=True, exist_ok=True)
        probe = folder / f".probe.{os.getpid()}"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise StudyError(
            f"cannot write results to {folder}: {error.strerror or error}. Choose another "
            "folder with --results, or change its permissions."
        ) from error


def load_result(study: str, label: str, root: Path = ROOT) -> tuple[xr.Dataset, dict[str, Any]]:
    """Read a finished result and its manifest.

    Parameters
    ----------
    study, label : str
        As in the folder `root/study/label`.

    Returns
    -------
    data : xarray.Dataset
        Results and timings together, dimension "replicate" first.
    manifest : dict

    Raises
    ------
    StudyError
        Missing, unfinished or corrupt; names the file and the command that makes it.
    """
    folder = root / study / label
    profile, *settings = label.split(",")
    command = " ".join(
        [f"python -m experiments run {study} --profile {profile}"]
        + [f"--set {setting}" for setting in settings]
        + ([] if root == ROOT else [f"--results {root}"])
    )
    manifest = read_manifest(folder)
    if manifest is None or manifest.get("status") != "complete":
        raise StudyError(f"no finished result {study}/{label} in {root}. Make it with: {command}")
    parts = []
    for name in ("results.nc", "timing.nc"):
        path = folder / name
        if name not in manifest["sha256"]:
            continue
        if not path.exists() or file_hash(path) != manifest["sha256"][name]:
            raise StudyError(
                f"{path} is damaged or missing: its contents are not those that were saved. "
                f"Delete {folder} and make it again with: {command}"
            )
        parts.append(xr.load_dataset(path, engine="h5netcdf"))
    return xr.merge(parts, combine_attrs="override"), manifest


def read_manifest(folder: Path) -> dict[str, Any] | None:
    """Read a folder's manifest; None where there is none.

    Raises
    ------
    StudyError
        It is not JSON.
    """
    path = folder / "manifest.json"
    try:
        manifest: dict[str, Any] = json.loads(path.read_text())
    except FileNotFoundError:
        return None
    except ValueError as error:
        raise StudyError(f"{path} is damaged ({error}). Delete {folder} and run again.") from error
    return manifest


def file_hash(path: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def provenance() -> dict[str, Any]:
    """Versions, commit and platform that a result was made with."""
    versions = {name: importlib.metadata.version(name) for name in PACKAGES}
    return {"versions": versions, "python": sys.version.split()[0], "commit": _commit()}


def _commit() -> str:
    def git(*words: str) -> str:
        done = subprocess.run(
            ["git", "-C", str(Path(__file__).parent), *words],
            capture_output=True,
            text=True,
            check=True,
        )
        return done.stdout.strip()

    try:
        return git("rev-parse", "HEAD") + ("+changes" if git("status", "--porcelain") else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
