"""What is imported is declared, what is declared is locked, and extras are asked for by name."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import numpy as np
import pytest

from probreg import LinearProblem, Posterior, extras
from probreg.errors import InvalidInputError, MissingExtraError
from probreg.noise import Gaussian
from probreg.samplers import Nuts
from probreg.samplers.paths import NutsPath
from tests.page.conftest import command

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
LOCKS = [ROOT / "requirements.lock", ROOT / "requirements-cuda.lock"]
PARTS = {"arviz-stats": "arviz"}  # a package of arviz from 1.0


def plain(name):
    return re.split(r"[<>=!~;\[ ]", name)[0].lower().replace("_", "-")


def extra(name):
    """Packages of an extra, those of the extras that it names included."""
    found = set()
    for line in PROJECT["optional-dependencies"][name]:
        inner = re.fullmatch(r"probreg\[(.*)\]", line)
        found |= set().union(*map(extra, inner[1].split(","))) if inner else {plain(line)}
    return found


CORE = {plain(line) for line in PROJECT["dependencies"]}


def imported(path, *, at_once=False):
    """Top-level names that a file imports; `at_once`, those outside functions and classes only."""
    tree = ast.parse(path.read_text())
    for node in tree.body if at_once else ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module.split(".")[0]
        elif isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)


def third_party(folder):
    """Distributions that a folder's files import."""
    own = {"probreg", "experiments", "paper_figs", "tests", "crowded"} | sys.stdlib_module_names
    names = {name for path in (ROOT / folder).rglob("*.py") for name in imported(path)} - own
    known = packages_distributions()
    found = {plain(known.get(name, [name])[0]) for name in names}
    return {PARTS.get(plain(name), plain(name)) for name in found}


@pytest.mark.parametrize(
    ("folder", "declared"),
    [
        ("probreg", CORE | extra("asterix") | extra("nuts")),
        ("experiments", CORE | extra("studies")),
        ("paper_figs", CORE | extra("studies")),
    ],
)
def test_what_is_imported_is_declared(folder, declared):
    assert third_party(folder) <= declared


def test_what_is_declared_is_used():
    """But for h5py, without which h5netcdf cannot write."""
    assert CORE - third_party("probreg") == {"h5py"}
    used = third_party("experiments") | third_party("paper_figs") | third_party("benchmarks")
    assert extra("studies") <= used


def test_extras_are_those_of_the_project_file():
    for name, modules in extras.EXTRAS.items():
        assert extra(name) == set(modules.values())
        assert extra(name) <= extra("all") <= extra("dev")
    assert extra("studies") <= extra("all")


@pytest.mark.parametrize(
    "path", sorted((ROOT / "probreg").rglob("*.py")), ids=lambda p: str(p.relative_to(ROOT))
)
def test_extras_are_imported_inside_functions_only(path):
    optional = {module for modules in extras.EXTRAS.values() for module in modules}
    assert not set(imported(path, at_once=True)) & optional


def entries(path):
    """Each pinned version with its hashes."""
    text = path.read_text().replace("\\\n", "")
    return [line for line in text.splitlines() if line and not line.startswith("#")]


@pytest.mark.parametrize("path", LOCKS, ids=lambda p: p.name)
def test_every_entry_of_the_lock_has_hashes_and_none_says_where_from(path):
    assert entries(path)
    for entry in entries(path):
        assert re.match(r"[a-z0-9-]+==[^ ]+ .*--hash=sha256:[0-9a-f]{64}", entry)
    assert not re.search(r"://|index-url|find-links|(^|\s)/", path.read_text())


def test_the_lock_has_everything_that_is_declared():
    locked = {plain(entry) for entry in entries(LOCKS[0])}
    assert CORE | extra("dev") <= locked


def _hide(monkeypatch, *names):
    for name in names:
        monkeypatch.setitem(sys.modules, name, None)


def _posterior():
    rng = np.random.default_rng(1)
    B = rng.standard_normal((20, 2, 2))
    problem = LinearProblem(rng.standard_normal((20, 2)), B, np.broadcast_to(np.eye(2), (20, 2, 2)))
    return Posterior(problem, Gaussian())


@pytest.mark.parametrize(
    ("hidden", "packages"),
    [
        (["torch", "pyro"], "torch and pyro-ppl"),
        (["pyro"], "pyro-ppl"),
    ],
)
@pytest.mark.parametrize(
    ("who", "ask"),
    [
        ("Nuts", lambda: Nuts().sample(_posterior(), 100, 2, np.random.default_rng(1))),
        ("NutsPath", lambda: NutsPath().sample(None, 100, 2, np.random.default_rng(1))),
        ("A Pyro model", lambda: _posterior().to_pyro()),
    ],
)
def test_nuts_without_its_packages_is_one_sentence(monkeypatch, hidden, packages, who, ask):
    _hide(monkeypatch, *hidden)
    with pytest.raises(MissingExtraError) as caught:
        ask()
    assert isinstance(caught.value, InvalidInputError)
    assert str(caught.value) == (
        f"{who} needs {packages}, not installed here: pip install 'probreg[nuts]'."
    )


def test_other_samplers_are_there_without_torch():
    code = (
        "import sys; sys.modules.update(torch=None, pyro=None)\n"
        "from probreg.samplers import Nuts\nimport probreg.samplers.paths\nprint(Nuts())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.startswith("Nuts("), done.stderr


def test_the_version_is_in_one_place():
    assert "version" in PROJECT["dynamic"]
    assert not re.search(r"^version:", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    said = command("--version").stdout
    assert re.fullmatch(r"probreg \d+\.\d+\.\d+(\.?\w+)?\n", said)
