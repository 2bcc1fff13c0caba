"""Tables that cannot be read: each error names what is wrong, where, and what to do."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.recordings import Recording, table
from tests.recordings.test_table import frame_of, save, traffic


def lines(n=60):
    recording, setup = traffic(n)
    text = frame_of(recording).drop(columns="remark").to_csv(index=False)
    return text.splitlines(), setup


def refused(tmp_path, rows, setup, **options):
    path = tmp_path / "r.csv"
    path.write_text("\n".join(rows) + "\n")
    with pytest.raises(InvalidInputError) as caught:
        table.read(path, setup, **options)
    assert "r.csv" in str(caught.value)
    return str(caught.value)


CELL = {"time_s": 0, "sensor": 1, "range_m": 2, "azimuth_deg": 3, "target": 4}


@pytest.mark.parametrize(
    ("column", "text", "words"),
    [
        ("range_m", "12,5", ["line 8", "6 cells instead of 5"]),
        ("range_m", "far", ["line 8", "range_m", "'far'", "no number"]),
        ("range_m", "", ["line 8", "range_m", "empty"]),
        ("range_m", "nan", ["line 8", "range_m", "not finite"]),
        ("range_m", "inf", ["line 8", "range_m", "not finite"]),
        ("range_m", "-3", ["line 8", "range_m", "-3"]),
        ("azimuth_deg", "361", ["line 8", "azimuth_deg", "361"]),
        ("time_s", "", ["line 8", "time_s", "empty"]),
        ("time_s", "noon", ["line 8", "time_s", "'noon'"]),
        ("sensor", "radar7", ["line 8", "'radar7'", "radar1"]),
        ("sensor", "", ["line 8", "sensor is empty"]),
    ],
)
def test_a_bad_cell_is_named_by_line_and_column(tmp_path, column, text, words):
    rows, setup = lines()
    cells = rows[7].split(",")
    cells[CELL[column]] = text
    said = refused(tmp_path, [*rows[:7], ",".join(cells), *rows[8:]], setup)
    for word in words:
        assert word in said
    # blank lines do not shift the count
    if "cells" not in words[1]:
        assert "line 10" in refused(
            tmp_path, [rows[0], "", "", *rows[1:7], ",".join(cells), *rows[8:]], setup
        )


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("range_m", "range_km", ["'range_km'", "'range_m'"]),
        ("azimuth_deg", "azimuth_rad", ["'azimuth_rad'", "'azimuth_deg'"]),
        ("azimuth_deg", "azimut_deg", ["'azimut_deg'", "'azimuth_deg'"]),
        ("azimuth_deg", "bearing", ["'bearing'", "'azimuth_deg'"]),
        ("azimuth_deg", "angle", ["'azimuth_deg' is missing", "radar1"]),
        ("time_s", "clock", ["one column of", "time_s"]),
        ("sensor", "station", ["'sensor' is missing"]),
        ("target", "range_m", ["'range_m'", "twice"]),
        (",", ";", ["commas"]),
    ],
)
def test_a_bad_name_of_a_column_is_named(tmp_path, old, new, words):
    rows, setup = lines()
    said = refused(tmp_path, [rows[0].replace(old, new), *rows[1:]], setup)
    for word in words:
        assert word in said


def test_other_columns_may_be_like_ours_when_ours_are_there(tmp_path):
    rows, setup = lines()
    rows = [rows[0] + ",time_ms,range_km", *(row + ",1,2" for row in rows[1:])]
    path = tmp_path / "r.csv"
    path.write_text("\n".join(rows) + "\n")
    assert len(table.read(path, setup).notes) == 2


def test_files_that_are_missing_empty_cut_off_or_of_another_encoding(tmp_path):
    rows, setup = lines()
    with pytest.raises(InvalidInputError, match=r"none.csv cannot be read"):
        table.read(tmp_path / "none.csv", setup)
    with pytest.raises(InvalidInputError, match=r"ends with none of .csv"):
        table.read(tmp_path / "r.xls", setup)
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(InvalidInputError, match="cannot be read"):
        table.read(tmp_path / "folder.csv", setup)
    path = tmp_path / "r.csv"
    path.write_text("")
    with pytest.raises(InvalidInputError, match="is empty"):
        table.read(path, setup)
    assert "no rows" in refused(tmp_path, rows[:1], setup)
    path.write_text("\n".join(rows)[: -len(rows[-1].split(",", 3)[3])])
    with pytest.raises(InvalidInputError, match=rf"line {len(rows)}, .*cut off"):
        table.read(path, setup)
    path.write_text("\n".join(rows))
    assert any("line break" in note for note in table.read(path, setup).notes)
    bad = "\n".join([*rows[:9], rows[9] + "é", *rows[10:]])
    path.write_bytes(bad.encode("latin-1"))
    with pytest.raises(InvalidInputError, match="line 10, is not UTF-8"):
        table.read(path, setup)
    path.write_bytes(bad.encode("utf-16"))
    with pytest.raises(InvalidInputError, match="line 1, is not UTF-8"):
        table.read(path, setup)
    good = save(frame_of(traffic()[0]), tmp_path / "r.parquet")
    good.write_bytes(good.read_bytes()[:-300])
    with pytest.raises(InvalidInputError, match="no complete Parquet"):
        table.read(good, setup)


def test_parquet_errors_name_the_row(tmp_path):
    recording, setup = traffic()
    frame = frame_of(recording)
    frame.loc[41, "range_m"] = np.nan
    with pytest.raises(InvalidInputError, match="row 42: range_m is empty"):
        table.read(save(frame, tmp_path / "r.parquet"), setup)
    frame["range_m"] = frame["range_m"].astype(str)
    frame.loc[41, "range_m"] = "x"
    with pytest.raises(InvalidInputError, match="row 42: range_m is 'x'"):
        table.read(save(frame, tmp_path / "r.parquet"), setup)


def test_wrong_units_by_the_look_of_them(tmp_path):
    recording, setup = traffic()
    frame = frame_of(recording)
    radians = frame.assign(azimuth_deg=recording.values[:, 1])
    with pytest.raises(InvalidInputError, match="look like radians.*--trust-units"):
        table.read(save(radians, tmp_path / "r.csv"), setup)
    table.read(tmp_path / "r.csv", setup, trust_units=True)
    with pytest.raises(InvalidInputError, match="look like kilometres"):
        table.read(save(frame.assign(range_m=frame.range_m / 1e3), tmp_path / "r.csv"), setup)
    for late in (1e3 * frame.time_s, 1.7e12 + 1e3 * frame.time_s):
        save(frame.assign(time_s=late), tmp_path / "r.csv")
        with pytest.raises(InvalidInputError, match="look like milliseconds"):
            table.read(tmp_path / "r.csv", setup)
        table.read(tmp_path / "r.csv", setup, trust_units=True)
    # a narrow sector of a few degrees is no circle of radians
    narrow = frame.assign(azimuth_deg=np.linspace(0.5, 5.5, len(frame)))
    table.read(save(narrow, tmp_path / "r.csv"), setup)
    # with better radars only the distance between them tells
    sharp = dataclasses.replace(
        setup, sensors=tuple(dataclasses.replace(s, sigma_range=1.0) for s in setup.sensors)
    )
    with pytest.raises(InvalidInputError, match="leave a gap"):
        table.read(save(frame.assign(range_m=frame.range_m / 1e3), tmp_path / "r.csv"), sharp)


def test_rows_that_repeat_clocks_that_miss_and_sensors_that_are_silent(tmp_path):
    rows, setup = lines()
    said = refused(tmp_path, [*rows, rows[7]], setup)
    assert f"line {len(rows) + 1} repeats line 8" in said
    only = [rows[0], *(row for row in rows if ",radar1," in row)]
    assert "'radar2' has no report" in refused(tmp_path, only, setup)
    alone = dataclasses.replace(setup, sensors=setup.sensors[:1], biases={})
    assert "one sensor only" in refused(tmp_path, only, alone)

    def shifted(seconds):
        for row in rows[1:]:
            time, rest = row.split(",", 1)
            yield f"{float(time) + seconds * (',radar3,' in row)},{rest}"

    said = refused(tmp_path, [rows[0], *shifted(1_000.0)], setup)
    ends = [float(row.split(",")[0]) for row in rows[1:] if ",radar3," not in row]
    starts = [float(row.split(",")[0]) for row in rows[1:] if ",radar3," in row]
    assert f"by {starts[0] + 1_000.0 - ends[-1]:.3f} s" in said
    own = [row.replace(",radar1,", ",radar1,") + "x" * (",radar1," in row) for row in rows]
    assert "'radar1' has no target in common" in refused(tmp_path, own, setup)


def test_a_time_of_day_past_midnight_is_refused_and_a_mere_disorder_sorted(tmp_path):
    rows, setup = lines(200)
    moved = [rows[0]]
    for row in rows[1:]:
        time, rest = row.split(",", 1)
        moved.append(f"{np.mod(float(time) + 86_390.0, 86_400.0)},{rest}")
    said = refused(tmp_path, moved, setup)
    assert "past midnight" in said
    assert "line" in said
    path = tmp_path / "r.csv"
    path.write_text("\n".join([rows[0], *reversed(rows[1:])]) + "\n")
    found = table.read(path, setup)
    assert (np.diff(found.recording.time) >= 0.0).all()
    np.testing.assert_array_equal(np.sort(found.rows), np.arange(200))
    assert found.rows[0] == 199


def test_long_files_are_refused_by_a_limit(tmp_path):
    rows, setup = lines()
    assert "row_limit = 59" in refused(tmp_path, rows, setup, row_limit=59)


def test_nothing_is_written_when_something_is_wrong(tmp_path):
    recording, setup = traffic()
    like = save(frame_of(recording), tmp_path / "in.csv")
    out = tmp_path / "out.csv"
    found = table.read(like, setup).recording
    part = Recording(
        found.sensors, *(getattr(found, n)[:-1] for n in ("sensor", "time", "values", "target"))
    )
    for wrong in (part, traffic(401)[0]):
        with pytest.raises(InvalidInputError, match=r"in\.csv"):
            table.write(out, wrong, like=like, setup=setup)
    with pytest.raises(InvalidInputError, match=r"must end with .csv"):
        table.write(tmp_path / "out.parquet", found, like=like, setup=setup)
    with pytest.raises(InvalidInputError, match="each of the 400 rows"):
        table.write(out, found, like=like, setup=setup, rows=np.zeros(400, dtype=int))
    with pytest.raises(InvalidInputError, match="cannot be written"):
        table.write(tmp_path / "no" / "out.csv", found, like=like, setup=setup)
    assert [path.name for path in tmp_path.iterdir()] == ["in.csv"]
