"""What a user decides of a watch."""

from __future__ import annotations

from dataclasses import dataclass

from probreg.errors import InvalidInputError
from probreg.validation import positive_number, whole_number


@dataclass(frozen=True)
class WatchSettings:
    """What a user decides of a watch.

    Parameters
    ----------
    slice_s : float
        Length of a time slice, seconds: one result and one knot of every bias each.
    lag_s : float
        How long reports stay open: their weights and paths are refined by what follows.
    window : int
        Knots of every bias that are kept apart, at the ends of the open slices and
        before; older ones are merged into the oldest.
    delay_s : float
        How late a report may come and still be used; below `lag_s`.
    forget_s : float
        A track without reports for so long is forgotten.
    false_alarms_per_day : float
        Of all kinds of alarms together, while nothing is wrong.
    drift : bool
        Whether biases may walk, with a spread that is learned; else they are constant.
    floor : float
        Standard deviation that every bias gains in an hour even if constant, as a share of its
        prior standard deviation.
    half_life_s : float
        Of what is remembered of the noise.

    Raises
    ------
    InvalidInputError
        Numbers out of range or that contradict each other.
    """

    slice_s: float = 10.0
    lag_s: float = 60.0
    window: int = 8
    delay_s: float = 20.0
    forget_s: float = 120.0
    false_alarms_per_day: float = 1.0
    drift: bool = True
    floor: float = 1e-3
    half_life_s: float = 3600.0

    def __post_init__(self) -> None:
        for name in (
            "slice_s",
            "lag_s",
            "forget_s",
            "false_alarms_per_day",
            "half_life_s",
            "floor",
        ):
            positive_number(name, getattr(self, name))
        positive_number("delay_s", self.delay_s, zero=True)
        whole_number("window", self.window)
        if abs(self.lag_s / self.slice_s - self.open_slices) > 1e-9 or self.open_slices < 2:
            raise InvalidInputError(
                f"lag_s {self.lag_s} must be a whole number of slices of {self.slice_s} s, two or "
                "more."
            )
        if self.window <= self.open_slices:
            raise InvalidInputError(
                f"window is {self.window}; {self.open_slices + 1} or more knots are needed, at the "
                f"ends of {self.open_slices} open slices and before."
            )
        if self.delay_s > self.lag_s - self.slice_s:
            raise InvalidInputError(
                f"delay_s {self.delay_s} must be at most {self.lag_s - self.slice_s}: reports that "
                "are later find their slice closed. Enlarge lag_s, and window with it."
            )

    @property
    def open_slices(self) -> int:
        """Slices whose reports are open."""
        return round(self.lag_s / self.slice_s)
