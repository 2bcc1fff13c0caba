"""The page: well-formed, complete in itself, its numbers those of the registration."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest

from probreg.page import write_report
from probreg.page._units import SHOWN
from probreg.registration import LAWS, _registration, register
from probreg.scenarios.traffic import TrafficScene, simulate

VOID = {"meta", "link", "br", "hr", "img", "input", "source", "col", "wbr"}
LOADING = ("src", "href", "xlink:href", "srcset", "data", "action", "poster")


class Page(HTMLParser):
    """Elements, and whether they nest."""

    def __init__(self, text):
        super().__init__()
        self.open, self.elements, self.loads, self.faults = [], [], [], []
        self.tables, self._cells, self.styles = {}, None, []
        self.feed(text)
        self.close()
        self.faults += self.open

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.elements.append((tag, found))
        self.loads += [found[name] for name in LOADING if name in found]
        if tag not in VOID:
            self.open.append(tag)
        if tag == "table":
            self._cells = self.tables.setdefault(found.get("id"), [])
        elif tag == "tr" and self._cells is not None:
            self._cells.append([])
        elif tag in ("td", "th"):
            self._cells[-1].append("")
        elif tag == "data":
            self._cells[-1][-1] = float(found["value"])

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        self.loads += [value for name, value in attributes if name in LOADING]

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.faults.append(tag)
        if tag == "table":
            self._cells = None

    def handle_data(self, data):
        if self.open and self.open[-1] == "style":
            self.styles.append(data)
        cells = self._cells
        if cells and cells[-1] and isinstance(cells[-1][-1], str) and "caption" not in self.open:
            cells[-1][-1] += data.strip()


@pytest.fixture(scope="module")
def text(done):
    return (done.result / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_the_parser_finds_what_is_wrong():
    assert Page("<p><b>x</p></b>").faults
    assert Page('<img src="http://x/y">').loads == ["http://x/y"]


def test_elements_nest_and_ids_are_unique(page):
    assert not page.faults
    ids = [found["id"] for _, found in page.elements if "id" in found]
    assert len(ids) == len(set(ids))
    assert {"html", "head", "title", "main", "h1", "h2", "h3"} <= {tag for tag, _ in page.elements}


def test_nothing_is_loaded_and_nothing_runs(page, text):
    assert page.loads
    assert all(value.startswith(("#", "data:image/png;base64,")) for value in page.loads)
    assert "http:" not in text
    assert "https:" not in text
    assert "url(" not in "".join(page.styles)
    assert "@import" not in "".join(page.styles)
    tags = {tag for tag, _ in page.elements}
    assert not tags & {"script", "link", "iframe", "object", "embed", "form"}


def test_links_within_the_page_have_a_place(page):
    ids = {found["id"] for _, found in page.elements if "id" in found}
    links = [found["href"] for tag, found in page.elements if tag == "a"]
    assert len(links) >= 6
    assert {link.removeprefix("#") for link in links} <= ids


def test_every_picture_says_in_words_what_it_shows(page):
    assert all(found.get("alt") for tag, found in page.elements if tag == "img")
    pictures = [found for tag, found in page.elements if tag == "svg"]
    assert len(pictures) > 20
    for found in pictures:
        assert found["role"] == "img"
        assert len(found["aria-label"]) > 20


def test_headings_do_not_skip_a_level(page):
    levels = [int(tag[1]) for tag, _ in page.elements if re.fullmatch(r"h[1-6]", tag)]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))


def test_cells_of_heads_have_a_scope(page):
    heads = [found for tag, found in page.elements if tag == "th"]
    assert heads
    assert {found.get("scope") for found in heads} == {"col", "row"}


def test_the_title_names_the_sensors_and_the_page_its_language(page, text):
    title = re.search("<title>(.*?)</title>", text).group(1)
    assert all(name in title for name in ("radar1", "radar2", "radar3"))
    assert ("html", {"lang": "en"}) in page.elements


def test_numbers_of_the_bias_table_are_those_of_the_registration(page, done):
    content = json.loads((done.result / "biases.json").read_text())
    rows = {row[0]: row for row in page.tables["bias-table"][1:]}
    assert set(rows) == {bias["name"] for bias in content["biases"]}
    for bias in content["biases"]:
        row, shown = rows[bias["name"]], SHOWN[bias["unit"]]
        assert row[1] == shown.symbol
        keys = ("mean", "sd", "low_50", "high_50", "low_90", "high_90")
        np.testing.assert_allclose(row[2:8], [shown.factor * bias[key] for key in keys], rtol=1e-12)


def test_what_is_printed_is_the_number_rounded(text):
    found = re.findall(r'<data value="([^"]+)">([^<]+)</data>', text)
    assert len(found) > 50
    for value, printed in found:
        if printed == "not known":
            assert value == "nan"
            continue
        decimals = len(printed.partition(".")[2])
        shown = float(printed.replace("\N{MINUS SIGN}", "-"))
        assert abs(shown - float(value)) <= 0.5000001 * 10.0**-decimals


def test_the_summary_says_what_to_subtract(text, done):
    table = pd.read_csv(done.result / "biases.csv", index_col="name")
    said = re.findall(r'class="subtract">([^ ]+) (\w+)<', text)
    clear = table[np.sign(table.low_90) == np.sign(table.high_90)]
    assert len(clear) >= 3
    assert len(said) == len(clear)
    for (amount, unit), (_, row) in zip(said, clear.iterrows(), strict=True):
        assert unit == row.unit
        assert float(amount.replace("\N{MINUS SIGN}", "-")) == pytest.approx(row["mean"], rel=0.2)


def test_every_section_is_there(page, text):
    for name in (
        "bias-table",
        "correlation-table",
        "limit-table",
        "held-out-table",
        "residual-table",
        "law-table",
        "noise-table",
        "convergence-table",
        "prior-table",
    ):
        assert len(page.tables[name]) > 1, name
    assert "SHA-256" in text
    assert "The mode against short chains" in text
    assert "tracks.parquet" in text
    assert "reports.parquet" in text


def test_one_law_is_marked_as_used_and_its_parameters_are_by_sensor(page, done):
    noise = json.loads((done.result / "biases.json").read_text())["noise"]
    head, *laws = page.tables["law-table"]
    assert head[-1] == "used"
    assert [law[0] for law in laws if law[-1] == "yes"] == [noise["law"]]
    head, *rows = page.tables["noise-table"]
    assert [row[0] for row in rows] == [one["sensor"] for one in noise["sensors"]]
    for row, one in zip(rows, noise["sensors"], strict=True):
        for name, value in one["parameters"].items():
            assert row[head.index(name)] == pytest.approx(value)


def test_suspects_are_reports_of_the_file(page, done):
    reports = pd.read_csv(done.demo / "reports.csv")
    judged = pd.read_parquet(done.result / "reports.parquet").set_index("report")
    _, *rows = page.tables["suspect-table"]
    assert 0 < len(rows) <= 20
    for line, sensor, time, target, *_, fits in rows:
        number = int(line.removeprefix("line ")) - 2
        assert sensor == reports.sensor[number]
        assert time == pytest.approx(reports.time_s[number], abs=1e-6)
        assert target == str(reports.target[number])
        one = judged.loc[number]
        assert one.moved or one.wrong + one.outlier > 0.5
        assert fits == (one.target if one.moved else "none")


def test_the_page_takes_the_residuals_that_registration_has(monkeypatch, tmp_path):
    calls = []

    def counted(*given, compute=_registration.report_residuals):
        calls.append(given)
        return compute(*given)

    monkeypatch.setattr(_registration, "report_residuals", counted)
    recording, setup, _ = simulate(TrafficScene(400), np.random.default_rng(1))
    found = register(recording, setup, rng=np.random.default_rng(2), laws=LAWS[:1])
    for name in ("first.html", "second.html"):
        write_report(found, tmp_path / name)
    found.reports()
    assert len(calls) == 1
