"""One registration by the command line that the tests of the report share."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest


class Done(NamedTuple):
    """A finished command and where it worked."""

    code: int
    out: str
    err: str
    demo: Path
    result: Path


def command(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "probreg", *map(str, arguments)], capture_output=True, text=True
    )


@pytest.fixture(scope="session")
def done(tmp_path_factory):
    """`probreg simulate` and `probreg register`, as a newcomer types them."""
    demo = tmp_path_factory.mktemp("work") / "demo"
    first = command("simulate", "--out", demo, "--reports", 2_000, "--seed", 3)
    assert first.returncode == 0, first.stderr
    sensors = demo / "sensors.toml"
    text = sensors.read_text()
    # no radar's azimuth is five degrees off: a limit that is kept
    sensors.write_text(
        text.replace('name = "radar1"', 'name = "radar1"\nlimits = {azimuth_deg = 5.0}', 1)
    )
    result = demo / "result"
    second = command("register", demo / "reports.csv", "--sensors", sensors, "--out", result)
    return Done(second.returncode, second.stdout, second.stderr, demo, result)
