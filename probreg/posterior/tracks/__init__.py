"""Posterior of a recording's tracks: biases, paths, precisions and identities of reports."""

from probreg.posterior.tracks.biases import (
    as_constant,
    bias_scores,
    evidence_at,
    local_covariance,
    some_targets_say,
    telling_targets,
    with_draws,
)
from probreg.posterior.tracks.cavity import Judgement, ReportMixtures
from probreg.posterior.tracks.drift_draws import DriftDraws, draw_drift
from probreg.posterior.tracks.drifting import DriftPrior, Profile, Spreads, profile
from probreg.posterior.tracks.fit import TrackFit, fit_tracks
from probreg.posterior.tracks.model import TrackModel
from probreg.posterior.tracks.prediction import LeftOut, Prediction, left_out, predict
from probreg.posterior.tracks.score import Scores, SpreadScores, score_missing, score_spread
from probreg.posterior.tracks.steps import Point, Solution, judge, smooth, solve

__all__ = [
    "DriftDraws",
    "DriftPrior",
    "Judgement",
    "LeftOut",
    "Point",
    "Prediction",
    "Profile",
    "ReportMixtures",
    "Scores",
    "Solution",
    "SpreadScores",
    "Spreads",
    "TrackFit",
    "TrackModel",
    "as_constant",
    "bias_scores",
    "draw_drift",
    "evidence_at",
    "fit_tracks",
    "judge",
    "left_out",
    "local_covariance",
    "predict",
    "profile",
    "score_missing",
    "score_spread",
    "smooth",
    "solve",
    "some_targets_say",
    "telling_targets",
    "with_draws",
]
