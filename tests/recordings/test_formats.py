"""One door for every format: each is found by discovery, and knows its own files only."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from probreg import Radar2D, recordings
from probreg.discovery import public_classes
from probreg.errors import InvalidInputError
from probreg.recordings import Setup, correct, formats, restore, setup_file, table, write_changed
from probreg.recordings.formats import autoferry, known_formats
from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene
from tests.recordings.test_autoferry import TRUTH, detection, save


def test_each_file_is_of_one_format(tmp_path):
    (tmp_path / "scenario9").mkdir()
    save(tmp_path, [detection(3, [])], [TRUTH])
    mine = {"a.csv": "Csv", "a.PARQUET": "Parquet", "a.ast": "Asterix", "scenario9": "Autoferry"}
    assert set(mine.values()) <= set(public_classes(formats))
    for name, wanted in mine.items():
        found = [type(f).__name__ for f in known_formats() if f.recognises(tmp_path / name)]
        assert found == [wanted]
    for name in ("a.xls", "a", "scenario7", "."):
        with pytest.raises(InvalidInputError, match=r"none of .*\.csv, .*; convert it"):
            recordings.read(tmp_path / name, Setup((), {}))


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    scene = TrafficScene(reports=300, aircraft=10)
    reports, sensors, _ = demonstration(folder, np.random.default_rng(1), scene)
    return reports, setup_file.read(sensors)


def test_a_table_through_the_door_is_a_table(demo):
    reports, setup = demo
    found, wanted = recordings.read(reports, setup), table.read(reports, setup)
    np.testing.assert_array_equal(found.recording.values, wanted.recording.values)
    assert found.notes == wanted.notes
    assert (found.changed_ending, found.row_name(0)) == (".csv", wanted.row_name(0))
    assert found.row_name(0).startswith("line ")


def test_a_file_that_changed_since_it_was_read_is_not_rewritten(demo, tmp_path):
    reports, setup = demo
    path = shutil.copy(reports, tmp_path / "r.csv")
    source = recordings.read(path, setup)
    lines = path.read_text().splitlines()
    theta = np.zeros(len(recordings.bias_model(setup).names))
    for changed in (lines[:-1], [lines[0], *reversed(lines[1:])], [*lines, lines[1]]):
        path.write_text("\n".join(changed) + "\n")
        with pytest.raises(InvalidInputError, match=r"r\.csv"):
            write_changed(tmp_path / "out.csv", source, setup, theta, correct)
    assert not (tmp_path / "out.csv").exists()


def test_a_scenario_of_the_benchmark_comes_through_the_door(tmp_path):
    save(tmp_path, [detection(2, [3.0, 4.0]), detection(3, 0.25)], [TRUTH])
    setup = autoferry.setup()
    found = recordings.read(tmp_path / "scenario9", setup).recording
    wanted = autoferry.read(tmp_path, 9)
    np.testing.assert_array_equal(found.values, wanted.values)
    np.testing.assert_array_equal(found.own_position, wanted.own_position)
    assert found.sensors == setup.sensors
    with pytest.raises(InvalidInputError, match=r"scenario9: the sensors of the setup must be"):
        recordings.read(tmp_path / "scenario9", Setup(setup.sensors[:2], {}))


@pytest.fixture
def json_lines(tmp_path, monkeypatch):
    shutil.copy(Path(__file__).with_name("json_lines_format.py"), tmp_path / "json_lines.py")
    monkeypatch.setattr(formats, "__path__", [*formats.__path__, str(tmp_path)])
    known_formats.cache_clear()
    yield
    sys.modules.pop(f"{formats.__name__}.json_lines")
    vars(formats).pop("json_lines")
    known_formats.cache_clear()


@pytest.mark.usefixtures("json_lines")
def test_a_format_is_one_module(tmp_path):
    radars = tuple(Radar2D((x, 0.0), 20.0, 2e-3, name) for x, name in ((0.0, "a"), (9e3, "b")))
    setup = Setup(radars, {"a": ("range",), "b": ("time",)})
    rows = [
        {"sensor": "ab"[k % 2], "time": float(k), "values": [2e4 + k, 0.1 * k], "target": k % 3 - 1}
        for k in range(12)
    ]
    path = tmp_path / "r.jsonl"
    path.write_text("\n".join(map(json.dumps, rows)) + "\n")
    source = recordings.read(path, setup)
    assert (source.notes, source.row_name(3)) == (("12 lines",), "report 3")
    # what is only read is written as a new table, in the order of the new times
    theta = np.array([30.0, 2.5])
    write_changed(tmp_path / f"out{source.changed_ending}", source, setup, theta, correct)
    out = pd.read_csv(tmp_path / "out.csv", keep_default_na=False)
    wanted = pd.DataFrame(rows)
    wanted["range_m"] = [row["values"][0] - 30.0 * (row["sensor"] == "a") for row in rows]
    wanted["time"] -= 2.5 * (wanted.sensor == "b")
    wanted = wanted.sort_values("time")
    np.testing.assert_allclose(out.range_m, wanted.range_m)
    np.testing.assert_allclose(out.time_s, wanted.time)
    assert list(out.sensor) == list(wanted.sensor)
    assert list(out.target) == [["", "p", "q"][k + 1] for k in wanted.target]
    back = correct(source.recording, setup, theta)
    again = restore(back, setup, theta)
    np.testing.assert_allclose(again.values, source.recording.values)
