"""The engineer's file: units by name, places on the earth, and errors that name the key."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.recordings import Recording, Setup, setup_file
from probreg.sensors import BearingSensor, PositionSensor, Radar2D, Radar3D
from probreg.sensors.frame import LocalFrame

FULL = """
acceleration_m_s2 = 2.5
window_s = 12
gate_m = 800.0

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
        Radar2D((-40e3, 1e3), 50.0, 0.1 * deg, "west", from_north=True),
        BearingSensor(0.5 * deg, "ship", from_north=False),
        PositionSensor(((400.0, 0.0), (0.0, 400.0)), "adsb"),
    )
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
    assert (setup.acceleration_m_s2, setup.window_s, setup.gate_m) == (2.5, 12.0, 800.0)
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
    np.testing.assert_allclose(setup.sensors[0].position, [0, 0], atol=1e-6)
    frame = LocalFrame(50.0, 8.0, 80.0)
    expected = frame.from_geodetic(np.array([50.2, 8.4, 0.0]))[:2]
    np.testing.assert_allclose(setup.sensors[1].position, expected, atol=1e-9)
    origin = "origin = {latitude_deg = 51.0, longitude_deg = 8.0, height_m = 0}\n"
    moved = read(tmp_path, origin + two + radar("c"))
    assert moved.origin == (51.0, 8.0, 0.0)
    assert moved.sensors[0].position[1] < -100e3
    assert moved.sensors[2].position == (0.0, 0.0)


def test_what_is_written_is_read_again(tmp_path):
    for text in (FULL, radar(kind='"radar3d"', sigma_elevation_deg="0.2"), radar(**places(50, 8))):
        setup = read(tmp_path, text)
        setup_file.write(tmp_path / "again.toml", setup)
        again = setup_file.read(tmp_path / "again.toml")
        for field in dataclasses.fields(Setup):
            if field.name in ("prior_sd", "limits"):
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


def test_correlated_errors_cannot_be_written(tmp_path):
    sensor = PositionSensor(((2.0, 1.0), (1.0, 2.0)), "p")
    with pytest.raises(InvalidInputError, match="correlate"):
        setup_file.write(tmp_path / "s.toml", Setup((sensor,), {"p": ()}))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["no sensors"]),
        ("window = 3\n" + radar(), ["'window'", "window_s"]),
        (radar(sigma_range="50"), ["'sigma_range'", "sigma_range_m", "'a'"]),
        (radar(sigma_elevation_deg="1"), ["'sigma_elevation_deg'"]),
        (radar(sigma_range_m=None), ["'a'", "lacks 'sigma_range_m'"]),
        (radar(sigma_range_m='"fifty"'), ["sigma_range_m", "'fifty'"]),
        (radar(sigma_range_m="-1"), ["sigma_range_m", "above zero"]),
        (radar(kind='"lidar"'), ["'lidar'", "bearing, position, radar2d, radar3d, tracker2d"]),
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
        ("window_s = 0\n" + radar(), ["window_s", "above zero"]),
        ("origin = 3\n" + radar(), ["origin", "table"]),
        ("origin = {lat = 3}\n" + radar(), ["'lat'", "latitude_deg"]),
        ("window_s = \n", ["not TOML", "line 1"]),
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
