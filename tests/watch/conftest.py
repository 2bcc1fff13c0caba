"""A short recording that was watched to its end, and copies of it to watch again."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene
from probreg.watch import run
from probreg.watch.run import watch
from tests.watch.kill_often import task


@pytest.fixture
def at_once(monkeypatch):
    """Every slice is saved, as in a recording that is no faster than time."""
    monkeypatch.setattr(run, "SAVE_S", 0.0)


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    scene = TrafficScene(reports=2_000, aircraft=20)
    demonstration(folder, np.random.default_rng(1), scene)
    list(watch(task(folder, folder / "reports.csv", "whole")))
    return folder


@pytest.fixture
def work(demo, tmp_path):
    for name in ("reports.csv", "sensors.toml"):
        (tmp_path / name).write_bytes((demo / name).read_bytes())
    return tmp_path
