"""Loops that apply a compiled scalar function to many rows."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from probreg.typing import FloatArray


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
