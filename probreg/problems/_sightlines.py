"""Lines of sight from known places: where they meet, and whether they do.

Azimuths are counted from x counter-clockwise, (n,), own positions in metres, (n, 2).
"""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError, UnobservableError
from probreg.sensors import geometry
from probreg.typing import FloatArray
from probreg.validation import LARGE_ANGLE_SIGMA

PARALLAX = 3.0  # standard deviations by which the lines of sight must turn to give a distance
_SPREAD_OUT = 0.9  # resultant of doubled angles below which the lines plainly cross
_PAIRS = 32
_MEDIAN_SPREAD = 1.45  # of the median of half-track slopes over least squares, straight track


def line_equations(azimuth: FloatArray, own: FloatArray) -> tuple[FloatArray, FloatArray]:
    """H (n, 2) and Z (n,) of the lines of sight H X = Z, metres."""
    H = np.stack([np.sin(azimuth), -np.cos(azimuth)], axis=1)
    return H, np.einsum("ni,ni->n", H, own)


def meeting_point(azimuth: FloatArray, own: FloatArray) -> FloatArray:
    """Where the lines meet by equal-weight least squares, (2,), metres."""
    place: FloatArray = np.linalg.lstsq(*line_equations(azimuth, own), rcond=None)[0]
    return place


def meeting_points(azimuth: FloatArray, own: FloatArray) -> FloatArray:
    """Where all lines (1), and lines half a recording apart (up to _PAIRS), meet: (k, 2)."""
    H, Z = line_equations(azimuth, own)
    half = (len(azimuth) + 1) // 2
    first = np.unique(np.linspace(0, len(azimuth) - half - 1, _PAIRS).astype(int))
    pair = np.stack([first, first + half], axis=1)
    pair = pair[np.abs(np.linalg.det(H[pair])) > 1e-9]
    crossings = np.linalg.solve(H[pair], Z[pair][..., None])[..., 0]
    return np.concatenate([meeting_point(azimuth, own)[None], crossings])


def points_ahead(azimuth: FloatArray, own: FloatArray) -> FloatArray:
    """Points (k, 2) along the median azimuth, from a tenth of the track's length on."""
    track = float(np.ptp(own, axis=0).max()) or 1e3
    mean = np.angle(np.sum(np.exp(1j * azimuth)))
    mean += np.median(geometry.wrap_angle(azimuth - mean))
    distance = track * np.logspace(-1.0, 3.0, 17)
    return own.mean(axis=0) + distance[:, None] * _direction(mean)


def parallel_direction(
    azimuth: FloatArray, own: FloatArray, sigma: FloatArray
) -> FloatArray | None:
    """Direction (2,) of the lines of sight if they are parallel within their noise (n,).

    They are if the own ship stays, or moves along them: the distance is then not told.
    """
    weight = sigma**-2.0
    total = weight.sum()
    double = np.sum(weight * np.exp(2j * azimuth)) / total
    if abs(double) < _SPREAD_OUT and sigma.max() < LARGE_ANGLE_SIGMA:
        return None
    common = 0.5 * np.angle(double)
    turn = 0.5 * geometry.wrap_angle(2.0 * (azimuth - common))
    across = own @ np.array([-np.sin(common), np.cos(common)])
    across = across - weight @ across / total
    length = np.sqrt(weight @ across**2)
    moved = length > 1e-9 * np.sqrt(total) * np.abs(own).max(initial=1.0)
    if moved and _parallax(turn, across, weight, length) > PARALLAX:
        return None
    return _direction(common)


def require_distance(place: FloatArray, own: FloatArray, sigma: FloatArray) -> None:
    """Raise unless a place (2,) has bearings, and bearings that tell its distance.

    Raises
    ------
    InvalidInputError
        The place is on the track, where its bearing is undefined.
    UnobservableError
        It is so far that the bearings tell no distance.
    """
    distance = np.linalg.norm(place - own, axis=1)
    if distance.min() <= 1e-9 * max(1.0, distance.max()):
        raise InvalidInputError(
            f"the emitter would be at own position {int(distance.argmin())}, on the track: its "
            "bearing is undefined there. Remove bearings taken on top of it, or start "
            "elsewhere."
        )
    track = np.linalg.norm(np.ptp(own, axis=0))
    if 0.0 < track < 1e-3 * sigma.min() / np.sqrt(len(own)) * distance.min():
        raise UnobservableError(
            f"the emitter would be {distance.min():.3g} m away, where these bearings tell no "
            "distance: they agree best with an emitter at infinity. Are there outliers "
            "(Irls(StudentT(4.0)))? Otherwise add bearings from other places or give a prior."
        )


def _parallax(turn: FloatArray, across: FloatArray, weight: FloatArray, length: float) -> float:
    """Significance of the lines' turn with the way across them, in standard deviations.

    The larger of that by least squares and that by a median, which bears outliers.
    """
    plain = np.sum(weight * across * turn) / length
    half = (len(turn) + 1) // 2
    apart = across[half:] - across[: len(turn) - half]
    slopes = (turn[half:] - turn[: len(turn) - half])[apart != 0.0] / apart[apart != 0.0]
    robust = np.median(slopes) * length / _MEDIAN_SPREAD if slopes.size else 0.0
    return float(max(abs(plain), abs(robust)))


def _direction(azimuth: float) -> FloatArray:
    return np.array([np.cos(azimuth), np.sin(azimuth)])
