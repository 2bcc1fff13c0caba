"""Scenes of the two bearings-only papers, and the weight they share, for the tests of both."""

from __future__ import annotations

import numpy as np

from probreg import BearingProblem
from probreg.scenarios import rekf, rrtls


def scene(outliers="one_sided", seed=2, **kwargs):
    settings = rekf.RekfScene(outliers=outliers, **kwargs)
    data, truth = rekf.simulate(settings, np.random.default_rng(seed))
    return BearingProblem.of(data), truth


def distant(seed=2, **kwargs):
    data, truth = rrtls.simulate(rrtls.RrtlsScene(**kwargs), np.random.default_rng(seed))
    return BearingProblem.of(data), truth


def igg3(u, k1, k2):
    u = abs(u)
    if u <= k1:
        return 1.0
    return k1 / u * ((k2 - u) / (k2 - k1)) ** 2 if u < k2 else 0.0
