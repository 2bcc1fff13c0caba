"""Registration and association together: one method a module, each says which pairs it believes."""

from probreg.joint._frames import JointEstimator
from probreg.joint.consensus import Consensus
from probreg.joint.reassociation import Reassociation

__all__ = ["Consensus", "JointEstimator", "Reassociation"]
