"""A watch whose process is killed again and again while its recording grows; run as a script.

Arguments: folder with reports.csv and sensors.toml, seed, number of kills.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

import numpy as np

from probreg.recordings import setup_file
from probreg.recordings.growing import follow
from probreg.watch import run
from probreg.watch.run import watch
from probreg.watch.task import Ends, Task
from tests.watch import mean_engine


def task(folder, recording, out, **more):
    setup = setup_file.read(folder / "sensors.toml")
    (folder / out).mkdir(exist_ok=True)
    settings = mean_engine.MeanSettings()
    given = {"start_s": 40.0, "ends": Ends(patience_s=0.0), **more}
    return Task(follow(recording), setup, folder / out, mean_engine, settings, **given)


def child(folder):
    run.SAVE_S = 0.02
    code = 1
    try:
        patient = Ends(patience_s=60.0)
        for _ in watch(task(folder, folder / "grows.csv", "killed", ends=patient)):
            pass
        code = 0
    finally:
        os._exit(code)


def main(folder, seed, kills):
    rng = np.random.default_rng(seed)
    content = (folder / "reports.csv").read_bytes()
    cuts = np.sort(rng.integers(0, len(content), kills)).tolist()
    ended = 0
    for start, end in zip([0, *cuts[:-1]], cuts, strict=True):
        with (folder / "grows.csv").open("ab") as file:
            file.write(content[start:end])
        pid = os.fork()
        if not pid:
            child(folder)
        time.sleep(rng.uniform(0.0, 0.15))
        os.kill(pid, signal.SIGKILL)
        ended += os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == -signal.SIGKILL
    with (folder / "grows.csv").open("ab") as file:
        file.write(content[cuts[-1] :])
    list(watch(task(folder, folder / "grows.csv", "killed")))
    print(ended)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
