"""The same table as JSON lines and as CSV is the same recording."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from probreg import recordings
from probreg.errors import InvalidInputError
from probreg.recordings import setup_file
from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene


def test_it_reads_what_csv_reads(tmp_path):
    scene = TrafficScene(reports=200, aircraft=8)
    reports, sensors, _ = demonstration(tmp_path, np.random.default_rng(1), scene)
    lines = tmp_path / "reports.ndjson"
    pd.read_csv(reports, dtype={"target": str}).to_json(
        lines, orient="records", lines=True, double_precision=15
    )
    setup = setup_file.read(sensors)
    one, two = (recordings.read(path, setup).recording for path in (reports, lines))
    np.testing.assert_allclose(two.values, one.values, rtol=1e-9)
    np.testing.assert_allclose(two.time, one.time, atol=1e-6)
    assert [two.labels[k] for k in two.target] == [one.labels[k] for k in one.target]
    lines.write_text("[1, 2\n")
    with pytest.raises(InvalidInputError, match="JSON object a line"):
        recordings.read(lines, setup)
