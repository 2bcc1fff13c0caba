"""Posterior of a recording's tracks: biases, paths, precisions and identities of reports."""

from probreg.posterior.tracks.cavity import Judgement, ReportMixtures
from probreg.posterior.tracks.fit import TrackFit, fit_tracks
from probreg.posterior.tracks.model import TrackModel
from probreg.posterior.tracks.prediction import LeftOut, Prediction, left_out, predict
from probreg.posterior.tracks.score import Scores, SpreadScores, score_missing, score_spread
from probreg.posterior.tracks.steps import Point, Solution, judge, smooth, solve

__all__ = [
    "Judgement",
    "LeftOut",
    "Point",
    "Prediction",
    "ReportMixtures",
    "Scores",
    "Solution",
    "SpreadScores",
    "TrackFit",
    "TrackModel",
    "fit_tracks",
    "judge",
    "left_out",
    "predict",
    "score_missing",
    "score_spread",
    "smooth",
    "solve",
]
