"""probreg: sensor registration as probabilistic inference.

A problem and a noise law make a posterior; estimators and samplers are ways to read it.
Report = truth + bias + noise, in metres and radians.
"""

from probreg.errors import ImproperLawError, InvalidInputError, ProbregError, UnobservableError
from probreg.posterior import Posterior
from probreg.prior import GaussianPrior
from probreg.problems import BearingProblem, LinearProblem, ReportProblem
from probreg.sensors import BearingSensor, PositionSensor, Radar2D, Radar3D, Tracker2D
from probreg.sensors.reports import AssociatedReports, BearingReports, SensorReports

__version__ = "0.1.0"

RegistrationProblem = LinearProblem  # the former name, for one release

__all__ = [
    "AssociatedReports",
    "BearingProblem",
    "BearingReports",
    "BearingSensor",
    "GaussianPrior",
    "ImproperLawError",
    "InvalidInputError",
    "LinearProblem",
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
