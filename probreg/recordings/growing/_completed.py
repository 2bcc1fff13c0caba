"""What the first reports said of a setup, to be said again after an end."""

from __future__ import annotations

import dataclasses
from typing import Any

from probreg.recordings._heights import beside_kinds, with_kind
from probreg.recordings._setup import Setup


def said(given: Setup, completed: Setup) -> dict[str, Any]:
    """How a completed setup differs from the one given, in words that JSON keeps exactly."""
    return {
        "added": [sensor.kind.name for sensor in completed.sensors[len(given.sensors) :]],
        "geodetic": sorted(completed.geodetic),
        "places": {name: list(place) for name, place in completed.places.items()},
    }


def completed(given: Setup, content: dict[str, Any]) -> Setup:
    """The setup given, completed by what `said` gave."""
    setup = given
    for name in content["added"]:
        column, owner = next((c, o) for c, o in beside_kinds().items() if o.kind.name == name)
        setup, _ = with_kind(setup, owner, column)
    places = {name: (p[0], p[1], p[2]) for name, p in content["places"].items()}
    return dataclasses.replace(setup, geodetic=frozenset(content["geodetic"]), places=places)
