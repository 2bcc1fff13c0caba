"""Pages of biases over time: well-formed, complete in themselves, with the numbers given."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from probreg.page import alarm_text, fill_days, when, write_watch
from probreg.page._timeline import Course, _calendar, courses
from probreg.registration.days import pool_days, read_days
from probreg.watch.history import History, with_line
from tests.page.test_page import Page
from tests.registration.test_saved import COVARIANCE, write

UNITS = {"a.range": "m", "a.azimuth": "rad"}
STEP = {
    "kind": "step", "sensor": "a", "term": "azimuth", "time": 1.7e9 + 30.0,
    "size": np.deg2rad(0.1), "sd": np.deg2rad(0.012), "score": 3.0,
}  # fmt: skip


def past(slices=40, alarms=(STEP,), start=1.7e9):
    found = History()
    for k in range(slices):
        line = {
            "time": start + 10.0 * k,
            "biases": {
                "a.range": {"unit": "m", "mean": 10.0 + k, "sd": 2.0, "p_exceeded": 0.25},
                "a.azimuth": {"unit": "rad", "mean": 0.001, "sd": 1e-4},
            },
            "alarms": list(alarms) if k == slices - 2 else [],
        }
        found = with_line(found, line)
    return found


def test_the_page_of_a_watch_refreshes_itself_and_loads_nothing(tmp_path):
    path = tmp_path / "watch.html"
    write_watch(path, past(), {"a.range": 60.0}, refresh_s=30)
    page = Page(path.read_text())
    assert page.faults == []
    assert all(found.startswith(("#", "data:")) for found in page.loads)
    assert ("meta", {"http-equiv": "refresh", "content": "30"}) in page.elements
    row = next(row for row in page.tables["now-table"] if row and row[0] == "a.range")
    assert row[1:4] == ["m", 49.0, 2.0]
    assert row[4:] == ["60", "25.0\N{NO-BREAK SPACE}%"]
    azimuth = next(row for row in page.tables["now-table"] if row and row[0] == "a.azimuth")
    assert azimuth[2] == pytest.approx(np.rad2deg(0.001))
    assert "a.azimuth changed by 0.100 deg (sd 0.012) since 2023-11-14 22:13:50 UTC." in (
        path.read_text()
    )
    assert len([tag for tag, _ in page.elements if tag == "svg"]) == 2
    # the last page of a watch stays as it is
    write_watch(path, past(alarms=()), {}, refresh_s=None)
    text = path.read_text()
    assert "http-equiv" not in text
    assert "No alarm so far." in text
    assert [found.name for found in tmp_path.iterdir()] == ["watch.html"]


def test_a_page_of_one_slice_and_of_seconds_is_drawn(tmp_path):
    write_watch(tmp_path / "w.html", past(1, (), 5.0), {}, refresh_s=5)
    assert "From 5.0 s to 5.0 s." in (tmp_path / "w.html").read_text()


ALARMS = {
    "ramp": ({"kind": "ramp", "size": np.deg2rad(0.1) / 3600.0, "sd": np.deg2rad(0.02) / 3600.0},
             "a.azimuth drifts by 0.100 deg/h (sd 0.020) since 50.0 s."),
    "silence": ({"kind": "silence", "term": "", "size": None, "sd": None},
                "a is silent since 50.0 s."),
    "noise": ({"kind": "noise", "term": "", "size": 1.5, "sd": 0.1},
              "The noise of a is 1.5 times what it was, since 50.0 s."),
    "clock": ({"kind": "clock", "term": "", "size": -5e4, "sd": 1.0},
              "The clock of a is 50000 s behind since 50.0 s."),
    "without sd": ({"kind": "step", "size": np.deg2rad(0.1), "sd": None},
                   "a.azimuth changed by 0.100 deg (sd not known) since 50.0 s."),
}  # fmt: skip


@pytest.mark.parametrize("name", ALARMS)
def test_alarms_are_said_in_engineers_units(name):
    changes, words = ALARMS[name]
    assert alarm_text({**STEP, "time": 50.0, **changes}, UNITS) == words


def test_times_are_dates_where_they_can_be():
    assert when(12.34) == "12.3 s"
    assert when(0.0) == "0.0 s"
    assert when(1.7e9) == "2023-11-14 22:13:20 UTC"


def test_limits_far_away_do_not_flatten_a_panel():
    time = np.arange(5.0) * 60.0
    panels = [
        courses([Course("a.range", "m", time, time, np.ones(5), limit)], joined=True)[0].svg
        for limit in (np.nan, 1e6, 250.0)
    ]
    assert panels[0] == panels[1] != panels[2]


@pytest.fixture
def days(tmp_path):
    rng = np.random.default_rng(3)
    for k in range(5):
        mean = [10.0 + rng.normal() + 40.0 * (k == 3), 0.002]
        write(tmp_path / "in" / f"day{k}", mean, COVARIANCE, start=1.7e9 + 86_400.0 * k)
    return pool_days(read_days(tmp_path / "in"), np.random.default_rng(1))


def test_the_page_of_many_days_names_the_one_apart(days, tmp_path):
    (tmp_path / "out").mkdir()
    (said,) = fill_days(days, tmp_path / "out")
    assert said.startswith("day3: a.range is ")
    page = Page((tmp_path / "out" / "history.html").read_text())
    assert page.faults == []
    assert all(found.startswith(("#", "data:")) for found in page.loads)
    rows = {row[0]: row for row in page.tables["pooled-table"][1:]}
    common = np.median(days.pooled[0].common)
    assert rows["a.range"][2] == pytest.approx(common)
    content = json.loads((tmp_path / "out" / "history.json").read_text())
    assert len(content["days"]) == 10
    pooled = {row["name"]: row for row in content["pooled"]}
    assert pooled["a.range"]["recordings"] == 5
    assert pooled["a.range"]["spread_mean"] == pytest.approx(days.pooled[0].spread.mean())
    table = pd.read_csv(tmp_path / "out" / "history.csv")
    azimuth = table[table.name == "a.azimuth"]
    np.testing.assert_allclose(azimuth["mean"], np.rad2deg(0.002))
    assert set(azimuth.unit) == {"deg"}
    csv = pd.read_csv(tmp_path / "out" / "pooled.csv").set_index("name")
    ends = np.rad2deg(days.pooled[1].interval(0.9)[0])
    np.testing.assert_allclose(csv.loc["a.azimuth", ["common_low_90", "common_high_90"]], ends)


@pytest.mark.parametrize("span", [0.0, 7.0, 400.0, 5e3, 9e4, 5e5, 3e7, 1e9])
def test_a_calendar_has_a_few_round_times(span):
    ticks, labels = _calendar(np.array([1.7e9, 1.7e9 + span]))
    assert len(ticks) == len(labels) <= 7
    assert span == 0.0 or (len(ticks) >= 2 and ticks[0] >= 1.7e9 and ticks[-1] <= 1.7e9 + span)
    if span == 9e4:
        assert labels == ["00:00", "06:00", "12:00", "18:00"]
