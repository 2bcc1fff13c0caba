"""Slices of arrivals: the same whatever pieces came, nothing twice, no clock that jumps."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.recordings import Setup
from probreg.recordings.growing import Arrivals, Buffer, arrive, complete, completed, cut, said
from probreg.sensors import Radar2D

RADARS = tuple(Radar2D((x, 0.0), 20.0, 2e-3, name) for x, name in ((0.0, "a"), (9e3, "b")))
SETUP = Setup(RADARS, {"a": ("range",)})


def arrivals(time, sensor, target=None, labels=("p", "q", "r")):
    time, sensor = np.asarray(time, dtype=float), np.asarray(sensor)
    n = len(time)
    arrays = {
        "time": time,
        "sensor": sensor,
        "target": np.arange(n) % 3 - 1 if target is None else np.asarray(target),
        "values": np.stack([1e4 + time, 0.01 * np.arange(n)], axis=1),
        "beside": np.arange(n),
    }
    return Arrivals(SETUP, arrays, labels)


def slices(pieces, ends):
    """Slices as they become complete, the state going through arrays each time."""
    buffer, found, ends = Buffer(), [], list(ends)
    for piece in pieces:
        buffer = arrive(Buffer.from_arrays(buffer.to_arrays()), piece)
        while ends and complete(buffer, ends[0]):
            one, buffer = cut(buffer, SETUP, ends.pop(0))
            found.append(one)
    return found, buffer


def told(one):
    if one.reports is None:
        return one.until, None, one.ahead.sensor.tolist(), one.repeated
    reports = one.reports
    names = [reports.labels[k] if k >= 0 else "" for k in reports.target]
    rows = zip(reports.time.tolist(), reports.sensor.tolist(), names, strict=True)
    return one.until, list(rows), one.ahead.sensor.tolist(), one.repeated


def test_slices_do_not_depend_on_the_pieces():
    rng = np.random.default_rng(3)
    time = 100.0 + np.sort(rng.uniform(0.0, 300.0, 400)) + rng.exponential(4.0, 400)
    sensor = rng.integers(0, 2, 400)
    time[rng.choice(400, 5, replace=False)] += 1e6
    target = rng.integers(-1, 3, 400)
    ends = 100.0 + 10.0 * np.arange(1, 29)
    results = []
    for _ in range(5):
        cuts = np.sort(rng.choice(400, 30, replace=False))
        rows = np.split(np.arange(400), cuts)
        pieces = []
        for part in rows:
            if len(part):
                # other numbers for the same targets in each piece
                order = rng.permutation(3)
                labels = tuple(np.array(["p", "q", "r"])[order])
                numbers = np.append(np.argsort(order), -1)[target[part]]
                pieces.append(arrivals(time[part], sensor[part], numbers, labels))
        found, buffer = slices(pieces, ends)
        results.append([told(one) for one in found])
        assert (
            sum(0 if one.reports is None else len(one.reports) for one in found) + len(buffer)
            == 400 - 5
        )
        for one in found:
            assert one.reports is None or one.reports.time.max() <= one.until
    assert all(one == results[0] for one in results)
    assert sum(len(one[2]) for one in results[0]) + len(buffer.ahead.by) == 5


def test_late_reports_come_with_the_slice_in_which_they_arrive():
    found, buffer = slices([arrivals([1.0, 11.0, 9.0, 25.0], [0, 1, 0, 1])], [10.0, 20.0, 30.0])
    assert [one.reports.time.tolist() for one in found] == [[1.0], [9.0, 11.0]]
    assert buffer.reached.tolist() == [25.0]


def test_a_slice_without_reports_is_empty():
    found, _ = slices([arrivals([1.0, 45.0], [0, 1])], [10.0, 20.0, 30.0, 40.0])
    assert [one.reports is None for one in found] == [False, True, True, True]


def test_a_clock_that_jumps_does_not_move_time_on():
    time = [1.0, 2.0, 5e5, 3.0, 5e5 + 1.0, 4.0, 15.0]
    found, _ = slices([arrivals(time, [0, 1, 0, 1, 0, 1, 1])], [10.0])
    assert found[0].reports.time.tolist() == [1.0, 2.0, 3.0, 4.0]
    assert found[0].ahead.sensor.tolist() == [0, 0]
    np.testing.assert_allclose(found[0].ahead.by, [5e5 - 2.0, 5e5 - 2.0])


@pytest.mark.parametrize("sensors", [[0, 1, 0, 1], [0] * 30])
def test_a_gap_of_the_whole_recording_is_believed(sensors):
    after = 5e5 + np.arange(len(sensors))
    found, buffer = slices([arrivals([1.0, *after], [1, *sensors])], [10.0])
    lost = 1 if 1 in sensors else 19
    assert len(buffer) == len(sensors) - lost
    assert buffer.newest == after[-1]
    assert found[0].reports.time.tolist() == [1.0]


def test_what_stands_beside_a_doubted_report_is_left_out_with_it():
    came = arrivals([1.0, 1.0, 9e4, 9e4, 2.0], [0, 1, 0, 1, 0])
    came.arrays["beside"] = np.array([0, 0, 2, 2, 4])
    buffer = arrive(Buffer(), came)
    assert buffer.arrays["time"].tolist() == [1.0, 1.0, 2.0]
    assert buffer.arrays["beside"].tolist() == [0, 0, 2]
    assert buffer.ahead.sensor.tolist() == [0]


def test_repeated_reports_are_counted_and_used_once():
    came = arrivals([1.0, 2.0, 2.0, 15.0], [0, 1, 1, 1], [0, 1, 1, 0])
    came.arrays["values"][2] = came.arrays["values"][1]
    found, _ = slices([came], [10.0])
    assert (found[0].reports.time.tolist(), found[0].repeated) == ([1.0, 2.0], 1)
    assert found[0].reports.labels == ("p", "q")


def test_labels_of_targets_that_are_gone_are_forgotten():
    buffer = Buffer()
    for k in range(50):
        buffer = arrive(buffer, arrivals([10.0 * k + 1.0], [0], [0], (f"t{k}",)))
        _, buffer = cut(buffer, SETUP, 10.0 * k + 5.0)
        assert len(buffer.labels) <= 1


def test_what_reports_said_of_a_setup_is_kept_exactly():
    from probreg.recordings._heights import beside_kinds, with_kind

    plain = Setup(RADARS, {"a": ("range",)}, origin=(50.0, 8.0, 0.0))
    full, _ = with_kind(plain, beside_kinds()["flight_level"], "flight_level")
    again = completed(plain, said(plain, full))
    assert again.sensors == full.sensors
    assert (again.biases, again.places, again.geodetic) == (full.biases, {}, frozenset())
