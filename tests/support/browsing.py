"""Chromium without a screen, driven by ``viewer/drive.js``: pages, what they ask for, and pictures of them."""

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

from support.paths import ROOT

NODE = shutil.which("node")
CHROMIUM = shutil.which("chromium")
DRIVER = ROOT / "viewer/node_modules/puppeteer-core"

# Pictures are compared by the mean colours (0 to 255) of a coarse grid: drivers of graphics differ in edges and shades.
NEAR = 4.0
NEAR_CELL = 45.0

Cells = list[list[float]]


def lacking() -> str:
    """Return what is not installed here, and how it is; empty if nothing is."""
    if NODE is None or CHROMIUM is None:
        return "nodejs and chromium open the pages"
    return "" if DRIVER.is_dir() else "npm ci in viewer brings what drives the browser"


class Browser:
    """A browser with one page."""

    def __init__(self, folder: Path) -> None:
        environment = {**os.environ, "PROFILE": str(folder / "profile"), "CHROMIUM": str(CHROMIUM)}
        command = [str(NODE), "drive.js"]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "bufsize": 1}
        self.process = subprocess.Popen(command, cwd=ROOT / "viewer", env=environment, **pipes)

    def close(self) -> None:
        """End the browser."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.close()
        self.process.wait(60)
        self.process.stdout.close()

    def ask(self, do: str, **more: Any) -> Any:
        """Return what the driver answers."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps({"do": do, **more}) + "\n")
        answer = json.loads(self.process.stdout.readline())
        assert "problem" not in answer, answer["problem"]
        return answer.get("found")

    def open(self, url: str, **more: Any) -> None:
        """Open an address, and wait for the robot; ``width``, ``height`` (pixels), ``touch``, ``dark``, ``ready``.

        A page of which a ``picture`` is to be taken has a ``light``, which costs seconds.
        """
        self.ask("open", url=url, **more)

    def evaluate(self, code: str) -> Any:
        """Return the value of an expression in the page."""
        return self.ask("evaluate", code=code)

    def wait(self, code: str) -> None:
        """Wait until an expression in the page is true."""
        self.ask("wait", code=code)

    def click(self, selector: str, count: int = 1) -> None:
        """Click in the middle of an element."""
        self.ask("click", on=selector, count=count)

    def enter(self, selector: str, text: str) -> None:
        """Replace the content of a field by typing, and press Enter."""
        self.click(selector, 3)
        self.ask("type", text=text)
        self.ask("press", key="Enter")

    def slide(self, joint: str, value: float) -> None:
        """Move the slider of a joint (rad or m), as a hand does."""
        self.evaluate(f"""(() => {{
            const slider = document.querySelector('[data-joint="{joint}"] input[type=range]');
            slider.value = {value};
            slider.dispatchEvent(new Event("input", {{bubbles: true}}));
        }})()""")

    def place(self, link: str) -> tuple[list[float], list[float]]:
        """Return where the page has a link in the root frame: position (m), and rotation row by row."""
        found = self.evaluate(f"app.places.get({json.dumps(link)})")
        return found["p"], found["r"]

    def picture(self, file: Path) -> Path:
        """Write what is on the screen of a page with ``light``."""
        self.ask("picture", file=str(file))
        return file

    def cells(self, file: Path) -> Cells:
        """Return the mean colours of the cells of a picture."""
        found: Cells = self.ask("cells", file=str(file))
        return found

    @property
    def asked(self) -> list[str]:
        """What the page has asked for."""
        return list(self.ask("kept")["asked"])

    @property
    def complaints(self) -> list[str]:
        """Errors and warnings of the page."""
        return list(self.ask("kept")["complaints"])


def apart(one: Cells, other: Cells) -> tuple[float, float]:
    """Return how far two pictures are apart in the mean, and in the cell that is farthest; 0 to 255."""
    each = [sum(abs(a - b) for a, b in zip(x, y, strict=True)) / 3 for x, y in zip(one, other, strict=True)]
    return sum(each) / len(each), max(each)


def is_near(one: Cells, other: Cells) -> bool:
    """Say whether two pictures show the same."""
    mean, farthest = apart(one, other)
    return mean < NEAR and farthest < NEAR_CELL
