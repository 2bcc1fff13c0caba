"""Targets' paths with white acceleration: eliminated, smoothed, drawn, all compiled.

Reports enter as scalar equations (`TrackEquations`) in order of target and time.
"""

from probreg.motion.tracks._build import ScalarEquations, track_equations, track_motion
from probreg.motion.tracks._equations import LEAST_WEIGHT, TrackEquations, TrackMotion, spans
from probreg.motion.tracks._online import LiveTracks, Sums
from probreg.motion.tracks.drifting import DriftInformation, eliminate_drifting
from probreg.motion.tracks.information import BiasInformation, eliminate_paths
from probreg.motion.tracks.online import carried, follow_tracks, merged
from probreg.motion.tracks.smoothing import (
    SmoothedTracks,
    add_bias_uncertainty,
    bias_response,
    draw_model,
    draw_tracks,
    smooth_tracks,
    with_times,
)

__all__ = [
    "LEAST_WEIGHT",
    "BiasInformation",
    "DriftInformation",
    "LiveTracks",
    "ScalarEquations",
    "SmoothedTracks",
    "Sums",
    "TrackEquations",
    "TrackMotion",
    "add_bias_uncertainty",
    "bias_response",
    "carried",
    "draw_model",
    "draw_tracks",
    "eliminate_drifting",
    "eliminate_paths",
    "follow_tracks",
    "merged",
    "smooth_tracks",
    "spans",
    "track_equations",
    "track_motion",
    "with_times",
]
