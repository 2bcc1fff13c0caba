"""From a growing file to the posterior of each bias: the engine, its state and the journal."""

from __future__ import annotations

import json

import numpy as np

import probreg.watch as engine
from probreg.recordings import setup_file
from probreg.recordings.growing import follow
from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene
from probreg.watch import WatchSettings, going, run, state_file
from probreg.watch.run import watch
from probreg.watch.task import Ends, Task


def test_a_watch_ended_after_every_slice_is_that_of_one_that_was_not(tmp_path):
    scene = TrafficScene(reports=1_500, aircraft=12)
    reports, sensors, _ = demonstration(tmp_path, np.random.default_rng(1), scene)
    setup = setup_file.read(sensors)

    def task(out):
        (tmp_path / out).mkdir(exist_ok=True)
        settings = WatchSettings(slice_s=15.0)
        ends = Ends(patience_s=0.0)
        return Task(follow(reports), setup, tmp_path / out, engine, settings, 180.0, ends=ends)

    list(watch(task("whole")))
    count = len((tmp_path / "whole" / run.JOURNAL).read_text().splitlines())
    assert count > 4
    for _ in range(count):
        steps = watch(task("cut"))
        next(steps, None)
        steps.close()
    for name in ("whole", "cut"):
        first, *rest = map(json.loads, (tmp_path / name / run.JOURNAL).read_text().splitlines())
        assert first["biases"].keys() == rest[-1]["biases"].keys()
    journals, states = zip(
        *(
            (
                (tmp_path / name / run.JOURNAL).read_bytes(),
                state_file.read(tmp_path / name / going.STATE)[0],
            )
            for name in ("whole", "cut")
        ),
        strict=True,
    )
    assert journals[0] == journals[1]
    assert states[0].keys() == states[1].keys()
    assert [k for k in states[0] if states[0][k].tobytes() != states[1][k].tobytes()] == []
