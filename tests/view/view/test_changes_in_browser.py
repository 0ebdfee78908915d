"""The page of a change in Chromium: the robot before is drawn, listed, and flown to."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

from rosorin_compile.cli.main import main
from support.commands import edit
from support.paths import data_text

CHROMIUM = shutil.which("chromium")
CASES = yaml.safe_load(data_text("cases/changes_in_browser.yaml"))
PROJECT = CASES["project"]
WORDS = [
    *("--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--virtual-time-budget=8000", "--window-size=1000,700"),
]
# Asks the page what it shows when it is ready, and leaves the answer where the test finds it.
PROBE = data_text("robots/changes_in_browser.html")

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="Chromium opens the page")]


@pytest.mark.parametrize("distance", [10, pytest.param(100, marks=pytest.mark.tier("outside"))])
def test_a_part_that_moved(project: Path, distance: int) -> None:
    assert main(["all", "-q"]) == 0
    edit(project / "descriptions/mast/robot.yaml", "200 mm", f"{200 + distance} mm")
    assert main(["check", "--html", "page.html"]) == 1
    page = Path("page.html").read_text("utf-8")
    (project / "asked.html").write_text(page.replace("</body>", PROBE, 1), "utf-8")
    assert CHROMIUM is not None
    words = [CHROMIUM, *WORDS, f"--user-data-dir={project / 'browser'}", "--dump-dom", f"file://{project}/asked.html"]
    ran = subprocess.run(words, check=True, capture_output=True, text=True, timeout=120)
    found = re.search(r'data-answer="([^"]*)"', ran.stdout)
    assert found, ran.stderr[-2000:]
    answer = json.loads(found[1].replace("&quot;", '"'))
    assert answer["boxes"] == [["head"], []]
    assert answer["off"] == [pytest.approx(distance / 1000, abs=1e-9)]
    (row,) = answer["rows"]
    assert row.startswith(f"head moved {distance:.1f} mm in base_link")
    assert (answer["before"], answer["toggled"], answer["flown"]) == (True, False, "head")
    # The camera looks at what was and what is, together.
    assert answer["camera"] == pytest.approx([0, 0, 0.2 + distance / 2000], abs=1e-6)
