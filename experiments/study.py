"""Finding studies, and turning what a user typed into a configuration."""

from __future__ import annotations

import ast
import dataclasses
import difflib
import importlib
import itertools
import pkgutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
import xarray as xr

import experiments.studies


class StudyError(ValueError):
    """A study, setting or result that does not exist or does not fit; says the remedy."""


@dataclass(frozen=True)
class Study:
    """One module of `experiments.studies`.

    Attributes
    ----------
    name : str
    summary : str
        First line of its docstring.
    profiles : mapping of str to Config
        Frozen dataclasses with at least `replicates` and `seed`, and a method `resolved()`
        that gives every number the results depend on.
    grid : mapping of str to tuple
        Settings that `run` walks through unless they are set.
    replicate : callable
        (config, numpy.random.Generator) -> xarray.Dataset without a replicate dimension.
        Variables called "seconds..." are timings of this machine.
    missing : callable
        Why the study cannot run here (data that the project does not ship), or nothing.
    """

    name: str
    summary: str
    profiles: Mapping[str, Any]
    grid: Mapping[str, tuple[Any, ...]]
    replicate: Callable[[Any, np.random.Generator], xr.Dataset]
    missing: Callable[[], str]


def study_names() -> list[str]:
    """Names of all studies, found by walking the package."""
    found = pkgutil.iter_modules(experiments.studies.__path__)
    return sorted(module.name for module in found)


def load_study(name: str) -> Study:
    """Load a study by name.

    Raises
    ------
    StudyError
        Unknown name; gives the nearest known one.
    """
    if name not in study_names():
        raise StudyError(f"no study {name!r}. {nearest(name, study_names())}")
    module: ModuleType = importlib.import_module(f"experiments.studies.{name}")
    summary = (module.__doc__ or "").strip().split("\n")[0]
    missing = getattr(module, "missing", lambda: "")
    return Study(name, summary, module.PROFILES, module.GRID, module.replicate, missing)


def nearest(name: str, known: Iterable[str]) -> str:
    """Say which known name is meant, or list them all."""
    known = list(known)
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    listing = f"Known: {', '.join(known)}."
    return f"Did you mean {close[0]!r}? {listing}" if close else listing


def configurations(study: Study, profile: str, settings: Iterable[str]) -> list[tuple[str, Any]]:
    """Resolve a profile and `key=value` settings into labelled configurations.

    Parameters
    ----------
    study : Study
    profile : str
    settings : iterable of str
        "key=value"; a key of the grid that is not set takes all its values.

    Returns
    -------
    list of (label, Config)
        The label names the results folder.

    Raises
    ------
    StudyError
        Unknown profile or key (with the nearest known one), or a value of the wrong type.
    """
    if profile not in study.profiles:
        raise StudyError(f"no profile {profile!r}. {nearest(profile, study.profiles)}")
    base = study.profiles[profile]
    chosen = dict(_parse(base, text) for text in settings)
    free = {key: values for key, values in study.grid.items() if key not in chosen}
    found = []
    for values in itertools.product(*free.values()):
        changed = {**dict(zip(free, values, strict=True)), **chosen}
        # grid keys first, so that the label of a run does not depend on how it was asked for
        order = [*(k for k in study.grid if k in changed), *sorted(set(changed) - set(study.grid))]
        parts = [f"{key}={changed[key]}" for key in order]
        config = dataclasses.replace(base, **changed)
        if config.replicates < 1:
            raise StudyError(f"replicates is {config.replicates}; at least one is needed.")
        found.append((",".join([profile, *parts]), config))
    return found


def _parse(base: Any, text: str) -> tuple[str, Any]:
    key, equals, raw = text.partition("=")
    fields = {f.name: getattr(base, f.name) for f in dataclasses.fields(base) if f.init}
    if not equals:
        raise StudyError(f"setting {text!r} is not of the form key=value.")
    if key not in fields:
        raise StudyError(f"no setting {key!r}. {nearest(key, fields)}")
    try:
        value = ast.literal_eval(raw)
    except (ValueError, SyntaxError):
        value = raw
    old = fields[key]
    if isinstance(old, float) and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if type(value) is not type(old):
        raise StudyError(
            f"setting {key}={raw!r} is {type(value).__name__}; {type(old).__name__} is needed, "
            f"such as {key}={old!r}."
        )
    return key, value
