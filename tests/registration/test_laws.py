"""Laws that registration knows: by discovery, with the priors that their own files give."""

from __future__ import annotations

import importlib
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import probreg.noise
from probreg.cli import app
from probreg.noise import Contaminated, Gaussian, StudentT
from probreg.prior import NoiseParameter
from probreg.registration import LAWS, LawChoice, known_laws, register
from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene, simulate

LOG_COSH = '''
from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from probreg.noise import NoiseLaw


def _weight(d2, m, params):
    d = np.sqrt(d2) + 1e-12
    return np.tanh(d) / d


def _log_kernel(d2, m, params):
    d = np.sqrt(d2)
    return -(d + np.log1p(np.exp(-2.0 * d)) - np.log(2.0))


@dataclass(frozen=True)
class LogCosh(NoiseLaw):
    """Density proportional to 1 / cosh(d)."""

    _: KW_ONLY
    scale: Any = 1.0
    componentwise: bool = False

    weight_function = staticmethod(_weight)
    kernel_function = staticmethod(_log_kernel)

    def sample_unit(self, rng, n, m):
        raise AssertionError("registration simulates no noise")
'''


@pytest.fixture
def log_cosh(tmp_path, monkeypatch):
    """A law whose file lies where those of `probreg.noise` lie, and that nothing else names."""
    folder = tmp_path / "laws"
    folder.mkdir()
    (folder / "log_cosh.py").write_text(LOG_COSH)
    monkeypatch.setattr(probreg.noise, "__path__", [*probreg.noise.__path__, str(folder)])
    importlib.invalidate_caches()
    yield
    sys.modules.pop("probreg.noise.log_cosh", None)
    probreg.noise.__dict__.pop("log_cosh", None)


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    scene = TrafficScene(reports=300, aircraft=10)
    reports, sensors, _ = demonstration(folder, np.random.default_rng(1), scene)
    return ["register", str(reports), "--sensors", str(sensors), "--out"]


def test_the_laws_compared_by_default():
    # in this order: each takes its random numbers after the one before it
    assert (
        LawChoice(
            StudentT(4.0), (NoiseParameter("nu", 4.0, 1.0), NoiseParameter("scale", 1.0, 0.5))
        ),
        LawChoice(
            Contaminated(0.1, 10.0),
            (
                NoiseParameter("rate", 0.1, 1.0),
                NoiseParameter("scale", 10.0, 0.7),
                NoiseParameter("core_scale", 1.0, 0.5),
            ),
        ),
        LawChoice(Gaussian(), (NoiseParameter("scale", 1.0, 0.5),)),
    ) == LAWS


def test_proper_laws_are_known_and_rejection_rules_are_not():
    known = known_laws()
    assert set(known) == {"Contaminated", "Gaussian", "Huber", "Hyperbolic", "StudentT"}
    for choice in known.values():
        for parameter in choice.unknown:
            parameter.check(choice.law)


@pytest.mark.parametrize("name", ["Huber", "Hyperbolic"])
def test_laws_outside_the_comparison_register_too(name):
    recording, setup, truth = simulate(TrafficScene(1_500), np.random.default_rng(5))
    rng = np.random.default_rng(6)
    found = register(recording, setup, rng=rng, laws=[known_laws()[name]])
    assert [law.name for law in found.laws] == [name]
    assert found.draws.names[-1] == "noise.scale"
    wanted = np.array([truth.bias[name] for name in found.names])
    # 6 biases at 4.5 posterior standard deviations: false alarm about 1e-4
    assert (np.abs(found.mean - wanted) < 4.5 * found.sd).all()


def test_a_file_of_a_new_law_is_all_that_the_command_needs(log_cosh, demo, tmp_path):
    out = tmp_path / "out"
    found = CliRunner().invoke(app, [*demo, str(out), "--law", "LogCosh"])
    assert found.exit_code in (0, 3), found.output
    assert "Parameters of the noise law LogCosh." in (out / "report.html").read_text()
    told = " ".join(CliRunner().invoke(app, ["register", "--help"]).output.split())
    assert "LogCosh" in told


def test_without_its_file_the_law_is_unknown(demo, tmp_path):
    found = CliRunner().invoke(app, [*demo, str(tmp_path / "out"), "--law", "LogCosh"])
    assert found.exit_code == 2
    assert all(name in found.stderr for name in known_laws())
    assert not (tmp_path / "out").exists()
