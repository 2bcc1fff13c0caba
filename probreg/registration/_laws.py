"""Noise laws tried on a recording, their parameters unknown."""

from __future__ import annotations

from dataclasses import dataclass

from probreg.noise import Contaminated, Gaussian, NoiseLaw, StudentT
from probreg.prior import NoiseParameter


@dataclass(frozen=True)
class LawChoice:
    """A noise law and which of its parameters are unknown.

    Parameters
    ----------
    law : NoiseLaw
        Proper.
    unknown : tuple of NoiseParameter
    """

    law: NoiseLaw
    unknown: tuple[NoiseParameter, ...] = ()

    @property
    def name(self) -> str:
        """Of the law's class."""
        return type(self.law).__name__


# sensors are seldom as accurate as their sheets say: every law has an unknown common scale
LAWS = (
    LawChoice(StudentT(4.0), (NoiseParameter("nu", 4.0, 1.0), NoiseParameter("scale", 1.0, 0.5))),
    LawChoice(
        Contaminated(0.1, 10.0),
        (
            NoiseParameter("rate", 0.1, 1.0),
            NoiseParameter("scale", 10.0, 0.7),
            NoiseParameter("core_scale", 1.0, 0.5),
        ),
    ),
    LawChoice(Gaussian(), (NoiseParameter("scale", 1.0, 0.5),)),
)
