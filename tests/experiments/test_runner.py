"""The runner: seeds, workers, interruption, failure, damaged files."""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from rich.console import Console

from experiments import results, runner
from experiments.results import load_result
from experiments.runner import run_study
from experiments.study import StudyError, configurations, load_study, study_names

ROOT = Path(__file__).parents[2]
SMALL = ["case=1", "replicates=3", "lms_subsets=5"]
EIGHT = ["case=1", "replicates=8", "lms_subsets=5"]  # to be stopped among


def quiet():
    return Console(file=io.StringIO())


def run(tmp_path, jobs=1, settings=SMALL, study="ralad"):
    found = load_study(study)
    ((label, config),) = configurations(found, "quick", settings)
    return run_study(found, label, config, tmp_path, jobs, quiet()), label


def command(tmp_path, *words):
    return [sys.executable, "-m", "experiments", *words, "--results", str(tmp_path)]


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    folder, label = run(tmp_path_factory.mktemp("one"), jobs=1)
    return folder, label


def same_bits(one: Path, two: Path) -> bool:
    return (one / "results.nc").read_bytes() == (two / "results.nc").read_bytes()


def test_two_workers_give_the_same_bits_as_one(tmp_path, reference):
    folder, _ = run(tmp_path, jobs=2)
    assert same_bits(folder, reference[0])


def test_replicates_do_not_depend_on_their_order(reference):
    study = load_study("ralad")
    ((_, config),) = configurations(study, "quick", SMALL)
    saved = xr.load_dataset(reference[0] / "results.nc", engine="h5netcdf")
    for k in (2, 0):
        alone = runner.draw_replicate("ralad", config, k)
        np.testing.assert_array_equal(alone["theta"], saved["theta"].isel(replicate=k))
    assert not np.array_equal(saved["theta"][0], saved["theta"][1])


def test_manifest_says_what_was_run(reference):
    manifest = json.loads((reference[0] / "manifest.json").read_text())
    assert manifest["status"] == "complete"
    assert manifest["config"]["scene"]["outlier_factor"] == 50.0
    assert manifest["config"]["replicates"] == manifest["replicates"] == 3
    assert manifest["versions"]["numpy"] == np.__version__
    assert manifest["wall_time_s"] > 0.0
    assert manifest["checks"]
    assert not (reference[0] / "parts").exists()
    data, _ = load_result("ralad", reference[1], reference[0].parents[1])
    assert {"theta", "seconds"} <= set(data.data_vars)
    kept = xr.load_dataset(reference[0] / "results.nc", engine="h5netcdf")
    assert "seconds" not in kept


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder, _ = run(tmp_path_factory.mktemp("undisturbed"), settings=EIGHT)
    return folder


@pytest.mark.parametrize(
    ("stop", "jobs"),
    [(signal.SIGKILL, 1), (signal.SIGKILL, 2), (signal.SIGINT, 1), (signal.SIGINT, 2)],
)
def test_a_killed_run_resumes_to_the_same_bits(tmp_path, undisturbed, stop, jobs):
    settings = [word for one in EIGHT for word in ("--set", one)]
    words = command(tmp_path, "run", "ralad", *settings, "--jobs", str(jobs))
    process = subprocess.Popen(
        words,
        cwd=ROOT,
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        start_new_session=True,
    )
    deadline = time.time() + 120
    while time.time() < deadline and len(list(tmp_path.glob("ralad/*/parts/0*.nc"))) < 2:
        time.sleep(0.02)
    os.kill(process.pid, stop)  # the parent alone: its workers must notice
    process.wait(60)
    time.sleep(3.0)
    (folder,) = (tmp_path / "ralad").iterdir()
    done = sorted(p.name for p in folder.glob("parts/0*.nc"))
    assert 2 <= len(done) < 8, "stopped too late to show anything"
    assert json.loads((folder / "manifest.json").read_text())["status"] == "running"
    stamps = {name: (folder / "parts" / name).stat().st_mtime_ns for name in done}
    assert all(xr.load_dataset(folder / "parts" / n, engine="h5netcdf").sizes for n in done)
    with pytest.raises(StudyError, match="no finished result"):
        load_result("ralad", folder.name, tmp_path)

    kept = {}
    original = runner._finish

    def look_first(folder, config, manifest):
        kept.update({p.name: p.stat().st_mtime_ns for p in folder.glob("parts/0*.nc")})
        original(folder, config, manifest)

    runner._finish = look_first
    try:
        run(tmp_path, settings=EIGHT)
    finally:
        runner._finish = original
    assert {name: kept[name] for name in done} == stamps  # not computed a second time
    assert same_bits(folder, undisturbed)


def test_two_runs_do_not_share_a_folder(tmp_path):
    from filelock import FileLock

    folder = tmp_path / "ralad" / "quick,case=1,lms_subsets=5,replicates=1"
    folder.mkdir(parents=True)
    with (
        FileLock(folder / ".lock"),
        pytest.raises(StudyError, match="another process is running ralad"),
    ):
        run(tmp_path, settings=["case=1", "replicates=1", "lms_subsets=5"])


def test_results_of_other_code_are_computed_anew(tmp_path, monkeypatch, reference):
    with monkeypatch.context() as patch:
        fail_on(patch, 1)
        patch.setattr(results, "code_hash", lambda: "older")
        with pytest.raises(StudyError):
            run(tmp_path)
    (folder,) = (tmp_path / "ralad").iterdir()
    part = folder / "parts" / "000000.nc"
    part.write_bytes((folder / "parts" / "000002.nc").read_bytes())  # what old code would give
    run(tmp_path)
    assert same_bits(folder, reference[0])
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["code"] = "older"
    (folder / "manifest.json").write_text(json.dumps(manifest))
    stamp = (folder / "results.nc").stat().st_mtime_ns
    run(tmp_path)
    assert (folder / "results.nc").stat().st_mtime_ns > stamp


def test_a_finished_run_is_not_computed_again(tmp_path):
    folder, _ = run(tmp_path, settings=["case=1", "replicates=1", "lms_subsets=5"])
    stamp = (folder / "results.nc").stat().st_mtime_ns
    run(tmp_path, settings=["case=1", "replicates=1", "lms_subsets=5"])
    assert (folder / "results.nc").stat().st_mtime_ns == stamp


def fail_on(monkeypatch, bad):
    original = runner.draw_replicate

    def draw(name, config, index):
        if index == bad:
            raise ValueError("a made-up failure")
        return original(name, config, index)

    # in this process, so that the patch is seen
    monkeypatch.setattr(runner, "draw_replicate", draw)
    monkeypatch.setattr(runner, "_run_missing", in_process)


def in_process(name, config, folder, todo, jobs, console, label):
    outcomes = [runner._one(name, config, folder, k, os.getpid()) for k in todo]
    return [outcome for outcome in outcomes if outcome.error is not None]


def test_a_failed_replicate_is_recorded_and_the_rest_kept(tmp_path, monkeypatch, reference):
    with monkeypatch.context() as patch:
        fail_on(patch, 1)
        with pytest.raises(StudyError, match="1 of 3 replicates.*number 1: ValueError: a made-up"):
            run(tmp_path)
    (folder,) = (tmp_path / "ralad").iterdir()
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["status"] == "failed"
    assert "a made-up failure" in manifest["failed"]["1"]
    assert sorted(p.name for p in folder.glob("parts/0*.nc")) == ["000000.nc", "000002.nc"]
    run(tmp_path)  # tries the failed one again and finishes
    assert same_bits(folder, reference[0])


def test_a_damaged_part_is_computed_again(tmp_path, monkeypatch, reference):
    with monkeypatch.context() as patch:
        fail_on(patch, 1)
        with pytest.raises(StudyError):
            run(tmp_path)
    (folder,) = (tmp_path / "ralad").iterdir()
    part = folder / "parts" / "000002.nc"
    part.write_bytes(part.read_bytes()[:1000])
    (folder / "parts" / ".000001.nc.99999.tmp").write_bytes(b"half")
    run(tmp_path)
    assert same_bits(folder, reference[0])


@pytest.mark.parametrize("how", ["truncate", "flip", "remove"])
def test_a_damaged_result_is_named_with_its_remedy(tmp_path, how):
    folder, label = run(tmp_path, settings=["case=1", "replicates=1", "lms_subsets=5"])
    path = folder / "results.nc"
    content = bytearray(path.read_bytes())
    if how == "truncate":
        path.write_bytes(content[: len(content) // 2])
    elif how == "flip":
        content[len(content) // 2] ^= 0xFF
        path.write_bytes(content)
    else:
        path.unlink()
    with pytest.raises(
        StudyError, match=r"results\.nc is damaged or missing.*Delete.*experiments run ralad"
    ):
        load_result("ralad", label, tmp_path)
    with pytest.raises(StudyError, match="damaged or missing"):
        run(tmp_path, settings=["case=1", "replicates=1", "lms_subsets=5"])


def test_a_damaged_manifest_is_named(tmp_path):
    folder, label = run(tmp_path, settings=["case=1", "replicates=1", "lms_subsets=5"])
    for text in ("{not json", "{}", "[1]"):
        (folder / "manifest.json").write_text(text)
        with pytest.raises(StudyError, match=r"manifest\.json is damaged"):
            load_result("ralad", label, tmp_path)


def test_other_settings_do_not_mix_into_a_folder(tmp_path):
    folder, _label = run(tmp_path, settings=["case=1", "replicates=1", "lms_subsets=5"])
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["config"]["mu"] = 0.5
    (folder / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(StudyError, match="other settings"):
        run(tmp_path, settings=["case=1", "replicates=1", "lms_subsets=5"])


def test_a_missing_result_names_the_command_that_makes_it(tmp_path):
    expected = r"python -m experiments run ralad --profile paper --set case=2"
    with pytest.raises(StudyError, match=expected):
        load_result("ralad", "paper,case=2", tmp_path)


def test_an_unwritable_folder_is_named(tmp_path):
    blocker = tmp_path / "file"
    blocker.write_text("in the way")
    with pytest.raises(StudyError, match="cannot write results to .*--results"):
        run(blocker)


def test_writing_is_whole_or_not_at_all(tmp_path):
    path = tmp_path / "result"
    path.write_text("old")

    def break_off(temporary):
        temporary.write_text("ha")
        raise RuntimeError("interrupted")

    with pytest.raises(RuntimeError):
        results.write_whole(path, break_off)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("settings", "profile", "message"),
    [
        (["cas=1"], "quick", "no setting 'cas'. Did you mean 'case'"),
        (["case"], "quick", "not of the form key=value"),
        (["case=one"], "quick", "case='one' is str; int is needed"),
        (["mu=small"], "quick", "float is needed"),
        (["case=9"], "quick", "case 9 does not exist"),
        ([], "papr", "no profile 'papr'. Did you mean 'paper'"),
        (["replicates=0"], "quick", "replicates is 0; at least one"),
    ],
)
def test_unknown_settings_name_the_nearest(settings, profile, message):
    with pytest.raises(StudyError, match=message):
        configurations(load_study("ralad"), profile, settings)


def test_unknown_study_names_the_nearest():
    with pytest.raises(StudyError, match="no study 'rald'. Did you mean 'ralad'"):
        load_study("rald")


def test_the_label_does_not_depend_on_how_the_grid_was_asked_for():
    study = load_study("ralad")
    everything = dict(configurations(study, "quick", []))
    assert list(everything) == ["quick,case=1", "quick,case=2"]
    assert configurations(study, "quick", ["case=2"]) == [
        ("quick,case=2", everything["quick,case=2"])
    ]
    ((label, config),) = configurations(study, "quick", ["mu=1", "case=2"])
    assert label == "quick,case=2,mu=1.0"
    assert config.mu == 1.0


def test_command_line_lists_and_explains(tmp_path):
    listing = subprocess.run(
        [sys.executable, "-m", "experiments", "list"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    for name in study_names():
        assert name in listing.stdout
    for words, message in (
        (["run", "rald"], "Did you mean 'ralad'"),
        (["run"], "name one study or give --all"),
        (["run", "--all", "--set", "case=1"], "--set goes with one study"),
    ):
        wrong = subprocess.run(command(tmp_path, *words), cwd=ROOT, capture_output=True, text=True)
        assert wrong.returncode == 1
        assert message in wrong.stderr
        assert "Traceback" not in wrong.stderr
