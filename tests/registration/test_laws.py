"""Laws that registration knows: by discovery, with the priors that their own files give."""

from __future__ import annotations

import importlib
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import probreg.noise
from probreg.cli import app
from probreg.errors import InvalidInputError
from probreg.noise import Contaminated, Gaussian, Huber, StudentT
from probreg.prior import NoiseParameter
from probreg.registration import LAWS, LawChoice, known_laws, register
from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene, simulate

THREE_SCALES = '''
from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from probreg.noise import Gaussian, Mixture, ScaleMixture


@dataclass(frozen=True)
class ThreeScales(ScaleMixture):
    """Good, worse and bad rows in fixed shares."""

    _: KW_ONLY
    scale: Any = 1.0
    componentwise: bool = False

    weight_function = staticmethod(Gaussian.weight_function)
    kernel_function = staticmethod(Gaussian.kernel_function)

    def unit_mixture(self, m):
        return Mixture(np.array([0.85, 0.1, 0.05]), np.array([1.0, 9.0, 81.0]))

    def draw_unit_precision(self, rng, d2, m):
        raise AssertionError("tracks draw from the mixture")

    def sample_unit(self, rng, n, m):
        raise AssertionError("registration simulates no noise")
'''


@pytest.fixture
def three_scales(tmp_path, monkeypatch):
    """A law whose file lies where those of `probreg.noise` lie, and that nothing else names."""
    folder = tmp_path / "laws"
    folder.mkdir()
    (folder / "three_scales.py").write_text(THREE_SCALES)
    monkeypatch.setattr(probreg.noise, "__path__", [*probreg.noise.__path__, str(folder)])
    importlib.invalidate_caches()
    yield
    sys.modules.pop("probreg.noise.three_scales", None)
    probreg.noise.__dict__.pop("three_scales", None)


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    scene = TrafficScene(reports=300, aircraft=10)
    reports, sensors, _ = demonstration(folder, np.random.default_rng(1), scene)
    return ["register", str(reports), "--sensors", str(sensors), "--out"]


def test_the_laws_compared_by_default_the_simplest_first():
    assert (
        LawChoice(Gaussian(), (NoiseParameter("scale", 1.0, 0.5),)),
        LawChoice(
            Contaminated(0.1, 10.0),
            (
                NoiseParameter("rate", 0.1, 1.0),
                NoiseParameter("scale", 10.0, 0.7),
                NoiseParameter("core_scale", 1.0, 0.5),
            ),
        ),
        LawChoice(
            StudentT(4.0), (NoiseParameter("nu", 4.0, 1.0), NoiseParameter("scale", 1.0, 0.5))
        ),
    ) == LAWS


def test_sums_of_gaussians_are_known_and_others_are_not():
    known = known_laws()
    assert set(known) == {"Contaminated", "Gaussian", "Hyperbolic", "StudentT"}
    for choice in known.values():
        for parameter in choice.unknown:
            parameter.check(choice.law)


@pytest.mark.parametrize("law", [Huber(), StudentT(componentwise=True)], ids=str)
def test_other_laws_are_refused_with_those_to_take(law):
    recording, setup, _ = simulate(TrafficScene(300), np.random.default_rng(5))
    with pytest.raises(InvalidInputError, match="no sum of Gaussians.*take Contaminated"):
        register(recording, setup, rng=np.random.default_rng(6), laws=[LawChoice.usual(law)])


def test_of_laws_as_good_the_simplest_is_taken():
    recording, setup, _ = simulate(TrafficScene(1_500), np.random.default_rng(5))
    found = register(recording, setup, rng=np.random.default_rng(6))
    assert found.law == "Gaussian"
    assert {law.name for law in found.laws} == {"Gaussian", "Contaminated", "StudentT"}
    assert max(law.behind for law in found.laws) < 40.0


@pytest.mark.parametrize("name", ["StudentT", "Hyperbolic"])
def test_laws_outside_the_comparison_register_too(name):
    recording, setup, truth = simulate(TrafficScene(1_500), np.random.default_rng(5))
    rng = np.random.default_rng(6)
    found = register(recording, setup, rng=rng, laws=[known_laws()[name]])
    assert [law.name for law in found.laws] == [name]
    wanted = np.array([truth.bias[name] for name in found.names])
    # 6 biases at 4.5 posterior standard deviations: false alarm about 1e-4
    assert (np.abs(found.mean - wanted) < 4.5 * found.sd).all()


def test_a_file_of_a_new_law_is_all_that_the_command_needs(three_scales, demo, tmp_path):
    out = tmp_path / "out"
    found = CliRunner().invoke(app, [*demo, str(out), "--law", "ThreeScales"])
    assert found.exit_code in (0, 3), found.output
    assert "ThreeScales" in (out / "report.html").read_text()
    told = " ".join(CliRunner().invoke(app, ["register", "--help"]).output.split())
    assert "ThreeScales" in told


def test_without_its_file_the_law_is_unknown(demo, tmp_path):
    found = CliRunner().invoke(app, [*demo, str(tmp_path / "out"), "--law", "ThreeScales"])
    assert found.exit_code == 2
    assert all(name in found.stderr for name in known_laws())
    assert not (tmp_path / "out").exists()
