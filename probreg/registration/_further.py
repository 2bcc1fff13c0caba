"""Bias models that a recording may ask for: the setup's, and it with one term more."""

from __future__ import annotations

from probreg.recordings import Setup
from probreg.sensors.terms import known_terms

GIVEN = "as in the setup"


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
