"""Mode and curvature of a density that is no posterior: the protocol is all they ask for."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.posterior import Laplace
from probreg.posterior.laplace import climb, joint_covariance, require_mode

MEAN = np.array([120.0, 0.03, -2.0])
ROOT = np.array([[8.0, 0.0, 0.0], [1e-3, 2e-3, 0.0], [0.2, -0.1, 0.5]])
COVARIANCE = ROOT @ ROOT.T


class Bell:
    """A Gaussian of very different scales, or its reciprocal, which has no top."""

    names = ("metres", "radians", "free")
    dim = 3

    def __init__(self, sign=1.0, box=None):
        self.sign, self.box = sign, box

    def inside(self, x):
        return bool(((x[:2] >= self.box[:, 0]) & (x[:2] <= self.box[:, 1])).all())

    def log_prob(self, x):
        return self.log_prob_and_grad(x)[0]

    def log_prob_and_grad(self, x):
        pulled = (x - MEAN) @ np.linalg.inv(COVARIANCE)
        value = -0.5 * self.sign * np.einsum("...d,...d->...", x - MEAN, pulled)
        return value, -self.sign * pulled

    likelihood_and_grad = log_prob_and_grad


def test_a_gaussian_is_its_own_approximation():
    bell, unit = Bell(), np.array([5.0, 1e-3, 1.0])
    mode = climb(bell, MEAN + 4.0 * unit, unit)
    sd = np.sqrt(np.diag(COVARIANCE))
    assert np.abs((mode - MEAN) / sd).max() < 1e-4
    known = np.linalg.inv(COVARIANCE)[:2, :2]
    covariance = joint_covariance(bell, mode, known, np.array([1e-4]))
    np.testing.assert_allclose((covariance - COVARIANCE) / np.outer(sd, sd), 0.0, atol=1e-6)
    found = Laplace.at(mode, covariance)
    np.testing.assert_allclose(found.root @ found.root.T, covariance, rtol=1e-12, atol=1e-15)


def test_a_density_without_a_top_is_refused():
    known = -np.linalg.inv(COVARIANCE)[:2, :2]
    with pytest.raises(InvalidInputError, match="not curved downwards"):
        joint_covariance(Bell(-1.0), MEAN, known, np.array([1e-4]))


def test_a_mode_where_no_sampler_can_start_is_named():
    require_mode(Bell(box=np.array([[0.0, 200.0], [-1.0, 1.0]])), MEAN)
    with pytest.raises(InvalidInputError, match=r"excludes the mode \(metres 120, radians 0.03\)"):
        require_mode(Bell(box=np.array([[0.0, 100.0], [-1.0, 1.0]])), MEAN)
    with pytest.raises(InvalidInputError, match="log-density at the mode is -inf"):
        require_mode(Bell(), MEAN + np.array([1e200, 0.0, 0.0]))
