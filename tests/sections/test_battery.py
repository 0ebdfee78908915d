"""The example package of docs/sections.md: it stands on the page as it is, whose tests install and use it."""

from __future__ import annotations

import pytest

from support.pages import blocks
from support.paths import DOCS, ROOT

EXAMPLE = ROOT / "examples" / "rosorin-battery"
PAGE = {block.mark[1]: "\n".join(block.lines) + "\n" for block in blocks((DOCS / "sections.md").read_text("utf-8"))}
PACKAGE = {
    f"rosorin-battery/{path.relative_to(EXAMPLE)}": path for path in EXAMPLE.rglob("*.*") if "cart" not in path.parts
}
FILES = {**PACKAGE, "cart/robot.yaml": EXAMPLE / "cart" / "robot.yaml"}


@pytest.mark.parametrize("name", sorted(FILES))
def test_the_page_shows_the_files_of_the_example(name: str) -> None:
    assert PAGE[name] == FILES[name].read_text("utf-8")
