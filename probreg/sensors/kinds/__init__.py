"""Kinds of sensor, one a module: a module with one public class is found by every room."""

from __future__ import annotations

import sys
from functools import cache

from probreg.discovery import public_classes
from probreg.sensors._sensor import Sensor

__all__ = ["known_kinds"]


@cache
def known_kinds() -> dict[str, type[Sensor]]:
    """Classes of sensors by the name of their kind in a setup file."""
    found: list[type[Sensor]] = list(public_classes(sys.modules[__name__]).values())
    return {owner.kind.name: owner for owner in found}
