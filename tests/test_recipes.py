"""The recipes of docs/design.md, each followed in a copy of the project."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
RECIPES = ROOT / "docs" / "recipes"
PARTS = ("probreg", "experiments", "paper_figs", "tests")
# what to run for each addition; the words must stand in what it prints
CONFORM = "tests/conformance/test_{}.py".format
PYTEST = ("-m", "pytest", "-vv")
RUNS = {
    "noise law": ((*PYTEST, CONFORM("noise_laws"), "-k", "LogCosh"), "LogCosh"),
    "estimator": ((*PYTEST, CONFORM("estimators"), "-k", "TrimmedFit"), "TrimmedFit"),
    "sampler": ((*PYTEST, CONFORM("samplers"), "-k", "Independence"), "Independence"),
    "bias term": (
        (*PYTEST, CONFORM("terms"), "tests/sensors/test_range_square.py"),
        "test_range_square",
    ),
    "sensor kind": ((*PYTEST, CONFORM("sensors"), "-k", "lidar2d"), "lidar2d"),
    "format": (
        (*PYTEST, "tests/recordings/test_formats.py", "tests/recordings/test_ndjson.py"),
        "test_ndjson",
    ),
    "study": (("-m", "experiments", "run", "median_error"), "median_error"),
    "figure": (("-m", "paper_figs", "median_error"), "median_error.pdf"),
}


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    folder = tmp_path_factory.mktemp("copy")
    shutil.copy(ROOT / "pyproject.toml", folder)
    for part in PARTS:
        left_out = shutil.ignore_patterns("results", "out")
        shutil.copytree(ROOT / part, folder / part, ignore=left_out)
    shutil.copytree(RECIPES, folder, dirs_exist_ok=True)
    return folder


def run(folder, words):
    known = {**os.environ, "PYTHONPATH": str(folder)}
    return subprocess.run(
        [sys.executable, *words], cwd=folder, env=known, capture_output=True, text=True
    )


@pytest.mark.parametrize("name", RUNS)
def test_a_recipe_works_by_its_own_files(copy, name):
    words, wanted = RUNS[name]
    found = run(copy, words)
    assert found.returncode == 0, found.stdout + found.stderr
    assert wanted in found.stdout
    assert "pytest" not in words or " passed" in found.stdout


def test_without_its_file_nothing_is_found(copy, tmp_path):
    """Negative control: the runs above see the recipes and nothing else of that name."""
    for word in ("LogCosh", "lidar2d", "median_error"):
        own = [p for p in ROOT.joinpath("probreg").rglob("*.py") if word in p.read_text()]
        assert not own
    found = run(ROOT, ["-m", "experiments", "run", "median_error", "--results", str(tmp_path)])
    assert found.returncode == 1
    assert "no study 'median_error'" in found.stderr


def test_every_recipe_is_in_the_docs():
    text = (ROOT / "docs" / "design.md").read_text()
    for path in RECIPES.rglob("*.py"):
        assert f"recipes/{path.relative_to(RECIPES).as_posix()}" in text
