"""How long the steps of a registration take."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


class Clock:
    """Runs steps one after the other, counts the seconds of each and says when it is over.

    Parameters
    ----------
    on_step : callable
        Called with the name of each step when it is over.
    """

    def __init__(self, on_step: Callable[[str], object]) -> None:
        self._on_step = on_step
        self.seconds: dict[str, float] = {}

    def run(self, name: str, step: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """What the step returns."""
        started = time.perf_counter()
        result = step(*args, **kwargs)
        self.seconds[name] = time.perf_counter() - started
        self._on_step(name)
        return result
