"""A watch over the biases of sensors that never stops: slice by slice, in bounded memory."""

from probreg.watch._advance import advance
from probreg.watch._begin import begin
from probreg.watch.results import Alarm, Counts, SliceResult
from probreg.watch.saving import from_arrays, to_arrays
from probreg.watch.settings import WatchSettings
from probreg.watch.state import WatchState

__all__ = [
    "Alarm",
    "Counts",
    "SliceResult",
    "WatchSettings",
    "WatchState",
    "advance",
    "begin",
    "from_arrays",
    "to_arrays",
]
