"""States and journals of other watches, or damaged ones, are refused and left as they are."""

from __future__ import annotations

import itertools

import pytest

from probreg.errors import InvalidInputError
from probreg.watch import going, run, state_file
from probreg.watch.run import watch
from tests.watch import mean_engine
from tests.watch.kill_often import task

pytestmark = pytest.mark.usefixtures("at_once")


def other_sensors(folder):
    path = folder / "sensors.toml"
    path.write_text(path.read_text().replace('"radar2"', '"radar9"'))
    rows = (folder / "reports.csv").read_text().replace("radar2", "radar9")
    (folder / "reports.csv").write_text(rows)


def other_accuracy(folder):
    path = folder / "sensors.toml"
    text = path.read_text()
    start = text.index("sigma_range_m = ")
    path.write_text(text[:start] + "sigma_range_m = 77.5" + text[text.index("\n", start) :])


OTHERS = {
    "sensors": (other_sensors, {}, r'sensors was \["radar1", "radar2", "radar3"\], and is'),
    "accuracy": (other_accuracy, {}, r"sigma_range_m of radar1 was \d+.*, and is 77.5"),
    "settings": (
        lambda folder: None,
        {"settings": mean_engine.MeanSettings(slice_s=5.0)},
        "slice_s was 10.0, and is 5.0",
    ),
    "seed": (lambda folder: None, {"seed": 4}, "seed was 0, and is 4"),
}


@pytest.mark.parametrize("name", OTHERS)
def test_a_state_of_another_watch_is_refused_and_left(work, name):
    change, more, words = OTHERS[name]
    steps = watch(task(work, work / "reports.csv", "out"))
    next(steps)
    steps.close()
    before = {path.name: path.read_bytes() for path in (work / "out").iterdir()}
    change(work)
    given = task(work, work / "reports.csv", "out")._replace(**more)
    with pytest.raises(InvalidInputError, match=words):
        list(watch(given))
    assert {path.name: path.read_bytes() for path in (work / "out").iterdir()} == before


@pytest.mark.parametrize(
    ("facts", "words"),
    [({"FORMAT": 99}, "format was 2, and is 99"), ({}, 'probreg was ".*", and is "9.9"')],
)
def test_a_state_of_another_version_is_refused(work, monkeypatch, facts, words):
    list(itertools.islice(watch(task(work, work / "reports.csv", "out")), 2))
    for name, value in facts.items():
        monkeypatch.setattr(state_file, name, value)
    if not facts:
        monkeypatch.setattr("probreg.__version__", "9.9")
    with pytest.raises(InvalidInputError, match=words):
        list(watch(task(work, work / "reports.csv", "out")))


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 cut off", b"mine"])
def test_a_damaged_state_is_refused_and_left(work, content):
    (work / "out").mkdir()
    (work / "out" / going.STATE).write_bytes(content)
    with pytest.raises(InvalidInputError, match=r"state\.npz is damaged, or no state"):
        list(watch(task(work, work / "reports.csv", "out")))
    assert (work / "out" / going.STATE).read_bytes() == content


def test_a_journal_that_became_shorter_is_refused(work):
    list(itertools.islice(watch(task(work, work / "reports.csv", "out")), 2))
    (work / "out" / run.JOURNAL).write_text("")
    with pytest.raises(InvalidInputError, match=r"journal\.jsonl has 0 bytes, and had"):
        list(watch(task(work, work / "reports.csv", "out")))


def test_two_watches_do_not_write_into_one_folder(work):
    steps = watch(task(work, work / "reports.csv", "out"))
    next(steps)
    with pytest.raises(InvalidInputError, match="another watch writes into"):
        next(watch(task(work, work / "reports.csv", "out")))
    steps.close()
    next(watch(task(work, work / "reports.csv", "out")))
