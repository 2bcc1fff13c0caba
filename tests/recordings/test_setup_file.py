"""The engineer's file: units by name, places on the earth, and errors that name the key."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.recordings import Recording, Setup, observing_axes, setup_file, table
from probreg.sensors import (
    Barometer,
    BearingSensor,
    Height,
    PositionSensor,
    Radar2D,
    Radar3D,
)
from probreg.sensors.frame import LocalFrame

FULL = """
acceleration_m_s2 = 2.5
gate_m = 800.0
target_height = {mean_m = 9e3, sd_m = 2e3}
target_terms = {range_m = 20, azimuth_deg = 0.1, time_s = 0.2, height_gain = 0.01}

[[sensor]]
name = "west"
kind = "radar2d"
position_m = [-40e3, 1e3, 120]
sigma_range_m = 50
sigma_azimuth_deg = 0.1
biases = ["range", "azimuth", "range_gain", "azimuth_sine", "time"]
prior_sd = {range_m = 100, azimuth_deg = 1, range_gain = 1e-3, azimuth_sine_deg = 0.5, time_s = 0.2}
limits = {azimuth_deg = 0.1}

[[sensor]]
name = "ship"
kind = "bearing"
sigma_azimuth_deg = 0.5
from_north = false
body_frame = true
biases = ["bearing", "heading"]
prior_sd = {heading_deg = 2.0}

[[sensor]]
name = "adsb"
kind = "position"
sigma_m = 20
reference = true
"""

HEIGHTS = """
[[sensor]]
name = "up"
kind = "barometer"
sigma_height_m = 8
prior_sd = {height_m = 100, height_gain = 0.01}

[[sensor]]
name = "sure"
kind = "height"
sigma_height_m = 15
"""
ORIGIN = "origin = {{latitude_deg = 50, longitude_deg = 8, height_m = {}}}\n"


def radar(name="a", **changes):
    keys = {
        "kind": '"radar2d"',
        "position_m": "[0, 0, 0]",
        "sigma_range_m": "50",
        "sigma_azimuth_deg": "0.1",
    } | changes
    lines = [f"{key} = {value}" for key, value in keys.items() if value is not None]
    return f'[[sensor]]\nname = "{name}"\n' + "\n".join(lines) + "\n"


def read(tmp_path, text):
    path = tmp_path / "sensors.toml"
    path.write_text(text)
    return setup_file.read(path)


def test_every_key_arrives_in_si_units(tmp_path):
    setup = read(tmp_path, FULL)
    deg = np.pi / 180.0
    assert setup.sensors == (
        Radar2D((-40e3, 1e3, 120.0), 50.0, 0.1 * deg, "west", from_north=True),
        BearingSensor(0.5 * deg, "ship", from_north=False),
        PositionSensor(((400.0, 0.0), (0.0, 400.0)), "adsb"),
    )
    assert setup.dim == 2
    assert setup.target_height == (9e3, 2e3)
    terms = {"range": 20.0, "azimuth": 0.1 * deg, "time": 0.2, "height_gain": 0.01}
    assert setup.target_terms == pytest.approx(terms, rel=1e-12)
    assert setup.biases == {
        "west": ("range", "azimuth", "range_gain", "azimuth_sine", "time"),
        "ship": ("bearing", "heading"),
        "adsb": (),
    }
    expected = {
        "west.range": 100.0,
        "west.azimuth": deg,
        "west.range_gain": 1e-3,
        "west.azimuth_sine": 0.5 * deg,
        "west.time": 0.2,
        "ship.heading": 2.0 * deg,
    }
    assert setup.prior_sd == pytest.approx(expected, rel=1e-12)
    assert setup.limits == pytest.approx({"west.azimuth": 0.1 * deg}, rel=1e-12)
    assert setup.body_frame == {"ship"}
    assert (setup.acceleration_m_s2, setup.gate_m) == (2.5, 800.0)
    assert setup.origin is None


def test_three_dimensions_and_the_default_biases(tmp_path):
    text = radar(kind='"radar3d"', sigma_elevation_deg="0.2") + (
        '[[sensor]]\nname = "ref"\nkind = "position"\nsigma_m = [10, 10, 30]\nreference = true\n'
        '[[sensor]]\nname = "pos"\nkind = "position"\nsigma_m = 5\n'
    )
    setup = read(tmp_path, text)
    assert setup.sensors[0] == Radar3D(
        (0.0, 0.0, 0.0), 50.0, np.deg2rad(0.1), np.deg2rad(0.2), "a", from_north=True
    )
    assert setup.biases["a"] == ("range", "azimuth", "elevation")
    np.testing.assert_array_equal(np.diag(setup.sensors[1].noise_covariance), [100, 100, 900])
    assert setup.sensors[2].dim == 3
    assert setup.biases["pos"] == ("x", "y", "z")


def earth_centred(places):
    """Textbook ellipsoid, by hand."""
    lat, lon = np.deg2rad(places[..., 0]), np.deg2rad(places[..., 1])
    a, f = 6378137.0, 1 / 298.257223563
    e2 = f * (2 - f)
    n = a / np.sqrt(1 - e2 * np.sin(lat) ** 2)
    h = places[..., 2]
    return np.stack(
        [
            (n + h) * np.cos(lat) * np.cos(lon),
            (n + h) * np.cos(lat) * np.sin(lon),
            (n * (1 - e2) + h) * np.sin(lat),
        ],
        axis=-1,
    )


def east_north_up(lat, lon):
    lat, lon = np.deg2rad(lat), np.deg2rad(lon)
    return np.array(
        [
            [-np.sin(lon), np.cos(lon), 0.0],
            [-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)],
            [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)],
        ]
    )


def test_the_local_frame_is_that_of_the_ellipsoid_by_hand():
    origin = np.array([50.0, 8.5, 100.0])
    places = np.array([[50.3, 9.4, 300.0], [49.2, 8.5, 0.0], [50.0, 6.0, 9_000.0]])
    frame = LocalFrame(*origin)
    expected = (earth_centred(places) - earth_centred(origin)) @ east_north_up(50.0, 8.5).T
    found = frame.from_geodetic(places)
    np.testing.assert_allclose(found, expected, atol=1e-6)
    np.testing.assert_allclose(frame.to_geodetic(found)[:, :2], places[:, :2], atol=1e-10)


def test_true_north_of_another_place_is_turned_by_the_convergence():
    frame = LocalFrame(60.0, 10.0, 0.0)
    place = np.array([60.2, 11.5, 50.0])
    here = frame.from_geodetic(place)
    step = frame.from_geodetic(place + np.array([1e-5, 0.0, 0.0])) - here
    expected = np.arctan2(step[0], step[1])
    np.testing.assert_allclose(frame.convergence(here), expected, atol=1e-7)
    # a degree and a half of longitude, at 60 degrees: not a small thing
    assert np.rad2deg(abs(expected)) > 1.2
    np.testing.assert_allclose(frame.convergence(np.zeros(2)), 0.0, atol=1e-12)


def places(lat, lon, height=0.0):
    return {
        "position_m": None,
        "latitude_deg": lat,
        "longitude_deg": lon,
        "height_m": height,
    }


def test_sensors_by_latitude_are_put_about_the_origin_or_the_first_of_them(tmp_path):
    two = radar("a", **places(50.0, 8.0, 80.0)) + radar("b", **places(50.2, 8.4))
    setup = read(tmp_path, two)
    assert setup.origin == (50.0, 8.0, 80.0)
    np.testing.assert_allclose(setup.sensors[0].position, [0, 0, 0], atol=1e-6)
    assert setup.places == {"a": (50.0, 8.0, 80.0), "b": (50.2, 8.4, 0.0)}
    assert setup.dim == 3
    assert all(setup.refracted(sensor) for sensor in setup.sensors)
    frame = LocalFrame(50.0, 8.0, 80.0)
    expected = frame.from_geodetic(np.array([50.2, 8.4, 0.0]))
    np.testing.assert_allclose(setup.sensors[1].position, expected, atol=1e-9)
    origin = "origin = {latitude_deg = 51.0, longitude_deg = 8.0, height_m = 0}\n"
    moved = read(tmp_path, origin + two + radar("c"))
    assert moved.origin == (51.0, 8.0, 0.0)
    assert moved.sensors[0].position[1] < -100e3
    assert moved.sensors[2].position == (0.0, 0.0, 0.0)
    assert not moved.refracted(moved.sensors[2])


def test_what_is_written_is_read_again(tmp_path):
    for text in (
        FULL,
        radar(kind='"radar3d"', sigma_elevation_deg="0.2"),
        radar(**places(50, 8), refraction='"none"'),
        'targets = "surface"\n' + radar(position_m="[1, 2]"),
        radar(**places(50, 8)) + HEIGHTS,
    ):
        setup = read(tmp_path, text)
        setup_file.write(tmp_path / "again.toml", setup)
        again = setup_file.read(tmp_path / "again.toml")
        for field in dataclasses.fields(Setup):
            if field.name in ("prior_sd", "limits", "target_terms"):
                expected = pytest.approx(getattr(setup, field.name), rel=1e-12)
                assert getattr(again, field.name) == expected
            elif field.name != "sensors":
                assert getattr(again, field.name) == getattr(setup, field.name)
        for one, two in zip(setup.sensors, again.sensors, strict=True):
            assert type(one) is type(two)
            for field in dataclasses.fields(one):
                value = getattr(one, field.name)
                assert getattr(two, field.name) == (
                    value if isinstance(value, str) else pytest.approx(np.array(value), rel=1e-12)
                )
    assert not list(tmp_path.glob("*.part"))


def test_sensors_of_heights_and_what_is_usual_for_them(tmp_path):
    setup = read(tmp_path, radar() + HEIGHTS)
    assert setup.sensors[1:] == (Barometer(8.0, "up"), Height(15.0, "sure"))
    assert setup.biases["up"] == ("height", "height_gain")
    assert setup.biases["sure"] == ()
    assert setup.prior_sd == pytest.approx({"up.height": 100.0, "up.height_gain": 0.01})
    assert setup.dim == 3


def test_who_is_refracted_and_how_many_dimensions_there_are(tmp_path):
    earth = radar("a", **places(50, 8)) + radar("b", **places(50, 9), refraction='"none"')
    setup = read(tmp_path, earth)
    assert [setup.refracted(sensor) for sensor in setup.sensors] == [True, False]
    sea = read(tmp_path, 'targets = "surface"\n' + earth)
    assert (setup.dim, sea.dim) == (3, 2)
    assert not any(sea.refracted(sensor) for sensor in sea.sensors)
    assert read(tmp_path, radar()).dim == 2
    assert read(tmp_path, radar() + HEIGHTS).dim == 3
    # an origin alone is a place on the earth; a sensor in metres is refracted if it says so
    metres = ORIGIN.format(0) + radar(refraction='"standard"') + radar("b")
    setup = read(tmp_path, metres)
    assert setup.dim == 3
    assert [setup.refracted(sensor) for sensor in setup.sensors] == [True, False]
    assert [axes.refracted for axes in observing_axes(setup)] == [True, False]


def test_a_key_that_is_no_longer_needed_is_read_and_said(tmp_path):
    setup = read(tmp_path, "window_s = 12\n" + radar())
    assert len(setup.notes) == 1
    assert "window_s is no longer needed" in setup.notes[0]
    assert read(tmp_path, radar()).notes == ()
    # readers of recordings pass it on
    text = "window_s = 12\n" + radar() + radar("b", position_m="[9e3, 0, 0]")
    reports = tmp_path / "r.csv"
    reports.write_text("time_s,sensor,range_m,azimuth_deg\n1,a,9e3,1\n2,b,9e3,2\n")
    assert setup.notes[0] in table.read(reports, read(tmp_path, text)).notes


def test_correlated_errors_cannot_be_written(tmp_path):
    sensor = PositionSensor(((2.0, 1.0), (1.0, 2.0)), "p")
    with pytest.raises(InvalidInputError, match="correlate"):
        setup_file.write(tmp_path / "s.toml", Setup((sensor,), {"p": ()}))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["no sensors"]),
        ("gate = 3\n" + radar(), ["'gate'", "gate_m"]),
        (radar(sigma_range="50"), ["'sigma_range'", "sigma_range_m", "'a'"]),
        (radar(sigma_elevation_deg="1"), ["'sigma_elevation_deg'"]),
        (radar(sigma_range_m=None), ["'a'", "lacks 'sigma_range_m'"]),
        (radar(sigma_range_m='"fifty"'), ["sigma_range_m", "'fifty'"]),
        (radar(sigma_range_m="-1"), ["sigma_range_m", "above zero"]),
        (radar(kind='"lidar"'), ["'lidar'", "barometer, bearing, height, position, radar2d"]),
        (radar(name=""), ["name"]),
        (radar(name="a.b"), ["without dots"]),
        (radar() + radar(), ["'a'", "twice"]),
        (radar(position_m="[1]"), ["position_m", "1 numbers"]),
        (radar(position_m=None), ["lacks position_m"]),
        (radar(latitude_deg="50"), ["keep one"]),
        (radar(position_m=None, latitude_deg="50"), ["lacks 'longitude_deg'"]),
        (radar(**places(95, 8)), ["95"]),
        (radar("b", **places(50, 8)) + radar(), ["'b'", "'a'", "origin"]),
        (radar(from_north='"yes"'), ["from_north", "true or false"]),
        (radar(biases="[1]"), ["list of names"]),
        (radar(biases='["range", "range"]'), ["repeat"]),
        (radar(reference="true", biases='["range"]'), ["reference", "drop one"]),
        (radar(prior_sd="{azimuth = 1}"), ["'azimuth'", "azimuth_deg"]),
        (radar(prior_sd="{azimuth_m = 1}"), ["'azimuth_m'", "azimuth_deg"]),
        (radar(biases='["range"]', prior_sd="{azimuth_deg = 1}"), ["'azimuth_deg'", "range_m"]),
        (radar(limits="{range_m = 0}"), ["range_m", "above zero"]),
        (radar(limits="3"), ["limits", "table"]),
        (radar(asterix="[25]"), ["asterix", "'a'", "[SAC, SIC]"]),
        (radar(asterix="[25, true]"), ["asterix", "[SAC, SIC]"]),
        (radar(asterix="[25, 256]"), ["asterix", "[SAC, SIC]"]),
        (radar(asterix="[1, 2]") + radar("b", asterix="[1, 2]"), ["'a'", "'b'", "[1, 2]"]),
        ("gate_m = 0\n" + radar(), ["gate_m", "above zero"]),
        ('targets = "sea"\n' + radar(), ["'sea'", "surface"]),
        ('targets = "surface"\n' + radar() + HEIGHTS, ["'up'", "surface", "air"]),
        ("target_height = 3\n" + radar(), ["target_height", "table"]),
        ("target_height = {mean_m = 3}\n" + radar(), ["target_height", "sd_m"]),
        (
            "target_height = {mean_m = 3, sd_m = 0}\n" + radar(),
            ["sd of target_height", "above zero"],
        ),
        ("target_height = {mean_m = 1e6, sd_m = 1}\n" + radar(), ["1e+06 m", "ellipsoid"]),
        ("target_terms = {range = 3}\n" + radar(), ["'range'", "range_m"]),
        ("target_terms = {bearing_deg = 3}\n" + radar(), ["'bearing_deg'", "azimuth_deg"]),
        (radar(**places(50, 8), refraction='"some"'), ["'a'", "'some'", "standard"]),
        (radar(refraction='"standard"'), ["refraction", "'a'", "origin"]),
        (radar(**places(50, 8, 25e3)), ["25000", "far above", "9000"]),
        (radar(**places(50, 8, -6371e3)), ["inside the earth"]),
        (ORIGIN.format(9e4) + radar(), ["the origin", "90000"]),
        ("origin = 3\n" + radar(), ["origin", "table"]),
        ("origin = {lat = 3}\n" + radar(), ["'lat'", "latitude_deg"]),
        ("gate_m = \n", ["not TOML", "line 1"]),
    ],
)
def test_an_error_names_the_file_the_key_and_what_is_known(tmp_path, text, words):
    with pytest.raises(InvalidInputError) as caught:
        read(tmp_path, text)
    for word in [*words, "sensors.toml"]:
        assert word in str(caught.value)


def test_files_that_cannot_be_read_or_written(tmp_path):
    with pytest.raises(InvalidInputError, match="nothing.toml cannot be read"):
        setup_file.read(tmp_path / "nothing.toml")
    (tmp_path / "bad.toml").write_bytes(b'name = "\xff"')
    with pytest.raises(InvalidInputError, match="not UTF-8 at byte 8"):
        setup_file.read(tmp_path / "bad.toml")
    setup = read(tmp_path, FULL)
    with pytest.raises(InvalidInputError, match="cannot be written"):
        setup_file.write(tmp_path / "no" / "s.toml", setup)


def test_a_recording_takes_bearings_beside_ranges(tmp_path):
    sensors = read(tmp_path, FULL).sensors[:2]
    values = np.array([[1e3, 0.5], [0.7, np.nan]])
    time = np.arange(2.0)
    recording = Recording(sensors, np.array([0, 1]), time, values, np.array([-1, -1]))
    np.testing.assert_array_equal(recording.values, values)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"places": {"x": (50.0, 8.0, 0.0)}}, r"\['x'\] are no sensors"),
        ({"refraction": {"x": "none"}}, r"\['x'\] are no sensors"),
        ({"geodetic": frozenset({"x"})}, r"\['x'\] are no sensors"),
        ({"places": {"a": (50.0, 8.0, 0.0)}}, "'a' has a latitude, and the setup no origin"),
        ({"origin": (50.0, 8.0, np.nan)}, "place of the origin"),
        ({"targets": "land"}, "'land'; one of"),
        ({"target_terms": {"heading": 1.0}}, "target_terms has 'heading'"),
        ({"target_terms": {"range": -1.0}}, "target_terms of range"),
        ({"target_height": (9e3, -1.0)}, "sd of target_height"),
    ],
)
def test_setups_that_cannot_be_are_refused(changes, message):
    sensors = (Radar2D((0.0, 0.0), 50.0, 1e-3, "a"),)
    with pytest.raises(InvalidInputError, match=message):
        Setup(sensors, {}, **changes)
