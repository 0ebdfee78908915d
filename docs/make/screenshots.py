"""Take the two screenshots of the README with headless Chromium: the page of `view`, and an error message.

    python docs/make/screenshots.py

Needs chromium on PATH. Look at the pictures before you commit them: another Chromium renders other pixels.
"""

from __future__ import annotations

import html
import os
import pty
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
PICTURES = ROOT / "docs" / "pictures"
TOOL = [sys.executable, "-m", "rosorin_compile"]
BROWSER = (
    *("chromium", "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--hide-scrollbars", "--force-device-scale-factor=1", "--virtual-time-budget=15000"),
)
STYLE = (
    "margin:0;padding:18px 22px;height:100vh;white-space:pre-wrap;background:#1e1e2e;color:#d9e0ee;"
    "font:14px/1.5 'DejaVu Sans Mono',monospace"
)
COLOURS = {"31": "color:#f28fad", "1": "font-weight:bold", "33": "color:#fae3b0", "36": "color:#89dceb"}


def main() -> None:
    """Write docs/pictures/page.png and docs/pictures/error.png."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        page = folder / "page.html"
        subprocess.run([*TOOL, "view", ROOT / "examples/porter/robot.yaml", "--html", page], cwd=folder, check=True)
        screenshot(page, PICTURES / "page.png", "1280,720", folder)
        subprocess.run([*TOOL, "init", "scout", "base"], cwd=folder, check=True, capture_output=True)
        robot = folder / "descriptions" / "scout" / "robot.yaml"
        robot.write_text(robot.read_text("utf-8").replace("rpy: [0, 0, 180 deg]", "rpy: [0, 0, 180]"), "utf-8")
        text = "$ rosorin-compile all scout\n" + on_a_terminal([*TOOL, "all", "scout"], folder)
        message = folder / "message.html"
        message.write_text(
            f'<meta charset="utf-8"><body style="margin:0"><pre style="{STYLE}">{in_colour(text)}</pre>', "utf-8"
        )
        screenshot(message, PICTURES / "error.png", "1280,170", folder)


def on_a_terminal(command: list[str], folder: Path) -> str:
    """Return what a command prints on a terminal, with its escape sequences for colours."""
    reader, writer = pty.openpty()
    subprocess.run(command, cwd=folder, stdout=writer, stderr=writer, check=False)
    os.close(writer)
    with os.fdopen(reader, "rb") as stream:
        return stream.read1(65_536).decode().replace("\r\n", "\n")


def in_colour(text: str) -> str:
    """Return a text with escape sequences for colours as HTML."""
    parts = re.split(r"\x1b\[(\d+)m", html.escape(text.rstrip("\n")))
    spans = [
        f'<span style="{COLOURS.get(code, "")}">{part}</span>'
        for code, part in zip(parts[1::2], parts[2::2], strict=True)
    ]
    return "".join([parts[0], *spans])


def screenshot(page: Path, target: Path, size: str, folder: Path) -> None:
    """Write a picture of a page with a size in pixels: "WIDTH,HEIGHT"."""
    options = (f"--user-data-dir={folder / 'profile'}", f"--window-size={size}", f"--screenshot={target}")
    subprocess.run([*BROWSER, *options, page.as_uri()], check=True, capture_output=True)


if __name__ == "__main__":
    main()
