"""What lies beside the page: numbers, draws, the corrected recording; and the way back."""

from __future__ import annotations

import json

import arviz
import numpy as np
import pandas as pd
import pytest
import xarray

from probreg.page import Provenance, checksum, matters, write
from probreg.recordings import (
    bias_model,
    correct,
    read,
    read_biases,
    restore,
    setup_file,
    table,
    write_changed,
)
from probreg.registration import LAWS, register
from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene
from probreg.sensors.geometry import wrap_angle
from tests.page.conftest import command

FILES = {
    "report.html",
    "biases.csv",
    "biases.json",
    "posterior.nc",
    "tracks.parquet",
    "reports.parquet",
    "corrected.csv",
    "manifest.json",
}


def test_the_command_says_what_it_found(done):
    assert done.code == 0, done.err
    assert done.err == ""
    assert {path.name for path in done.result.iterdir()} == FILES
    assert "radar1.azimuth" in done.out
    assert str(done.result / "report.html") in done.out


def test_the_reports_used_are_told_by_sensor(done):
    used = json.loads((done.result / "manifest.json").read_text())["checks"]["reports_used"]
    reports = pd.read_csv(done.demo / "reports.csv")["sensor"].value_counts()
    assert set(used) == set(reports.index)
    page = (done.result / "report.html").read_text()
    for name, count in used.items():
        assert 0 < count <= reports[name]
        assert f"{name} {reports[name]:,}, used {count:,}" in page


def test_reports_are_named_by_their_lines_as_in_errors(done, tmp_path):
    lines = (done.demo / "reports.csv").read_text().splitlines()
    path = tmp_path / "reports.csv"
    path.write_text("\n".join([*lines[:5], "", *lines[5:]]) + "\n")
    source = read(path, setup_file.read(done.demo / "sensors.toml"))
    text = path.read_text().splitlines()
    for report in (0, 3, 10, 1_999):
        line = int(source.row_name(report).removeprefix("line "))
        time = float(text[line - 1].split(",")[0])
        assert time == source.recording.time[report]
    assert "line " in (done.result / "report.html").read_text().split('id="suspect-table"')[1]


def test_biases_cover_the_truth(done):
    truth = json.loads((done.demo / "truth.json").read_text())["bias"]
    content = json.loads((done.result / "biases.json").read_text())["biases"]
    # 6 biases at 4.5 posterior standard deviations: false alarm about 1e-4 with some tail
    assert set(truth) == {row["name"] for row in content}
    for row in content:
        assert abs(row["mean"] - truth[row["name"]]) < 4.5 * row["sd"]
        assert row["low_90"] < row["low_50"] < row["mean"] < row["high_50"] < row["high_90"]


def test_csv_and_json_agree(done):
    rows = pd.read_csv(done.result / "biases.csv").set_index("name")
    content = json.loads((done.result / "biases.json").read_text())
    for bias in content["biases"]:
        row = rows.loc[bias["name"]]
        factor = np.rad2deg(1.0) if bias["unit"] == "rad" else 1.0
        assert row.unit == ("deg" if bias["unit"] == "rad" else bias["unit"])
        assert row["mean"] == pytest.approx(factor * bias["mean"], rel=1e-12)
    limited = rows[rows.limit.notna()]
    assert list(limited.index) == ["radar1.azimuth"]
    assert limited.limit.iloc[0] == pytest.approx(5.0)
    covariance = np.array(content["covariance"])
    np.testing.assert_allclose(
        np.sqrt(np.diag(covariance)), [bias["sd"] for bias in content["biases"]], rtol=1e-9
    )


def test_draws_open_with_arviz_and_xarray(done):
    content = json.loads((done.result / "biases.json").read_text())
    draws = arviz.from_netcdf(done.result / "posterior.nc")
    for bias in content["biases"]:
        values = draws["posterior"][bias["name"]]
        assert float(values.mean()) == pytest.approx(bias["mean"], rel=1e-9)
        assert values.attrs["units"] == bias["unit"]
    with xarray.open_dataset(
        done.result / "posterior.nc", group="posterior", engine="h5netcdf"
    ) as opened:
        assert opened.sizes["chain"] == 4


def test_the_manifest_vouches_for_every_file(done):
    manifest = json.loads((done.result / "manifest.json").read_text())
    assert set(manifest["outputs"]) == FILES - {"manifest.json"}
    for name, told in manifest["outputs"].items():
        assert checksum(done.result / name) == told
    assert manifest["inputs"]["reports.csv"] == checksum(done.demo / "reports.csv")
    assert manifest["seed"] == 0
    assert manifest["settings"]["law"] == "Gaussian, Contaminated, StudentT"
    assert manifest["versions"]["probreg"]
    assert not [path for path in done.demo.iterdir() if path.name.endswith(".part")]


def test_correction_takes_the_biases_out_and_restoring_puts_them_back(done, tmp_path):
    setup = setup_file.read(done.demo / "sensors.toml")
    before = table.read(done.demo / "reports.csv", setup).recording
    after = table.read(done.result / "corrected.csv", setup).recording
    bias = json.loads((done.result / "biases.json").read_text())["biases"]
    means = {row["name"]: row["mean"] for row in bias}
    for k, sensor in enumerate(setup.sensors):
        rows = before.sensor == k
        change = before.values[rows] - after.values[rows]
        np.testing.assert_allclose(change[:, 0], means[f"{sensor.name}.range"], atol=1e-6)
        turned = wrap_angle(change[:, 1] - means[f"{sensor.name}.azimuth"])
        np.testing.assert_allclose(turned, 0.0, atol=1e-12)
    ways = ("--sensors", done.demo / "sensors.toml", "--biases", done.result / "biases.json")
    back = command("restore", done.result / "corrected.csv", *ways, "--out", tmp_path / "back.csv")
    assert back.returncode == 0, back.stderr
    again = table.read(tmp_path / "back.csv", setup).recording
    np.testing.assert_allclose(again.values[:, 0], before.values[:, 0], rtol=1e-9)
    np.testing.assert_allclose(wrap_angle(again.values[:, 1] - before.values[:, 1]), 0.0, atol=1e-9)
    np.testing.assert_array_equal(again.time, before.time)


def test_the_same_seed_gives_the_same_numbers_again_and_replaces_the_result(done, tmp_path):
    folder = tmp_path / "twice"
    inputs = (done.demo / "reports.csv", "--sensors", done.demo / "sensors.toml")
    first = command("register", *inputs, "--out", folder, "--quiet")
    assert (first.returncode, first.stdout, first.stderr) == (0, "", "")
    # the draws hold the time they were made at
    for name in FILES - {"posterior.nc", "manifest.json", "report.html"}:
        assert (folder / name).read_bytes() == (done.result / name).read_bytes()
    (folder / "mine.txt").write_text("kept")
    assert command("register", *inputs, "--out", folder, "--law", "Gaussian").returncode == 0
    assert (folder / "mine.txt").read_text() == "kept"
    assert json.loads((folder / "biases.json").read_text())["noise"]["law"] == "Gaussian"


def test_clock_biases_are_corrected_and_restored_in_the_order_of_the_file(tmp_path):
    names = {"radar1.range": 30.0, "radar2.time": 0.7, "radar3.azimuth": 0.004}
    scene = TrafficScene(reports=800, biases=names)
    reports, sensors, _ = demonstration(tmp_path / "in", np.random.default_rng(2), scene)
    setup = setup_file.read(sensors)
    source = read(reports, setup)
    theta = np.array([names.get(name, 0.0) for name in bias_model(setup).names])
    write_changed(tmp_path / "out.csv", source, setup, theta, correct)
    old, new = pd.read_csv(reports), pd.read_csv(tmp_path / "out.csv")
    late = old.sensor == "radar2"
    np.testing.assert_allclose((old.time_s - new.time_s)[late], 0.7, atol=1e-9)
    assert (old.time_s == new.time_s)[~late].all()
    assert (old.sensor == new.sensor).all()
    assert (old.target == new.target).all()
    near = old.sensor == "radar1"
    np.testing.assert_allclose((old.range_m - new.range_m)[near], 30.0, atol=1e-9)
    moved = read(tmp_path / "out.csv", setup)
    write_changed(tmp_path / "back.csv", moved, setup, theta, restore)
    back = pd.read_csv(tmp_path / "back.csv")
    for name in ("time_s", "range_m", "azimuth_deg"):
        np.testing.assert_allclose(back[name], old[name], rtol=1e-9, atol=1e-9)


def test_python_writes_the_same_and_says_what_matters(tmp_path):
    reports, sensors, _ = demonstration(
        tmp_path / "in", np.random.default_rng(5), TrafficScene(reports=800)
    )
    text = sensors.read_text()
    sensors.write_text(text.replace('"azimuth"]', '"azimuth"]\nlimits = {range_m = 0.001}', 1))
    setup = setup_file.read(sensors)
    recording = table.read(reports, setup).recording
    found = register(recording, setup, rng=np.random.default_rng(1), laws=LAWS[:1])
    write(found, tmp_path / "out", provenance=Provenance(seed=1))
    assert {path.name for path in (tmp_path / "out").iterdir()} == FILES
    theta = read_biases(tmp_path / "out" / "biases.json", found.names)
    np.testing.assert_array_equal(theta, found.mean)
    assert any("radar1.range exceeds its limit of 0.001 m" in text for text in matters(found))
    assert "Read this before you use the numbers" in (tmp_path / "out/report.html").read_text()
    corrected = table.read(tmp_path / "out" / "corrected.csv", setup).recording
    wanted = found.correct().values
    np.testing.assert_allclose(corrected.values[:, 0], wanted[:, 0], rtol=1e-12)
    turned = wrap_angle(corrected.values[:, 1] - wanted[:, 1])
    np.testing.assert_allclose(turned, 0.0, atol=1e-12)
