"""Sensors of a recording as the track model sees them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.problems.recording.sensor_model import SensorModel
from probreg.recordings import BiasModel, Recording, Setup, observing_axes
from probreg.sensors import Sensor
from probreg.sensors.axes import Axes
from probreg.sensors.terms import Term, known_terms
from probreg.typing import IntArray


class Models(NamedTuple):
    """Models of the sensors of some reports.

    Attributes
    ----------
    models : tuple of SensorModel
    which : ndarray of int, shape (n,)
        Model of each report.
    kinds : tuple of (int, int)
        Of each model, its sensor, and the one whose reports it comes with.
    constants : dict of str to float
        Terms of which each target has one of its own, with their expected spread, SI units.
    known : frozenset of str
        Those whose spread is as expected: of sensors that are declared free of biases, as a
        common error would hide in a spread that is free.
    """

    models: tuple[SensorModel, ...]
    which: IntArray
    kinds: tuple[tuple[int, int], ...]
    constants: dict[str, float]
    known: frozenset[str]


def models_of(recording: Recording, setup: Setup, model: BiasModel, rows: IntArray) -> Models:
    """Models of the sensors of reports `rows`, one for each company that they come in."""
    beside = companions(recording)
    pairs, which = np.unique(
        np.stack([recording.sensor[rows], recording.sensor[beside[rows]]], axis=1),
        axis=0,
        return_inverse=True,
    )
    return models_of_kinds(setup, model, pairs)._replace(which=which.reshape(-1))


def models_of_kinds(setup: Setup, model: BiasModel, pairs: IntArray) -> Models:
    """Models of sensors in company, pairs (k, 2) as in `Models.kinds`, of no reports."""
    constants = _constants(setup, pairs[:, 0])
    axes = observing_axes(setup)
    models = tuple(
        _sensor_model(setup, (model, tuple(constants)), axes, s, along)
        for s, along in pairs.tolist()
    )
    kinds = tuple((int(s), int(along)) for s, along in pairs)
    free = [setup.sensors[k].kind.constants for k in np.unique(pairs[:, 0])
            if setup.biases.get(setup.sensors[k].name)]  # fmt: skip
    known = frozenset(constants) - frozenset(setup.target_terms) - frozenset().union(*free)
    return Models(models, np.zeros(0, dtype=np.int64), kinds, constants, known)


def companions(recording: Recording) -> IntArray:
    """Number of the report that each came with, (n,)."""
    return np.arange(len(recording)) if recording.beside is None else recording.beside


def _constants(setup: Setup, seen: IntArray) -> dict[str, float]:
    """Terms of single targets: those of the setup, and those of the kinds that are seen."""
    usual: dict[str, float] = {}
    for k in np.unique(seen).tolist():
        usual |= setup.sensors[k].kind.constants
    return {**usual, **setup.target_terms}


def _sensor_model(
    setup: Setup,
    unknown: tuple[BiasModel, tuple[str, ...]],
    axes: tuple[Axes, ...],
    s: int,
    along: int,
) -> SensorModel:
    """Sensor s whose reports come with those of another, by whose clock they are stamped."""
    sensor, (model, constants) = setup.sensors[s], unknown
    terms = list(zip(model.columns[s].tolist(), model.terms[s], strict=True))
    if s != along:
        clocks = zip(model.columns[along].tolist(), model.terms[along], strict=True)
        known = known_terms(sensor)
        terms += [(c, known[term.name]) for c, term in clocks if term.stamp]
    own = [
        (k, term)
        for k, name in enumerate(constants)
        for term in [target_term(sensor, name)]
        if term is not None and (name in setup.target_terms or name in sensor.kind.constants)
    ]
    metric = tuple(
        sensor.kind.sigma_key(j).endswith("_m") and unit == "rad"
        for j, unit in enumerate(sensor.bias_units)
    )
    sigmas, mixing = sensor.principal
    return SensorModel(
        axes[s], sigmas, tuple(terms), tuple(own), sensor.azimuth_column, metric, mixing
    )


def target_term(sensor: Sensor, name: str) -> Term | None:
    """The term of that name where an error of it may belong to targets; None where not.

    A late stamp is a target's own only where the target reports its position itself.
    """
    term = known_terms(sensor).get(name)
    return None if term is None or (term.stamp and not sensor.cartesian) else term
