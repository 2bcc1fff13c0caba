"""Figures and tables: drawn from saved results only, and saying so when these are missing."""

from __future__ import annotations

import ast
import csv
import sys
from pathlib import Path

import pytest

import paper_figs
from experiments.results import load_result
from experiments.study import study_names
from paper_figs.__main__ import figures
from tests.paper_figs import test_autoferry as autoferry
from tests.paper_figs import test_recording_drift as recording_drift
from tests.paper_figs.small import draw, draw_all, missing, run_small
from tests.paper_figs.test_bayes_figures import BAYES
from tests.paper_figs.test_bayes_figures import STUDIES as BAYES_STUDIES
from tests.paper_figs.test_drift_figures import MH
from tests.paper_figs.test_drift_figures import STUDIES as DRIFT_STUDIES

PAPER = [f"ralad_fig{k}" for k in range(1, 9)] + ["ralad_tables", "ralad_beyond"]
PAPER += [*(f"lts_fig{k}" for k in range(1, 5)), "lts_beyond"]
PASSIVE = [*(f"rekf_fig{k}" for k in range(1, 5)), *(f"rrtls_fig{k}" for k in range(1, 7))]
PASSIVE += ["rekf_table1", "rrtls_table1", "rrtls_influence", "passive_beyond"]
PASSIVE_TABLES = ["rekf_errors", "rekf_cost", "rrtls_errors", "passive_beyond_table"]
FILES = [*PAPER[:8], "ralad_beyond", *PAPER[10:], *(f"ralad_table{k}" for k in range(1, 7))]
FILES += ["ralad_beyond_case1_rmse", "lts_fig3_symmetric", "lts_beyond_table"]
FILES += PASSIVE + PASSIVE_TABLES


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    elsewhere = [*BAYES_STUDIES, *DRIFT_STUDIES, *autoferry.STUDIES, *recording_drift.STUDIES]
    studies = [name for name in study_names() if name not in elsewhere]
    return run_small(studies, tmp_path_factory.mktemp("results"))


@pytest.fixture(scope="module")
def drawn(results, tmp_path_factory):
    elsewhere = [*BAYES, *MH, *autoferry.FIGURES, *recording_drift.FIGURES]
    wanted = [name for name in figures() if name not in elsewhere]
    return draw_all(wanted, results, tmp_path_factory.mktemp("out"))


def test_all_figures_of_the_paper_are_there():
    assert set(PAPER + PASSIVE) <= set(figures())


def test_every_figure_is_drawn_as_vector_and_picture(drawn):
    assert missing(FILES, drawn) == []
    assert not list(drawn[0].glob("*.tmp"))


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


def test_numbers_change_with_the_results(results, drawn, tmp_path):
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
    assert draw("ralad_tables", "--results", other, "--out", tmp_path / "b").returncode == 0
    one, two = ((out / "ralad_table2.csv").read_text() for out in (drawn[0], tmp_path / "b"))
    first, second = (
        float(
            next(r for r in csv.reader(t.splitlines()) if r[0] == "  ours, true")[1].split(" ")[0]
        )
        for t in (one, two)
    )
    assert second - first == pytest.approx(1.0, abs=0.02)


def test_drawing_again_alone_gives_the_same_picture(results, drawn, tmp_path):
    assert draw("ralad_fig7", "--results", results, "--out", tmp_path).returncode == 0
    one, two = ((out / "ralad_fig7.png").read_bytes() for out in (drawn[0], tmp_path))
    assert one == two


def test_a_missing_result_names_its_command(tmp_path):
    done = draw(
        "ralad_fig4", "--profile", "paper", "--results", tmp_path, "--out", tmp_path / "out"
    )
    assert done.returncode == 1
    assert "python -m experiments run ralad --profile paper --set case=2" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_an_unknown_figure_names_the_nearest_and_all_known(tmp_path):
    done = draw("ralad_fig9", "--out", tmp_path / "out")
    assert done.returncode == 1
    assert "Did you mean 'ralad_fig" in done.stderr
    known = done.stderr.split("Known: ")[1].rstrip(".\n").split(", ")
    elsewhere = autoferry.FIGURES + recording_drift.FIGURES
    assert known == sorted(set(PAPER + PASSIVE + BAYES + MH + elsewhere))
    assert not (tmp_path / "out").exists()


def test_neither_helpers_nor_tables_of_figures_are_names(tmp_path):
    for module in ("_style", "style", "_ralad", "ralad", "rekf", "__main__"):
        assert draw(module, "--out", tmp_path / "out").returncode == 1, module
    assert not (tmp_path / "out").exists()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder whose modules count as modules of the package."""
    monkeypatch.setattr(paper_figs, "__path__", [*paper_figs.__path__, str(tmp_path)])
    yield tmp_path
    for path in tmp_path.glob("*.py"):
        sys.modules.pop(f"paper_figs.{path.stem}", None)
        if hasattr(paper_figs, path.stem):
            delattr(paper_figs, path.stem)


def test_a_new_file_is_found_without_a_line_elsewhere(folder):
    before = set(figures())
    (folder / "new_alone.py").write_text("NEEDS = 'DATA'\ndef draw(*_):\n    return []\n")
    (folder / "new_table.py").write_text("FIGURES = {'new_b': print, 'new_a': print}\n")
    (folder / "_new_help.py").write_text("raise RuntimeError('never imported')\n")
    found = figures()
    assert set(found) - before == {"new_alone", "new_a", "new_b"}
    assert (found["new_alone"].needs, found["new_a"].needs) == ("DATA", "")


def test_a_name_given_twice_is_refused(folder):
    (folder / "new_twice.py").write_text("FIGURES = {'ralad_fig1': print}\n")
    with pytest.raises(ValueError, match="ralad_fig1"):
        figures()


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
