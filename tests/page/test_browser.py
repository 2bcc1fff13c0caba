"""The page in a browser: it fits a telephone, follows dark mode and shows its figures."""

from __future__ import annotations

import html
import os
import re
import shutil
import subprocess

import matplotlib.image
import numpy as np
import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
BROWSER = next((found for found in map(shutil.which, NAMES) if found), None)
pytestmark = pytest.mark.skipif(
    BROWSER is None and not os.environ.get("PROBREG_REQUIRE_BROWSER"),
    reason="no browser; PROBREG_REQUIRE_BROWSER=1 demands one",
)


def browse(*arguments):
    fixed = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars")
    found = subprocess.run(
        [BROWSER, *fixed, *map(str, arguments)], capture_output=True, text=True, timeout=120
    )
    assert found.returncode == 0, found.stderr
    return found.stdout


def picture(page, path, width, height, *more):
    browse(f"--screenshot={path}", f"--window-size={width},{height}", *more, page.as_uri())
    return matplotlib.image.imread(path)[..., :3]


@pytest.fixture(scope="module")
def page(done):
    assert BROWSER is not None, "PROBREG_REQUIRE_BROWSER is set and there is no browser"
    return done.result / "report.html"


def test_the_browser_keeps_every_element(page):
    text = browse("--dump-dom", page.as_uri())
    assert text.count("<svg") == page.read_text().count("<svg")
    assert 'id="provenance"' in text


@pytest.mark.parametrize("width", [360, 400, 800, 1280])
def test_nothing_is_wider_than_the_window(page, tmp_path, width):
    # in a frame, because a headless window cannot be as narrow as a telephone
    script = "<script>parent.document.title = document.documentElement.scrollWidth</script>"
    text = page.read_text().replace("</body>", script + "</body>")
    frame = f'<iframe style="width:{width}px;height:900px;border:0" srcdoc="{html.escape(text)}">'
    (tmp_path / "frame.html").write_text(f"<title>none</title>{frame}</iframe>")
    found = browse("--window-size=1400,1000", "--dump-dom", (tmp_path / "frame.html").as_uri())
    assert int(re.search("<title>(.*?)</title>", found).group(1)) <= width


def test_dark_mode_is_dark_and_both_show_figures_in_colour(page, tmp_path):
    light = picture(page, tmp_path / "light.png", 1280, 3000)
    dark = picture(page, tmp_path / "dark.png", 1280, 3000, "--force-dark-mode")
    assert np.median(light) > 0.95
    assert np.median(dark) < 0.15
    for image in (light, dark):
        assert image.shape == (3000, 1280, 3)
        coloured = np.ptp(image, axis=2) > 0.25
        assert 0.005 < coloured.mean() < 0.5


def test_it_prints(page, tmp_path):
    browse(f"--print-to-pdf={tmp_path / 'report.pdf'}", page.as_uri())
    content = (tmp_path / "report.pdf").read_bytes()
    assert content.startswith(b"%PDF")
    pages = len(re.findall(rb"/Type\s*/Page\b", content))
    assert 3 <= pages <= 20
