"""The rooms of the house: what each may import, and that no way leads round in a circle.

``MAY_KNOW`` is the table of docs/architecture.md, which a test compares. The rooms are what stands at the top of the
package: its folders and its loose modules.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import pytest

from rosorin_compile import diagnostics, extending
from support.imports import Import, circle, imports, modules
from support.paths import DOCS, PACKAGE

PAGE = DOCS / "architecture.md"

# Each room and the rooms that it may import, itself aside.
MAY_KNOW: Mapping[str, Sequence[str]] = {
    "backend": (
        *("meaning", "output", "formats", "rules", "frontend", "sections"),
        *("model", "xml", "diagnostics", "project", "units", "numbers", "startup"),
    ),
    "commands": (
        *("pipeline", "meaning", "output", "formats", "rules", "frontend"),
        *(
            "sections",
            "model",
            "xml",
            "diagnostics",
            "plugins",
            "shipped",
            "project",
            "units",
            "numbers",
            "world",
            "startup",
        ),
    ),
    "pipeline": (
        "meaning",
        "output",
        "formats",
        "rules",
        "frontend",
        "sections",
        "model",
        "diagnostics",
        "plugins",
        "world",
        "startup",
    ),
    "output": ("diagnostics", "plugins", "project", "world", "startup"),
    "meaning": (
        *("formats", "frontend", "sections", "model", "xml"),
        *("diagnostics", "project", "units", "numbers", "world", "startup"),
    ),
    "formats": (
        *("rules", "frontend", "sections", "model", "xml"),
        *("diagnostics", "plugins", "shipped", "project", "units", "numbers", "world", "startup"),
    ),
    "rules": ("frontend", "sections", "model", "xml", "diagnostics", "plugins", "units", "numbers", "world", "startup"),
    "frontend": (
        *("sections", "model", "xml", "diagnostics", "plugins", "project"),
        *("units", "numbers", "world", "startup"),
    ),
    "sections": ("model", "diagnostics", "units", "numbers", "world", "startup"),
    "xml": ("diagnostics", "project", "world", "startup"),
    "model": ("shipped", "diagnostics", "units", "numbers", "world", "startup"),
    "plugins": ("diagnostics", "project", "world", "startup"),
    "project": ("diagnostics", "shipped", "world", "startup"),
    "diagnostics": ("shipped", "world", "startup"),
    "units": ("startup",),
    "numbers": ("startup",),
    "extending": ("startup",),
    "world": ("shipped", "startup"),
    "shipped": (),
    "startup": (),
    "cli": ("commands", "plugins", "diagnostics", "world", "startup"),
    "__main__": ("cli", "world", "startup"),
    "__init__": (),
}
# All may ask which version this is. The other names of the public API are not for us: they would lead round.
VERSION = "__version__"

MOST_LOOSE = 8
LEAF = 100  # lines: what is shorter and has one importer next door belongs into that importer


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


def forbidden(package: Path, may_know: Mapping[str, Sequence[str]]) -> list[str]:
    """Return the imports between rooms that the table does not have, and those of a room that it does not name."""
    wrong = [(arrow, uses) for arrow, uses in arrows(imports(package)).items() if arrow[1] not in may_know[arrow[0]]]
    return [f"{by} may not know {of}: {one}" for (by, of), uses in sorted(wrong) for one in uses]


def readers_and_writers(package: Path) -> list[str]:
    """Return where a module of a format reads and imports one that writes, or the other way round.

    The record of a format may know both.
    """
    known = modules(package)
    between = [one for one in imports(package) if one.of.startswith("formats.") and not known[one.by].is_package]
    return [f"a reader imports a writer: {one}" for one in between if is_writer(one.of) and not is_writer(one.by)] + [
        f"a writer imports a reader: {one}" for one in between if is_writer(one.by) and is_reader(one.of)
    ]


def is_writer(module: str) -> bool:
    return module.rpartition(".")[2].startswith("write")


def is_reader(module: str) -> bool:
    return module.rpartition(".")[2] in ("facts", "grammar", "reading", "robot") and module.count(".") > 1


def loose(package: Path) -> list[str]:
    return [path.name for path in sorted(package.glob("*.py"))]


def leaves(package: Path) -> list[str]:
    """Return short modules that one module alone imports, which stands in the same folder."""
    importers: dict[str, set[str]] = defaultdict(set)
    for one in imports(package):
        importers[one.of].add(one.by)
    for home in (*extending._HOMES.values(), *diagnostics._HOMES.values()):
        importers[home].add("extending")  # the door, which imports a module when a name of it is asked for
    known = modules(package)
    return [
        f"{name}, {module.lines} lines, belongs into {next(iter(importers[name]))}, which alone imports it"
        for name, module in known.items()
        if len(importers[name]) == 1 and module.lines < LEAF and not module.is_package
        if not name.endswith(".answers")  # of which the schemas are made, by the name of the module
        if known[next(iter(importers[name]))].folder == module.folder
    ]


def test_no_way_leads_round_between_rooms() -> None:
    assert not circles(PACKAGE), "\n".join(circles(PACKAGE))


def test_every_room_stands_in_the_table() -> None:
    assert {room(name) for name in modules(PACKAGE)} == set(MAY_KNOW)


def test_rooms_know_what_they_may_know() -> None:
    wrong = forbidden(PACKAGE, MAY_KNOW)
    assert not wrong, "\n".join(wrong)


def test_the_table_itself_allows_no_circle() -> None:
    assert not circle(MAY_KNOW), circle(MAY_KNOW)


def test_readers_and_writers_do_not_import_each_other() -> None:
    assert {"formats.urdf.write"} <= set(filter(is_writer, modules(PACKAGE)))
    assert {"formats.urdf.facts", "formats.urdf.grammar", "formats.urdf.reading"} <= set(
        filter(is_reader, modules(PACKAGE))
    )
    assert not readers_and_writers(PACKAGE), "\n".join(readers_and_writers(PACKAGE))


def test_few_modules_stand_loose_at_the_top() -> None:
    assert len(loose(PACKAGE)) <= MOST_LOOSE, loose(PACKAGE)


def test_no_leaf_stands_beside_its_only_importer() -> None:
    assert not leaves(PACKAGE), "\n".join(leaves(PACKAGE))


def test_the_page_has_the_table() -> None:
    rows = re.findall(r"^\| `(\w+)` \| ([^|]*) \|$", PAGE.read_text("utf-8"), re.MULTILINE)
    shown = {name: tuple(re.findall(r"`(\w+)`", known)) for name, known in rows}
    assert shown == {name: tuple(known) for name, known in MAY_KNOW.items()}


# ---- That these tests can fail ----

HOUSE = {
    "__init__.py": '__version__ = "1"\n',
    "model/__init__.py": "",
    "rules/__init__.py": "from ..model import Robot\n",
    "formats/__init__.py": "from ..rules import check\nfrom .. import __version__\n",
    "formats/sdf/__init__.py": "def f():\n    from .write import write\n    from .reading import read\n",
    "formats/sdf/write.py": "from ...model import Robot\n" + "\n" * LEAF,
    "formats/sdf/reading.py": "from ...model import Robot\n" + "\n" * LEAF,
}
KNOWN = {"__init__": (), "model": (), "rules": ("model",), "formats": ("model", "rules")}


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """A small package in which all is as it should be."""
    build(tmp_path / "house", HOUSE)
    return tmp_path / "house"


def build(package: Path, files: Mapping[str, str]) -> None:
    for name, text in files.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(text, "utf-8")


def test_nothing_is_wrong_with_a_sound_house(house: Path) -> None:
    assert not circles(house) + forbidden(house, KNOWN) + readers_and_writers(house) + leaves(house)
    assert loose(house) == ["__init__.py"]


@pytest.mark.parametrize(
    "line",
    [
        "from ..formats import FORMATS",
        "from .. import formats",
        "import house.formats",
        "from house.formats.sdf import FORMAT",
        "def lazily():\n    from ..formats.sdf.reading import read",
    ],
)
def test_a_circle_is_found_by_the_import_that_ties_it(house: Path, line: str) -> None:
    build(house, {"model/robot.py": f"{line}\n"})
    (found,) = circles(house)
    way, _, knot = found.partition(": ")
    assert way == "formats -> model -> formats"
    assert knot.startswith(f"model.robot, line {line.count(chr(10)) + 1}, imports ")
    assert forbidden(house, KNOWN) == [f"model may not know formats: {knot}"]


def test_a_circle_through_three_rooms_is_found(house: Path) -> None:
    build(house, {"formats/__init__.py": "from ..rules import check\n", "formats/sdf/write.py": "\n" * LEAF})
    build(house, {"formats/sdf/reading.py": "\n" * LEAF, "model/robot.py": "from ..formats import FORMATS\n"})
    (found,) = circles(house)
    assert found.startswith("formats -> rules -> model -> formats: ")


def test_imports_for_types_alone_are_no_arrows(house: Path) -> None:
    text = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from ..formats import FORMATS\n"
    build(house, {"model/robot.py": text})
    assert not circles(house) + forbidden(house, KNOWN)


def test_the_public_names_are_not_for_the_rooms(house: Path) -> None:
    build(house, {"model/robot.py": "from .. import compile, __version__\n"})
    assert forbidden(house, KNOWN) == [
        "model may not know __init__: model.robot, line 1, imports compile of the package"
    ]


def test_a_forbidden_arrow_without_a_circle_is_found(house: Path) -> None:
    build(house, {"rules/frames.py": "from ..xml.markup import parse\n", "xml/markup.py": ""})
    known = {**KNOWN, "xml": ()}
    assert not circles(house)
    assert forbidden(house, known) == [
        "rules may not know xml: rules.frames, line 1, imports parse of xml.markup",
    ]


def test_a_reader_that_imports_a_writer_is_found(house: Path) -> None:
    build(house, {"formats/sdf/joints.py": "def f():\n    from .write import axis\n"})
    assert readers_and_writers(house) == [
        "a reader imports a writer: formats.sdf.joints, line 2, imports axis of formats.sdf.write"
    ]


def test_a_writer_that_imports_a_reader_is_found(house: Path) -> None:
    build(house, {"formats/sdf/write_joints.py": "from .reading import Reading\n"})
    assert readers_and_writers(house) == [
        "a writer imports a reader: formats.sdf.write_joints, line 1, imports Reading of formats.sdf.reading"
    ]


def test_a_ninth_loose_module_is_found(house: Path) -> None:
    build(house, {f"loose_{number}.py": "" for number in range(MOST_LOOSE)})
    assert len(loose(house)) == MOST_LOOSE + 1


def test_a_leaf_is_found(house: Path) -> None:
    build(house, {"model/letters.py": "WIDTH = 1\n", "model/text.py": "from .letters import WIDTH\n"})
    assert leaves(house) == ["model.letters, 1 lines, belongs into model.text, which alone imports it"]
    build(house, {"rules/width.py": "from ..model.letters import WIDTH\n"})
    assert not leaves(house)
