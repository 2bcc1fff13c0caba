"""Tables: what is written is read, cells that did not change stay, errors name the line."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from probreg.errors import InvalidInputError
from probreg.recordings import Recording, Setup, observing_axes, places, table, turns
from probreg.scenarios.traffic import TrafficScene, radars, simulate
from probreg.sensors import BearingSensor, PositionSensor, Radar2D, Radar3D
from probreg.sensors.frame import LocalFrame
from probreg.sensors.geometry import wrap_angle

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


def test_azimuth_stays_as_it_is_from_true_north_and_the_axes_know_it(tmp_path):
    """A target placed by latitude: both radars must see it where the ellipsoid has it."""
    origin = (60.0, 10.0, 0.0)
    frame, place = LocalFrame(*origin), (60.1, 11.5, 0.0)
    east = frame.from_geodetic(np.array(place))
    sensors = tuple(
        Radar3D(tuple(where), 20.0, 1e-3, 1e-3, name, from_north=True)
        for name, where in (("a", np.zeros(3).tolist()), ("b", east.tolist()))
    )
    setup = Setup(
        sensors,
        {"a": (), "b": ()},
        origin=origin,
        places={"a": origin, "b": place},
        refraction={"a": "none", "b": "none"},
    )
    # due north of b by its own meridian, level with it by its own vertical
    target = frame.from_geodetic(np.array([60.2, 11.5, 0.0]))
    own = sensors[0].to_report(target[None])[0]
    away = LocalFrame(*place).from_geodetic(np.array([60.2, 11.5, 0.0]))
    distance = np.linalg.norm(away)
    path = tmp_path / "r.csv"
    path.write_text(
        "time_s,sensor,range_m,azimuth_deg,elevation_deg\n"
        f"1,a,{own[0]},{np.rad2deg(own[1])},{np.rad2deg(own[2])}\n"
        f"1.5,b,{distance},0.0,{np.rad2deg(np.arcsin(away[2] / distance))}\n"
    )
    read = table.read(path, setup, trust_units=True)
    found = read.recording
    np.testing.assert_array_equal(found.values[1, 1], 0.0)
    np.testing.assert_allclose(places(found, setup, found.values), [target, target], atol=1e-6)
    # level with the frame b would be off by hundreds of metres
    flat = dataclasses.replace(setup, places={})
    off = places(found, flat, found.values)[1] - target
    assert np.linalg.norm(off) > 200.0
    table.write(tmp_path / "o.csv", found, like=path, setup=setup)
    assert (tmp_path / "o.csv").read_text() == path.read_text()


def test_in_the_plane_the_meridians_turn_the_axes(tmp_path):
    origin, place = (60.0, 10.0, 0.0), (60.1, 11.5, 0.0)
    frame = LocalFrame(*origin)
    east = frame.from_geodetic(np.array(place))
    target = frame.from_geodetic(np.array([60.2, 11.5, 0.0]))
    for from_north in (True, False):
        sensors = (
            Radar2D(tuple(east.tolist()), 20.0, 1e-3, "b", from_north=from_north),
            Radar2D((0.0, 0.0), 20.0, 1e-3, "c", from_north=from_north),
        )
        setup = Setup(sensors, {}, origin=origin, places={"b": place}, targets="surface")
        axes = observing_axes(setup)
        seen = axes[0].observe(target[None, :2]).value[0]
        np.testing.assert_allclose(
            seen[1], 0.0 if from_north else 0.5 * np.pi, atol=2e-5
        )  # as flat as the plane
        np.testing.assert_allclose(axes[0].place(seen[None], np.zeros(1))[0], target[:2], atol=1e-6)
        # given in metres: north is the frame's
        straight = axes[1].observe(np.array([[0.0, 5e3]])).value[0]
        np.testing.assert_allclose(straight[1], 0.0 if from_north else 0.5 * np.pi, atol=1e-12)


def test_a_moving_platform_counts_from_true_north_where_it_is():
    sensors = (Radar2D((0.0, 0.0), 20.0, 1e-3, "a", from_north=True),)
    own = np.array([[90e3, 1e4], [0.0, 0.0]])
    recording = Recording(
        sensors, np.zeros(2, int), np.arange(2.0), np.full((2, 2), 0.1), np.zeros(2, int),
        own_position=own,
    )  # fmt: skip
    setup = Setup(sensors, {}, origin=(60.0, 8.0, 0.0), targets="surface")
    turn = LocalFrame(60.0, 8.0, 0.0).convergence(own[0])
    np.testing.assert_allclose(turns(recording, setup, np.arange(2)), [turn, 0.0], atol=1e-12)
    assert abs(turn) > 0.02
    flat = dataclasses.replace(setup, origin=None)
    np.testing.assert_array_equal(turns(recording, flat, np.arange(2)), 0.0)
