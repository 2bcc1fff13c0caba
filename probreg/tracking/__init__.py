"""Following a bias scan by scan."""

from probreg.tracking._track import Track
from probreg.tracking.particle_filter import ParticleFilter
from probreg.tracking.scan_metropolis import ScanMetropolis
from probreg.tracking.targets import (
    AccumulatedMemory,
    Flat,
    GaussianMemory,
    Literal,
    ParticleMemory,
)

__all__ = [
    "AccumulatedMemory",
    "Flat",
    "GaussianMemory",
    "Literal",
    "ParticleFilter",
    "ParticleMemory",
    "ScanMetropolis",
    "Track",
]
