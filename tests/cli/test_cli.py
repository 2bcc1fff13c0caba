"""The command line: help, exit codes, one line for each bad input and nothing written."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import probreg
from probreg.cli import _terminal, app
from probreg.cli._terminal import DOING
from probreg.registration import STEPS, known_laws
from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene
from tests.page.conftest import command


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    reports, sensors, _ = demonstration(
        folder, np.random.default_rng(1), TrafficScene(reports=300, aircraft=10)
    )
    return reports.read_text(), sensors.read_text()


def test_version_and_help():
    runner = CliRunner()
    assert runner.invoke(app, ["--version"]).output.strip() == f"probreg {probreg.__version__}"
    for name in ("register", "correct", "restore", "simulate", "watch", "check", "history"):
        assert runner.invoke(app, [name, "--help"]).exit_code == 0
    text = " ".join(runner.invoke(app, ["register", "--help"]).output.split())
    assert "Exit codes: 0 done." in text
    assert "3 done, but with warnings that matter" in text
    assert all(name in text for name in known_laws())


def test_help_loads_nothing_that_computes():
    code = (
        "import sys, runpy; sys.argv = ['probreg', '--help']\n"
        "try: runpy.run_module('probreg', run_name='__main__')\n"
        "except SystemExit: print(*sorted(sys.modules))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(out.stdout.split())
    assert "typer" in loaded
    assert not {name.split(".")[0] for name in loaded} & {"numpy", "scipy", "numba", "matplotlib"}
    ours = {name for name in loaded if name.startswith("probreg")}
    assert ours == {
        "probreg",
        "probreg.cli",
        "probreg.cli._comparing",
        "probreg.cli._options",
        "probreg.cli._terminal",
        "probreg.cli._watching",
        "probreg.errors",
    }


@pytest.mark.parametrize(
    "arguments",
    [["register"], ["register", "x.csv", "--sensors", "s.toml"], ["nonsense"], ["simulate"]],
)
def test_wrong_usage_is_two(arguments):
    assert CliRunner().invoke(app, arguments).exit_code == 2


def run(folder, reports, sensors, *more, name="reports.csv"):
    (folder / name).write_bytes(reports if isinstance(reports, bytes) else reports.encode())
    (folder / "sensors.toml").write_text(sensors)
    inputs = [folder / name, "--sensors", folder / "sensors.toml", "--out", folder / "out", *more]
    return CliRunner().invoke(app, ["register", *map(str, inputs)])


def refusal(found, folder):
    """What a refused command said: one line on stderr, and nothing written."""
    assert found.exit_code == 1, found.output
    assert found.stdout == ""
    assert found.stderr.startswith("probreg: ")
    assert found.stderr.count("\n") == 1
    assert {path.name for path in folder.iterdir()} <= {"reports.csv", "r.parquet", "sensors.toml"}
    return found.stderr


def edited(text, change):
    from io import StringIO

    frame = pd.read_csv(StringIO(text))
    return change(frame).to_csv(index=False)


def cell(column, value):
    def change(frame):
        return frame.astype({column: object}).assign(**{column: [value, *frame[column].iloc[1:]]})

    return change


BAD_TABLES = {
    "no number": (cell("range_m", "far"), "line 2: range_m is 'far', no number"),
    "empty cell": (cell("range_m", ""), "range_m is empty"),
    "out of limits": (cell("azimuth_deg", 400.0), "azimuth_deg is 400"),
    "unknown sensor": (cell("sensor", "radar9"), "sensor is 'radar9'"),
    "no time": (cell("time_s", ""), "time_s is empty"),
    "missing column": (lambda f: f.drop(columns="range_m"), "column 'range_m' is missing"),
    "another unit": (lambda f: f.rename(columns={"range_m": "range_km"}), "'range_km'"),
    "no sensors": (lambda f: f.drop(columns="sensor"), "column 'sensor' is missing"),
    "no rows": (lambda f: f.iloc[:0], "no rows"),
    "radians": (lambda f: f.assign(azimuth_deg=np.deg2rad(f.azimuth_deg)), "radians"),
    "kilometres": (lambda f: f.assign(range_m=1e-3 * f.range_m), "kilometres"),
    "a row twice": (lambda f: pd.concat([f, f.iloc[:1]]), "repeats"),
    "silent sensor": (lambda f: f[f.sensor != "radar3"], "sensor 'radar3' has no report"),
    "other clock": (
        lambda f: f.assign(time_s=f.time_s + 1e6 * (f.sensor == "radar2")),
        "miss those of every other",
    ),
    "nothing in common": (
        lambda f: f.assign(target=f.sensor + f.target.astype(str)),
        "no target in common",
    ),
}


@pytest.mark.parametrize("name", BAD_TABLES)
def test_a_bad_table_is_one_line_and_no_result(demo, tmp_path, name):
    change, words = BAD_TABLES[name]
    assert words in refusal(run(tmp_path, edited(demo[0], change), demo[1]), tmp_path)


BAD_FILES = {
    "empty": (lambda text: b"", "is empty"),
    "semicolons": (lambda text: text.replace(",", ";").encode(), "not separated by commas"),
    "another encoding": (lambda text: text.encode("utf-16"), "not UTF-8"),
    "cut off": (lambda text: text[: int(0.6 * len(text))].rpartition(",")[0].encode(), "cut off"),
    "column twice": (lambda text: text.replace("range_m", "time_s", 1).encode(), "there twice"),
}


@pytest.mark.parametrize("name", BAD_FILES)
def test_a_bad_file_is_one_line_and_no_result(demo, tmp_path, name):
    change, words = BAD_FILES[name]
    assert words in refusal(run(tmp_path, change(demo[0]), demo[1]), tmp_path)


def test_a_damaged_parquet_file_is_one_line_and_no_result(demo, tmp_path):
    found = run(tmp_path, b"PAR1 and nothing else", demo[1], name="r.parquet")
    assert "no complete Parquet file" in refusal(found, tmp_path)


BAD_SETUPS = {
    "no TOML": (lambda text: "[[sensor", "is not TOML"),
    "unknown key": (lambda text: "gate_km = 1.0\n" + text, "unknown key 'gate_km'"),
    "no sensor": (lambda text: "window_s = 10.0", "no sensors"),
    "a name twice": (lambda text: text.replace('"radar2"', '"radar1"'), "is there twice"),
    "unknown bias": (lambda text: text.replace('"range", ', '"tilt", '), "has no bias 'tilt'"),
}


@pytest.mark.parametrize("name", BAD_SETUPS)
def test_a_bad_setup_is_one_line_and_no_result(demo, tmp_path, name):
    change, words = BAD_SETUPS[name]
    assert words in refusal(run(tmp_path, demo[0], change(demo[1])), tmp_path)


def test_missing_files_and_other_endings_are_one_line(demo, tmp_path):
    share = run(tmp_path, demo[0], demo[1], "--holdout", "1.5")
    assert "holdout 1.5" in refusal(share, tmp_path)
    (tmp_path / "reports.csv").unlink()
    inputs = [str(tmp_path / "reports.csv"), "--sensors", str(tmp_path / "sensors.toml")]
    found = CliRunner().invoke(app, ["register", *inputs, "--out", str(tmp_path / "out")])
    assert "reports.csv" in refusal(found, tmp_path)


def test_a_real_process_says_one_line_too(demo, tmp_path):
    (tmp_path / "reports.csv").write_text(demo[0].replace("range_m", "range_km"))
    (tmp_path / "sensors.toml").write_text(demo[1])
    found = command(
        *("register", tmp_path / "reports.csv", "--sensors", tmp_path / "sensors.toml"),
        *("--out", tmp_path / "out"),
    )
    assert (found.returncode, found.stdout) == (1, "")
    assert found.stderr.count("\n") == 1
    assert "Traceback" not in found.stderr
    assert not (tmp_path / "out").exists()


def test_a_folder_of_another_hand_is_refused_before_anything_is_computed(demo, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.txt").write_text("mine")
    found = run(tmp_path, demo[0], demo[1])
    assert found.exit_code == 1
    assert "not empty" in found.stderr
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.txt"]


@pytest.mark.parametrize("name", ["h5netcdf", "h5py"])
def test_without_an_engine_for_the_draws_nothing_is_computed(demo, tmp_path, name):
    (tmp_path / "reports.csv").write_text(demo[0])
    (tmp_path / "sensors.toml").write_text(demo[1])
    code = (
        f"import sys; sys.modules['{name}'] = None\n"
        "import probreg\nfrom probreg import registration, cli\n"
        "def register(*args, **more): raise SystemExit('computed')\n"
        "registration.register = register\ncli.main()"
    )
    words = ["register", "reports.csv", "--sensors", "sensors.toml", "--out", "out"]
    found = subprocess.run(
        [sys.executable, "-c", code, *words], cwd=tmp_path, capture_output=True, text=True
    )
    assert (found.returncode, found.stdout) == (1, "")
    assert found.stderr.startswith("probreg: posterior.nc could not be written")
    assert found.stderr.endswith("pip install h5netcdf h5py.\n")
    assert found.stderr.count("\n") == 1
    assert {path.name for path in tmp_path.iterdir()} == {"reports.csv", "sensors.toml"}


def test_the_check_of_the_engine_comes_before_the_estimation(demo, tmp_path, monkeypatch):
    """Negative control: with the engine there, the same chain does begin to compute."""
    monkeypatch.setattr("probreg.registration.register", lambda *a, **k: 1 / 0)
    assert isinstance(run(tmp_path, demo[0], demo[1]).exception, ZeroDivisionError)


def test_an_unknown_law_is_wrong_usage_that_lists_the_known(demo, tmp_path):
    found = run(tmp_path, demo[0], demo[1], "--law", "Cauchy")
    assert found.exit_code == 2
    assert all(name in found.stderr for name in known_laws())


def test_a_law_that_tracks_cannot_take_is_one_line_that_names_those_they_can(demo, tmp_path):
    said = refusal(run(tmp_path, demo[0], demo[1], "--law", "Huber"), tmp_path)
    assert "the law Huber is no sum of Gaussians" in said
    assert all(name in said for name in known_laws())
    assert "Huber" not in known_laws()


def test_every_step_of_a_registration_has_words():
    given = [step for step in DOING if step not in ("read", "terms", "report")]
    assert tuple(given) == STEPS
    assert next(iter(DOING)) == "read"
    assert tuple(DOING)[-2:] == ("terms", "report")


def test_warnings_that_matter_are_three(demo, tmp_path):
    strict = demo[1].replace('"azimuth"]', '"azimuth"]\nlimits = {range_m = 0.001}', 1)
    found = run(tmp_path, demo[0], strict, "--law", "StudentT")
    assert found.exit_code == 3, found.stderr
    assert "warning: radar1.range exceeds its limit of 0.001 m" in found.stderr
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_leaves_nothing_behind(demo, tmp_path, number):
    (tmp_path / "reports.csv").write_text(demo[0])
    (tmp_path / "sensors.toml").write_text(demo[1])
    arguments = ["register", "reports.csv", "--sensors", "sensors.toml", "--out", "out"]
    process = subprocess.Popen(
        [sys.executable, "-m", "probreg", *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.getcwd()},
        stderr=subprocess.PIPE,
        text=True,
    )
    # interrupted as soon as it has begun to work
    while process.poll() is None and not list(tmp_path.glob(".out.*.part")):
        time.sleep(0.01)
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said == "probreg: interrupted; nothing was written.\n"
    assert {path.name for path in tmp_path.iterdir()} == {"reports.csv", "sensors.toml"}


def test_an_interrupt_that_compiled_code_swallows_ends_the_run_at_the_next_step(monkeypatch):
    monkeypatch.setattr(_terminal, "_asked", [])
    with _terminal.progress(quiet=True, compare=False) as told:
        told("read")
        with contextlib.suppress(KeyboardInterrupt):  # as compiled code does
            _terminal.end_on(signal.SIGINT, None)
        with pytest.raises(KeyboardInterrupt):
            told("associate")


def test_further_bias_terms_are_compared(demo, tmp_path):
    found = run(tmp_path, demo[0], demo[1], "--law", "StudentT", "--compare")
    assert found.exit_code in (0, 3), found.stderr
    text = (tmp_path / "out" / "report.html").read_text()
    assert 'id="terms-table"' in text
    assert "with range_gain" in text
