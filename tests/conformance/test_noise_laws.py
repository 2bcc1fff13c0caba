"""Every noise law found in probreg.noise, whole-vector and component-wise."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad

import probreg.noise
from probreg.discovery import public_classes
from probreg.errors import ImproperLawError, InvalidInputError
from probreg.noise import (
    Contaminated,
    Gaussian,
    Huber,
    Hyperbolic,
    StudentT,
    apply_same,
    compile_scalar,
)

# settings beside the defaults, so that every branch of a law is walked
EXTRA = [Hyperbolic(0.5), Hyperbolic(1e-3, piecewise_at=1.345), Hyperbolic(0.3, piecewise_at=0.8)]
LAWS = [cls() for cls in public_classes(probreg.noise).values()] + EXTRA
PROPER = [law for law in LAWS if law.proper]
IMPROPER = [law for law in LAWS if not law.proper]
MIXTURES = [law for law in LAWS if law.scale_mixture]
RADII = np.array([1e-4, 0.03, 0.4, 0.9, 1.2, 1.7, 2.9, 3.3, 4.4, 6.0, 25.0, 400.0])


def both_ways(laws):
    return [dataclasses.replace(law, componentwise=way) for law in laws for way in (False, True)]


def unit(law):
    return {"core_scale" if hasattr(law, "core_scale") else "scale": 1.7}


def test_discovery_finds_the_eight_laws():
    assert set(public_classes(probreg.noise)) == {
        "Gaussian", "Hyperbolic", "StudentT", "Contaminated",
        "Huber", "Igg3", "HardReject", "Tukey",
    }  # fmt: skip


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("m", [1, 2, 3, 6])
def test_weight_is_minus_twice_the_slope_of_the_log_kernel(law, m):
    d2 = RADII**2
    step = 1e-30
    slope = np.imag(law.log_kernel(d2 + 1j * step, m)) / step
    np.testing.assert_allclose(law.unit_weight(d2, m), -2.0 * slope, rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_curvature_holds_the_weight_and_its_slope(law):
    edges = np.array(law.corners)
    radii = RADII[np.abs(RADII[:, None] / edges - 1.0).min(axis=1) > 1e-3]
    v = np.zeros((radii.size, 2))
    v[:, 0] = radii
    h = 1e-4 * radii**2
    shifted = [law.unit_weight(radii**2 + k * h, 2) for k in (-2, -1, 1, 2)]
    reference = (shifted[0] - 8 * shifted[1] + 8 * shifted[2] - shifted[3]) / (12 * h)
    across, along = law.curvature(v)
    np.testing.assert_allclose(across, law.unit_weight(radii**2, 2))
    np.testing.assert_allclose(along, across + 2.0 * reference * radii**2, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("law", [law for law in LAWS if law.kinked], ids=repr)
def test_mean_curvature_of_a_kinked_law_is_that_of_the_mean_score(law):
    # oracle: E d2/dx2 rho(z + x) for Gaussian z is the derivative of E psi(z + x) at x = 0;
    # 60 000 draws, 5 standard errors of the kernel estimate, bias of the bandwidth below 2 %
    z = np.random.default_rng(0).normal(size=60_000)
    width = 60_000 ** (-1 / 3)
    _, along = dataclasses.replace(law, componentwise=True).curvature(z[:, None], None, width)

    def mean_score(x):
        def psi(y):
            return float(law.unit_weight(np.array([y * y]), 1)[0]) * y

        inside = quad(lambda y: psi(y) * stats.norm.pdf(y - x), -9, 9, limit=400,
                      points=[-c for c in law.corners] + [0.0, *law.corners])  # fmt: skip
        return inside[0]

    expected = (mean_score(0.05) - mean_score(-0.05)) / 0.1
    error = along.std() / np.sqrt(len(z))
    assert abs(along.mean() - expected) < 5 * error + 0.02


@pytest.mark.parametrize("law", PROPER, ids=repr)
@pytest.mark.parametrize("m", [1, 2, 3])
def test_density_integrates_to_one(law, m):
    law = dataclasses.replace(law, **unit(law))
    sphere = {1: 2.0, 2: 2.0 * np.pi, 3: 4.0 * np.pi}[m]

    def shell(radius):
        v = np.zeros((1, m))
        v[0, 0] = radius
        return sphere * radius ** (m - 1) * np.exp(law.log_density(v)[0])

    edges = [0.0, *sorted({1.7 * c for c in law.corners} | {3.0, 30.0, 300.0}), np.inf]
    total = sum(quad(shell, a, b, limit=200)[0] for a, b in itertools.pairwise(edges))
    assert total == pytest.approx(1.0, abs=1e-7)


@pytest.mark.parametrize("law", PROPER, ids=repr)
def test_componentwise_density_is_a_product_of_univariate_ones(law):
    v = np.random.default_rng(1).normal(size=(7, 3)) * 2.0
    apart = dataclasses.replace(law, componentwise=True)
    one = dataclasses.replace(law, componentwise=False)
    expected = sum(one.log_density(v[:, [c]]) for c in range(3))
    np.testing.assert_allclose(apart.log_density(v), expected, rtol=1e-12)


@pytest.mark.parametrize("law", both_ways(LAWS), ids=repr)
def test_padded_components_change_nothing(law):
    v = np.random.default_rng(2).normal(size=(9, 2))
    padded = np.pad(v, ((0, 0), (0, 2)))
    size = np.full(9, 2)
    got = law.weight(padded, size)
    np.testing.assert_allclose(got[:, :2] if law.componentwise else got, law.weight(v))
    if law.proper:
        np.testing.assert_allclose(law.log_density(padded, size), law.log_density(v))


@pytest.mark.parametrize("law", both_ways(PROPER), ids=repr)
def test_scale_stretches_the_residual(law):
    v = np.random.default_rng(3).normal(size=(5, 3))
    wide = dataclasses.replace(law, **unit(law))
    expected = law.log_density(v / 1.7) - 3 * np.log(1.7)
    np.testing.assert_allclose(wide.log_density(v), expected)
    np.testing.assert_allclose(wide.weight(v), law.weight(v / 1.7) / 1.7**2)


def radius_probabilities(law, edges, m):
    """Probability of |v| between edges, by quadrature of the public density."""
    sphere = {1: 2.0, 3: 4.0 * np.pi}[m]

    def shell(radius):
        v = np.zeros((1, m))
        v[0, 0] = radius
        return sphere * radius ** (m - 1) * np.exp(law.log_density(v)[0])

    corners, masses, low = sorted(1.7 * c for c in law.corners), [], 0.0
    for edge in edges:
        points = [low, *(c for c in corners if low < c < edge), edge]
        masses.append(sum(quad(shell, a, b)[0] for a, b in itertools.pairwise(points)))
        low = edge
    return np.array([*masses, 1.0 - sum(masses)])


def sampler_p_value(law, m, stretch=1.0):
    """Chi-square test of 4000 radii in 20 cells against the density."""
    pilot = np.linalg.norm(law.sample(np.random.default_rng(4), 4000, m), axis=1)
    edges = np.quantile(pilot, np.linspace(0.0, 1.0, 21)[1:-1])
    radius = stretch * np.linalg.norm(law.sample(np.random.default_rng(5), 4000, m), axis=1)
    counts = np.histogram(radius, [0.0, *edges, np.inf])[0]
    return stats.chisquare(counts, 4000 * radius_probabilities(law, edges, m)).pvalue


@pytest.mark.parametrize("law", PROPER, ids=repr)
@pytest.mark.parametrize("m", [1, 3])
def test_sampler_follows_the_density(law, m):
    # 16 tests at 1e-4: false alarm rate 0.2 %
    assert sampler_p_value(dataclasses.replace(law, **unit(law)), m) > 1e-4


@pytest.mark.parametrize("law", PROPER, ids=repr)
def test_a_sampler_of_the_wrong_scale_fails_that_test(law):
    # negative control: 15 % too wide
    assert sampler_p_value(dataclasses.replace(law, **unit(law)), 3, stretch=1.15) < 1e-4


@pytest.mark.parametrize("law", PROPER, ids=repr)
@pytest.mark.parametrize("m", [1, 2, 3])
def test_covariance_factor_against_quadrature(law, m):
    law = dataclasses.replace(law, **unit(law))
    unit_law = dataclasses.replace(law, **dict.fromkeys(unit(law), 1.0))
    mass = unit_law.radial_integral(np.ones_like, m)
    second = unit_law.radial_integral(lambda d2: d2, m)
    assert law.covariance_factor(m) == pytest.approx(1.7**2 * second / (m * mass), rel=1e-7)


@pytest.mark.parametrize("law", PROPER, ids=repr)
def test_information_factor_against_the_curvature_of_the_density(law):
    # E (d log f / dv)^2 = -E d^2 log f / dv^2 holds for smooth laws; here by quadrature in one
    # dimension of finite differences of the public density
    def score2(x):
        h = 1e-6 * max(1.0, abs(x))
        low, high = law.log_density(np.array([[x - h], [x + h]]))
        return ((high - low) / (2 * h)) ** 2 * np.exp(law.log_density(np.array([[x]]))[0])

    edges = [1e-9, *sorted({1e-4, 1e-2, 3.0, 30.0, 300.0} | set(law.corners)), np.inf]
    total = 2.0 * sum(quad(score2, a, b)[0] for a, b in itertools.pairwise(edges))
    assert law.information_factor(1) == pytest.approx(total, rel=2e-3)


@pytest.mark.parametrize("law", both_ways(MIXTURES), ids=repr)
def test_mean_precision_is_the_weight(law):
    # 20 comparisons at 5 standard errors: false alarm rate 1e-5
    v = np.repeat([[0.5, 0.2], [1.5, -1.0], [6.0, 3.0]], 40_000, axis=0)
    draws = law.draw_precision(np.random.default_rng(8), v).reshape(3, 40_000, -1)
    weights = law.weight(v).reshape(3, 40_000, -1)[:, 0]
    error = draws.std(axis=1) / np.sqrt(40_000)
    assert (np.abs(draws.mean(axis=1) - weights) <= 5.0 * (error + 1 / 40_000)).all()


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_compiled_weight_is_the_python_function(law):
    params = law.constants
    for d2 in RADII**2:
        expected = type(law).weight_function(d2, 3.0, params)
        assert law.unit_weight(np.array([d2]), 3)[0] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("law", IMPROPER, ids=repr)
def test_improper_laws_have_no_density(law):
    v = np.ones((2, 3))
    for ask in (
        lambda: law.log_density(v),
        lambda: law.sample(np.random.default_rng(0), 2, 3),
        lambda: law.covariance_factor(3),
        lambda: law.information_factor(3),
    ):
        with pytest.raises(ImproperLawError, match=type(law).__name__):
            ask()


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf])
def test_parameters_must_be_positive(law, bad):
    for field in dataclasses.fields(law):
        if isinstance(getattr(law, field.name), float):
            with pytest.raises(InvalidInputError, match=type(law).__name__):
                dataclasses.replace(law, **{field.name: bad})


@pytest.mark.parametrize("law", both_ways(PROPER), ids=repr)
def test_parameters_broadcast_over_chains(law):
    v = np.random.default_rng(9).normal(size=(4, 6, 2)) * 2.0
    names = [f.name for f in dataclasses.fields(law) if isinstance(getattr(law, f.name), float)]
    names = [name for name in names if name != "piecewise_at"]
    if not law.scale_mixture and law.log_normalizer.__func__.__qualname__.startswith("NoiseLaw"):
        names = ["scale"]  # normalised by quadrature: scalar shape parameters only
    if getattr(law, "piecewise_at", None) is not None:
        names = ["scale"]
    factors = np.array([0.9, 1.0, 1.1, 1.05])
    chains = {name: (getattr(law, name) * factors)[:, None] for name in names}
    together = dataclasses.replace(law, **chains)
    for k, factor in enumerate(factors):
        alone = dataclasses.replace(law, **{n: getattr(law, n) * factor for n in names})
        np.testing.assert_allclose(together.log_density(v)[k], alone.log_density(v[k]))
        np.testing.assert_allclose(together.weight(v)[k], alone.weight(v[k]))


@pytest.mark.parametrize("bad", [[3.0, 4.0], "four", None])
def test_parameters_must_be_numbers(bad):
    for make in (StudentT, Huber, Hyperbolic):
        with pytest.raises(InvalidInputError, match="must be a number"):
            make(bad)


def test_extreme_parameters_keep_their_digits():
    far = np.array([[30.0]])
    np.testing.assert_allclose(Contaminated(0.1, 1e9).weight(far), 1e-18, rtol=1e-9)
    near = np.array([[0.3, -1.0, 2.0]])
    gaussian = Gaussian().log_density(near)
    np.testing.assert_allclose(StudentT(1e15).log_density(near), gaussian, rtol=1e-9)


@pytest.mark.parametrize("law", both_ways(PROPER), ids=repr)
def test_same_seed_same_draws(law):
    first, second = (law.sample(np.random.default_rng(3), 50, 3) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert first.shape == (50, 3)


@pytest.mark.parametrize("law", both_ways(PROPER), ids=repr)
def test_slopes_by_parameters_are_finite_differences(law):
    law = dataclasses.replace(law, **unit(law))
    v = np.pad(np.random.default_rng(8).normal(size=(30, 2)) * 4.0, ((0, 0), (0, 1)))
    size = np.where(np.arange(30) % 2, 2, 1)
    v[size == 1, 1] = 0.0
    assert law.unit_name in law.supports
    for name, support in law.supports.items():
        value = float(getattr(law, name))
        assert support.holds(value)
        assert support.natural(support.free(value)) == pytest.approx(value)
        step = 1e-5 * value
        ends = [
            dataclasses.replace(law, **{name: value + s}).log_density(v, size)
            for s in (step, -step)
        ]
        slope = law.log_density_slope(name, v, size)
        expected = (ends[0] - ends[1]) / (2.0 * step)
        np.testing.assert_allclose(slope, expected, rtol=1e-6, atol=2e-8)
        many = dataclasses.replace(law, **{name: np.array([[value], [1.1 * value]])})
        both = many.log_density_slope(name, v, size)
        np.testing.assert_allclose(both[0], slope, rtol=1e-9, atol=1e-12)
        assert both.shape == (2, 30)
        free, eps = float(support.free(value)), 1e-6
        change = support.natural(free + eps) - support.natural(free - eps)
        assert support.slope(free) == pytest.approx(change / (2 * eps), rel=1e-6)


@pytest.mark.parametrize("law", PROPER, ids=repr)
@pytest.mark.parametrize("m", [1, 3])
def test_the_compiled_log_kernel_is_the_same_expression(law, m):
    kernel = compile_scalar(type(law).kernel_function)
    params = law.constants
    d2 = np.array([0.0, 0.3, 1.0, 4.0, 90.0, 1e4])
    # the same loop that applies weights
    found = apply_same(kernel, d2, float(m), params)
    np.testing.assert_allclose(found, law.log_kernel(d2, m), rtol=1e-12)
