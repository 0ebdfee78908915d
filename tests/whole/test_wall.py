"""The wall: what stands beside the core takes nothing of it but the public names, which are few and stand on a page.

The tool's own packages take beside them what ``rosorin_compile.backend`` hands on, which is written down there, name by
name, and only becomes less.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

from rosorin_compile import shipped
from rosorin_compile.formats import FORMATS
from rosorin_compile.model.sections import own_sections
from support.door import BACKEND, DOOR, breaches
from support.paths import DOCS, PACKAGE, PACKAGES

MOST = 150
MOST_HANDED_ON = 223
PAGE = DOCS / "python.md"
ARCHITECTURE = DOCS / "architecture.md"


def door() -> dict[str, ModuleType]:
    """Return the modules of the door by their names within the package."""
    return {name: import_module(f"{PACKAGE.name}.{name}".rstrip(".")) for name in DOOR}


def public() -> dict[str, list[str]]:
    return {name: module.__all__ for name, module in door().items()}


def backend() -> dict[str, list[str]]:
    """Return the names that the door hands on to the tool's own packages, by module."""
    folder = PACKAGE / BACKEND
    names = [f"{BACKEND}.{path.stem}" for path in sorted(folder.glob("*.py")) if path.stem != "__init__"]
    return {name: import_module(f"{PACKAGE.name}.{name}").__all__ for name in names}


@pytest.mark.parametrize("package", [one for one in PACKAGES if one != PACKAGE], ids=lambda path: path.name)
def test_a_package_beside_the_core_takes_the_public_names_alone(package: Path) -> None:
    wrong = breaches(package, PACKAGE.name, {**public(), **backend()})
    assert not wrong, "\n".join(wrong)


def test_the_core_names_no_package_beside_it_but_in_one_place() -> None:
    beside = [one.name for one in PACKAGES if one != PACKAGE]
    found = {path for path in PACKAGE.rglob("*.py") if any(one in path.read_text("utf-8") for one in beside)}
    assert found == {PACKAGE / "shipped.py"}


@pytest.mark.parametrize(
    ("line", "breach"),
    [
        ("from rosorin_compile.pipeline import compile_robot", "compile_robot of rosorin_compile.pipeline"),
        ("from rosorin_compile.model import of_robot", "of_robot of rosorin_compile.model"),
        ("def f():\n    from rosorin_compile.world import read", "read of rosorin_compile.world"),
        ("import rosorin_compile.formats", "rosorin_compile.formats"),
        ("from rosorin_compile_other import thing", "thing of rosorin_compile_other"),
        ("import_module('rosorin_compile.xml.markup')", "rosorin_compile.xml.markup"),
        ("from rosorin_compile.model import Robot", ""),
        ("from rosorin_compile_own.lines import summary", ""),
        ("from .lines import summary", ""),
        ('"""See rosorin_compile."""', ""),
    ],
)
def test_a_breach_of_the_wall_is_told(line: str, breach: str, tmp_path: Path) -> None:
    package = tmp_path / "rosorin_compile_own"
    package.mkdir()
    (package / "__init__.py").write_text(f"{line}\n", "utf-8")
    told = [one.partition(": ")[2] for one in breaches(package, PACKAGE.name, public())]
    assert told == ([breach] if breach else [])


@pytest.mark.parametrize("script", sorted((DOCS / "make").glob("*.py")), ids=lambda path: path.name)
def test_what_makes_the_pages_takes_the_public_names_alone(script: Path) -> None:
    doors = {f"{PACKAGE.name}.{name}".rstrip(".") for name in DOOR}
    found = [node for node in ast.walk(ast.parse(script.read_text("utf-8"))) if isinstance(node, ast.ImportFrom)]
    taken = [node for node in found if (node.module or "").partition(".")[0] == PACKAGE.name]
    assert {node.module for node in taken} <= doors
    named = {name for names in public().values() for name in names}
    assert {alias.name for node in taken for alias in node.names} <= named


@pytest.mark.parametrize("name", DOOR)
def test_each_public_name_is_there_and_no_module(name: str) -> None:
    module = door()[name]
    assert len(module.__all__) == len(set(module.__all__))
    assert set(module.__all__) <= set(dir(module))
    assert [each for each in module.__all__ if isinstance(getattr(module, each), ModuleType)] == []
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = module.nothing


def test_there_are_few_and_a_name_is_one_thing() -> None:
    there: dict[str, object] = {}
    for module in door().values():
        for name in module.__all__:
            assert there.setdefault(name, getattr(module, name)) is getattr(module, name), name
    assert len(there) <= MOST, len(there)


@pytest.mark.parametrize("name", DOOR)
def test_the_page_has_a_line_for_each_public_name(name: str) -> None:
    title = f"### `{'.'.join(filter(None, [PACKAGE.name, name]))}`"
    _, _, below = PAGE.read_text("utf-8").partition(f"{title}\n")
    section = below.partition("\n#")[0]
    rows = re.findall(r"^\| (`[^|]*) \| ([^|]+) \|$", section, re.MULTILINE)
    named = [each for names, words in rows if words.strip() for each in re.findall(r"`(\w+)`", names)]
    assert sorted(named) == sorted(public()[name])


def test_importing_the_door_loads_none_of_the_rooms() -> None:
    program = (
        "import sys, rosorin_compile.extending as e; dir(e); e.__all__; "
        "print(*(n for n in sys.modules if n.startswith('rosorin_compile.')))"
    )
    ran = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert set(ran.stdout.split()) <= {
        *("rosorin_compile.extending", "rosorin_compile.startup", "rosorin_compile.startup.lazily"),
    }


@cache
def taken() -> dict[str, set[str]]:
    """Return the names that the tool's own packages import of what is handed on, by module."""
    found: dict[str, set[str]] = {}
    backend_modules = [f"{PACKAGE.name}.{name}" for name in backend()]
    texts = [path.read_text("utf-8") for package in PACKAGES for path in package.rglob("*.py")]
    for text in texts:
        for node in ast.walk(ast.parse(text)) if BACKEND in text else ():
            if isinstance(node, ast.ImportFrom) and node.module in backend_modules:
                found.setdefault(str(node.module), set()).update(alias.name for alias in node.names)
    return found


@pytest.mark.parametrize("name", backend())
def test_what_is_handed_on_is_no_public_name_and_some_package_takes_it(name: str) -> None:
    names, module = backend()[name], f"{PACKAGE.name}.{name}"
    assert set(names) == taken()[module]
    open_to_all = {id(getattr(part, each)) for part in door().values() for each in part.__all__}
    there = import_module(module)
    assert [each for each in names if callable(getattr(there, each)) and id(getattr(there, each)) in open_to_all] == []


def test_the_core_does_without_what_it_hands_on() -> None:
    known = {path: path.read_text("utf-8") for path in PACKAGE.rglob("*.py") if path.parent != PACKAGE / BACKEND}
    assert [path for path, text in known.items() if re.search(rf"^\s*from \.+{BACKEND}\b", text, re.MULTILINE)] == []


def test_it_does_not_become_more() -> None:
    assert sum(map(len, backend().values())) <= MOST_HANDED_ON


def brought(package: str) -> set[str]:
    """Return the formats, sections, commands and checks of a package, as its row on the page names them."""
    records = [import_module(one) for one in shipped.SHIPPED if one.startswith(f"{package}.")]
    sections = {one.name for one in own_sections().values() if one.package.startswith(f"{package}.")}
    commands = {one.name for module in records for one in getattr(module, "COMMANDS", ())}
    checks = {f"check {one.name}" for module in records for one in getattr(module, "CHECKS", ())}
    beside = {one.rpartition(".")[2]: one for one in shipped.FORMATS}
    formats = {name for name in FORMATS if FORMATS.is_own(name)}
    own = {name for name in formats if beside.get(name, f"{PACKAGE.name}.formats").startswith(f"{package}.")}
    # the row of the core leaves out its commands and sections: all that are in no other row
    return own if package == PACKAGE.name else own | sections | commands | checks


def test_the_page_says_what_each_package_brings() -> None:
    row = re.compile(rf"^\| \[({PACKAGE.name}\w*)\]\([^)]*\) \| [^|]+ \| ([^|]+) \|$", re.MULTILINE)
    rows = row.findall(ARCHITECTURE.read_text("utf-8"))
    shown = {package: set(re.findall(r"`([^`]+)`", words)) for package, words in rows}
    assert shown.keys() == {package.name for package in PACKAGES}
    differing = {package: words ^ brought(package) for package, words in shown.items() if words != brought(package)}
    assert differing == {}
