"""How things move: steps of the unknowns in time, and the state space they make."""

from probreg.motion.dynamics import (
    Constant,
    Dynamics,
    LinearGaussian,
    NearConstantVelocity,
    RandomWalk,
    Together,
)
from probreg.motion.state_space import Backward, Filtered, Smoothed
from probreg.motion.target_state import Target, follow_target
from probreg.motion.trajectory import Trajectory

__all__ = [
    "Backward",
    "Constant",
    "Dynamics",
    "Filtered",
    "LinearGaussian",
    "NearConstantVelocity",
    "RandomWalk",
    "Smoothed",
    "Target",
    "Together",
    "Trajectory",
    "follow_target",
]
