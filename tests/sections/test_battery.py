"""The example package of docs/sections.md: it stands on the page as it is, whose tests install and use it."""

from __future__ import annotations

import pytest

from support.pages import blocks
from support.paths import DOCS, ROOT

EXAMPLE = ROOT / "examples" / "rosorin-battery"
PAGE = {block.mark[1]: "\n".join(block.lines) + "\n" for block in blocks((DOCS / "sections.md").read_text("utf-8"))}
NAMES = ("pyproject.toml", *(f"rosorin_battery/{name}" for name in ("__init__.py", "section.py", "schema.json")))
FILES = {f"rosorin-battery/{name}": EXAMPLE / name for name in NAMES} | {"cart/robot.yaml": EXAMPLE / "cart.yaml"}


@pytest.mark.parametrize("name", sorted(FILES))
def test_the_page_shows_the_files_of_the_example(name: str) -> None:
    assert PAGE[name] == FILES[name].read_text("utf-8")
