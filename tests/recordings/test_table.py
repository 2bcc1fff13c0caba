"""Tables: what is written is read, cells that did not change stay, errors name the line."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from probreg.errors import InvalidInputError
from probreg.geometry import wrap_angle
from probreg.recordings import Recording, Setup, table
from probreg.recordings.local_frame import LocalFrame
from probreg.scenarios.traffic import TrafficScene, radars, simulate
from probreg.sensors import BearingSensor, PositionSensor, Radar2D, Radar3D

FORMATS = ["csv", "parquet"]


def traffic(n=400, dim=2, seed=4):
    recording, setup, _ = simulate(
        TrafficScene(reports=n, sensors=radars(dim=dim), aircraft=10), np.random.default_rng(seed)
    )
    return recording, setup


def frame_of(recording, signed=False):
    names = np.array([sensor.name for sensor in recording.sensors])
    azimuth = np.rad2deg(recording.values[:, 1])
    columns = {
        "remark": [f'a, "b" {k}' for k in range(len(recording))],
        "time_s": recording.time,
        "sensor": names[recording.sensor],
        "range_m": recording.values[:, 0],
        "azimuth_deg": azimuth if signed else np.mod(azimuth, 360.0),
        "target": np.array([*recording.labels, ""])[recording.target],
    }
    if recording.values.shape[1] == 3:
        columns["elevation_deg"] = np.rad2deg(recording.values[:, 2])
    return pd.DataFrame(columns)


def save(frame, path):
    if path.suffix == ".csv":
        frame.to_csv(path, index=False)
    else:
        frame.to_parquet(path, index=False)
    return path


def load(path):
    if path.suffix == ".csv":
        return pd.read_csv(path, dtype=str, keep_default_na=False)
    return pd.read_parquet(path)


def same_angles(one, two, atol=1e-12):
    np.testing.assert_allclose(wrap_angle(one - two), 0.0, atol=atol)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", FORMATS)
def test_a_table_is_read_as_the_recording_it_was_made_of(tmp_path, kind, dim):
    recording, setup = traffic(dim=dim)
    found = table.read(save(frame_of(recording), tmp_path / f"r.{kind}"), setup)
    again = found.recording
    np.testing.assert_allclose(again.time, recording.time, atol=1e-9)
    np.testing.assert_array_equal(again.sensor, recording.sensor)
    np.testing.assert_allclose(again.values[:, 0], recording.values[:, 0], rtol=1e-14)
    same_angles(again.values[:, 1:], recording.values[:, 1:])
    assert [again.labels[k] for k in again.target] == [
        recording.labels[k] for k in recording.target
    ]
    assert found.notes == ("column 'remark' is not used",)


@pytest.mark.parametrize("signed", [False, True])
@pytest.mark.parametrize("kind", FORMATS)
def test_what_is_written_is_read_again_and_the_rest_stays(tmp_path, kind, signed):
    recording, setup = traffic()
    frame = frame_of(recording, signed).sample(frac=1.0, random_state=2)
    like = save(frame, tmp_path / f"in.{kind}")
    old = table.read(like, setup)
    assert any("sorted by time" in note for note in old.notes)
    bias = np.where(recording.sensor[:, None] == 1, [120.0, 0.02], 0.0)
    new = dataclasses.replace(old.recording, values=old.recording.values - bias)
    out = tmp_path / f"out.{kind}"
    table.write(out, new, like=like, setup=setup)
    again = table.read(out, setup)
    np.testing.assert_allclose(again.recording.values[:, 0], new.values[:, 0], rtol=1e-12)
    same_angles(again.recording.values[:, 1], new.values[:, 1])
    assert again.signed == signed
    before, after = load(like), load(out)
    assert list(before.columns) == list(after.columns)
    for name in ("remark", "time_s", "sensor", "target"):
        assert (before[name] == after[name]).all()
    touched = (before["range_m"] != after["range_m"]).to_numpy()
    np.testing.assert_array_equal(touched, (before["sensor"] == "radar2").to_numpy())
    azimuth = after["azimuth_deg"].astype(float)
    low = -180.0 if signed else 0.0
    assert azimuth.between(low, low + 360.0).all()
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.parametrize("kind", FORMATS)
def test_an_unchanged_recording_gives_the_same_cells(tmp_path, kind):
    recording, setup = traffic(60)
    like = save(frame_of(recording), tmp_path / f"in.{kind}")
    table.write(tmp_path / f"o.{kind}", table.read(like, setup).recording, like=like, setup=setup)
    pd.testing.assert_frame_equal(load(like), load(tmp_path / f"o.{kind}"))


def test_line_ends_and_the_mark_of_an_encoding_are_kept(tmp_path):
    recording, setup = traffic(30)
    text = frame_of(recording).drop(columns="remark").to_csv(index=False)
    like = tmp_path / "in.csv"
    like.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    table.write(tmp_path / "out.csv", table.read(like, setup).recording, like=like, setup=setup)
    assert (tmp_path / "out.csv").read_bytes() == like.read_bytes()


@pytest.mark.parametrize("kind", [*FORMATS, "stamps", "posix"])
def test_clock_times_are_read_and_corrected(tmp_path, kind):
    recording, setup = traffic(60)
    frame = frame_of(recording)
    stamps = pd.Timestamp("2024-03-01T23:59:50Z") + pd.to_timedelta(
        np.rint(recording.time * 1e6), "us"
    )
    posix = stamps.as_unit("ns").astype("int64").to_numpy() / 1e9
    frame = frame.drop(columns="time_s")
    frame["time"] = {"stamps": stamps, "posix": posix}.get(
        kind, stamps.strftime("%Y-%m-%dT%H:%M:%S.%f+00:00")
    )
    suffix = {"stamps": "parquet", "posix": "csv"}.get(kind, kind)
    like = save(frame, tmp_path / f"in.{suffix}")
    old = table.read(like, setup)
    np.testing.assert_allclose(old.recording.time, posix, atol=5e-7)
    late = np.where(old.recording.sensor == 2, 0.5, 0.0)
    time = old.recording.time - late
    order = np.argsort(time, kind="stable")
    parts = {name: getattr(old.recording, name)[order] for name in ("sensor", "values", "target")}
    new = dataclasses.replace(old.recording, time=time[order], **parts)
    out = tmp_path / f"out.{suffix}"
    table.write(out, new, like=like, setup=setup, rows=old.rows[order])
    again = table.read(out, setup).recording
    np.testing.assert_allclose(again.time, new.time, atol=1e-6)
    np.testing.assert_array_equal(again.values, new.values)
    with pytest.raises(InvalidInputError, match="pass the rows"):
        table.write(out, new, like=like, setup=setup)


def test_a_moving_platform_with_a_radar_a_camera_and_a_reference(tmp_path):
    sensors = (
        Radar2D((0.0, 0.0), 5.0, 0.01, "radar", from_north=True),
        BearingSensor(0.01, "camera", from_north=True),
        PositionSensor(((1.0, 0.0), (0.0, 1.0)), "gnss"),
    )
    setup = Setup(sensors, {"radar": ("range",)}, body_frame=frozenset({"camera"}))
    text = (
        "time,sensor,range_m,azimuth_deg,north_m,east_m,own_north_m,own_east_m,heading_deg,target\n"
        "1,radar,900,350,,,30,40,90,\n"
        "2,camera,,-20.5,,,31,41,90,7\n"
        "3,gnss,,,100,-5,31,41,,7\n"
        "4,radar,901,10,,,,,,\n"
    )
    path = tmp_path / "r.csv"
    path.write_text(text)
    found = table.read(path, setup).recording
    deg = np.pi / 180.0
    expected = [[900, -10 * deg], [-20.5 * deg, np.nan], [-5, 100], [901, 10 * deg]]
    np.testing.assert_allclose(found.values, expected, atol=1e-12)
    np.testing.assert_allclose(found.own_position, [[40, 30], [41, 31], [0, 0], [0, 0]])
    np.testing.assert_allclose(found.heading, [0.0, 0.0, np.nan, np.nan], atol=1e-15)
    assert found.labels == ("7",)
    np.testing.assert_array_equal(found.target, [-1, 0, 0, -1])
    path.write_text(text.replace(",31,41,90,7", ",31,41,,7"))
    with pytest.raises(InvalidInputError, match="line 3: heading_deg is empty"):
        table.read(path, setup)
    path.write_text(text.replace(",31,41,90,7", ",31,,90,7"))
    with pytest.raises(InvalidInputError, match="line 3: own_east_m is empty"):
        table.read(path, setup)


def test_azimuth_from_true_north_is_turned_to_the_frame(tmp_path):
    """A target placed by latitude: both radars must see it where the ellipsoid has it."""
    origin = (60.0, 10.0, 0.0)
    frame = LocalFrame(*origin)
    east = frame.from_geodetic(np.array([60.1, 11.5, 0.0]))
    sensors = tuple(
        Radar3D(place, 20.0, 1e-3, 1e-3, name, from_north=True)
        for name, place in (("a", (0.0, 0.0, 0.0)), ("b", tuple(east.tolist())))
    )
    setup = Setup(sensors, {"a": (), "b": ()}, origin=origin)
    # due north of b by its own meridian
    target = frame.from_geodetic(np.array([60.2, 11.5, 0.0]))
    away = np.linalg.norm(target - east)
    own = sensors[0].to_report(target[None])[0]
    path = tmp_path / "r.csv"
    path.write_text(
        "time_s,sensor,range_m,azimuth_deg,elevation_deg\n"
        f"1,a,{own[0]},{np.rad2deg(own[1])},{np.rad2deg(own[2])}\n"
        f"1.5,b,{away},0.0,{np.rad2deg(np.arcsin((target - east)[2] / away))}\n"
    )
    found = table.read(path, setup, trust_units=True).recording
    for k, sensor in enumerate(sensors):
        where = sensor.to_cartesian(found.values[k][None], unbiased=False)[0]
        np.testing.assert_allclose(where, target, atol=0.5)
    # without the turn b would be off by a quarter of a kilometre
    raw = np.array([[away, 0.0, found.values[1, 2]]])
    wrong = sensors[1].to_cartesian(raw, unbiased=False)[0]
    assert np.linalg.norm(wrong - target) > 200.0
    table.write(tmp_path / "o.csv", found, like=path, setup=setup)
    assert (tmp_path / "o.csv").read_text() == path.read_text()


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
