"""Packages that only some users need: what is missing is said in one sentence."""

from __future__ import annotations

from importlib.util import find_spec

from probreg.errors import MissingExtraError

# extra of pyproject.toml -> module that is imported -> package that brings it
EXTRAS = {
    "asterix": {"asterix": "libasterix"},
    "nuts": {"torch": "torch", "pyro": "pyro-ppl"},
}


def require(extra: str, what: str) -> None:
    """Check that the packages of an extra are installed, without loading them.

    Parameters
    ----------
    extra : str
        One of `EXTRAS`.
    what : str
        What asks for it, the first word of the sentence.

    Raises
    ------
    MissingExtraError
        Names the packages that are missing, and the extra that brings them.
    """
    missing = [package for module, package in EXTRAS[extra].items() if find_spec(module) is None]
    if missing:
        raise MissingExtraError(
            f"{what} needs {' and '.join(missing)}, not installed here: "
            f"pip install 'probreg[{extra}]'."
        )
