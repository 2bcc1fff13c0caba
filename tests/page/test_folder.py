"""Results that are complete or not there."""

from __future__ import annotations

import json

import pytest

from probreg.errors import InvalidInputError
from probreg.page import result_folder, write_summary


def fill(folder, name="a.txt", text="new"):
    (folder / name).write_text(text)
    write_summary(folder, "try", {})


def test_a_result_appears_at_once_and_nothing_else_does(tmp_path):
    target = tmp_path / "deep" / "out"
    with result_folder(target, "try") as part:
        fill(part)
        assert not target.exists()
    assert {path.name for path in target.iterdir()} == {"a.txt", "manifest.json"}
    assert [path.name for path in tmp_path.iterdir()] == ["deep"]


def _stop_halfway(target, error):
    with result_folder(target, "try") as part:
        fill(part)
        raise error


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
@pytest.mark.parametrize("there", [False, True])
def test_an_error_leaves_everything_as_it_was(tmp_path, error, there):
    target = tmp_path / "out"
    if there:
        with result_folder(target, "try") as part:
            fill(part, text="old")
    with pytest.raises(error):
        _stop_halfway(target, error)
    assert target.exists() == there
    assert len(list(tmp_path.iterdir())) == int(there)
    if there:
        assert (target / "a.txt").read_text() == "old"


def test_an_earlier_result_is_replaced_and_its_stale_files_go(tmp_path):
    target = tmp_path / "out"
    with result_folder(target, "try") as part:
        fill(part, "corrected.parquet")
    (target / "notes.txt").write_text("mine")
    with result_folder(target, "try") as part:
        fill(part, "corrected.csv")
    names = {path.name for path in target.iterdir()}
    assert names == {"corrected.csv", "manifest.json", "notes.txt"}


@pytest.mark.parametrize("manifest", [None, "{", "[]", '{"program": "probreg", "command": "x"}'])
def test_files_of_another_hand_are_refused_unless_allowed(tmp_path, manifest):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "a.txt").write_text("mine")
    if manifest is not None:
        (tmp_path / "out" / "manifest.json").write_text(manifest)
    with (
        pytest.raises(InvalidInputError, match="not empty and holds no result of `probreg try`"),
        result_folder(tmp_path / "out", "try"),
    ):
        pytest.fail("must not be entered")
    with result_folder(tmp_path / "out", "try", overwrite=True) as part:
        fill(part, "b.txt")
    assert (tmp_path / "out" / "a.txt").read_text() == "mine"
    assert json.loads((tmp_path / "out" / "manifest.json").read_text())["command"] == "try"


def test_a_file_in_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "out").write_text("a file")
    with (
        pytest.raises(InvalidInputError, match="is a file; name a folder"),
        result_folder(tmp_path / "out", "try", overwrite=True),
    ):
        pytest.fail("must not be entered")


def test_a_folder_that_cannot_be_written_is_refused_at_once(tmp_path, monkeypatch):
    target = tmp_path / "out"
    target.mkdir()
    refused = lambda path, mode: path != target  # noqa: E731
    monkeypatch.setattr("probreg.page._folder.os.access", refused)
    with pytest.raises(InvalidInputError, match="out cannot be written"):
        _stop_halfway(target, AssertionError("computed"))
    assert list(tmp_path.iterdir()) == [target]
