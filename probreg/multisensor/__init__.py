"""Registration of asynchronous recordings: rows of a target's reports, its path eliminated."""

from probreg.multisensor._bias import bias_model
from probreg.multisensor._correct import correct, corrected_values, restore
from probreg.multisensor._observing import counter_clockwise, gives_position, places, turned, turns
from probreg.multisensor._rows import RowPlan, plan_rows
from probreg.multisensor.recording_problem import RecordingProblem

__all__ = [
    "RecordingProblem",
    "RowPlan",
    "bias_model",
    "correct",
    "corrected_values",
    "counter_clockwise",
    "gives_position",
    "places",
    "plan_rows",
    "restore",
    "turned",
    "turns",
]
