"""Errors that say what is wrong, where, and what to do about it."""

from __future__ import annotations


class ProbregError(ValueError):
    """Base class of every error that probreg raises about its input."""


class InvalidInputError(ProbregError):
    """An array or setting that cannot be what the caller meant."""


class MissingExtraError(InvalidInputError):
    """What was asked for needs an optional package that is not installed."""


class UnobservableError(ProbregError):
    """Data and prior leave a combination of the unknowns undetermined."""


class ImproperLawError(ProbregError):
    """A density was asked of a noise law that has none."""
