"""Heights in tables: slant ranges and places on the earth, into the common frame and back."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from probreg.errors import InvalidInputError
from probreg.recordings import setup_file, table
from probreg.sensors.frame import LocalFrame
from probreg.sensors.geometry import wrap_angle

NORTH, SOUTH = (50.1, 8.1, 250.0), (49.4, 8.6, 120.0)


def setup_of(tmp_path, dim=2, from_north=True, **top):
    lines = [f"{key} = {value}" for key, value in top.items()]
    if dim == 3:
        lines += ["origin = {latitude_deg = 50.1, longitude_deg = 8.1, height_m = 250}"]
    for name, place in (("north", NORTH), ("south", SOUTH)) if dim == 2 else ():
        lines += ["[[sensor]]", f'name = "{name}"', 'kind = "radar2d"']
        keys = ("latitude_deg", "longitude_deg", "height_m")
        lines += [f"{key} = {one}" for key, one in zip(keys, place, strict=True)]
        lines += ["sigma_range_m = 50", "sigma_azimuth_deg = 0.1"]
        lines += [f"from_north = {str(from_north).lower()}"]
    for name in ("adsb", "mlat") if dim == 3 else ("adsb",):
        sigma = "[10, 10, 30]" if dim == 3 else "10"
        lines += ["[[sensor]]", f'name = "{name}"', 'kind = "position"', f"sigma_m = {sigma}"]
    path = tmp_path / "sensors.toml"
    path.write_text("\n".join(lines))
    return setup_file.read(path)


def aircraft(n=150, seed=3):
    rng = np.random.default_rng(seed)
    lows, highs = (49.0, 7.0, 2e3), (50.5, 9.5, 11e3)
    return rng.uniform(lows, highs, (n, 3))


def reports(places, from_north=True):
    """Slant range and azimuth from true north at each radar, by earth-centred geometry alone."""
    parts = []
    for name, site in (("north", NORTH), ("south", SOUTH)):
        local = LocalFrame(*site).from_geodetic(places)
        azimuth = np.rad2deg(np.arctan2(local[:, 0], local[:, 1]))
        parts.append(
            pd.DataFrame(
                {
                    "time_s": np.arange(len(places)) + (0.5 if name == "south" else 0.0),
                    "sensor": name,
                    "range_m": np.linalg.norm(local, axis=1),
                    "azimuth_deg": np.mod(azimuth if from_north else 90.0 - azimuth, 360.0),
                    "height_m": places[:, 2],
                }
            )
        )
    return pd.concat([*parts, geodetic("adsb", places, 0.2)]).sort_values("time_s")


def geodetic(name, places, offset):
    columns = dict(zip(("latitude_deg", "longitude_deg", "height_m"), places.T, strict=True))
    return pd.DataFrame({"time_s": np.arange(len(places)) + offset, "sensor": name, **columns})


def where(sensor, values):
    """Places of reports without the allowance for noise that `to_cartesian` makes."""
    if sensor.position is None:
        return values
    azimuth = 0.5 * np.pi - values[:, 1] if sensor.from_north else values[:, 1]
    line = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    return sensor.position + values[:, :1] * line


def save(frame, path):
    frame.to_csv(path, index=False)
    return path


@pytest.mark.parametrize("from_north", [True, False])
def test_slant_ranges_with_heights_are_where_the_aircraft_are(tmp_path, from_north):
    places, setup = aircraft(), setup_of(tmp_path, from_north=from_north)
    found = table.read(save(reports(places, from_north), tmp_path / "r.csv"), setup)
    true = LocalFrame(*NORTH).from_geodetic(places)[:, :2]
    recording = found.recording
    for k, sensor in enumerate(setup.sensors):
        there = where(sensor, recording.values[recording.sensor == k, :2])
        np.testing.assert_allclose(there, true, atol=0.02)
    assert not any("ground" in note for note in found.notes)
    # the negative control: without heights they are hundreds of metres away, and it is said
    frame = reports(places, from_north)
    frame.loc[frame.sensor != "adsb", "height_m"] = np.nan
    flat = table.read(save(frame, tmp_path / "flat.csv"), setup)
    rows = flat.recording.sensor == 1
    there = where(setup.sensors[1], flat.recording.values[rows, :2])
    assert np.median(np.linalg.norm(there - true, axis=1)) > 100.0
    assert sum("ground ranges" in note for note in flat.notes) == 2


def test_what_is_written_is_slant_range_again(tmp_path):
    setup = setup_of(tmp_path)
    like = save(reports(aircraft()), tmp_path / "in.csv")
    old = table.read(like, setup)
    values = old.recording.values - np.where(old.recording.sensor[:, None] == 1, [90, 0.01], 0.0)
    new = dataclasses.replace(old.recording, values=values)
    table.write(tmp_path / "out.csv", new, like=like, setup=setup)
    again = table.read(tmp_path / "out.csv", setup).recording
    np.testing.assert_allclose(again.values[:, 0], values[:, 0], atol=1e-3)
    radar = old.recording.sensor < 2
    turned = wrap_angle(again.values[radar, 1] - values[radar, 1])
    np.testing.assert_allclose(turned, 0.0, atol=1e-7)
    before, after = (pd.read_csv(tmp_path / f"{name}.csv", dtype=str) for name in ("in", "out"))
    assert (before["height_m"] == after["height_m"]).all()
    still = (before["sensor"] == "north").to_numpy()
    assert (before["range_m"] == after["range_m"]).to_numpy()[still].all()
    # a slant range changes by less than the range in the plane: by the cosine of elevation
    moved = (before["range_m"].astype(float) - after["range_m"].astype(float)).to_numpy()
    south = (before["sensor"] == "south").to_numpy()
    assert np.median(moved[south]) == pytest.approx(90.0, abs=1.0)
    assert moved[south].min() < 85.0
    table.write(tmp_path / "same.csv", old.recording, like=like, setup=setup)
    assert (tmp_path / "same.csv").read_bytes() == like.read_bytes()


def test_without_an_origin_heights_count_from_the_plane(tmp_path):
    text = "".join(
        f'[[sensor]]\nname = "{name}"\nkind = "radar2d"\nposition_m = [0, {y}, {up}]\n'
        "sigma_range_m = 50\nsigma_azimuth_deg = 0.1\n"
        for name, y, up in (("a", 0, 100), ("b", 3e3, 0))
    )
    (tmp_path / "s.toml").write_text(text)
    setup = setup_file.read(tmp_path / "s.toml")
    frame = pd.DataFrame(
        {
            "time_s": [0.0, 1.0],
            "sensor": ["a", "b"],
            "range_m": [5e3, 5e3],
            "azimuth_deg": 0.0,
            "height_m": [3100.0, 4e3],
        }
    )
    found = table.read(save(frame, tmp_path / "r.csv"), setup, trust_units=True)
    np.testing.assert_allclose(found.recording.values[:, 0], [4e3, 3e3])
    frame.loc[1, "height_m"] = 6e3
    with pytest.raises(InvalidInputError, match=r"line 3: no target can be 5000 m .* 6000 m high"):
        table.read(save(frame, tmp_path / "r.csv"), setup, trust_units=True)


def test_heights_in_part_are_refused(tmp_path):
    frame = reports(aircraft())
    frame.iloc[3, frame.columns.get_loc("height_m")] = np.nan
    with pytest.raises(InvalidInputError, match=r"line 5: height_m is empty.*\(1 of 150"):
        table.read(save(frame, tmp_path / "r.csv"), setup_of(tmp_path))


@pytest.mark.parametrize("dim", [2, 3])
def test_positions_may_be_latitudes_and_are_written_so(tmp_path, dim):
    places, setup = aircraft(), setup_of(tmp_path, dim)
    frame = reports(places)
    if dim == 3:
        frame = pd.concat([geodetic("adsb", places, 0.0), geodetic("mlat", places, 0.4)])
    like = save(frame.sort_values("time_s"), tmp_path / "in.csv")
    old = table.read(like, setup)
    k = len(setup.sensors) - 1
    own = old.recording.sensor == k
    true = LocalFrame(*NORTH).from_geodetic(places)[:, :dim]
    np.testing.assert_allclose(old.recording.values[own, :dim], true, atol=1e-6)
    values = old.recording.values + np.where(own[:, None], 25.0, 0.0)
    table.write(
        tmp_path / "out.csv",
        dataclasses.replace(old.recording, values=values),
        like=like,
        setup=setup,
    )
    again = table.read(tmp_path / "out.csv", setup).recording
    np.testing.assert_allclose(again.values[own, :dim], true + 25.0, atol=1e-3)


def test_latitudes_without_an_origin_are_refused(tmp_path):
    text = "".join(
        f'[[sensor]]\nname = "{name}"\nkind = "position"\nsigma_m = 5\n' for name in "ab"
    )
    (tmp_path / "s.toml").write_text(text)
    like = save(geodetic("a", aircraft(), 0.0), tmp_path / "r.csv")
    with pytest.raises(InvalidInputError, match="give it an origin"):
        table.read(like, setup_file.read(tmp_path / "s.toml"))


def test_heights_of_radars_survive_a_setup_file(tmp_path):
    setup = setup_of(tmp_path)
    assert setup.heights_m == {"north": 250.0, "south": 120.0}
    setup_file.write(tmp_path / "again.toml", setup)
    again = setup_file.read(tmp_path / "again.toml")
    assert again.heights_m == pytest.approx(setup.heights_m, abs=1e-6)
    assert again.sensors == setup.sensors
