"""Samplers of whole paths, one a module, each a frozen dataclass of its settings."""

from probreg.samplers.paths._draws import PathDraws, PathSampler
from probreg.samplers.paths._step_scale import StepScale
from probreg.samplers.paths.exact_path import ExactPath
from probreg.samplers.paths.gibbs_path import GibbsPath
from probreg.samplers.paths.metropolis_path import MetropolisPath
from probreg.samplers.paths.nuts_path import NutsPath

__all__ = [
    "ExactPath",
    "GibbsPath",
    "MetropolisPath",
    "NutsPath",
    "PathDraws",
    "PathSampler",
    "StepScale",
]
