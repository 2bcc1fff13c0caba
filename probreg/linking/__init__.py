"""Whose report is it? Identities where a recording has none, and doubts where it has."""

from probreg.linking._associate import associate
from probreg.linking._doubt import OFF_PATH, TOO_FAST, doubt_identities, doubts

__all__ = ["OFF_PATH", "TOO_FAST", "associate", "doubt_identities", "doubts"]
