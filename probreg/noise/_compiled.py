"""Scalar functions of a law, compiled once; numba is loaded with the first of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from probreg.typing import FloatArray

WeightFunction = Callable[[float, float, FloatArray], float]
KernelFunction = Callable[[Any, Any, Any], Any]
_SIGNATURE = "float64(float64, float64, float64[::1])"


class LawNumbers(NamedTuple):
    """Numbers of a law as compiled loops take them, beside its weight or log kernel.

    Attributes
    ----------
    params : ndarray
    unit : float
        Residuals are divided by it first.
    """

    params: FloatArray
    unit: float


@cache
def compile_scalar(function: WeightFunction | KernelFunction) -> Any:
    """Compile a weight or log kernel f(d2, m, params) once; all have one machine-code type.

    Because that type is shared, a loop that takes such a function is compiled once for all
    laws and kept on disk.
    """
    import numba  # slow to import: laws are used without weights too

    return numba.cfunc(_SIGNATURE, cache=True)(function)


def apply_each(weight: Any, d2: FloatArray, m: FloatArray, params: FloatArray) -> FloatArray:
    """Values f(d2, m, params) of rows with parameters of their own, shapes (n,), (n,), (n, k)."""
    from probreg.noise import _loops

    return _loops.apply_each(weight, d2, m, params)


def apply_same(weight: Any, d2: FloatArray, m: float, params: FloatArray) -> FloatArray:
    """Values f(d2, m, params) of rows (n,) with the same m and params (k,)."""
    from probreg.noise import _loops

    return _loops.apply_same(weight, d2, m, params)
