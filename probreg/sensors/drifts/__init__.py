"""How the coefficient of a bias term moves in time, one kind of drift a module.

coefficient(t) = level + spread times what `Drift.root` spans.
"""

from __future__ import annotations

import sys
from functools import cache

from probreg.discovery import public_classes
from probreg.sensors.drifts._drift import Drift

__all__ = ["Drift", "known_drifts"]


@cache
def known_drifts() -> dict[str, Drift]:
    """Every kind of drift, by the name that a setup calls it by."""
    kinds = [kind() for kind in public_classes(sys.modules[__name__]).values()]
    return {kind.name: kind for kind in kinds}
