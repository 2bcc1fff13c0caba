"""The demonstration's files are read as any engineer's, and the truth beside them is true."""

from __future__ import annotations

import json

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.recordings import setup_file, table
from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene, simulate


def test_the_files_are_the_simulated_recording(tmp_path):
    scene = TrafficScene(reports=800, wrong_share=0.1, outlier_share=0.1)
    reports, sensors, known = demonstration(tmp_path / "d", np.random.default_rng(7), scene)
    recording, setup, truth = simulate(scene, np.random.default_rng(7))
    read = setup_file.read(sensors)
    found = table.read(reports, read)
    assert read.biases == setup.biases
    assert found.notes == ()
    np.testing.assert_allclose(found.recording.time, recording.time, rtol=1e-14)
    np.testing.assert_allclose(found.recording.values, recording.values, rtol=1e-11, atol=1e-11)
    content = json.loads(known.read_text())
    assert content["bias"] == truth.bias
    np.testing.assert_array_equal(content["wrong_rows"], np.flatnonzero(truth.wrong))
    np.testing.assert_array_equal(content["outlier_rows"], np.flatnonzero(truth.outlier))
    assert sorted(p.name for p in (tmp_path / "d").iterdir()) == [
        "reports.csv",
        "sensors.toml",
        "truth.json",
    ]
    with pytest.raises(InvalidInputError, match="cannot be made"):
        demonstration(reports, np.random.default_rng(7), scene)
