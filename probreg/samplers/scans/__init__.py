"""Following a bias scan by scan."""

from probreg.samplers.scans._target import ScanTarget
from probreg.samplers.scans._track import Track, Tracker
from probreg.samplers.scans.particle_filter import ParticleFilter
from probreg.samplers.scans.scan_metropolis import ScanMetropolis
from probreg.samplers.scans.targets import (
    AccumulatedMemory,
    AllScans,
    AsPrinted,
    Flat,
    GaussianMemory,
    ParticleMemory,
)

__all__ = [
    "AccumulatedMemory",
    "AllScans",
    "AsPrinted",
    "Flat",
    "GaussianMemory",
    "ParticleFilter",
    "ParticleMemory",
    "ScanMetropolis",
    "ScanTarget",
    "Track",
    "Tracker",
]
