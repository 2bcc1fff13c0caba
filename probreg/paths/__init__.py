"""Samplers of whole paths, one a module, each a frozen dataclass of its settings."""

from probreg.paths._draws import PathDraws, PathSampler
from probreg.paths._step_scale import StepScale
from probreg.paths.exact_path import ExactPath
from probreg.paths.gibbs_path import GibbsPath
from probreg.paths.metropolis_path import MetropolisPath
from probreg.paths.nuts_path import NutsPath

__all__ = [
    "ExactPath",
    "GibbsPath",
    "MetropolisPath",
    "NutsPath",
    "PathDraws",
    "PathSampler",
    "StepScale",
]
