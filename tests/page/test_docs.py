"""What the documents show works as they show it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
from typer.testing import CliRunner

from probreg.cli import app
from probreg.recordings import bias_model, setup_file

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "docs" / "register.md").read_text(encoding="utf-8")


def blocks(text, language):
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def test_the_annotated_sensors_are_read():
    (text,) = blocks(GUIDE, "toml")
    setup = setup_file.parse(tomllib.loads(text))
    assert [sensor.name for sensor in setup.sensors] == ["north radar", "south radar", "adsb"]
    assert setup.limits["north radar.azimuth"] == np.deg2rad(0.2)
    assert "north radar.time" in bias_model(setup).names
    assert not setup.biases["adsb"]


def test_the_commands_and_the_script_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    commands, quick = (
        [line for block in blocks(text, "sh") for line in block.splitlines()]
        for text in (GUIDE, readme)
    )
    assert len(commands) == 4
    assert quick == commands[:2]
    for line in commands:
        program, *arguments = line.split()
        assert program == "probreg"
        found = CliRunner().invoke(app, arguments)
        assert found.exit_code == 0, found.output
    (script,) = blocks(GUIDE, "python")
    exec(compile(script, "register.md", "exec"), {})
    command, script = (
        (tmp_path / "demo" / name / "biases.csv").read_text() for name in ("result", "from_python")
    )
    assert command == script
    before, back = (Path(f"demo/{name}.csv").read_text() for name in ("reports", "back"))
    assert before.splitlines()[0] == back.splitlines()[0]


def test_the_commands_of_the_watch_are_commands():
    text = (ROOT / "docs" / "watch.md").read_text(encoding="utf-8")
    lines = [line.split() for block in blocks(text, "sh") for line in block.splitlines()]
    assert {line[1] for line in lines} == {"simulate", "watch", "check", "history"}
    for program, name, *given in lines:
        assert program == "probreg"
        told = CliRunner(env={"COLUMNS": "200"}).invoke(app, [name, "--help"]).output
        assert all(word in told for word in given if word.startswith("--"))
