"""Engineers' units, and how many digits a number deserves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Unit:
    """A unit to show, and how many of it are in the SI unit."""

    symbol: str
    factor: float


# by the unit inside
SHOWN = {
    "m": Unit("m", 1.0),
    "rad": Unit("deg", float(np.rad2deg(1.0))),
    "s": Unit("s", 1.0),
    "m/m": Unit("m/km", 1e3),
    "": Unit("", 1.0),
}
MOST_DECIMALS = 9


@dataclass(frozen=True)
class Number:
    """A number as it is shown, and the number itself, both in the unit shown."""

    value: float
    text: str

    def __str__(self) -> str:
        return self.text


def decimals(spread: float) -> int:
    """Decimals that show two digits of a spread."""
    if not (np.isfinite(spread) and spread > 0.0):
        return 3
    return int(np.clip(1 - np.floor(np.log10(spread)), 0, MOST_DECIMALS))


def number(value: float, places: int) -> Number:
    """A number with so many decimals, and a minus sign that no line breaks at."""
    if not np.isfinite(value):
        return Number(value, "not known")
    text = f"{value:.{places}f}"
    text = text.lstrip("-") if float(text) == 0.0 else text
    return Number(float(value), text.replace("-", "\N{MINUS SIGN}"))


def percent(probability: float) -> str:
    """A probability in words that claim no more than the draws support."""
    if not np.isfinite(probability):
        return "not known"
    if probability < 0.001:
        return "below 0.1\N{NO-BREAK SPACE}%"
    if probability > 0.999:
        return "above 99.9\N{NO-BREAK SPACE}%"
    return f"{100.0 * probability:.1f}\N{NO-BREAK SPACE}%"
