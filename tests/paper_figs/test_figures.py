"""Figures and tables: drawn from saved results only, and saying so when these are missing."""

from __future__ import annotations

import ast
import csv
import dataclasses
import io
import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console

import paper_figs
from experiments.results import load_result
from experiments.runner import run_study
from experiments.study import configurations, load_study, study_names
from paper_figs.__main__ import names

ROOT = Path(__file__).parents[2]
PAPER = [f"ralad_fig{k}" for k in range(1, 9)] + ["ralad_tables", "ralad_beyond"]
PAPER += [*(f"lts_fig{k}" for k in range(1, 5)), "lts_beyond"]
PASSIVE = [*(f"rekf_fig{k}" for k in range(1, 5)), *(f"rrtls_fig{k}" for k in range(1, 7))]
PASSIVE += ["rekf_table1", "rrtls_table1", "rrtls_influence", "passive_beyond"]
PASSIVE_TABLES = ["rekf_errors", "rekf_cost", "rrtls_errors", "passive_beyond_table"]
FILES = [*PAPER[:8], "ralad_beyond", *PAPER[10:], *(f"ralad_table{k}" for k in range(1, 7))]
FILES += ["ralad_beyond_case1_rmse", "lts_fig3_symmetric", "lts_beyond_table"]
FILES += PASSIVE + PASSIVE_TABLES
BAYES = ["calibration_sbc", "calibration_reports", "calibration_position", "coverage_by_gamma"]
BAYES += ["posterior_ralad", "coverage_methods"]
FILES += [f"calibration_{kind}_pair_{d}d" for kind in ("sbc", "ranks") for d in (2, 3)] + BAYES[1:]
MH = [*(f"mh_fig{k}" for k in range(1, 9)), "mh_table", "mh_sensitivity", "mh_gamma", "mh_lowpass"]
MH += ["mh_radar", "drift_methods", "drift_trace", "drift_calibration"]
FILES += [*MH, "mh_radar_table", "drift_methods_table", "drift_calibration_table"]
FILES += ["calibration_table", "calibration_reports_table", "calibration_position_table"]


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A few runs of every study, stored under the labels that figures ask for."""
    folder = tmp_path_factory.mktemp("results")
    for name in study_names():
        study = load_study(name)
        for label, config in configurations(study, "quick", []):
            few = {"replicates": min(2, config.replicates)}
            if hasattr(config, "runs"):
                few["runs"] = min(4, config.runs)
            if hasattr(config, "keep"):
                few["keep"] = 19
            small = dataclasses.replace(config, **few)
            run_study(study, label, small, folder, 2, Console(file=io.StringIO()))
    return folder


def draw(*words):
    return subprocess.run(
        [sys.executable, "-m", "paper_figs", *map(str, words)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )


@pytest.fixture(scope="module")
def drawn(results, tmp_path_factory):
    out = tmp_path_factory.mktemp("out")
    done = draw("--results", results, "--out", out)
    assert done.returncode == 0, done.stderr
    return out, done


def test_all_figures_of_the_paper_are_there():
    assert set(PAPER + PASSIVE + BAYES + MH) <= set(names())


def test_every_figure_is_drawn_as_vector_and_picture(drawn):
    out, done = drawn
    for name in FILES:
        assert (out / f"{name}.pdf").read_bytes().startswith(b"%PDF")
        assert (out / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert str(out / f"{name}.pdf") in done.stdout
    assert not [p for p in out.iterdir() if p.suffix == ".tmp"]


def test_tables_hold_the_saved_numbers_and_the_papers(drawn, results):
    out, _ = drawn
    rows = list(csv.reader((out / "ralad_table2.csv").read_text().splitlines()))
    data, _ = load_result("ralad", "quick,case=1", results)
    runs = data["theta"].sel(estimator="RALAD", reading="true", parameter="i.range")
    at = next(k for k, row in enumerate(rows) if row[0] == "RALAD")
    assert rows[at + 1][1] == "17.00"  # printed in the paper's Table 2: 16.999
    assert float(rows[at + 2][1].split(" ± ")[0]) == pytest.approx(float(runs.mean()), abs=0.006)
    printed = [row for row in rows if row[0] == "  paper"]
    assert [float(row[2]) for row in printed] == pytest.approx([446.0, 23.1, 62.7, 15.0], abs=0.1)
    assert (out / "ralad_table2.md").read_text().count("| ") > 20


def test_numbers_change_with_the_results(results, tmp_path):
    # a figure drawn from anything but the results would not notice
    import shutil

    import xarray as xr

    from experiments.results import file_hash, write_dataset, write_json

    other = tmp_path / "results"
    shutil.copytree(results, other)
    folder = other / "ralad" / "quick,case=1"
    data = xr.load_dataset(folder / "results.nc", engine="h5netcdf")
    data["theta"] = data["theta"] + 1.0
    write_dataset(folder / "results.nc", data)
    import json

    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["sha256"]["results.nc"] = file_hash(folder / "results.nc")
    write_json(folder / "manifest.json", manifest)
    for source, out in ((results, tmp_path / "a"), (other, tmp_path / "b")):
        assert draw("ralad_tables", "--results", source, "--out", out).returncode == 0
    one, two = ((tmp_path / k / "ralad_table2.csv").read_text() for k in "ab")
    first, second = (
        float(
            next(r for r in csv.reader(t.splitlines()) if r[0] == "  ours, true")[1].split(" ")[0]
        )
        for t in (one, two)
    )
    assert second - first == pytest.approx(1.0, abs=0.02)


def test_drawing_twice_gives_the_same_picture(results, tmp_path):
    for k in "ab":
        assert draw("ralad_fig7", "--results", results, "--out", tmp_path / k).returncode == 0
    one, two = ((tmp_path / k / "ralad_fig7.png").read_bytes() for k in "ab")
    assert one == two


def test_a_missing_result_names_its_command(tmp_path):
    done = draw(
        "ralad_fig4", "--profile", "paper", "--results", tmp_path, "--out", tmp_path / "out"
    )
    assert done.returncode == 1
    assert "python -m experiments run ralad --profile paper --set case=2" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_an_unknown_figure_names_the_nearest(tmp_path):
    done = draw("ralad_fig9", "--out", tmp_path)
    assert done.returncode == 1
    assert "Did you mean 'ralad_fig" in done.stderr


def test_drawing_never_computes():
    for path in Path(paper_figs.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom):
                module = node.module or ""
                assert not module.startswith(
                    (
                        "probreg.estimators",
                        "probreg.scenarios",
                        "experiments.studies",
                        "experiments.runner",
                    )
                ), f"{path.name} imports {module}"
