"""probreg: sensor registration as probabilistic inference.

A problem and a noise law make a posterior; estimators and samplers are ways to read it.
Report = truth + bias + noise, in metres and radians.
"""

from probreg.bearings import BearingProblem
from probreg.contrast import ReportProblem
from probreg.errors import ImproperLawError, InvalidInputError, ProbregError, UnobservableError
from probreg.posterior import Posterior
from probreg.prior import GaussianPrior
from probreg.problem import RegistrationProblem
from probreg.reports import AssociatedReports, BearingReports, SensorReports
from probreg.sensors import BearingSensor, PositionSensor, Radar2D, Radar3D, Tracker2D

__version__ = "0.1.0"

__all__ = [
    "AssociatedReports",
    "BearingProblem",
    "BearingReports",
    "BearingSensor",
    "GaussianPrior",
    "ImproperLawError",
    "InvalidInputError",
    "PositionSensor",
    "Posterior",
    "ProbregError",
    "Radar2D",
    "Radar3D",
    "RegistrationProblem",
    "ReportProblem",
    "SensorReports",
    "Tracker2D",
    "UnobservableError",
    "__version__",
]
