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

import probreg
from experiments.study import StudyError

ROOT = Path(__file__).parent / "results"
PACKAGES = ("numpy", "scipy", "numba", "xarray")


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
    require_intact(folder, manifest, command)
    parts = [xr.load_dataset(folder / name, engine="h5netcdf") for name in manifest["sha256"]]
    return xr.merge(parts, combine_attrs="override"), manifest


def require_intact(folder: Path, manifest: dict[str, Any], command: str = "") -> None:
    """Raise StudyError if a result file is not the one that was saved."""
    for name, known in manifest["sha256"].items():
        path = folder / name
        if not path.exists() or file_hash(path) != known:
            remedy = f"make it again with: {command}" if command else "run again."
            raise StudyError(
                f"{path} is damaged or missing: its contents are not those that were saved. "
                f"Delete {folder} and {remedy}"
            )


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
        missing = {"config", "status", "code"} - set(manifest)
        if missing:
            raise ValueError(f"no entry {sorted(missing)}")
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (ValueError, TypeError) as error:
        raise StudyError(f"{path} is damaged ({error}). Delete {folder} and run again.") from error
    return manifest


def file_hash(path: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def provenance() -> dict[str, Any]:
    """Versions, commit, source hash and Python that a result was made with."""
    versions = {name: importlib.metadata.version(name) for name in PACKAGES}
    versions["probreg"] = probreg.__version__
    python = sys.version.split()[0]
    return {"versions": versions, "python": python, "commit": _commit(), "code": code_hash()}


def code_hash() -> str:
    """Hash of everything that results depend on: our computing sources and the versions."""
    digest = hashlib.sha256()
    for package in (Path(probreg.__file__).parent, Path(__file__).parent):
        for path in sorted(package.rglob("*.py")):
            digest.update(path.relative_to(package).as_posix().encode() + path.read_bytes())
    for name in PACKAGES:
        digest.update(f"{name} {importlib.metadata.version(name)}".encode())
    return digest.hexdigest()


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
