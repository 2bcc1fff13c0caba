"""Scalar functions of a law, compiled once, and loops that apply them to many rows."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numba
import numpy as np

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
    return numba.cfunc(_SIGNATURE, cache=True)(function)


@numba.njit(cache=True)
def apply_each(weight: Any, d2: FloatArray, m: FloatArray, params: FloatArray) -> FloatArray:
    out = np.empty(d2.size)
    for i in range(d2.size):
        out[i] = weight(d2[i], m[i], params[i])
    return out


@numba.njit(cache=True)
def apply_same(weight: Any, d2: FloatArray, m: float, params: FloatArray) -> FloatArray:
    out = np.empty(d2.size)
    for i in range(d2.size):
        out[i] = weight(d2[i], m, params)
    return out
