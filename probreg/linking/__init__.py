"""Whose report is it? Identities where a recording has none, and doubts where it has."""

from probreg.linking._associate import associate
from probreg.linking._doubt import doubt_identities

__all__ = ["associate", "doubt_identities"]
