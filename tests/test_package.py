"""What `import probreg` offers, and that it loads nothing before it is used."""

from __future__ import annotations

import ast
import inspect
import pkgutil
import subprocess
import sys

import pytest

import probreg


def loaded_by(code):
    """Modules that a fresh interpreter has after a statement, without those it starts with."""
    script = f"import sys; before = set(sys.modules); {code}; print(*set(sys.modules) - before)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


def packages(names):
    return {name.split(".")[0] for name in names}


FOLDERS = {entry.name for entry in pkgutil.iter_modules(probreg.__path__) if entry.ispkg}
USERS = ("register", "Recording", "Setup", "Trajectory", "NoiseParameter", "Posterior", "Radar2D")


def test_import_probreg_loads_nothing_but_the_standard_library():
    found = loaded_by("import probreg")
    assert packages(found) <= {"probreg"} | sys.stdlib_module_names
    assert {name for name in found if name.startswith("probreg")} == {"probreg"}


@pytest.mark.parametrize("name", ["errors", "extras"])
def test_errors_cost_nothing(name):
    assert packages(loaded_by(f"import probreg.{name}")) <= {"probreg"} | sys.stdlib_module_names


def test_noise_laws_load_no_compiler_until_a_weight_is_asked_for():
    code = "from probreg import noise; noise.StudentT(4.0).sample_unit"
    assert "numba" not in loaded_by(code)
    # negative control: the same probe sees the compiler once there is a weight
    assert "numba" in loaded_by("from probreg import noise; noise.StudentT(4.0).weight([[1.0]])")


def test_what_registers_needs_neither_torch_nor_pyro():
    found = loaded_by(
        "import probreg.page, probreg.samplers.paths, probreg.joint; probreg.register"
    )
    assert "probreg.samplers.nuts" in found
    assert not packages(found) & {"torch", "pyro", "asterix"}


@pytest.mark.parametrize("name", probreg.__all__)
def test_every_name_is_there(name):
    value = getattr(probreg, name)
    assert name == "__version__" or value.__module__.startswith("probreg.")
    assert name in dir(probreg)


def test_names_are_offered_before_they_are_loaded():
    done = subprocess.run(
        [sys.executable, "-c", "import probreg; print(*dir(probreg))"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert set(done.stdout.split()) >= {*USERS, *FOLDERS, *probreg.__all__}


@pytest.mark.parametrize("name", sorted(FOLDERS))
def test_folders_are_there_after_import_probreg(name):
    code = f"import sys, probreg; assert probreg.{name} is sys.modules['probreg.{name}']"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_former_name_is_the_same_class():
    assert probreg.RegistrationProblem is probreg.LinearProblem


@pytest.mark.parametrize("name", ["Radar4D", "registrate", "_private", "__wrapped__"])
def test_another_name_is_an_attribute_error(name):
    with pytest.raises(AttributeError, match=f"'probreg' has no attribute '{name}'"):
        getattr(probreg, name)


def _told_to_type_checkers():
    """Names and where they come from, in the block under TYPE_CHECKING."""
    body = ast.parse(inspect.getsource(probreg)).body
    (block,) = (node for node in body if isinstance(node, ast.If))
    return {
        alias.name: node.module
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


def test_type_checkers_are_told_what_is_loaded():
    told = _told_to_type_checkers()
    assert {name for name, module in told.items() if module == "probreg"} == FOLDERS
    names = set(probreg.__all__) - {"__version__", "RegistrationProblem"}
    assert set(told) - FOLDERS == names
    for name in names:
        assert getattr(sys.modules[told[name]], name) is getattr(probreg, name)


def test_a_star_import_gives_the_public_names():
    found = {}
    exec("from probreg import *", found)
    assert set(probreg.__all__) <= set(found)
