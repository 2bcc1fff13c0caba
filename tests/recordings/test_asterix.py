"""ASTERIX: simulated plots through bytes and back, and bytes put together by hand."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg import recordings
from probreg.errors import InvalidInputError
from probreg.recordings import Setup, new_table, observing_axes, setup_file, table
from probreg.recordings.formats import asterix
from probreg.sensors import PositionSensor, Radar2D, Radar3D
from probreg.sensors.frame import LocalFrame
from probreg.sensors.geometry import wrap_angle

pytest.importorskip("asterix.base")

ORIGIN = (50.0, 8.0, 100.0)
PLACES = {"west": (49.9, 7.4, 310.0), "east": (50.2, 8.9, 150.0)}
SOURCES = {(25, 1): "west", (25, 2): "east", (25, 9): "adsb"}
REFERENCE = PositionSensor(((100.0, 0.0), (0.0, 100.0)), "adsb")
NM, FOOT = 1852.0, 0.3048


def whole(value, octets):
    return round(value).to_bytes(octets, "big", signed=value < 0)


def block(category, *records):
    body = b"".join(records)
    return bytes([category]) + (len(body) + 3).to_bytes(2, "big") + body


def plot(source, time, slant_nm, azimuth_deg, level, address, track=7):
    """I048/010, 140, 040, 070, 090, 220, 161: the first and second octet of presence bits."""
    parts = [
        b"\xdd\x90" if level is not None else b"\xd9\x90",
        bytes(source),
        whole(time % 86400 * 128, 3),
        whole(slant_nm * 256, 2) + whole(azimuth_deg % 360 * 65536 / 360 % 65536, 2),
        b"\x0f\xff",
        b"" if level is None else whole(level * 4, 2),
        address.to_bytes(3, "big"),
        whole(track, 2),
    ]
    return b"".join(parts)


def station(source, time, place):
    """I034/010, 000, 030, 120."""
    lat, lon, height = place
    angles = (whole(angle * 2**23 / 180, 3) for angle in (lat, lon))
    return (
        b"\xe1\x10"
        + bytes(source)
        + b"\x01"
        + whole(time * 128, 3)
        + whole(height, 2)
        + b"".join(angles)
    )


def adsb(source, time, place, address):
    """I021/010, 040, 131, 080, 073, 145."""
    lat, lon, height = place
    angles = b"".join(whole(angle * 2**30 / 180, 4) for angle in (lat, lon))
    level = whole(height / FOOT / 100 * 4, 2)
    body = bytes(source) + b"\x00" + angles + address.to_bytes(3, "big")
    return b"\xc3\x19\x02" + body + whole(time % 86400 * 128, 3) + level


def system_track(source, time, place, address):
    """I062/010, 070, 105, 380 with the address only, 136."""
    lat, lon, height = place
    angles = b"".join(whole(angle * 2**25 / 180, 4) for angle in (lat, lon))
    level = whole(height / FOOT / 100 * 4, 2)
    head = b"\x99\x11\x20" + bytes(source) + whole(time % 86400 * 128, 3) + angles
    return head + b"\x80" + address.to_bytes(3, "big") + level


def setup(*names):
    frame = LocalFrame(*ORIGIN)
    radars = {
        name: Radar2D(
            tuple(frame.from_geodetic(np.array(place))[:2].tolist()),
            70.0,
            np.deg2rad(0.1),
            name,
            from_north=True,
        )
        for name, place in PLACES.items()
    }
    sensors = tuple((radars | {"adsb": REFERENCE})[name] for name in names)
    return Setup(sensors, dict.fromkeys(names, ()), origin=ORIGIN)


def of_reports(found):
    """Recording of what stands alone, and its heights."""
    recording = found.recording
    assert (recording.beside[recording.alone] == np.flatnonzero(recording.alone)).all()
    return recording, np.flatnonzero(recording.alone)


def scene(n=120, start=86_350.0):
    """Aircraft on straight lines over midnight: their places, and each source's view of them."""
    rng = np.random.default_rng(6)
    frame = LocalFrame(*ORIGIN)
    time = start + np.arange(n)
    number = np.arange(n) % 4
    speed = rng.uniform(-200, 200, (4, 2))
    begin = np.column_stack([rng.uniform(-60e3, 60e3, (4, 2)), rng.uniform(3e3, 10e3, 4)])
    height = np.round(begin[number, 2] / FOOT / 25) * 25 * FOOT
    xy = begin[number, :2] + speed[number] * (time - start)[:, None]
    places = frame.to_geodetic(np.column_stack([xy, height]))
    places[:, 2] = height
    return time, number + 0x3C0000, places, frame.from_geodetic(places)


def write(path, reference=adsb, **changes):
    time, address, places, xy = scene()
    blocks = [block(34, station(s, 10.0, PLACES[n])) for s, n in SOURCES.items() if n in PLACES]
    who = np.arange(len(time)) // 4 % 3
    for k, source in enumerate(SOURCES):
        name = SOURCES[source]
        for row in np.flatnonzero(who == k):
            if name == "adsb":
                record = reference(source, time[row], places[row], int(address[row]))
                blocks.append(block(62 if reference is system_track else 21, record))
                continue
            local = LocalFrame(*PLACES[name]).from_geodetic(places[row])
            slant, azimuth = np.linalg.norm(local) / NM, np.rad2deg(np.arctan2(*local[:2]))
            level = places[row, 2] / FOOT / 100
            record = plot(source, time[row], slant, azimuth, level, int(address[row]))
            blocks.append(block(48, record))
    path.write_bytes(b"".join(blocks))
    return time, address, xy, who


@pytest.mark.parametrize("reference", [adsb, system_track])
def test_simulated_plots_are_what_their_radars_see(tmp_path, reference):
    time, address, x, who = write(tmp_path / "r.ast", reference)
    said = setup("west", "east", "adsb")
    found = asterix.read(tmp_path / "r.ast", said, SOURCES)
    assert found.notes == ()
    recording, alone = of_reports(found)
    np.testing.assert_allclose(recording.time[alone], time, atol=1 / 256)
    np.testing.assert_array_equal(recording.sensor[alone], who)
    labels = [recording.labels[k] for k in recording.target[alone]]
    assert labels == [f"{number:06x}" for number in address]
    heights = np.flatnonzero(~recording.alone)
    assert len(heights) == len(alone)
    plain = dataclasses.replace(found.setup, refraction={"west": "none", "east": "none"})
    for k, axes in enumerate(observing_axes(plain)):
        rows = alone[who == k] if k < 3 else heights
        seen = axes.observe(x[who == k] if k < 3 else x[recording.beside[heights].argsort()])
        off = recording.values[rows] - np.pad(
            seen.value, ((0, 0), (0, recording.values.shape[1] - seen.value.shape[1]))
        )
        q = seen.value.shape[1]
        off = off[:, :q]
        off[:, axes.angles] = wrap_angle(off[:, axes.angles])
        # 1/256 NM and 0.0055 degrees of a plot, places of a station to 2e-5 degrees and a metre,
        # 2^-25 half turns of a track, 25 ft: as the items have it
        last = [NM / 512 + 3.0, 1.3e-4] if k < 2 else [0.7] * q
        assert (np.abs(off).max(axis=0) < last[:q]).all()
    assert found.setup.biases["barometer"] == ("height", "height_gain")


def test_geometric_heights_stay_with_positions_of_three_dimensions(tmp_path):
    """I021/140 by the library, which writes as well."""
    from asterix import generated

    _, _, _, _ = write(tmp_path / "r.ast")
    record = generated.Cat_021_2_7.cv_record.create(
        {
            "010": (("SAC", 25), ("SIC", 9)),
            "080": 0x3C0001,
            "131": (("LAT", (50.1, "°")), ("LON", (8.2, "°"))),
            "073": (86_380.0, "s"),
            "140": (30_000.0, "ft"),
            "145": (292.0, "FL"),
        }
    )
    block_ = generated.Cat_021_2_7.create([record]).unparse().to_bytes()
    path = tmp_path / "r.ast"
    path.write_bytes(path.read_bytes() + block_)
    for high in (True, False):
        said = setup("west", "east", "adsb")
        if high:
            solid = PositionSensor.independent((10.0, 10.0, 20.0), "adsb")
            said = dataclasses.replace(said, sensors=(*said.sensors[:2], solid))
        found = asterix.read(path, said, SOURCES)
        recording, names = found.recording, [s.name for s in found.setup.sensors]
        barometer = recording.sensor == names.index("barometer")
        assert np.isclose(recording.values[barometer, 0], 29_200 * FOOT).sum() == 1
        own = recording.sensor == 2
        if high:
            assert np.isclose(recording.values[own, 2], 30_000 * FOOT).sum() == 1
            assert np.isnan(recording.values[own, 2]).sum() == own.sum() - 1
            assert "height" not in names
        else:
            height = recording.values[recording.sensor == names.index("height"), 0]
            np.testing.assert_allclose(height, [30_000 * FOOT])


def test_a_recording_of_plots_is_kept_as_a_table(tmp_path):
    write(tmp_path / "r.ast")
    found = asterix.read(tmp_path / "r.ast", setup("west", "east", "adsb"), SOURCES)
    recording = found.recording
    new_table.create(tmp_path / "r.parquet", recording, found.setup)
    again = table.read(tmp_path / "r.parquet", found.setup).recording
    difference = again.values - recording.values
    difference[recording.sensor < 2, 1] = wrap_angle(difference[recording.sensor < 2, 1])
    assert np.nanmax(np.abs(difference)) < 1e-7
    np.testing.assert_array_equal(np.isnan(again.values), np.isnan(recording.values))
    for name in ("time", "sensor", "beside"):
        np.testing.assert_array_equal(getattr(again, name), getattr(recording, name))


def test_the_setup_names_the_sources_and_the_door_reads_them(tmp_path):
    write(tmp_path / "r.ast")
    said = dataclasses.replace(setup("west", "east", "adsb"), asterix=SOURCES)
    setup_file.write(tmp_path / "sensors.toml", said)
    again = setup_file.read(tmp_path / "sensors.toml")
    assert again.asterix == SOURCES
    found = recordings.read(tmp_path / "r.ast", said)
    wanted = asterix.read(tmp_path / "r.ast", said, SOURCES)
    assert found.notes == wanted.notes
    for name in ("values", "time", "sensor", "target"):
        np.testing.assert_array_equal(
            getattr(found.recording, name), getattr(wanted.recording, name)
        )
    with pytest.raises(InvalidInputError, match="sources must name each sensor"):
        recordings.read(tmp_path / "r.ast", dataclasses.replace(said, asterix={}))


def test_the_level_of_the_frame_would_be_wrong_by_more_than_the_biases_looked_for(tmp_path):
    """The control of the test above: radars that stand level with the frame's origin."""
    _, _, x, who = write(tmp_path / "r.ast")
    found = asterix.read(tmp_path / "r.ast", setup("west", "east", "adsb"), SOURCES)
    recording, alone = of_reports(found)
    level = observing_axes(dataclasses.replace(found.setup, places={}))[1]
    rows = alone[who == 1]
    off = recording.values[rows, :2] - level.observe(x[who == 1]).value
    assert np.abs(np.rad2deg(wrap_angle(off[:, 1]))).min() > 0.5


def test_a_survey_tells_who_sends_what_from_where(tmp_path):
    write(tmp_path / "r.ast")
    found = asterix.survey(tmp_path / "r.ast")
    assert set(found) == set(SOURCES)
    assert found[25, 1].counts == {34: 1, 48: 40}
    assert found[25, 9].counts == {21: 40}
    assert found[25, 9].place is None
    np.testing.assert_allclose(found[25, 1].place, PLACES["west"], atol=2e-5)


def test_records_written_by_the_library_are_read_as_those_by_hand(tmp_path):
    from asterix import generated

    record = generated.Cat_048_1_32.cv_record.create(
        {
            "010": (("SAC", 25), ("SIC", 1)),
            "140": (50_000.5, "s"),
            "040": (("RHO", (41.25, "NM")), ("THETA", (123.75, "°"))),
            "070": (0, 0, 0, 0, ("MODE3A", "7777")),
            "090": (0, 0, ("FL", (330.0, "FL"))),
            "220": 0x3C1234,
            "161": (0, 7),
        }
    )
    library = generated.Cat_048_1_32.create([record]).unparse().to_bytes()
    assert library == block(48, plot((25, 1), 50_000.5, 41.25, 123.75, 330.0, 0x3C1234))


def test_what_is_left_out_is_said(tmp_path):
    path = tmp_path / "r.ast"
    write(path)
    extra = [
        block(48, plot((25, 1), 86_360.0, 30.0, 10.0, None, 1)),
        block(48, plot((7, 7), 86_360.0, 0.5, 10.0, 300.0, 1)),
        block(1, b"\x00\x00"),
    ]
    path.write_bytes(path.read_bytes() + b"".join(extra))
    found = asterix.read(path, setup("west", "east", "adsb"), SOURCES)
    # a plot without a height is a plot
    assert found.recording.alone.sum() == 121
    assert len(found.recording) == 241
    assert any("source (7, 7) is not used" in note for note in found.notes)
    bare = path.read_bytes()[2 * len(block(34, station((25, 1), 0.0, PLACES["west"]))) :]
    assert bare[0] == 48
    path.write_bytes(bare[: -sum(map(len, extra))])
    placed = dataclasses.replace(setup("west", "east", "adsb"), places={"west": PLACES["west"]})
    assert asterix.read(path, placed, SOURCES).notes == (
        "the height of east is not given and taken as 0 m",
    )


def test_a_radar_far_from_where_its_messages_have_it_is_said(tmp_path):
    write(tmp_path / "r.ast")
    said = setup("west", "east", "adsb")
    wrong = Radar2D((0.0, 0.0), 70.0, 1e-3, "west", from_north=True)
    moved = Setup((wrong, *said.sensors[1:]), {}, origin=ORIGIN)
    found = asterix.read(tmp_path / "r.ast", moved, SOURCES)
    assert any("west is 44" in note and "m from where" in note for note in found.notes)
    assert set(found.setup.places) == {"east"}


def test_bytes_that_are_cut_off_or_damaged(tmp_path):
    path = tmp_path / "r.ast"
    write(path)
    said = setup("west", "east", "adsb")
    content = path.read_bytes()
    path.write_bytes(content[:-4])
    with pytest.raises(InvalidInputError, match="byte .* cut off"):
        asterix.read(path, said, SOURCES)
    path.write_bytes(content + block(48, b"\xff\xff\xff\xfe\x01"))
    with pytest.raises(InvalidInputError, match=f"byte {len(content)}: .* edition 1.32"):
        asterix.read(path, said, SOURCES)
    path.write_bytes(b"")
    with pytest.raises(InvalidInputError, match="is empty"):
        asterix.survey(path)
    with pytest.raises(InvalidInputError, match="cannot be read"):
        asterix.survey(tmp_path / "none.ast")


def test_sensors_and_sources_that_do_not_fit(tmp_path):
    path = tmp_path / "r.ast"
    write(path)
    said = setup("west", "east", "adsb")
    with pytest.raises(InvalidInputError, match="'adsb'"):
        asterix.read(path, said, {(25, 1): "west", (25, 2): "east"})
    with pytest.raises(InvalidInputError, match="no usable message of sensor 'east'"):
        asterix.read(path, said, {(25, 1): "west", (25, 8): "east", (25, 9): "adsb"})
    with pytest.raises(InvalidInputError, match="origin"):
        asterix.read(path, Setup(said.sensors, {}), SOURCES)
    solid = Radar3D((0.0, 0.0, 0.0), 50.0, 1e-3, 1e-3, "west", from_north=True)
    with pytest.raises(InvalidInputError, match="'west' must be a 2-D radar"):
        asterix.read(path, Setup((solid, *said.sensors[1:]), {}, origin=ORIGIN), SOURCES)
