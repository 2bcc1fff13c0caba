"""The base class says what a new law must give: one that lacks any of it cannot be made."""

from __future__ import annotations

from dataclasses import make_dataclass

import numpy as np
import pytest

from probreg.errors import ImproperLawError
from probreg.noise import Mixture, NoiseLaw, RejectionRule, ScaleMixture

GIVEN = {
    "scale": 1.0,
    "componentwise": False,
    "weight_function": staticmethod(lambda d2, m, params: 1.0),
    "kernel_function": staticmethod(lambda d2, m, params: -0.5 * d2),
    "sample_unit": lambda self, rng, n, m: rng.standard_normal((n, m)),
    "draw_unit_precision": lambda self, rng, d2, m: np.ones_like(d2),
    "unit_mixture": lambda self, m: Mixture(np.ones(1), np.ones(1)),
}
HIDDEN = {"draw_unit_precision", "unit_mixture"}
BASES = {
    NoiseLaw: set(GIVEN) - HIDDEN,
    ScaleMixture: set(GIVEN),
    RejectionRule: set(GIVEN) - HIDDEN - {"sample_unit"},
}
LACKING = [(base, name) for base, needed in BASES.items() for name in sorted(needed)]


def make(base, members):
    fields = [(name, object, GIVEN[name]) for name in ("scale", "componentwise") if name in members]
    namespace = {name: GIVEN[name] for name in members}
    return make_dataclass("Law", fields, bases=(base,), namespace=namespace, frozen=True)


@pytest.mark.parametrize("base", BASES)
def test_a_law_that_gives_what_is_asked_is_whole(base):
    law = make(base, BASES[base])()
    v = np.random.default_rng(1).normal(size=(5, 2))
    np.testing.assert_array_equal(law.weight(v), np.ones(5))
    if law.proper:
        expected = -0.5 * (v**2).sum(axis=1) - np.log(2.0 * np.pi)
        np.testing.assert_allclose(law.log_density(v), expected)
        assert law.sample(np.random.default_rng(1), 5, 2).shape == (5, 2)
    else:
        with pytest.raises(ImproperLawError, match="rejection rule"):
            law.sample(np.random.default_rng(1), 5, 2)


@pytest.mark.parametrize(("base", "missing"), LACKING)
def test_a_law_that_lacks_a_member_cannot_be_made(base, missing):
    with pytest.raises(TypeError, match=f"abstract.*{missing}"):
        make(base, BASES[base] - {missing})()
