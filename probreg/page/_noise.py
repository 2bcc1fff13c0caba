"""What was found of the noise, by sensor: for the page and for programs alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from probreg.registration import Registration
from probreg.sensors.terms import known_terms


class NoiseKind(NamedTuple):
    """Noise of one sensor's reports.

    Attributes
    ----------
    sensor : int
        Of the recording.
    name : str
        Of the sensor, and of that whose reports they came with.
    parameters : mapping of str to float
        Of the law, at the mode.
    wrong : float
        Expected share of reports that are of another target than they say.
    """

    sensor: int
    name: str
    parameters: Mapping[str, float]
    wrong: float


def noise_kinds(registration: Registration) -> list[NoiseKind]:
    """Noise of every sensor, and apart of reports that came with those of another."""
    sensors, fit, problem = registration.recording.sensors, registration.fit, registration.problem
    other = np.where(fit.target != problem.reports.target, 1.0, fit.wrong)
    found = []
    for k, ((own, along), law) in enumerate(zip(problem.kinds, fit.point.laws, strict=True)):
        wrong = float(other[problem.reports.sensor == k].mean())
        name = sensors[own].name
        name = name if own == along else f"{name}, with {sensors[along].name}"
        parameters = {key: float(getattr(law, key)) for key in law.supports}
        found.append(NoiseKind(own, name, parameters, wrong))
    return found


def target_spreads(registration: Registration) -> list[tuple[str, str, float, float]]:
    """Of each term that targets have of their own: name, unit, spread expected and found, SI."""
    setup = registration.setup
    known = [known_terms(sensor) for sensor in setup.sensors]
    spreads = zip(
        registration.problem.constants.items(), registration.fit.point.constant_sd, strict=True
    )
    return [
        (name, next(terms[name].unit for terms in known if name in terms), expected, float(found))
        for (name, expected), found in spreads
    ]
