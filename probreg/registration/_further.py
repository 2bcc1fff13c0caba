"""Bias models that a recording may ask for: the setup's, with one term or one drift more."""

from __future__ import annotations

import dataclasses

import numpy as np

from probreg.posterior.tracks import TrackFit, score_drift
from probreg.problems.recording import RecordingProblem
from probreg.recordings import DRIFT_SHARE, Setup
from probreg.sensors.drifts import known_drifts
from probreg.sensors.terms import known_terms

GIVEN = "as in the setup"
MOST_DRIFTS = 3


def further_terms(setup: Setup) -> dict[str, dict[str, tuple[str, ...]]]:
    """The biases of a setup, and these with each further term that its sensors can have.

    Sensors without biases, which are references, get none. For `compare_terms`.
    """
    given = {sensor.name: tuple(setup.biases.get(sensor.name, ())) for sensor in setup.sensors}
    can = {
        sensor.name: {
            term
            for term in known_terms(sensor)
            if given[sensor.name] and (term != "heading" or sensor.name in setup.body_frame)
        }
        for sensor in setup.sensors
    }
    models = {GIVEN: given}
    for term in sorted(set().union(*can.values())):
        more = {
            name: (*own, term) if term in can[name] and term not in own else own
            for name, own in given.items()
        }
        if more != given:
            models[f"with {term}"] = more
    return models


def further_drifts(problem: RecordingProblem, fit: TrackFit) -> dict[str, Setup]:
    """The setup, that without any drift, and those with one bias more that drifts.

    The three biases that the fit says drift most clearly, for `compare_setups`. They walk; the
    first may also return to its level ("ou"). Steps differ from a walk in their draws only.
    """
    setup = problem.setup
    found = {GIVEN: setup}
    if setup.drift:
        found["all biases constant"] = dataclasses.replace(setup, drift={}, drift_sd={})
    walk, returns = (known_drifts()[kind] for kind in ("walk", "ou"))
    gain = score_drift(fit, walk, DRIFT_SHARE * problem.prior_sd).gain
    new = [k for k in np.argsort(-gain, kind="stable").tolist() if k not in fit.knots.drifting]
    for place, k in enumerate(new[:MOST_DRIFTS]):
        for kind in (walk, returns)[: 2 if place == 0 else 1]:
            name = problem.names[k]
            drift = {**setup.drift, name: kind.name}
            found[f"{name} drifts ({kind.name})"] = dataclasses.replace(setup, drift=drift)
    return found
