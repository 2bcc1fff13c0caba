"""A state as plain arrays, and back: what another run needs to go on bit for bit."""

from __future__ import annotations

import json
from dataclasses import asdict, fields, is_dataclass
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

import probreg.noise
from probreg.discovery import public_classes
from probreg.errors import InvalidInputError
from probreg.noise import ScaleMixture
from probreg.recordings import Setup
from probreg.watch._scene import scene_of
from probreg.watch.settings import WatchSettings
from probreg.watch.state import WatchState

VERSION = 2
_GIVEN = ("setup", "settings", "scene")


def to_arrays(state: WatchState) -> dict[str, np.ndarray]:
    """Numbers and strings only: `numpy.savez` takes them, and loads them without pickles.

    The setup and the settings are not in it, but what they must be like is.
    """
    found = {"about": np.array(_about(state.setup, state.settings))}
    found["kinds"] = np.array(state.scene.seen.kinds)
    found["start_sd"] = np.array(state.scene.start_sd)
    for field in fields(state):
        if field.name not in _GIVEN:
            _flatten(field.name, getattr(state, field.name), found)
    return found


def from_arrays(arrays: dict[str, np.ndarray], setup: Setup, settings: WatchSettings) -> WatchState:
    """The state that was saved.

    Raises
    ------
    InvalidInputError
        A state of another version, of other sensors, terms or settings, or a damaged one.
    """
    wanted = _about(setup, settings)
    if "about" not in arrays or str(arrays["about"]) != wanted:
        raise InvalidInputError(
            "the state is of another version, or of other sensors, terms or settings than those "
            f"given: {arrays.get('about', 'nothing')} instead of {wanted}. Begin afresh, or give "
            "what it was made with."
        )
    try:
        kinds = tuple((int(s), int(along)) for s, along in arrays["kinds"])
        across, up, fast, climb = arrays["start_sd"].tolist()
        scene = scene_of(setup, kinds, (across, up, fast, climb))
        given: dict[str, Any] = {"setup": setup, "settings": settings, "scene": scene}
        hints = get_type_hints(WatchState)
        rest: dict[str, Any] = {
            f.name: _rebuilt(f.name, hints[f.name], arrays)
            for f in fields(WatchState)
            if f.name not in _GIVEN
        }
    except KeyError as error:
        raise InvalidInputError(f"the state is damaged: {error} is missing.") from None
    return WatchState(**given, **rest)


def _about(setup: Setup, settings: WatchSettings) -> str:
    """What a state and its user must agree on."""
    terms = {sensor.name: list(setup.biases.get(sensor.name, ())) for sensor in setup.sensors}
    units = {sensor.name: list(sensor.bias_units) for sensor in setup.sensors}
    facts = {"version": VERSION, "terms": terms, "units": units, "settings": asdict(settings)}
    return json.dumps(facts, sort_keys=True)


def _flatten(name: str, value: Any, found: dict[str, np.ndarray]) -> None:
    if isinstance(value, ScaleMixture):
        found[name] = np.array(json.dumps([type(value).__name__, vars(value)]))
    elif is_dataclass(value):
        for field in fields(value):
            _flatten(f"{name}.{field.name}", getattr(value, field.name), found)
    elif hasattr(value, "_asdict"):
        for key, part in value._asdict().items():
            _flatten(f"{name}.{key}", part, found)
    elif isinstance(value, tuple):
        found[f"{name}.length"] = np.array(len(value))
        for k, part in enumerate(value):
            _flatten(f"{name}.{k}", part, found)
    else:
        found[name] = np.asarray(value)


def _rebuilt(name: str, hint: Any, arrays: dict[str, np.ndarray]) -> Any:
    if hint is ScaleMixture:
        kind, parameters = json.loads(str(arrays[name]))
        return public_classes(probreg.noise)[kind](**parameters)
    if hint in (int, float, str, bool):
        return hint(arrays[name].item())
    if get_origin(hint) is tuple:
        inner = get_args(hint)[0]
        count = int(arrays[f"{name}.length"])
        return tuple(_rebuilt(f"{name}.{k}", inner, arrays) for k in range(count))
    if is_dataclass(hint) or hasattr(hint, "_fields"):
        hints = get_type_hints(hint)
        parts = {key: _rebuilt(f"{name}.{key}", own, arrays) for key, own in hints.items()}
        return hint(**parts)
    return arrays[name]
