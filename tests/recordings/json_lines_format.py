"""A format that the package does not have: one JSON object a report, in SI units."""

from __future__ import annotations

import json
from typing import ClassVar

import numpy as np

from probreg.recordings import Reading, Recording
from probreg.recordings.formats import RecordingFormat


class JsonLines(RecordingFormat):
    endings: ClassVar[tuple[str, ...]] = (".jsonl",)

    def read(self, path, setup, *, trust_units=False):
        rows = [json.loads(line) for line in path.read_text().splitlines()]
        names = [sensor.name for sensor in setup.sensors]
        sensor, target = (np.array([row[k] for row in rows]) for k in ("sensor", "target"))
        recording = Recording(
            setup.sensors,
            np.array([names.index(name) for name in sensor]),
            np.array([row["time"] for row in rows]),
            np.array([row["values"] for row in rows]),
            target,
            ("p", "q"),
        )
        return Reading(path, recording, setup, (f"{len(rows)} lines",))
