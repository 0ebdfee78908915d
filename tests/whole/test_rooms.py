"""The folders and modules at the top of the package do not import each other in a circle."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from support.imports import Import, circle, imports
from support.paths import PACKAGE

# All may ask which version this is. The other names of the public API are not for us: they would lead round.
VERSION = "__version__"

# The folder of a section has modules, or folders of them, of several rooms: these, by their names. Its record and value
# are of ``sections``.
OF_SECTIONS = {"lowering": "frontend", "rules": "rules", "comparison": "meaning"}


def room(module: str) -> str:
    top, *steps = module.split(".")
    found = (OF_SECTIONS[step] for step in steps[1:] if step in OF_SECTIONS) if top == "sections" else iter(())
    return next(found, top or "__init__")


def arrows(found: Sequence[Import]) -> dict[tuple[str, str], list[Import]]:
    """Return the imports between rooms, by the two rooms."""
    made: dict[tuple[str, str], list[Import]] = defaultdict(list)
    for one in found:
        if room(one.by) != room(one.of) and (one.of, one.name) != ("", VERSION):
            made[room(one.by), room(one.of)].append(one)
    return made


def circles(package: Path) -> list[str]:
    """Return a circle of rooms in words, by the imports of its rarest arrow: they tie the knot."""
    between = arrows(imports(package))
    knows: dict[str, list[str]] = defaultdict(list)
    for one, other in between:
        knows[one].append(other)
    way = circle(knows)
    if not way:
        return []
    knot = min(pairwise(way), key=lambda arrow: len(between[arrow]))
    return [f"{' -> '.join(way)}: {one}" for one in between[knot]]


def test_no_way_leads_round_between_rooms() -> None:
    assert not circles(PACKAGE), "\n".join(circles(PACKAGE))
