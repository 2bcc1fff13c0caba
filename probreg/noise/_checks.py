"""What is asked of a law and of its parameters before they are used."""

from __future__ import annotations

from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise._law import NoiseLaw


def above_zero(law: NoiseLaw, **values: Any) -> None:
    """Check that parameters of a law, scalars or arrays, are finite and above zero."""
    for name, value in values.items():
        number = isinstance(value, int | float | np.number | np.ndarray)
        if not (number and np.all(np.isfinite(value)) and np.all(np.asarray(value) > 0.0)):
            raise InvalidInputError(
                f"{type(law).__name__}: {name} is {value!r}; it must be a number (or an array of "
                "numbers, one a chain), finite and above zero."
            )


def require_law(noise: object) -> None:
    """Raise unless `noise` is a law: a class or a name is a common slip."""
    if not isinstance(noise, NoiseLaw):
        raise InvalidInputError(
            f"noise is {noise!r}; pass a law from probreg.noise, such as Huber(1.345)."
        )


def require_scalar_law(noise: object) -> None:
    """Raise unless `noise` is a law with one number a parameter."""
    require_law(noise)
    assert isinstance(noise, NoiseLaw)
    if any(np.ndim(value) for value in (*noise.params, noise.unit)):
        raise InvalidInputError(
            f"{type(noise).__name__} must have one number a parameter here, not an array."
        )
