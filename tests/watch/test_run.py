"""A watch that is ended at any point goes on as if nothing had happened, bit for bit."""

from __future__ import annotations

import errno
import io
import itertools
import json
import os
import subprocess
import sys

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.recordings import Setup
from probreg.recordings.growing import GrowingInput, follow
from probreg.sensors import Radar2D
from probreg.watch import going, journal, run, state_file
from probreg.watch.run import watch
from probreg.watch.task import Clock, Ends, Talk, Task
from tests.watch import mean_engine
from tests.watch.kill_often import task

pytestmark = pytest.mark.usefixtures("at_once")


class PowerCut(BaseException):
    """Nothing catches it, as nothing catches SIGKILL."""


def result(folder):
    """Journal and state, but for what the file system says of the recording."""
    arrays, words = state_file.read(folder / going.STATE)
    position = words.pop("position")
    files = [(f["read"], f["lines"], f["known_by"]) for f in position["files"]]
    text = (folder / run.JOURNAL).read_bytes()
    return text, {n: a.tobytes() for n, a in arrays.items()}, words, files, position["last"]


def lines(folder):
    return [json.loads(line) for line in (folder / run.JOURNAL).read_text().splitlines()]


def test_the_journal_has_a_line_a_slice(demo):
    first, *rest = lines(demo / "whole")
    assert first["start"]["reports"] > 100
    times = np.array([first["time"], *(line["time"] for line in rest)])
    np.testing.assert_allclose(np.diff(times), 10.0)
    # every report of the table is used once
    used = first["start"]["reports"] + sum(line["reports"]["used"] for line in rest)
    assert used == len((demo / "reports.csv").read_text().splitlines()) - 1


def test_killed_again_and_again_the_numbers_are_the_same(demo, work):
    arguments = [sys.executable, "-m", "tests.watch.kill_often", str(work), "5", "14"]
    found = subprocess.run(arguments, capture_output=True, text=True, check=True)
    assert int(found.stdout) == 14  # every one of them was killed while it ran
    assert result(work / "killed") == result(demo / "whole")


def points(monkeypatch, cut_at):
    """Cut the power at the n-th of all the moments at which something reaches the disk."""
    count = itertools.count()

    def guard(owner, name):
        real = getattr(owner, name)

        def broken(*given, **more):
            if next(count) == cut_at:
                raise PowerCut
            done = real(*given, **more)
            if next(count) == cut_at:
                raise PowerCut
            return done

        monkeypatch.setattr(owner, name, broken)

    for owner, name in ((os, "fsync"), (os, "replace"), (np, "savez"), (journal.json, "dumps")):
        guard(owner, name)


@pytest.mark.parametrize("cut_at", [*range(30), 101, 102, 103, 104])
def test_wherever_the_power_is_cut_the_numbers_are_the_same(demo, work, monkeypatch, cut_at):
    with monkeypatch.context() as patch:
        points(patch, cut_at)
        with pytest.raises(PowerCut):
            list(watch(task(work, work / "reports.csv", "cut")))
    list(watch(task(work, work / "reports.csv", "cut")))
    assert result(work / "cut") == result(demo / "whole")
    assert not list((work / "cut").glob("*.part"))


def test_slices_after_the_last_state_are_done_again(demo, work, monkeypatch):
    monkeypatch.setattr(run, "SAVE_S", 1e9)
    with monkeypatch.context() as patch:
        patch.setattr(run, "save", lambda *given: (_ for _ in ()).throw(PowerCut))
        with pytest.raises(PowerCut):
            list(watch(task(work, work / "reports.csv", "cut")))
    # all but the last slice, which the end of the recording completes
    assert lines(work / "cut") == lines(demo / "whole")[:-1]
    assert not (work / "cut" / going.STATE).exists()
    list(watch(task(work, work / "reports.csv", "cut")))
    assert result(work / "cut") == result(demo / "whole")


def test_an_error_in_the_recording_keeps_what_was_done(demo, work, monkeypatch):
    monkeypatch.setattr(run, "SAVE_S", 1e9)
    monkeypatch.setattr("probreg.recordings.formats.csv.Csv.piece_bytes", 4000)
    good = (work / "reports.csv").read_bytes()
    rows = good.splitlines(keepends=True)
    (work / "reports.csv").write_bytes(b"".join([*rows[:1500], b"broken\n", *rows[1500:]]))
    with pytest.raises(InvalidInputError, match=r"line 1501"):
        list(watch(task(work, work / "reports.csv", "cut")))
    assert len(lines(work / "cut")) > 5
    # the line is repaired, and the watch goes on
    (work / "reports.csv").write_bytes(good)
    list(watch(task(work, work / "reports.csv", "cut")))
    assert result(work / "cut")[:2] == result(demo / "whole")[:2]


def test_negative_control_a_journal_that_is_not_cut_back_repeats_a_line(demo, work, monkeypatch):
    def longer(path, length, line):
        with path.open("ab") as file:
            file.write(json.dumps(line).encode() + b"\n")
        return path.stat().st_size

    monkeypatch.setattr(run.journal, "append", longer)
    steps = watch(task(work, work / "reports.csv", "cut"))
    next(steps)
    with monkeypatch.context() as patch:
        patch.setattr(run, "save", lambda *given: (_ for _ in ()).throw(PowerCut))
        with pytest.raises(PowerCut):
            next(steps)
    list(watch(task(work, work / "reports.csv", "cut")))
    times = [line["time"] for line in lines(work / "cut")]
    assert len(times) == len(set(times)) + 1


@pytest.mark.parametrize("end", [KeyboardInterrupt, GeneratorExit])
def test_an_interrupt_saves_what_came(demo, work, end):
    steps = watch(task(work, work / "reports.csv", "ended"))
    next(steps)
    next(steps)
    if end is GeneratorExit:
        steps.close()
    else:
        with pytest.raises(end):
            steps.throw(end)
    assert len(lines(work / "ended")) == 3
    list(watch(task(work, work / "reports.csv", "ended")))
    assert result(work / "ended") == result(demo / "whole")


@pytest.mark.parametrize("again", [True, False])
def test_standard_input_goes_on_after_an_interrupt(demo, work, again):
    content = (work / "reports.csv").read_bytes()
    rows = content.splitlines(keepends=True)

    def given(part):
        stream = GrowingInput(io.BytesIO(b"".join(part)))
        return task(work, work / "reports.csv", "piped", ends=Ends())._replace(source=stream)

    steps = watch(given(rows[:1000]))
    for _ in range(4):
        next(steps)
    steps.close()
    list(watch(given(rows if again else [rows[0], *rows[1000:]])))
    assert result(work / "piped")[:2] == result(demo / "whole")[:2]


def test_a_full_disk_leaves_the_state_as_it_was(demo, work, monkeypatch):
    steps = watch(task(work, work / "reports.csv", "full"))
    next(steps)
    before = (work / "full" / going.STATE).read_bytes()

    def full(handle):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(OSError, match="No space left"):
            next(steps)
    assert (work / "full" / going.STATE).read_bytes() == before
    list(watch(task(work, work / "reports.csv", "full")))
    assert result(work / "full") == result(demo / "whole")


class Simulated:
    """A clock that passes while one sleeps, and does something at given times."""

    def __init__(self, start=0.0, at=()):
        self.now, self.start, self.at = 0.0, start, list(at)

    def sleep(self, seconds):
        self.now += seconds
        while self.at and self.at[0][0] <= self.now:
            self.at.pop(0)[1]()

    @property
    def clock(self):
        return Clock(lambda: self.now, lambda: self.start + self.now, self.sleep)


def test_silence_is_said_once_and_patience_ends_it(demo, work):
    rows = (work / "reports.csv").read_bytes().splitlines(keepends=True)
    path = work / "grows.csv"
    path.write_bytes(b"".join(rows[:1200])[:-5])

    def more():
        with path.open("ab") as file:
            file.write(b"".join(rows[:1200])[-5:] + b"".join(rows[1200:]))

    said, simulated = [], Simulated(at=[(30.0, more)])
    list(
        watch(
            task(
                *(work, path, "out"),
                ends=Ends(patience_s=40.0),
                talk=Talk(said.append),
                clock=simulated.clock,
            )
        )
    )
    assert said[0].endswith("bytes that are not complete; waiting for the rest")
    assert said[1:] == ["nothing new; waiting"]
    assert 69.0 < simulated.now < 72.0
    assert result(work / "out") == result(demo / "whole")


def test_until_ends_at_a_time_of_the_recording(demo, work):
    whole = lines(demo / "whole")
    list(watch(task(work, work / "reports.csv", "out", ends=Ends(until=whole[5]["time"] + 3.0))))
    assert lines(work / "out") == whole[:6]
    # a later end goes on
    list(watch(task(work, work / "reports.csv", "out", ends=Ends(until=whole[8]["time"]))))
    assert lines(work / "out") == whole[:9]


def test_until_ends_by_the_clock_of_the_computer_where_nothing_comes(work):
    rows = (work / "reports.csv").read_text().splitlines()
    head, first = rows[0].split(","), rows[1].split(",")
    column = head.index("time_s")
    epoch = 1.7e9
    late = [row.split(",") for row in rows[1:]]
    for row in late:
        row[column] = repr(epoch + float(row[column]))
    text = "\n".join([rows[0], *(",".join(row) for row in late)]) + "\n"
    (work / "posix.csv").write_text(text)
    last = float(late[-1][column])
    simulated = Simulated(start=last)
    ends = Ends(until=last + 100.0)
    list(watch(task(work, work / "posix.csv", "out", ends=ends, clock=simulated.clock)))
    assert 119.0 < simulated.now < 122.0
    assert first != late[0]
    assert lines(work / "out")[-1]["time"] >= last


def test_a_recording_without_reports_is_refused(work):
    path = work / "empty.csv"
    path.write_text((work / "reports.csv").read_text().splitlines()[0] + "\n")
    with pytest.raises(InvalidInputError, match="no report; there is nothing to watch"):
        list(watch(task(work, path, "out")))


def test_the_first_minutes_are_checked_as_a_recording_is(work):
    rows = (work / "reports.csv").read_text().splitlines()
    path = work / "bad.csv"
    path.write_text("\n".join(row for row in rows if "radar3" not in row) + "\n")
    with pytest.raises(InvalidInputError, match="sensor 'radar3' has no report"):
        list(watch(task(work, path, "out")))
    wrong = rows[1].split(",")
    wrong[rows[0].split(",").index("time_s")] = "5e6"
    path.write_text("\n".join([rows[0], ",".join(wrong), *rows[2:]]) + "\n")
    with pytest.raises(InvalidInputError, match="first report is of time 5000000"):
        list(watch(task(work, path, "out")))


@pytest.mark.parametrize("shift", [5e4, -5e4])
def test_a_clock_that_jumps_is_an_alarm_once(work, shift):
    rows = [row.split(",") for row in (work / "reports.csv").read_text().splitlines()]
    time, sensor = rows[0].index("time_s"), rows[0].index("sensor")
    wrong = [row for row in rows[1:] if row[sensor] == "radar2" and 80.0 < float(row[time]) < 130.0]
    for row in wrong:
        row[time] = repr(float(row[time]) + shift)
    path = work / "jumps.csv"
    path.write_text("\n".join(",".join(row) for row in rows) + "\n")
    list(watch(task(work, path, "out")))
    told = lines(work / "out")
    (alarm,) = [alarm for line in told[1:] for alarm in line["alarms"]]
    assert (alarm["kind"], alarm["sensor"]) == ("clock", "radar2")
    assert alarm["size"] == pytest.approx(shift, abs=20.0)
    assert 80.0 < alarm["time"] < 101.0
    left = sum(line["left_out"]["ahead"].get("radar2", 0) for line in told[1:])
    assert left == (len(wrong) if shift > 0 else 0)


@pytest.mark.parametrize("piece_bytes", [500, 1 << 20])
def test_heights_that_appear_late_are_counted_with_one_note(tmp_path, monkeypatch, piece_bytes):
    """Whether the watch began before they were read, or after."""
    monkeypatch.setattr("probreg.recordings.formats.csv.Csv.piece_bytes", piece_bytes)
    rows = ["time_s,sensor,target,range_m,azimuth_deg,pressure_altitude_m"]
    for k in range(200):
        height = 9000.0 if k > 120 else ""
        rows.append(f"{0.5 * k},{'ab'[k % 2]},t{k % 4 // 2},{9e4 + 3 * k},{10 + 0.01 * k},{height}")
    path = tmp_path / "r.csv"
    path.write_text("\n".join(rows) + "\n")
    radars = tuple(Radar2D((x, 0.0), 20.0, 2e-3, name) for x, name in ((0.0, "a"), (9e3, "b")))
    setup = Setup(radars, {"a": ("range",)}, origin=(50.0, 8.0, 0.0), geodetic=frozenset())
    settings, ends = mean_engine.MeanSettings(), Ends(patience_s=0.0)
    told = []
    for out in ("whole", "cut"):
        (tmp_path / out).mkdir()
        job = Task(follow(path), setup, tmp_path / out, mean_engine, settings, 40.0, ends=ends)
        for _ in range(100):  # the second one is ended after every slice
            steps = watch(job)
            for _ in steps:
                if out == "cut":
                    break
            else:
                break
            steps.close()
        told.append(lines(tmp_path / out))
    assert told[0] == told[1]
    first, *rest = told[0]
    assert list(first["biases"]) == ["a.range"]
    late = [line["reports"].get("unplaced", 0) for line in rest]
    assert sum(late) == 79
    assert late[:2] == [0, 0]
    noted = [line for line in rest if "notes" in line]
    assert [line["notes"][0].split(" have")[0] for line in noted] == ["reports of a barometer"]
    assert noted[0]["time"] == 70.0
    assert first["start"]["reports"] + sum(line["reports"]["used"] for line in rest) == 200
