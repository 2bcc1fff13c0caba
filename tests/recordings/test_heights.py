"""Heights in tables: reports of their own beside plots, read, corrected and written again."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from probreg import recordings
from probreg.errors import InvalidInputError
from probreg.recordings import correct, observing_axes, restore, setup_file, table, write_changed
from probreg.sensors.frame import LocalFrame
from probreg.sensors.geometry import wrap_angle

NORTH, SOUTH = (50.1, 8.1, 250.0), (49.4, 8.6, 120.0)
FOOT = 0.3048


def setup_of(tmp_path, from_north=True, more="", **top):
    lines = [f"{key} = {value}" for key, value in top.items()]
    for name, place in (("north", NORTH), ("south", SOUTH)):
        lines += ["[[sensor]]", f'name = "{name}"', 'kind = "radar2d"', 'refraction = "none"']
        keys = ("latitude_deg", "longitude_deg", "height_m")
        lines += [f"{key} = {one}" for key, one in zip(keys, place, strict=True)]
        lines += ["sigma_range_m = 50", "sigma_azimuth_deg = 0.1"]
        lines += [f"from_north = {str(from_north).lower()}"]
    lines += ["[[sensor]]", 'name = "adsb"', 'kind = "position"', "sigma_m = [10, 10, 30]", more]
    path = tmp_path / "sensors.toml"
    path.write_text("\n".join(lines))
    return setup_file.read(path)


def aircraft(n=150, seed=3):
    rng = np.random.default_rng(seed)
    lows, highs = (49.0, 7.0, 2e3), (50.5, 9.5, 11e3)
    return rng.uniform(lows, highs, (n, 3))


def reports(places, from_north=True, column="height_m", scale=1.0):
    """Slant range and azimuth from true north at each radar, by earth-centred geometry alone."""
    parts = []
    for k, (name, site) in enumerate((("north", NORTH), ("south", SOUTH))):
        local = LocalFrame(*site).from_geodetic(places)
        azimuth = np.rad2deg(np.arctan2(local[:, 0], local[:, 1]))
        parts.append(
            pd.DataFrame(
                {
                    "time_s": np.arange(len(places)) + 0.5 * k,
                    "sensor": name,
                    "range_m": np.linalg.norm(local, axis=1),
                    "azimuth_deg": np.mod(azimuth if from_north else 90.0 - azimuth, 360.0),
                    column: places[:, 2] / scale,
                    "target": [f"t{i}" for i in range(len(places))],
                }
            )
        )
    where = dict(zip(("latitude_deg", "longitude_deg", "height_m"), places.T, strict=True))
    target = [f"t{i}" for i in range(len(places))]
    time = np.arange(len(places)) + 0.2
    parts.append(pd.DataFrame({"time_s": time, "sensor": "adsb", "target": target, **where}))
    return pd.concat(parts).sort_values("time_s", kind="stable")


def save(frame, path):
    frame.to_csv(path, index=False)
    return path


@pytest.mark.parametrize(
    ("column", "scale", "kind"),
    [
        ("height_m", 1.0, "height"),
        ("pressure_altitude_m", 1.0, "barometer"),
        ("flight_level", 100.0 * FOOT, "barometer"),
    ],
)
@pytest.mark.parametrize("from_north", [True, False])
def test_reports_in_their_own_axes_are_where_the_aircraft_are(
    tmp_path, from_north, column, scale, kind
):
    places, setup = aircraft(), setup_of(tmp_path, from_north)
    frame = reports(places, from_north, column, scale)
    found = table.read(save(frame, tmp_path / "r.csv"), setup)
    recording, whole = found.recording, found.setup
    assert [s.kind.name for s in whole.sensors] == ["radar2d", "radar2d", "position", kind]
    assert whole.biases[kind] == ((), ("height", "height_gain"))[kind == "barometer"]
    assert whole.geodetic == {"adsb"}
    assert whole.dim == 3
    x = LocalFrame(*NORTH).from_geodetic(places)[[int(t[1:]) for t in frame["target"]]]
    for k, axes in enumerate(observing_axes(whole)):
        rows = np.flatnonzero(recording.sensor == k)
        assert rows.size == len(places) * (2 if k == 3 else 1)
        seen = axes.observe(x[found.rows[rows]])
        q = seen.value.shape[1]
        off = recording.values[rows, :q] - seen.value
        off[:, axes.angles] = wrap_angle(off[:, axes.angles])
        np.testing.assert_allclose(off * seen.factor, 0.0, atol=1e-5)
    # heights came with the plots
    heights = np.flatnonzero(recording.sensor == 3)
    plots = recording.beside[heights]
    assert recording.alone.sum() == len(frame)
    assert (recording.sensor[plots] < 2).all()
    np.testing.assert_array_equal(found.rows[heights], found.rows[plots])
    np.testing.assert_array_equal(recording.target[heights], recording.target[plots])
    np.testing.assert_array_equal(recording.time[heights], recording.time[plots])
    where = recordings.places(recording, whole, recording.values)
    placed = np.isfinite(where).all(axis=1)
    np.testing.assert_array_equal(placed, recording.sensor < 3)
    np.testing.assert_allclose(where[placed], x[found.rows[placed]], atol=8.0)


def test_a_height_may_be_missing_and_the_nearest_of_the_target_serves(tmp_path):
    places = aircraft(30)
    frame = reports(places)
    lost = (frame["sensor"] == "north").to_numpy()
    frame.loc[lost | (frame["sensor"] == "adsb").to_numpy(), "height_m"] = np.nan
    found = table.read(save(frame, tmp_path / "r.csv"), setup_of(tmp_path))
    recording = found.recording
    assert len(recording) == len(frame) + 30
    adsb = recording.sensor == 2
    assert np.isnan(recording.values[adsb, 2]).all()
    where = recordings.places(recording, found.setup, recording.values)
    x = LocalFrame(*NORTH).from_geodetic(places)[[int(t[1:]) for t in frame["target"]]]
    placed = recording.sensor < 3
    np.testing.assert_allclose(where[placed], x[found.rows[placed]], atol=8.0)
    # a position without a height says where a target is at any height
    axes = observing_axes(found.setup)[2]
    for up in (0.0, 5e3):
        high = LocalFrame(*NORTH).from_geodetic(places + np.array([0.0, 0.0, up]))
        np.testing.assert_allclose(
            axes.observe(high).value[:, :2][found.recording.target[adsb]],
            recording.values[adsb, :2],
            atol=1e-5,
        )


@pytest.mark.parametrize("column", ["height_m", "pressure_altitude_m", "flight_level"])
def test_corrected_files_have_the_columns_they_came_with(tmp_path, column):
    places = aircraft(60)
    scale = 100.0 * FOOT if column == "flight_level" else 1.0
    frame = reports(places, column=column, scale=scale)
    like = save(frame.sample(frac=1.0, random_state=1), tmp_path / "in.csv")
    kind = "height" if column == "height_m" else "barometer"
    more = f'[[sensor]]\nname = "up"\nkind = "{kind}"\nsigma_height_m = 8\nbiases = '
    more += '["height", "height_gain"]'
    setup = dataclasses.replace(
        setup_of(tmp_path, more=more),
        biases={"south": ("range", "time"), "adsb": ("x", "z"), "up": ("height", "height_gain")},
    )
    source = recordings.read(like, setup)
    assert source.setup.sensors == setup.sensors
    theta = np.array([90.0, 0.25, 12.0, 7.0, 120.0, 0.01])
    write_changed(tmp_path / "out.csv", source, source.setup, theta, correct)
    before, after = (pd.read_csv(tmp_path / f"{name}.csv") for name in ("in", "out"))
    assert list(before.columns) == list(after.columns)
    moved = {name: before[name] - after[name] for name in ("time_s", "range_m", column)}
    south, adsb = (before["sensor"] == name for name in ("south", "adsb"))
    np.testing.assert_allclose(moved["range_m"][south], 90.0, atol=1e-8)
    np.testing.assert_allclose(moved["time_s"], np.where(south, 0.25, 0.0), atol=1e-9)
    radar = ~adsb
    error = (before[column] - (after[column] + (120.0 + 0.01 * scale * after[column]) / scale))[
        radar
    ]
    np.testing.assert_allclose(error, 0.0, atol=1e-8)
    frame_of = LocalFrame(*NORTH)
    keys = ["latitude_deg", "longitude_deg", "height_m"]
    shift = [frame_of.from_geodetic(table_[keys][adsb].to_numpy()) for table_ in (before, after)]
    np.testing.assert_allclose(
        np.linalg.norm(shift[0] - shift[1], axis=1), np.hypot(12, 7), rtol=3e-3
    )
    # a height moves in time with the plot that it came with
    moved_too = correct(source.recording, source.setup, theta)
    np.testing.assert_array_equal(moved_too.time, moved_too.time[moved_too.beside])
    # what is corrected is restored, to the bits that a float can keep
    corrected = recordings.read(tmp_path / "out.csv", setup)
    back = restore(corrected.recording, corrected.setup, theta)
    np.testing.assert_allclose(back.values, source.recording.values, atol=1e-6)
    np.testing.assert_array_equal(back.beside, source.recording.beside)
    write_changed(tmp_path / "same.csv", source, source.setup, 0.0 * theta, correct)
    assert (tmp_path / "same.csv").read_bytes() == like.read_bytes()


def test_without_an_origin_heights_count_from_the_plane(tmp_path):
    text = "".join(
        f'[[sensor]]\nname = "{name}"\nkind = "radar2d"\nposition_m = [0, {y}, {up}]\n'
        "sigma_range_m = 50\nsigma_azimuth_deg = 0.1\n"
        for name, y, up in (("a", 0, 100), ("b", 3e3, 0))
    )
    (tmp_path / "s.toml").write_text(text)
    setup = setup_file.read(tmp_path / "s.toml")
    assert setup.dim == 2
    columns = {"time_s": [0.0, 1.0], "sensor": ["a", "b"], "range_m": 5e3, "azimuth_deg": 0.0}
    frame = pd.DataFrame(columns | {"height_m": [3100.0, 4e3]})
    found = table.read(save(frame, tmp_path / "r.csv"), setup, trust_units=True)
    assert found.setup.dim == 3
    where = recordings.places(found.recording, found.setup, found.recording.values)
    wanted = [[0.0, 4e3, 3100.0], [0.0, 6e3, 4e3]]
    np.testing.assert_allclose(where[found.recording.alone], wanted, atol=1e-9)
    np.testing.assert_array_equal(found.recording.values[found.recording.alone, 0], 5e3)


def test_targets_on_the_surface_have_no_heights_and_it_is_said(tmp_path):
    setup = setup_of(tmp_path)
    flat = dataclasses.replace(setup, sensors=setup.sensors[:2], biases={}, targets="surface")
    frame = reports(aircraft())
    found = table.read(save(frame[frame["sensor"] != "adsb"], tmp_path / "r.csv"), flat)
    assert found.setup.dim == 2
    assert len(found.recording) == 300
    assert any("'height_m' is not used" in note for note in found.notes)


@pytest.mark.parametrize("targets", ["air", "surface"])
def test_positions_may_be_latitudes_and_are_written_so(tmp_path, targets):
    sigma = "[10, 10, 30]" if targets == "air" else "10"
    text = f'targets = "{targets}"\norigin = {{latitude_deg = 50, longitude_deg = 8, height_m = 0}}'
    for name in ("adsb", "mlat"):
        text += f'\n[[sensor]]\nname = "{name}"\nkind = "position"\nsigma_m = {sigma}'
    (tmp_path / "s.toml").write_text(text)
    setup = setup_file.read(tmp_path / "s.toml")
    places = aircraft()
    high = setup.dim == 3
    names = ("latitude_deg", "longitude_deg", "height_m")[: setup.dim]
    frames = [
        pd.DataFrame({"time_s": np.arange(150) + late, "sensor": name}).assign(
            **dict(zip(names, places.T, strict=False))
        )
        for name, late in (("adsb", 0.0), ("mlat", 0.4))
    ]
    like = save(pd.concat(frames).sort_values("time_s"), tmp_path / "in.csv")
    old = table.read(like, setup)
    assert old.setup.geodetic == {"adsb", "mlat"}
    own = old.recording.sensor == 1
    axes = observing_axes(old.setup)[1]
    ground = places if high else places * np.array([1.0, 1.0, 0.0])
    true = LocalFrame(50, 8, 0).from_geodetic(ground)[:, : setup.dim]
    np.testing.assert_allclose(axes.observe(true).value, old.recording.values[own], atol=1e-6)
    np.testing.assert_allclose(
        recordings.places(old.recording, old.setup, old.recording.values)[own], true, atol=1e-6
    )
    values = old.recording.values + np.where(own[:, None], 25.0, 0.0)
    new = dataclasses.replace(old.recording, values=values)
    table.write(tmp_path / "out.csv", new, like=like, setup=setup)
    again = table.read(tmp_path / "out.csv", setup).recording
    np.testing.assert_allclose(again.values, values, atol=1e-6)
    # 25 m to the east are 25 m on the ground, wherever they are
    cells = pd.read_csv(tmp_path / "out.csv")
    moved = cells[cells["sensor"] == "mlat"][list(names)].to_numpy()
    flat = np.zeros((150, 1))
    one = LocalFrame(50, 8, 0).from_geodetic(np.column_stack([places[:, :2], flat]))
    two = LocalFrame(50, 8, 0).from_geodetic(np.column_stack([moved[:, :2], flat]))
    size = np.linalg.norm(two - one, axis=1)
    np.testing.assert_allclose(size, 25.0 * np.sqrt(2.0), rtol=0.02)


def test_latitudes_without_an_origin_are_refused(tmp_path):
    text = "".join(
        f'[[sensor]]\nname = "{name}"\nkind = "position"\nsigma_m = 5\n' for name in "ab"
    )
    (tmp_path / "s.toml").write_text(text)
    frame = reports(aircraft())
    frame = frame[frame["sensor"] == "adsb"].assign(sensor="a").dropna(axis=1)
    with pytest.raises(InvalidInputError, match="give it an origin"):
        table.read(save(frame, tmp_path / "r.csv"), setup_file.read(tmp_path / "s.toml"))


def test_heights_that_look_like_feet(tmp_path):
    places, setup = aircraft(), setup_of(tmp_path)
    feet = reports(places, column="pressure_altitude_m", scale=FOOT)
    with pytest.raises(InvalidInputError, match="'pressure_altitude_m' .* look like feet"):
        table.read(save(feet, tmp_path / "r.csv"), setup)
    table.read(tmp_path / "r.csv", setup, trust_units=True)
    rounded = feet.assign(pressure_altitude_m=25.0 * np.rint(feet["pressure_altitude_m"] / 25.0))
    low = rounded.assign(pressure_altitude_m=rounded["pressure_altitude_m"].clip(upper=9_000.0))
    found = table.read(save(low, tmp_path / "r.csv"), setup)
    assert any("if these are feet" in note for note in found.notes)
    with pytest.raises(InvalidInputError, match="look like feet"):
        table.read(save(rounded.assign(height_m=np.nan), tmp_path / "r.csv"), setup)
    metres = reports(places)
    assert not table.read(save(metres, tmp_path / "r.csv"), setup).notes


def test_a_prior_that_excludes_the_heights(tmp_path):
    path = save(reports(aircraft()), tmp_path / "r.csv")
    with pytest.raises(InvalidInputError, match="target_height is 100 m, give or take 50 m"):
        table.read(path, setup_of(tmp_path, target_height="{mean_m = 100, sd_m = 50}"))
    said = table.read(path, setup_of(tmp_path, target_height="{mean_m = 5e3, sd_m = 1e3}")).notes
    assert any("widen it" in note for note in said)
    assert not table.read(path, setup_of(tmp_path, target_height="{mean_m=7e3, sd_m=3e3}")).notes


def test_whose_heights_they_are_must_be_clear(tmp_path):
    frame = reports(aircraft(), column="pressure_altitude_m")
    path = save(frame, tmp_path / "r.csv")
    two = "".join(
        f'\n[[sensor]]\nname = "{name}"\nkind = "barometer"\nsigma_height_m = 8' for name in "pq"
    )
    with pytest.raises(InvalidInputError, match=r"\['p', 'q'\] either"):
        table.read(path, setup_of(tmp_path, more=two))
    named = '\n[[sensor]]\nname = "barometer"\nkind = "position"\nsigma_m = 8'
    with pytest.raises(InvalidInputError, match="another sensor has that name"):
        table.read(path, setup_of(tmp_path, more=named))
    save(frame.assign(flight_level=1.0), path)
    with pytest.raises(InvalidInputError, match="say the same"):
        table.read(path, setup_of(tmp_path))


def test_a_radar_and_its_heights_are_one_sensor(tmp_path):
    setup = setup_of(tmp_path)
    alone = dataclasses.replace(
        setup, sensors=setup.sensors[:1], biases={}, places={"north": NORTH}, refraction={}
    )
    frame = reports(aircraft())
    with pytest.raises(InvalidInputError, match=r"one sensor only \(north\)"):
        table.read(save(frame[frame["sensor"] == "north"], tmp_path / "r.csv"), alone)


def test_equal_heights_at_one_instant_are_no_repetition_and_repeated_plots_are(tmp_path):
    frame = reports(aircraft(40), column="flight_level", scale=100.0 * FOOT)
    together = frame.assign(time_s=np.floor(frame["time_s"]))
    found = table.read(save(together, tmp_path / "r.csv"), setup_of(tmp_path))
    heights = found.recording.sensor == 3
    same = np.unique(found.recording.time[heights], return_counts=True)[1]
    assert (same == 2).all()
    twice = pd.concat([together, together.iloc[[5]]])
    with pytest.raises(InvalidInputError, match="line 122 repeats line 7"):
        table.read(save(twice, tmp_path / "r.csv"), setup_of(tmp_path))


def test_heights_leave_with_the_reports_they_came_with(tmp_path):
    found = table.read(save(reports(aircraft(40)), tmp_path / "r.csv"), setup_of(tmp_path))
    part = found.recording.only("north", "height")
    assert len(part) == 80
    np.testing.assert_array_equal(part.sensor[part.beside], 0)
    assert len(found.recording.only("adsb", "height")) == 40


def test_no_height_at_all_is_said(tmp_path):
    frame = reports(aircraft(40)).assign(height_m=np.nan)
    path = save(frame, tmp_path / "r.csv")
    assert "no report tells a height" in table.read(path, setup_of(tmp_path)).notes[0]
    known = setup_of(tmp_path, target_height="{mean_m = 9e3, sd_m = 2e3}")
    found = table.read(path, known)
    assert found.notes == ()
    # and the prior's mean is where they are placed
    recording = found.recording
    where = recordings.places(recording, found.setup, recording.values)
    up = LocalFrame(*NORTH).height(where)[0]
    np.testing.assert_allclose(up, 9e3, atol=30.0)
