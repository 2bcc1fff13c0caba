"""Noise laws that a recording may follow, their parameters unknown."""

from __future__ import annotations

from dataclasses import dataclass

import probreg.noise
from probreg.discovery import public_classes
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

    @classmethod
    def usual(cls, law: NoiseLaw) -> LawChoice:
        """All that the law's `supports` name is unknown, about the values that the law has."""
        return cls(
            law,
            tuple(
                NoiseParameter(name, float(getattr(law, name)), support.spread)
                for name, support in law.supports.items()
            ),
        )

    @property
    def name(self) -> str:
        """Of the law's class."""
        return type(self.law).__name__


# compared unless others are asked for, the simpler first; sensors are seldom as accurate as
# their sheets say, so every law has an unknown common scale
LAWS = tuple(LawChoice.usual(law) for law in (Gaussian(), Contaminated(), StudentT()))


def known_laws() -> dict[str, LawChoice]:
    """Every law of `probreg.noise` that tracks can take, by the name of its class."""
    laws = [kind() for kind in public_classes(probreg.noise).values()]
    return {type(law).__name__: LawChoice.usual(law) for law in laws if _fits(law)}


def _fits(law: NoiseLaw) -> bool:
    return law.proper and law.scale_mixture and not law.componentwise
