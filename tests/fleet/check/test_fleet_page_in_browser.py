"""The page of a fleet in Chromium: offline, on a desk and on a phone."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from rosorin_compile.cli import main
from support.browsing import Browser, lacking
from support.fleets import calibrated, swept

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(lacking()), reason=lacking())]
LINES = "[...document.querySelectorAll('.fleet li p')].map((line) => line.textContent)"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    found = Browser(tmp_path_factory.mktemp("browser"))
    yield found
    found.close()


@pytest.fixture
def page(home: Path) -> str:
    rows = calibrated(20)
    rows["r003"]["lidar_x"] = 48.1
    file = swept(home, rows)
    assert main(["check", "fleet", str(file), "--html", "fleet.html", "-q"]) == 0
    return f"file://{home}/fleet.html"


@pytest.mark.parametrize(("width", "height", "touch"), [(1280, 800, False), (390, 800, True)])
def test_a_fleet_is_shown(browser: Browser, page: str, width: int, height: int, touch: bool) -> None:
    browser.open(page, width=width, height=height, touch=touch)
    assert browser.evaluate(LINES)[0].startswith("r003: lidar_x is 48,100")
    bars = "document.querySelectorAll('.fleet ol > li:first-child .bars i')"
    assert browser.evaluate(f"{bars}.length") >= 5
    assert browser.evaluate(f"[...{bars}].some((bar) => bar.getBoundingClientRect().height > 20)")
    assert browser.evaluate("document.querySelector('.fleet .far').textContent") == "1"
    panel = "document.querySelector('.fleet').getBoundingClientRect()"
    assert browser.evaluate(f"{panel}.left >= 0 && {panel}.right <= window.innerWidth")
    browser.evaluate("document.querySelector('.fleet ol .go').click()")
    browser.wait("window.app.selected === 'laser'")
    assert browser.asked == [page]
    assert browser.complaints == []
