"""The history of a watch: bounded, and denser the newer."""

from __future__ import annotations

import numpy as np

from probreg.watch import history
from probreg.watch.history import ALARMS, MOST, History, from_arrays, to_arrays, with_line


def line(k, alarms=()):
    biases = {
        "a.range": {"unit": "m", "mean": float(k), "sd": 2.0, "p_exceeded": 0.5},
        "a.azimuth": {"unit": "rad", "mean": -float(k), "sd": None},
    }
    return {"time": 10.0 * k, "biases": biases, "alarms": list(alarms)}


def test_a_long_history_is_bounded_and_denser_the_newer():
    found = History()
    for k in range(20_000):
        found = with_line(found, line(k, [{"number": k}] if k % 10 == 0 else []))
        assert len(found) <= MOST
    assert found.time[0] == 0.0
    np.testing.assert_array_equal(
        found.time[-MOST // 4 :], 10.0 * np.arange(20_000 - MOST // 4, 20_000)
    )
    gaps = np.diff(found.time)
    assert (np.diff(gaps) <= 0.0).all()
    # each point is one that was said: mean, sign and time belong together
    np.testing.assert_array_equal(10.0 * found.mean[:, 0], found.time)
    np.testing.assert_array_equal(found.mean[:, 1], -found.mean[:, 0])
    assert [alarm["number"] for alarm in found.alarms] == list(
        range(20_000 - 10 * ALARMS, 20_000, 10)
    )


def test_a_history_comes_back_from_its_arrays():
    found = History()
    for k in range(5):
        found = with_line(found, line(k, [{"number": k}]))
    again = from_arrays(to_arrays(found), found.alarms)
    for name in ("time", "mean", "sd", "exceeded"):
        np.testing.assert_array_equal(getattr(again, name), getattr(found, name))
    assert (again.names, again.units) == (("a.range", "a.azimuth"), ("m", "rad"))
    assert np.isnan(again.exceeded[:, 1]).all()
    assert len(from_arrays(to_arrays(History()), ())) == 0
    assert history.MOST == MOST
