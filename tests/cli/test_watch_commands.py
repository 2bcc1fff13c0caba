"""The commands watch, check and history as a user types them."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from typer.testing import CliRunner

from probreg.cli import app
from probreg.cli._watching import _seconds
from probreg.errors import InvalidInputError
from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene
from tests.registration.test_saved import COVARIANCE, write
from tests.watch import mean_engine


@pytest.fixture
def demo(tmp_path):
    scene = TrafficScene(reports=1_500, aircraft=15)
    demonstration(tmp_path, np.random.default_rng(1), scene)
    return tmp_path


@pytest.fixture
def quick(monkeypatch):
    """The stand-in that computes nothing but means."""
    import probreg.watch

    for name in ("begin", "advance", "to_arrays", "from_arrays"):
        monkeypatch.setattr(probreg.watch, name, getattr(mean_engine, name))


def watch(folder, *more, out="out"):
    words = ["watch", folder / "reports.csv", "--sensors", folder / "sensors.toml"]
    words += ["--out", folder / out, "--start", 40, "--patience", 0, *more]
    return CliRunner().invoke(app, list(map(str, words)))


FILES = {"state.npz", "journal.jsonl", "watch.html", "manifest.json", "lock"}


@pytest.mark.usefixtures("quick")
def test_a_watch_leaves_a_page_a_journal_and_a_state(demo):
    found = watch(demo)
    assert found.exit_code == 0, found.output
    assert {path.name for path in (demo / "out").iterdir()} == FILES
    assert found.stdout.startswith("until ")
    manifest = json.loads((demo / "out" / "manifest.json").read_text())
    assert (manifest["program"], manifest["command"]) == ("probreg", "watch")
    journal = (demo / "out" / "journal.jsonl").read_bytes()
    assert "http-equiv" not in (demo / "out" / "watch.html").read_text()
    # again: nothing is new
    assert watch(demo).exit_code == 0
    assert (demo / "out" / "journal.jsonl").read_bytes() == journal


@pytest.mark.usefixtures("quick")
def test_alarms_are_three_and_said_in_one_line(demo):
    rows = (demo / "reports.csv").read_text().splitlines()
    column, late = rows[0].split(",").index("range_m"), rows[1200].split(",")
    late[column] = "950000.0"
    rows[1200] = ",".join(late)
    (demo / "reports.csv").write_text("\n".join(rows) + "\n")
    found = watch(demo)
    assert found.exit_code == 3, found.output
    (line,) = found.stderr.splitlines()
    assert line.startswith("alarm: radar1.range changed by 1.00 m (sd 0.10) since ")
    assert watch(demo, "--quiet", out="other").stderr == ""


@pytest.mark.usefixtures("quick")
def test_bad_input_is_one_line_and_leaves_what_was_there(demo):
    assert watch(demo, "--until", "100").exit_code == 0
    before = {p.name: p.read_bytes() for p in (demo / "out").iterdir()}
    for more, words in (
        (("--slice", "5"), "slice_s was 10.0, and is 5.0"),
        (("--until", "noon"), "'noon' is neither seconds nor ISO 8601"),
        (("--slice", "-1"), "--slice is -1"),
        (("--false-alarms-per-day", "0"), "false_alarms_per_day"),
    ):
        found = watch(demo, *more)
        assert (found.exit_code, found.stdout) == (1, "")
        assert found.stderr.count("\n") == 1
        assert words in found.stderr
    assert {p.name: p.read_bytes() for p in (demo / "out").iterdir()} == before
    (demo / "mine").mkdir()
    (demo / "mine" / "thesis.txt").write_text("mine")
    found = watch(demo, out="mine")
    assert "holds no result of `probreg watch`" in found.stderr
    (demo / "reports.csv").unlink()
    assert "no such file" in watch(demo, out="third").stderr


def test_times_are_seconds_or_dates():
    assert _seconds("12.5") == 12.5
    assert _seconds("2023-11-14T22:13:20Z") == _seconds("2023-11-14T22:13:20") == 1.7e9
    with pytest.raises(InvalidInputError):
        _seconds("")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_a_watch_and_the_next_one_goes_on(demo, number):
    code = (
        "import probreg.watch\nfrom tests.watch import mean_engine\n"
        "for name in ('begin', 'advance', 'to_arrays', 'from_arrays'):\n"
        "    setattr(probreg.watch, name, getattr(mean_engine, name))\n"
        "from probreg import cli\ncli.main()"
    )
    words = ["watch", "reports.csv", "--sensors", "sensors.toml", "--out", "out", "--start", "40"]
    process = subprocess.Popen(
        [sys.executable, "-c", code, *words],
        cwd=demo,
        env={**os.environ, "PYTHONPATH": os.getcwd()},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    while process.poll() is None and not (demo / "out" / "watch.html").exists():
        time.sleep(0.02)
    process.send_signal(number)
    out, said = process.communicate(timeout=60)
    assert (process.returncode, said) == (0, "")
    assert "interrupted; the state is saved, the same command goes on." in out
    assert {path.name for path in (demo / "out").iterdir()} == FILES


@pytest.fixture
def results(tmp_path):
    write(tmp_path / "old", [10.0, 0.002], COVARIANCE, limits=(None, 0.004))
    write(tmp_path / "same", [11.0, 0.001], COVARIANCE, limits=(None, 0.004))
    write(tmp_path / "new", [60.0, 0.012], COVARIANCE, limits=(None, 0.004))
    return tmp_path


def check(folder, new, *more):
    words = ["check", folder / "old", folder / new, *more]
    return CliRunner().invoke(app, list(map(str, words)))


def test_check_says_what_changed(results):
    found = check(results, "same")
    assert found.exit_code == 0, found.output
    assert found.stderr == ""
    found = check(results, "new", "--json", results / "d.json")
    assert found.exit_code == 3
    first, second = found.stderr.splitlines()
    assert first.startswith("warning: a.range changed (probability above 99.9")
    assert second.startswith("warning: a.azimuth changed by more than 0.229183 deg (probability")
    line = next(line for line in found.stdout.splitlines() if line.startswith("a.range"))
    assert "+50.0 m" in line
    assert "90 %: +45.3 to +54.7" in line
    content = json.loads((results / "d.json").read_text())
    assert content["differences"][0]["difference"] == 50.0
    assert content["differences"][0]["limit"] is None
    # a limit that is kept is no warning
    found = check(results, "new", "--limit", "range=80", "--limit", "a.azimuth=1")
    assert (found.exit_code, found.stderr) == (0, "")
    assert "by more than 80 m: below 0.1" in found.stdout


def test_check_refuses_what_cannot_be_compared(results):
    for new, more, words in (
        ("nowhere", (), "cannot be read"),
        ("same", ("--limit", "tilt=1"), "--limit 'tilt=1' is not NAME=NUMBER"),
        ("same", ("--limit", "range"), "--limit 'range' is not NAME=NUMBER"),
    ):
        found = check(results, new, *more)
        assert (found.exit_code, found.stdout) == (1, "")
        assert words in found.stderr


def test_history_of_many_results(results):
    found = CliRunner().invoke(app, ["history", str(results), "--out", str(results / "h")])
    assert found.exit_code == 0, found.output
    names = {path.name for path in (results / "h").iterdir()}
    assert names == {"history.html", "history.json", "history.csv", "pooled.csv", "manifest.json"}
    shutil.rmtree(results / "old")
    shutil.rmtree(results / "new")
    found = CliRunner().invoke(app, ["history", str(results), "--out", str(results / "i")])
    assert (found.exit_code, found.stdout) == (1, "")
    assert "1 folders with a biases.json; two or more" in found.stderr
    assert not (results / "i").exists()
