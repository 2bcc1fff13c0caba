"""Following a bias scan by scan."""

from probreg.tracking._target import ScanTarget
from probreg.tracking._track import Track
from probreg.tracking.particle_filter import ParticleFilter
from probreg.tracking.scan_metropolis import ScanMetropolis
from probreg.tracking.targets import (
    AccumulatedMemory,
    AllScans,
    Flat,
    GaussianMemory,
    Literal,
    ParticleMemory,
)

__all__ = [
    "AccumulatedMemory",
    "AllScans",
    "Flat",
    "GaussianMemory",
    "Literal",
    "ParticleFilter",
    "ParticleMemory",
    "ScanMetropolis",
    "ScanTarget",
    "Track",
]
