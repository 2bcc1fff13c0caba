"""Where a sensor stands and how it is levelled: range, azimuth and elevation about its own axes.

A sensor on the round earth measures about its own vertical and its own north, which differ from
those of the common frame by a degree in 111 km. With its position p and the rotation M from the
common axes to its own, it sees a target at x as l = M (x - p).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from probreg.sensors.geometry import cartesian_to_polar, polar_to_cartesian
from probreg.typing import FloatArray


class Sight(NamedTuple):
    """Range, azimuth and elevation of targets, and how they change with the position.

    Attributes
    ----------
    polar : ndarray, shape (..., 3)
        Range in metres; azimuth from the sensor's x axis, counter-clockwise, and elevation,
        radians.
    directions : ndarray, shape (..., 3, 3)
        Rows are unit vectors in the common frame in which range, azimuth and elevation grow
        fastest; they are orthogonal to each other.
    levers : ndarray, shape (..., 3)
        Metres along each direction for one unit of its component: 1, r cos(elevation), r.
        Derivatives of `polar` by the position are directions / levers[..., None]. The second
        is zero on the sensor's vertical, where an azimuth says nothing.
    """

    polar: FloatArray
    directions: FloatArray
    levers: FloatArray


@dataclass(frozen=True, eq=False)
class Placement:
    """Position and own axes of one sensor, or of a platform at many times.

    Parameters
    ----------
    position : ndarray, shape (3,) or (..., 3)
        In the common frame, metres.
    level : ndarray, shape (3, 3) or (..., 3, 3)
        Rotations from the common axes to the sensor's own: rows are its east, north and up in
        the common frame. By default they are those of the common frame.
    """

    position: FloatArray
    level: FloatArray = field(default_factory=lambda: np.eye(3))

    def local(self, positions: FloatArray) -> FloatArray:
        """Convert positions (..., 3) to coordinates (..., 3) about the sensor, in its own axes."""
        return np.einsum("...ij,...j->...i", self.level, positions - self.position)

    def common(self, local: FloatArray) -> FloatArray:
        """Invert `local`."""
        return self.position + np.einsum("...ij,...i->...j", self.level, local)

    def polar(self, positions: FloatArray) -> FloatArray:
        """Range, azimuth and elevation (..., 3) of positions (..., 3); see `Sight`."""
        return cartesian_to_polar(self.local(positions))

    def positions(self, polar: FloatArray) -> FloatArray:
        """Invert `polar`."""
        return self.common(polar_to_cartesian(polar))

    def sight(self, positions: FloatArray) -> Sight:
        """Range, azimuth and elevation of positions (..., 3), with their derivatives."""
        local = self.local(positions)
        polar = cartesian_to_polar(local)
        # from the angles, which arctan2 defines on the vertical as well
        sine, cosine = np.sin(polar[..., 1]), np.cos(polar[..., 1])
        climb, flat = np.sin(polar[..., 2]), np.cos(polar[..., 2])
        own = np.stack(
            [
                np.stack([flat * cosine, flat * sine, climb], axis=-1),
                np.stack([-sine, cosine, np.zeros_like(sine)], axis=-1),
                np.stack([-climb * cosine, -climb * sine, flat], axis=-1),
            ],
            axis=-2,
        )
        ground = np.hypot(local[..., 0], local[..., 1])
        levers = np.stack([np.ones_like(ground), ground, polar[..., 0]], axis=-1)
        return Sight(polar, own @ self.level, levers)

    def tilted(self, axes: FloatArray) -> Placement:
        """The same place with rotations (..., 3, 3) after the level, such as an `attitude`."""
        return Placement(self.position, axes @ self.level)


def attitude(
    heading: FloatArray, pitch: FloatArray | float = 0.0, roll: FloatArray | float = 0.0
) -> FloatArray:
    """Rotations (..., 3, 3) from level axes to those of a platform: starboard, bow and up.

    The bow takes the place of north, so that what counts clockwise from north then counts
    clockwise from the bow.

    Parameters
    ----------
    heading : ndarray, shape (...,)
        From the level x axis (east), counter-clockwise, radians, as a `Recording` has it.
    pitch, roll : ndarray, shape (...,)
        Bow up and starboard down, radians; taken in this order after the heading.
    """
    heading, pitch, roll = np.broadcast_arrays(
        *(np.asarray(angle, dtype=float) for angle in (heading, pitch, roll))
    )
    zero = np.zeros_like(heading)
    forward = np.stack([np.cos(heading), np.sin(heading), zero], axis=-1)
    right = np.stack([np.sin(heading), -np.cos(heading), zero], axis=-1)
    up = np.stack([zero, zero, zero + 1.0], axis=-1)
    bow = np.cos(pitch)[..., None] * forward + np.sin(pitch)[..., None] * up
    mast = np.cos(pitch)[..., None] * up - np.sin(pitch)[..., None] * forward
    starboard = np.cos(roll)[..., None] * right - np.sin(roll)[..., None] * mast
    return np.stack([starboard, bow, np.cross(starboard, bow)], axis=-2)
