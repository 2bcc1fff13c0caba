"""probreg: sensor registration as probabilistic inference.

A problem and a noise law make a posterior; estimators and samplers are ways to read it.
Report = truth + bias + noise, in metres and radians.

The names below, and the folders such as `probreg.samplers`, are loaded when first used.
"""

from __future__ import annotations

import importlib
import pkgutil
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # what `_HOMES` says, for type checkers
    from probreg import association as association
    from probreg import cli as cli
    from probreg import diagnostics as diagnostics
    from probreg import estimators as estimators
    from probreg import joint as joint
    from probreg import motion as motion
    from probreg import noise as noise
    from probreg import numerics as numerics
    from probreg import page as page
    from probreg import posterior as posterior
    from probreg import problems as problems
    from probreg import recordings as recordings
    from probreg import registration as registration
    from probreg import samplers as samplers
    from probreg import scenarios as scenarios
    from probreg import sensors as sensors
    from probreg import watch as watch
    from probreg.errors import (
        ImproperLawError,
        InvalidInputError,
        MissingExtraError,
        ProbregError,
        UnobservableError,
    )
    from probreg.motion import Trajectory
    from probreg.posterior import Posterior
    from probreg.prior import GaussianPrior, NoiseParameter
    from probreg.problems import BearingProblem, LinearProblem, ReportProblem
    from probreg.recordings import Recording, Setup
    from probreg.registration import register
    from probreg.sensors import BearingSensor, PositionSensor, Radar2D, Radar3D, Tracker2D
    from probreg.sensors.reports import AssociatedReports, BearingReports, SensorReports

    RegistrationProblem = LinearProblem

__version__ = "0.1.0"

# where the names of a folder or module come from, loaded with the first of them
_HOMES = {
    "errors": (
        "ImproperLawError",
        "InvalidInputError",
        "MissingExtraError",
        "ProbregError",
        "UnobservableError",
    ),
    "motion": ("Trajectory",),
    "posterior": ("Posterior",),
    "prior": ("GaussianPrior", "NoiseParameter"),
    "problems": ("BearingProblem", "LinearProblem", "ReportProblem"),
    "recordings": ("Recording", "Setup"),
    "registration": ("register",),
    "sensors": ("BearingSensor", "PositionSensor", "Radar2D", "Radar3D", "Tracker2D"),
    "sensors.reports": ("AssociatedReports", "BearingReports", "SensorReports"),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}
_FORMER = {"RegistrationProblem": "LinearProblem"}  # former names, for one release

__all__ = [
    "AssociatedReports",
    "BearingProblem",
    "BearingReports",
    "BearingSensor",
    "GaussianPrior",
    "ImproperLawError",
    "InvalidInputError",
    "LinearProblem",
    "MissingExtraError",
    "NoiseParameter",
    "PositionSensor",
    "Posterior",
    "ProbregError",
    "Radar2D",
    "Radar3D",
    "Recording",
    "RegistrationProblem",
    "ReportProblem",
    "SensorReports",
    "Setup",
    "Tracker2D",
    "Trajectory",
    "UnobservableError",
    "__version__",
    "register",
]


def __getattr__(name: str) -> Any:
    """Load a name, or a folder, when it is first used (PEP 562)."""
    public = _FORMER.get(name, name)
    if public in _HOME:
        value = getattr(importlib.import_module(f"{__name__}.{_HOME[public]}"), public)
        globals()[name] = value
        return value
    if name in _modules():
        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """List what is offered, loaded or not."""
    return sorted({*globals(), *__all__, *_modules()})


def _modules() -> list[str]:
    """Folders and modules of the package that are not private."""
    entries = pkgutil.iter_modules(__path__)
    return [entry.name for entry in entries if not entry.name.startswith("_")]
