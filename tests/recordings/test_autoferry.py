"""The benchmark's files: every shape of a measurement, errors by entry, and known offsets."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.recordings import checks
from probreg.recordings.formats import autoferry
from probreg.sensors.geometry import wrap_angle

NAMES = ["lidar", "radar", "infrared", "electro_optical", "gnss"]
TRUTH = [
    {"targetID": 1, "time": 10.0, "position": [1.0, 2.0, 0.0]},
    {"targetID": 2, "time": 10.1, "position": [3.0, 4.0, 0.0]},
]


def detection(sensor, measurement, time=10.0):
    return {
        "sensorID": sensor,
        "measurements": [],
        "ownshipPosition": [100.0, 50.0],
        "time": time,
        "measurement": measurement,
    }


def save(folder, detections, truth, number=9):
    place = folder / f"scenario{number}"
    place.mkdir(exist_ok=True)
    for name, content in (("detections", detections), ("groundTruth", truth)):
        text = content if isinstance(content, str) else json.dumps(content)
        (place / f"scenario{number}_{name}.json").write_text(text)


def test_every_shape_of_a_measurement(tmp_path):
    detections = [
        detection(2, [[3.0, 0.0, -5.0], [4.0, 6.0, 0.0]], 12.0),
        detection(1, [0.0, -7.0], 11.0),
        detection(1, [[8.0, 0.0], [0.0, 9.0]], 11.5),
        detection(3, 0.25, 10.5),
        detection(4, [0.1, -0.2, 0.1], 10.6),
        detection(3, [], 10.7),
        detection(2, [], 10.8),
    ]
    save(tmp_path, detections, [TRUTH] * len(detections))
    found = autoferry.read(tmp_path, 9)
    assert [sensor.name for sensor in found.sensors] == NAMES
    np.testing.assert_allclose(found.time, [10, 10.1, 10.5, 10.6, 10.6, 11, 11.5, 11.5, 12, 12, 12])
    names = [NAMES[k] for k in found.sensor]
    assert (
        names
        == ["gnss"] * 2 + ["infrared"] + ["electro_optical"] * 2 + ["lidar"] * 3 + ["radar"] * 3
    )
    quarter = np.pi / 2
    expected = [
        [2, 1],
        [4, 3],
        [0.25, np.nan],
        [0.1, np.nan],
        [-0.2, np.nan],
        [7, -quarter],
        [8, 0],
        [9, quarter],
        [5, np.arctan2(4, 3)],
        [6, quarter],
        [5, np.pi],
    ]
    np.testing.assert_allclose(found.values, expected, atol=1e-12)
    np.testing.assert_array_equal(found.target, [0, 1] + [-1] * 9)
    assert found.labels == ("1", "2")
    np.testing.assert_array_equal(found.own_position, [[0, 0]] * 2 + [[50, 100]] * 9)


@pytest.mark.parametrize(
    ("detections", "truth", "words"),
    [
        ("[{", [TRUTH], ["detections.json", "line 1", "cut off"]),
        ([], [TRUTH], ["detections.json", "list of entries"]),
        ({"a": 1}, [TRUTH], ["list of entries"]),
        ([detection(5, [])], [TRUTH], ["entry 0", "sensorID is 5"]),
        ([detection(3, []), {"sensorID": 1}], [TRUTH], ["entry 1", "'ownshipPosition'"]),
        ([detection(3, []), 7], [TRUTH], ["entry 1"]),
        ([detection(1, [1.0, 2.0, 3.0])], [TRUTH], ["entry 0", "shape (3,)"]),
        ([detection(1, [[1.0, 2.0], [3.0]])], [TRUTH], ["entry 0"]),
        ([detection(3, ["x"])], [TRUTH], ["entry 0"]),
        ([detection(3, [float("nan")])], [TRUTH], ["entry 0", "nan"]),
        ([detection(3, [])], [[{"targetID": 3, "time": 1.0}]], ["groundTruth", "targetID is 3"]),
        ([detection(3, [])], [TRUTH, [{"targetID": 1, "time": 1.0}]], ["entry 1", "'position'"]),
    ],
)
def test_errors_name_the_file_and_the_entry(tmp_path, detections, truth, words):
    save(tmp_path, detections, truth)
    with pytest.raises(InvalidInputError) as caught:
        autoferry.read(tmp_path, 9)
    for word in words:
        assert word in str(caught.value)


def test_scenarios_that_are_not_there(tmp_path):
    save(tmp_path, [detection(3, [])], [TRUTH])
    with pytest.raises(InvalidInputError, match=r"no scenario 7; there are \[9\]"):
        autoferry.read(tmp_path, 7)
    (tmp_path / "scenario9" / "scenario9_groundTruth.json").unlink()
    with pytest.raises(InvalidInputError, match="groundTruth.json cannot be read"):
        autoferry.read(tmp_path, 9)


@pytest.fixture(scope="module")
def folder():
    place = Path(os.environ.get("PROBREG_DATA", "")) / "autoferry"
    if "PROBREG_DATA" in os.environ and place.is_dir():
        return place
    if "PROBREG_REQUIRE_DATA" in os.environ:
        pytest.fail("PROBREG_DATA must name the folder that contains autoferry/")
    pytest.skip("PROBREG_DATA names no folder that contains autoferry/")


def offsets(recording, name, transpose_pairs=False):
    """Nearest detection within 30 m of each GNSS target, in range (m) and azimuth (deg)."""
    k, gnss = NAMES.index(name), NAMES.index("gnss")
    found = []
    tracks = []
    for target in (0, 1):
        rows = (recording.sensor == gnss) & (recording.target == target)
        tracks.append((recording.time[rows], recording.values[rows]))
    for time in np.unique(recording.time[recording.sensor == k]):
        rows = (recording.sensor == k) & (recording.time == time)
        polar, own = recording.values[rows], recording.own_position[rows][0]
        at = polar[:, :1] * np.column_stack([np.sin(polar[:, 1]), np.cos(polar[:, 1])])
        if transpose_pairs and len(at) == 2:
            # the same four numbers with norths and easts read the other way
            at = at[:, ::-1].T[:, ::-1]
        for when, where in tracks:
            true = np.array([np.interp(time, when, where[:, axis]) for axis in (0, 1)]) - own
            distance = np.linalg.norm(at - true, axis=1)
            near = distance.argmin()
            if distance[near] < 30.0:
                turn = np.arctan2(*at[near]) - np.arctan2(*true)
                range_error = np.linalg.norm(at[near]) - np.linalg.norm(true)
                found.append((range_error, np.rad2deg(wrap_angle(turn))))
    return np.array(found)


def summary(found):
    middle = np.median(found, axis=0)
    return np.array([middle, 1.48 * np.median(np.abs(found - middle), axis=0)]).T.ravel()


# median and 1.48 median absolute deviation of range (m) and of azimuth (deg)
KNOWN = {
    (2, "radar"): (138, [1.8, 3.3, 1.0, 3.4]),
    (2, "lidar"): (335, [-2.0, 2.4, 1.2, 1.6]),
    (5, "radar"): (165, [6.7, 4.7, 2.2, 1.7]),
    (5, "lidar"): (248, [-1.0, 1.5, 1.4, 1.3]),
    (13, "radar"): (107, [1.3, 4.2, 0.8, 1.5]),
    (13, "lidar"): (257, [-1.2, 1.6, 0.5, 1.9]),
}


@pytest.mark.parametrize(("scenario", "name"), KNOWN)
def test_offsets_from_gnss_are_those_computed_from_the_raw_files(folder, scenario, name):
    """The numbers come from the files' lists, without times: 0.35 m and 0.15 deg for those."""
    count, expected = KNOWN[scenario, name]
    found = offsets(autoferry.read(folder, scenario), name)
    assert len(found) == count
    difference = np.abs(summary(found) - expected)
    assert (difference < [0.35, 0.35, 0.15, 0.15]).all(), summary(found)


# the same with the numbers of two detections read the other way round
TRANSPOSED = {
    (2, "radar"): [1.7, 3.4, 1.0, 3.4],
    (2, "lidar"): [-1.0, 2.5, 1.4, 1.9],
    (5, "radar"): [5.9, 5.5, 2.6, 2.2],
    (5, "lidar"): [-1.0, 1.5, 1.7, 1.5],
    (13, "radar"): [3.0, 2.8, 0.6, 1.8],
    (13, "lidar"): [-1.9, 1.7, 0.6, 7.4],
}


@pytest.mark.parametrize(("scenario", "name"), TRANSPOSED)
def test_a_measurement_of_two_by_two_has_norths_in_its_first_row(folder, scenario, name):
    """Read the other way round fewer detections lie by a vessel: the order is not a choice."""
    recording = autoferry.read(folder, scenario)
    other = offsets(recording, name, transpose_pairs=True)
    assert len(other) < 0.95 * len(offsets(recording, name))
    difference = np.abs(summary(other) - TRANSPOSED[scenario, name])
    assert (difference < [0.35, 0.35, 0.15, 0.5]).all(), summary(other)


@pytest.mark.parametrize("scenario", [2, 3, 4, 5, 13, 17])
def test_every_scenario_passes_the_checks_of_a_recording(folder, scenario):
    recording = autoferry.read(folder, scenario)
    checks.check(recording)
    assert (np.bincount(recording.sensor) > 40).all()
    assert np.ptp(recording.time) < 200.0
