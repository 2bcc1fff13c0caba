"""Recordings that grow: however they are cut and interrupted, each report comes once."""

from __future__ import annotations

import dataclasses
import io
import os
import time

import numpy as np
import pandas as pd
import pytest

from probreg import recordings
from probreg.errors import InvalidInputError
from probreg.recordings import Setup, growing, setup_file, table
from probreg.recordings._arrivals import joined
from probreg.recordings.growing import Buffer, GrowingInput, Position, arrive, cut, follow
from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene
from probreg.sensors import Radar2D
from tests.recordings import test_asterix as asterix_bytes


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    scene = TrafficScene(reports=300, aircraft=10)
    reports, sensors, _ = demonstration(folder, np.random.default_rng(1), scene)
    return reports.read_bytes(), setup_file.read(sensors)


def drain(source, position, setup, fixed=False):
    """Everything that there is, and the position after it; by way of JSON, as a state has it."""
    found = []
    while True:
        look = source.look(Position.from_json(position.to_json()), setup, fixed=fixed)
        if look.position == position:
            return found, position, look.waiting
        position = look.position
        if look.arrivals is not None:
            found.append(look.arrivals)
            setup = look.arrivals.setup


def rows(found):
    """What came, as one row a report, in order."""
    return [
        (part.arrays["sensor"][k], part.arrays["time"][k], *part.arrays["values"][k],
         part.labels[part.arrays["target"][k]])
        for part in found for k in range(len(part))
    ]  # fmt: skip


def whole(content, setup, folder):
    """The same by the reader of complete files, in the order of the rows."""
    path = folder / "whole.csv"
    path.write_bytes(content)
    read = table.read(path, setup)
    order = np.argsort(read.rows)
    recording = read.recording
    return [
        (recording.sensor[k], recording.time[k], *recording.values[k],
         recording.labels[recording.target[k]])
        for k in order
    ]  # fmt: skip


def test_a_table_cut_at_any_byte_comes_whole_and_once(demo, tmp_path):
    content, setup = demo
    path, rng = tmp_path / "r.csv", np.random.default_rng(2)
    cuts = np.sort(rng.choice(len(content), 40, replace=False)).tolist()
    path.write_bytes(b"")
    found, position = [], Position()
    for start, end in zip([0, *cuts], [*cuts, len(content)], strict=True):
        with path.open("ab") as file:
            file.write(content[start:end])
        # a new source each time, as after an end
        more, position, waiting = drain(follow(path), position, setup)
        found += more
        assert bool(waiting) == (content[:end].rpartition(b"\n")[2] != b"" or end < 20)
    assert rows(found) == whole(content, setup, tmp_path)
    # negative control: a position that is forgotten repeats what was read
    assert len(rows(drain(follow(path), Position(), setup)[0])) == len(rows(found))


def test_an_error_names_the_line_of_the_file(demo, tmp_path):
    content, setup = demo
    lines = content.splitlines(keepends=True)
    path = tmp_path / "r.csv"
    path.write_bytes(b"".join(lines[:50]))
    _, position, _ = drain(follow(path), Position(), setup)
    for bad, words in (
        (lines[60].replace(b"radar", b"sonar"), r"r\.csv: line 53: sensor is 'sonar"),
        (lines[60][:-1] + b",1\n", r"r\.csv, line 53, has 6 cells instead of 5"),
        (b"\xff" + lines[60], r"r\.csv, line 53, is not UTF-8"),
    ):
        path.write_bytes(b"".join([*lines[:50], *lines[50:52], bad]))
        with pytest.raises(InvalidInputError, match=words):
            drain(follow(path), position, setup)


def test_a_file_that_is_rotated_is_read_to_its_end_first(demo, tmp_path):
    content, setup = demo
    lines = content.splitlines(keepends=True)
    path = tmp_path / "r.csv"
    path.write_bytes(b"".join(lines[:100]))
    found, position, _ = drain(follow(path), Position(), setup)
    with path.open("ab") as file:
        file.writelines(lines[100:150])
    path.rename(tmp_path / "r.csv.1")
    assert drain(follow(path), position, setup)[2] == (f"{path} is gone; waiting for it",)
    path.write_bytes(b"".join([lines[0], *lines[150:]]))
    more, position, _ = drain(follow(path), position, setup)
    assert rows(found + more) == whole(content, setup, tmp_path)
    assert [file.name for file in position.files] == ["r.csv"]
    (tmp_path / "r.csv.1").unlink()
    assert drain(follow(path), position, setup)[0] == []


@pytest.mark.parametrize("size", [40, 100])
def test_a_file_that_shrinks_or_is_written_anew_is_refused(demo, tmp_path, size):
    content, setup = demo
    lines = content.splitlines(keepends=True)
    path = tmp_path / "r.csv"
    path.write_bytes(b"".join(lines[:60]))
    _, position, _ = drain(follow(path), Position(), setup)
    path.write_bytes(b"".join([lines[0], *lines[100 : 100 + size]]))
    with pytest.raises(InvalidInputError, match=r"r\.csv is not what was read before \(r\.csv"):
        drain(follow(path), position, setup)
    # a file that was repaired where it was not read yet is the same
    path.write_bytes(content)
    assert len(rows(drain(follow(path), position, setup)[0])) == len(lines) - 60


def frame(content):
    return pd.read_csv(io.BytesIO(content), dtype=str)


def test_a_folder_gives_its_files_in_the_order_of_writing(demo, tmp_path):
    content, setup = demo
    lines = content.splitlines(keepends=True)
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    (folder / ".hidden.csv").write_text("not complete")
    found, position = [], Position()
    assert drain(follow(folder), position, setup) == ([], position, ())
    for k, name in enumerate(("b.csv", "a.csv", "c.csv")):
        part = lines[1 + 100 * k : 1 + 100 * (k + 1)]
        (folder / name).write_bytes(b"".join([lines[0], *part]))
        os.utime(folder / name, ns=(k, k))
    found, position, _ = drain(follow(folder), position, setup)
    assert rows(found) == whole(content, setup, tmp_path)
    # renamed and removed files are not read again
    (folder / "a.csv").rename(folder / "z.csv")
    (folder / "b.csv").unlink()
    more, position, _ = drain(follow(folder), position, setup)
    assert more == []
    drained = drain(follow(folder), position, setup)[1]
    assert sorted(file.name for file in drained.files) == ["c.csv", "z.csv"]
    # one that grows goes on
    with (folder / "c.csv").open("ab") as file:
        file.write(lines[-1])
    assert rows(drain(follow(folder), position, setup)[0]) == rows(found)[-1:]


def test_parquet_files_are_read_once_they_are_complete(demo, tmp_path):
    content, setup = demo
    folder = tmp_path / "in"
    folder.mkdir()
    cells = frame(content).astype({"time_s": float, "range_m": float, "azimuth_deg": float})
    cells.to_parquet(tmp_path / "r.parquet", index=False)
    full = (tmp_path / "r.parquet").read_bytes()
    (folder / "r.parquet").write_bytes(full[:-10])
    found, position, waiting = drain(follow(folder), Position(), setup)
    assert found == []
    assert "r.parquet ends in" in waiting[0]
    (folder / "r.parquet").write_bytes(full)
    found, position, _ = drain(follow(folder), position, setup)
    assert rows(found) == whole(content, setup, tmp_path)
    assert drain(follow(folder), position, setup)[0] == []
    (folder / "r.parquet").write_bytes(full + full)
    with pytest.raises(InvalidInputError, match=r"r\.parquet had \d+ bytes when it was read"):
        drain(follow(folder), position, setup)


def test_other_columns_later_are_refused_by_the_name_of_the_file(demo, tmp_path):
    content, setup = demo
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "a.csv").write_bytes(content)
    _, position, _ = drain(follow(folder), Position(), setup)
    (folder / "b.csv").write_bytes(content.replace(b"time_s", b"time"))
    with pytest.raises(InvalidInputError, match=r"b\.csv has the columns time, .* with time_s"):
        drain(follow(folder), position, setup)


def test_bad_places_are_one_sentence(demo, tmp_path):
    _, setup = demo
    for path, words in (
        (tmp_path / "no.csv", "no such file"),
        (tmp_path / "no.xls", "ends with none of"),
    ):
        with pytest.raises(InvalidInputError, match=words):
            drain(follow(path), Position(), setup)
    folder = tmp_path / "in"
    folder.mkdir()
    source = follow(folder)
    folder.rmdir()
    with pytest.raises(InvalidInputError, match="in cannot be read: No such file"):
        drain(source, Position(), setup)


def test_a_file_without_permission_is_one_sentence(demo, tmp_path, monkeypatch):
    path = tmp_path / "r.csv"
    path.write_bytes(demo[0])

    def refused(self, *args, **more):
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr("pathlib.Path.open", refused)
    with pytest.raises(InvalidInputError, match=r"r\.csv cannot be read: Permission denied"):
        drain(follow(path), Position(), demo[1])


def test_a_line_without_end_is_refused(demo, tmp_path, monkeypatch):
    content, setup = demo
    path = tmp_path / "r.csv"
    path.write_bytes(content.splitlines(keepends=True)[0] + 5000 * b"x")
    monkeypatch.setattr("probreg.recordings.formats.csv.Csv.piece_bytes", 4000)
    with pytest.raises(InvalidInputError, match="no end of a line or block in 4000 bytes"):
        drain(follow(path), Position(), setup)


def settled(source, position, setup):
    """What a stream gives until it has ended."""
    found = []
    while True:
        more, position, _ = drain(source, position, setup)
        found += more
        if source.ended:
            return found, position
        time.sleep(0.001)


@pytest.mark.parametrize("again", [True, False])
def test_standard_input_goes_on_or_is_passed_over(demo, tmp_path, again):
    content, setup = demo
    lines = content.splitlines(keepends=True)
    first, position = settled(GrowingInput(io.BytesIO(b"".join(lines[:120]))), Position(), setup)
    rest = lines if again else [lines[0], *lines[120:]]
    more, position = settled(GrowingInput(io.BytesIO(b"".join(rest))), position, setup)
    assert rows(first + more) == whole(content, setup, tmp_path)
    with pytest.raises(InvalidInputError, match="standard input ended before"):
        settled(GrowingInput(io.BytesIO(b"")), Position(), setup)


def heights(folder, level):
    radars = tuple(Radar2D((x, 0.0), 20.0, 2e-3, name) for x, name in ((0.0, "a"), (9e3, "b")))
    lines = ["time_s,sensor,range_m,azimuth_deg,pressure_altitude_m"]
    lines += [f"{k},{'ab'[k % 2]},{9000 + k},{10 + k},{level if k % 3 else ''}" for k in range(9)]
    (folder / "r.csv").write_text("\n".join(lines) + "\n")
    return Setup(radars, {"a": ("range",)}, origin=(50.0, 8.0, 0.0), geodetic=frozenset())


def test_heights_come_with_the_plot_they_stand_beside(tmp_path):
    setup = heights(tmp_path, 7000.0)
    (part,), _, _ = drain(follow(tmp_path / "r.csv"), Position(), setup)
    assert [sensor.name for sensor in part.setup.sensors] == ["a", "b", "barometer"]
    assert part.arrays["sensor"].tolist() == [0, 1, 2, 0, 2, 1, 0, 2, 1, 2, 0, 1, 2, 0, 2]
    beside = part.arrays["beside"]
    np.testing.assert_array_equal(part.arrays["time"][beside], part.arrays["time"])


def test_heights_that_appear_late_are_counted_and_left_out(tmp_path):
    setup = heights(tmp_path, 7000.0)
    found, _, _ = drain(follow(tmp_path / "r.csv"), Position(), setup, fixed=True)
    buffer = Buffer()
    for part in found:
        assert part.setup is setup
        buffer = arrive(buffer, part)
    first, buffer = cut(buffer, setup, 4.0)
    second, buffer = cut(buffer, setup, 10.0)
    assert len(buffer) == 0
    assert [one.late_kinds for one in (first, second)] == [{"barometer": 3}, {"barometer": 3}]
    both = [one.reports for one in (first, second)]
    assert [time for one in both for time in one.time] == list(range(9))
    assert all(one.sensors == setup.sensors for one in both)


@pytest.fixture
def plots(tmp_path):
    pytest.importorskip("asterix.base")
    asterix_bytes.write(tmp_path / "r.ast")
    plain = asterix_bytes.setup("west", "east", "adsb")
    return tmp_path / "r.ast", dataclasses.replace(plain, asterix=asterix_bytes.SOURCES)


def by_time(setup, found):
    arrays = joined([part.arrays for part in found])
    labels = [part.labels[k] for part in found for k in part.arrays["target"]]
    order = np.lexsort((arrays["sensor"], arrays["time"]))
    return {name: array[order] for name, array in arrays.items()}, [labels[k] for k in order]


def test_asterix_cut_anywhere_counts_its_days_on(plots, tmp_path):
    path, setup = plots
    content = path.read_bytes()
    read = recordings.read(path, setup)
    (tmp_path / "in").mkdir()
    growing_path = tmp_path / "in" / "r.ast"
    growing_path.touch()
    cuts = np.sort(np.random.default_rng(4).choice(len(content), 25, replace=False)).tolist()
    found, position, known = [], Position(), setup
    for start, end in zip([0, *cuts], [*cuts, len(content)], strict=True):
        with growing_path.open("ab") as file:
            file.write(content[start:end])
        more, position, _ = drain(follow(tmp_path / "in"), position, known)
        found += more
        known = found[-1].setup if found else setup
    assert len(found) > 10
    arrays, labels = by_time(known, found)
    wanted = read.recording
    order = np.lexsort((wanted.sensor, wanted.time))
    np.testing.assert_array_equal(arrays["time"], wanted.time[order])
    np.testing.assert_array_equal(arrays["sensor"], wanted.sensor[order])
    np.testing.assert_array_equal(arrays["values"], wanted.values[order])
    assert labels == [wanted.labels[k] for k in wanted.target[order]]
    assert arrays["time"].max() > 86_400.0
    assert known.places == read.setup.places


def test_what_is_no_asterix_is_refused_with_its_byte(plots):
    path, setup = plots
    content = path.read_bytes()
    _, position, _ = drain(follow(path), Position(), setup)
    path.write_bytes(content + b"\x30\x00\x01 and so on")
    with pytest.raises(InvalidInputError, match=rf"r\.ast, byte {len(content)}: a block"):
        drain(follow(path), position, setup)


def test_the_sources_are_chosen_by_what_is_there(tmp_path):
    assert isinstance(follow(tmp_path), growing.GrowingFolder)
    assert isinstance(follow(tmp_path / "r.csv"), growing.GrowingFile)
    assert not follow(tmp_path).ended
