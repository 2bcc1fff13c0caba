"""Running a study: seeds, processes, progress, resuming, saving.

Replicate number k draws from the k-th child of the seed, so its numbers are the same in
any order and on any number of workers. Each finished replicate is a file of its own until
all are there; a run that was stopped, even by `kill -9`, goes on with the missing ones.
"""

from __future__ import annotations

import json
import os
import shutil
import time
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import xarray as xr
from filelock import AcquireReturnProxy, FileLock, Timeout
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from threadpoolctl import threadpool_limits

from experiments.results import (
    file_hash,
    prepare_folder,
    provenance,
    read_manifest,
    require_intact,
    write_dataset,
    write_json,
)
from experiments.study import Study, StudyError, load_study


@dataclass(frozen=True)
class Outcome:
    """What became of one replicate."""

    index: int
    error: str | None


def run_study(
    study: Study, label: str, config: Any, root: Path, jobs: int, console: Console
) -> Path:
    """Run the missing replicates of one configuration and save the whole.

    Parameters
    ----------
    study : Study
    label : str
        Name of the results folder.
    config : Config
        Resolved configuration.
    root : Path
        Results folder.
    jobs : int
        Worker processes; 0 takes every core.
    console : rich.console.Console
        Where progress is shown.

    Returns
    -------
    Path
        The finished folder.

    Raises
    ------
    StudyError
        Unwritable folder, a folder made with another configuration, or failed replicates
        (each recorded with its error, the others kept).
    """
    folder = root / study.name / label
    resolved = json.loads(json.dumps(config.resolved()))
    made_with = provenance()
    manifest = _earlier(folder, resolved)
    current = manifest is not None and manifest["code"] == made_with["code"]
    if manifest is not None and manifest["status"] == "complete" and current:
        require_intact(folder, manifest)
        console.print(f"{study.name} {label}: already there")
        return folder
    prepare_folder(folder)
    with _locked(folder, f"{study.name} {label}"):
        if manifest is not None and not current:
            console.print(f"{study.name} {label}: the code has changed since, computed anew")
            for part in folder.glob("parts/*.nc"):
                part.unlink()
        spent = float(manifest["wall_time_s"]) if manifest and current else 0.0
        opening = {"study": study.name, "label": label, "config": resolved, "status": "running"}
        made = {**opening, "wall_time_s": spent, **made_with}
        _run(study, label, config, folder, jobs, console, made)
    return folder


def _earlier(folder: Path, resolved: dict[str, Any]) -> dict[str, Any] | None:
    """The manifest of an earlier run with the same settings, None where there was no run."""
    manifest = read_manifest(folder)
    if manifest is not None and manifest["config"] != resolved:
        raise StudyError(
            f"{folder} was made with other settings than these. Delete it, or give another "
            "folder with --results."
        )
    return manifest


def _locked(folder: Path, name: str) -> AcquireReturnProxy:
    """The folder's lock, held until the context ends."""
    try:
        return FileLock(folder / ".lock").acquire(timeout=0)
    except Timeout:
        raise StudyError(
            f"another process is running {name} in {folder}. Wait for it, or give another folder "
            "with --results."
        ) from None


def _run(
    study: Study, label: str, config: Any, folder: Path, jobs: int, console: Console,
    manifest: dict[str, Any],
) -> None:  # fmt: skip
    """Compute what is missing in a folder that is ours alone."""
    started, spent = time.time(), manifest["wall_time_s"]
    write_json(folder / "manifest.json", manifest)
    for stale in folder.glob("parts/.*.tmp"):
        stale.unlink(missing_ok=True)  # half-written when an earlier run was killed
    todo = [k for k in range(config.replicates) if not _part_is_whole(_part(folder, k))]
    try:
        failed = _run_missing(study.name, config, folder, todo, jobs, console, label)
    finally:
        manifest["wall_time_s"] = spent + time.time() - started
        write_json(folder / "manifest.json", manifest)
    if failed:
        manifest.update(status="failed", failed={str(f.index): f.error for f in failed})
        write_json(folder / "manifest.json", manifest)
        last = (failed[0].error or "").strip().splitlines()[-1]
        raise StudyError(
            f"{len(failed)} of {config.replicates} replicates of {study.name} {label} failed, "
            f"first number {failed[0].index}: {last}. Their errors are in "
            f"{folder / 'manifest.json'}; the others are kept and a rerun tries only these."
        )
    _finish(folder, config, manifest)


def draw_replicate(study_name: str, config: Any, index: int) -> xr.Dataset:
    """Compute one replicate from its own seed, on one thread."""
    seed = np.random.SeedSequence(config.seed, spawn_key=(index,))
    with threadpool_limits(limits=1):
        return load_study(study_name).replicate(config, np.random.default_rng(seed))


def _one(study_name: str, config: Any, folder: Path, index: int, runner: int) -> Outcome:
    """Compute and save one replicate, unless the process that asked for it is gone."""
    if runner not in (os.getpid(), os.getppid()):
        os._exit(1)  # orphaned by kill -9: leave the rest to the run that resumes
    try:
        data = draw_replicate(study_name, config, index)
        write_dataset(_part(folder, index), data)
    except Exception:
        return Outcome(index, traceback.format_exc())
    return Outcome(index, None)


def _run_missing(
    name: str, config: Any, folder: Path, todo: list[int], jobs: int, console: Console, label: str
) -> list[Outcome]:
    workers = min(jobs if jobs > 0 else joblib.cpu_count(), max(1, len(todo)))
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with (
        joblib.parallel_config(backend="loky", inner_max_num_threads=1),
        Progress(*columns, console=console) as progress,
    ):
        task = progress.add_task(
            f"{name} {label}", total=config.replicates, completed=config.replicates - len(todo)
        )
        pool = joblib.Parallel(n_jobs=workers, return_as="generator_unordered", pre_dispatch="all")
        failed = []
        for outcome in pool(
            joblib.delayed(_one)(name, config, folder, k, os.getpid()) for k in todo
        ):
            progress.advance(task)
            if outcome.error is not None:
                failed.append(outcome)
    return sorted(failed, key=lambda outcome: outcome.index)


def _finish(folder: Path, config: Any, manifest: dict[str, Any]) -> None:
    """Join the parts in order of replicate, save, check by reading back, drop the parts."""
    parts = [xr.load_dataset(_part(folder, k), engine="h5netcdf") for k in range(config.replicates)]
    whole = xr.concat(parts, dim="replicate")
    timings = [str(name) for name in whole.data_vars if str(name).startswith("seconds")]
    # timings depend on the machine: kept apart, so that results are the same bit for bit
    pieces = {"results.nc": whole.drop_vars(timings)}
    if timings:
        pieces["timing.nc"] = whole[timings]
    hashes = {}
    for name, piece in pieces.items():
        piece = piece.assign_attrs(config=json.dumps(manifest["config"], sort_keys=True))
        write_dataset(folder / name, piece)
        xr.load_dataset(folder / name, engine="h5netcdf")
        hashes[name] = file_hash(folder / name)
    manifest.update(
        status="complete",
        sha256=hashes,
        replicates=config.replicates,
        seed=config.seed,
        finished=time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        checks=["every replicate present", "files read back", "sha256 recorded"],
    )
    write_json(folder / "manifest.json", manifest)
    shutil.rmtree(folder / "parts")


def _part(folder: Path, index: int) -> Path:
    return folder / "parts" / f"{index:06d}.nc"


def _part_is_whole(path: Path) -> bool:
    """Whether a replicate's file is there and readable; a damaged one is computed again."""
    if not path.exists():
        return False
    try:
        xr.load_dataset(path, engine="h5netcdf")
    except (OSError, ValueError, KeyError):
        path.unlink()
        return False
    return True
