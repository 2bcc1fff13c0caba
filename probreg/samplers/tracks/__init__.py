"""Samplers of track posteriors: biases, paths, precisions and identities together."""

from probreg.samplers.tracks._bias_draws import BiasDraws, normal_draws
from probreg.samplers.tracks._draws import TrackDraws
from probreg.samplers.tracks._mode_check import ModeCheck, check_mode
from probreg.samplers.tracks._path_draws import BiasPathDraws
from probreg.samplers.tracks.gibbs_tracks import GibbsTracks

__all__ = [
    "BiasDraws",
    "BiasPathDraws",
    "GibbsTracks",
    "ModeCheck",
    "TrackDraws",
    "check_mode",
    "normal_draws",
]
