"""Bias terms: how a systematic error enters a sensor's reports, one term a module.

report = truth + sum of coefficient times column(truth) + noise, and
stamp = time + coefficient times the term's `stamp`.
"""

from __future__ import annotations

import sys
from functools import cache

from probreg.discovery import public_classes
from probreg.sensors import Sensor
from probreg.sensors.terms._correction import add_terms, remove_terms
from probreg.sensors.terms._term import Term

__all__ = ["Term", "add_terms", "known_terms", "remove_terms"]


def known_terms(sensor: Sensor) -> dict[str, Term]:
    """Every term that a sensor can have, by name."""
    return {term.name: term for kind in _kinds() for term in kind.of(sensor)}


@cache
def _kinds() -> tuple[type[Term], ...]:
    return tuple(public_classes(sys.modules[__name__]).values())
