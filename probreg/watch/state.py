"""What a watch remembers: bounded, of plain arrays, enough to go on bit for bit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.motion.tracks import LiveTracks
from probreg.noise import MixtureCounts, ScaleMixture
from probreg.problems.recording.track_reports import PathPoints
from probreg.recordings import Setup
from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.watch._scene import Scene
from probreg.watch.settings import WatchSettings


@dataclass(frozen=True, eq=False)
class OpenReports:
    """Reports whose weights and paths may still change, in any order.

    Attributes
    ----------
    track : ndarray of int, shape (n,)
        Row of the tracks.
    kind : ndarray of int, shape (n,)
        Sensor model.
    time : ndarray, shape (n,)
        Stamps, seconds.
    values : ndarray, shape (n, q)
    own : ndarray, shape (n, d)
        Position of a moving platform, zero else.
    turn : ndarray, shape (n,)
        What a heading adds to the azimuth.
    weight : ndarray, shape (n,)
    path : PathPoints
        Where the target is near that time.
    """

    track: IntArray
    kind: IntArray
    time: FloatArray
    values: FloatArray
    own: FloatArray
    turn: FloatArray
    weight: FloatArray
    path: PathPoints

    def __len__(self) -> int:
        return len(self.time)

    def take(self, rows: IntArray | BoolArray) -> OpenReports:
        """Some of the reports."""
        path = PathPoints(*(part[rows] for part in self.path))
        arrays = {name: getattr(self, name)[rows] for name in _ARRAYS}
        return OpenReports(**arrays, path=path)

    def joined(self, other: OpenReports) -> OpenReports:
        """With others behind."""
        path = [np.concatenate(pair) for pair in zip(self.path, other.path, strict=True)]
        arrays = {k: np.concatenate([getattr(self, k), getattr(other, k)]) for k in _ARRAYS}
        return OpenReports(**arrays, path=PathPoints(*path))


_ARRAYS = ("track", "kind", "time", "values", "own", "turn", "weight")


@dataclass(frozen=True, eq=False)
class Tracks:
    """Targets that were seen of late, up to the closed slices.

    Attributes
    ----------
    label : ndarray of str, shape (K,)
        Of the identity; the last row of a label is that to which new reports go.
    begun : ndarray of bool, shape (K,)
        Whether a closed slice holds a report: else there is no state yet.
    seen : ndarray, shape (K,)
        Time of the last report, open ones too.
    live : LiveTracks
    """

    label: np.ndarray
    begun: BoolArray
    seen: FloatArray
    live: LiveTracks

    def take(self, rows: IntArray | BoolArray) -> Tracks:
        """Some of the tracks."""
        live = LiveTracks(*(part[rows] for part in self.live))
        return Tracks(self.label[rows], self.begun[rows], self.seen[rows], live)


@dataclass(frozen=True, eq=False)
class Filters:
    """Beliefs about the biases at the knots of a window, one filter a hypothesis of their walk.

    Filter 0 takes the estimated walk of every bias; L a bias follow, under which it walks as fast
    as each level and the others as estimated; the last takes the estimates of some time ago. Their
    log densities are log_scale + shift . delta - delta' precision delta / 2, of closed slices.

    Attributes
    ----------
    precision : ndarray, shape (F, W p, W p)
    shift : ndarray, shape (F, W p)
    log_scale : ndarray, shape (F,)
    step : ndarray, shape (F, W, p)
        Variance of the steps to each knot from that before.
    evidence : ndarray, shape (F,)
        Log evidence of each filter with all reports, up to a constant.
    past : ndarray, shape (H, F)
        The evidence after slices before, the latest last.
    """

    precision: FloatArray
    shift: FloatArray
    log_scale: FloatArray
    step: FloatArray
    evidence: FloatArray
    past: FloatArray


@dataclass(frozen=True, eq=False)
class Changes:
    """Scores of changes that may have happened, one a moment and bias.

    Attributes
    ----------
    begun : ndarray of int, shape (H,)
        Slice with which each began.
    gap : ndarray, shape (H, p, W p)
        What a unit of change leaves unexplained at the knots.
    score, information : ndarray, shape (H, p)
        Of the size of each change, against none.
    """

    begun: IntArray
    gap: FloatArray
    score: FloatArray
    information: FloatArray


@dataclass(frozen=True, eq=False)
class NoiseScores:
    """What is usual of the scores of less and of more noise, and evidence that they have shifted.

    Attributes
    ----------
    slices, reports : ndarray, shape (models,)
        From which it is learned, faded.
    mean : ndarray, shape (models, 2)
        Of the score of one report.
    variance, product : ndarray, shape (models, 2)
        Of what a slice's score is away from its mean, over the root of its reports; and with that
        of the slice before.
    last : ndarray, shape (models, 2)
        What the last slice was away.
    sums : ndarray, shape (models, 2, shifts)
        Log of Shiryaev-Roberts sums.
    recent : ndarray, shape (models, factors)
        Log likelihood ratios since there is evidence of a shift, faded.
    """

    slices: FloatArray
    reports: FloatArray
    mean: FloatArray
    variance: FloatArray
    product: FloatArray
    last: FloatArray
    sums: FloatArray
    recent: FloatArray


@dataclass(frozen=True, eq=False)
class Alarms:
    """What alarms remember, and their thresholds.

    Attributes
    ----------
    steps, ramps : Changes
    noise : NoiseScores
    expected : ndarray, shape (sensors,)
        Of each sensor's reports as a share of all.
    silent : ndarray, shape (sensors,)
        Log evidence of silence.
    thresholds : ndarray, shape (3,)
        On the log evidence of a change of biases, of noise and of silence.
    """

    steps: Changes
    ramps: Changes
    noise: NoiseScores
    expected: FloatArray
    silent: FloatArray
    thresholds: FloatArray


@dataclass(frozen=True, eq=False)
class Noise:
    """Laws of the sensor models, as given and as found, and what was counted for them.

    Attributes
    ----------
    about, laws : tuple of ScaleMixture
    unknown : tuple of tuple of str
        Parameters of each law that are estimated.
    about_wrong, wrong : ndarray, shape (models,)
    counts : tuple of MixtureCounts
        Of each model, faded with time.
    missed, reports : ndarray, shape (models,)
        Expected wrong identities, and reports.
    """

    about: tuple[ScaleMixture, ...]
    laws: tuple[ScaleMixture, ...]
    unknown: tuple[tuple[str, ...], ...]
    about_wrong: FloatArray
    wrong: FloatArray
    counts: tuple[MixtureCounts, ...]
    missed: FloatArray
    reports: FloatArray


@dataclass(frozen=True, eq=False)
class WatchState:
    """What a watch remembers.

    Attributes
    ----------
    setup : Setup
    settings : WatchSettings
    scene : Scene
        Made from the setup and the kinds of reports.
    origin : float
        Where slice 0 begins, seconds.
    slices : int
        That are taken in.
    theta : ndarray, shape (p,)
        Biases that all linearisations are about.
    density : float
        Of the targets' acceleration.
    area_m2 : float
    constant_sd : ndarray, shape (c,)
    mean, sd : ndarray, shape (p,)
        Of the biases now.
    knots : ndarray, shape (W, p)
        Biases at the knots of the window.
    """

    setup: Setup
    settings: WatchSettings
    scene: Scene
    origin: float
    slices: int
    theta: FloatArray
    density: float
    area_m2: float
    constant_sd: FloatArray
    mean: FloatArray
    sd: FloatArray
    knots: FloatArray
    noise: Noise
    tracks: Tracks
    reports: OpenReports
    filters: Filters
    alarms: Alarms

    @property
    def time(self) -> float:
        """End of the last slice, seconds."""
        return self.origin + self.slices * self.settings.slice_s

    @property
    def names(self) -> tuple[str, ...]:
        """Of the biases."""
        return self.scene.bias.names

    @property
    def units(self) -> tuple[str, ...]:
        """Of the biases, SI."""
        return self.scene.bias.units
