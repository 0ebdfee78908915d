"""The wall: what stands beside the core takes nothing of it but the public names, which are few and stand on a page.

``still_private.txt`` has the names that tools still take past the door, a line each. It only becomes shorter.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

from support.door import DOOR, breaches, owner, past_the_door
from support.paths import DOCS, PACKAGE, PACKAGES

MOST = 150
PAGE = DOCS / "python.md"
STILL_PRIVATE = Path(__file__).with_name("still_private.txt")


def door() -> dict[str, ModuleType]:
    """Return the modules of the door by their names within the package."""
    return {name: import_module(f"{PACKAGE.name}.{name}".rstrip(".")) for name in DOOR}


def public() -> dict[str, list[str]]:
    return {name: module.__all__ for name, module in door().items()}


def still() -> set[tuple[str, str]]:
    """Return the package and the name of what is taken past the door."""
    return {(taken.package, taken.name) for taken in past_the_door(PACKAGE, public())}


def test_tools_take_the_public_names_alone() -> None:
    listed = {tuple(line.split()) for line in STILL_PRIVATE.read_text("utf-8").splitlines()}
    new = [str(taken) for taken in past_the_door(PACKAGE, public()) if (taken.package, taken.name) not in listed]
    assert not new, "\n".join(new)
    assert not listed - still(), "nobody takes these any more: take them off the list"


@pytest.mark.parametrize("package", [one for one in PACKAGES if one != PACKAGE], ids=lambda path: path.name)
def test_a_package_beside_the_core_takes_the_public_names_alone(package: Path) -> None:
    wrong = breaches(package, PACKAGE.name, public())
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


def test_the_list_only_becomes_shorter() -> None:
    lines = STILL_PRIVATE.read_text("utf-8").splitlines()
    assert lines == sorted(set(lines))
    assert len(lines) <= AT_MOST_PRIVATE


@pytest.mark.parametrize("script", sorted((DOCS / "make").glob("*.py")), ids=lambda path: path.name)
def test_what_makes_the_pages_takes_the_public_names_alone(script: Path) -> None:
    doors = {f"{PACKAGE.name}.{name}".rstrip(".") for name in DOOR}
    found = [node for node in ast.walk(ast.parse(script.read_text("utf-8"))) if isinstance(node, ast.ImportFrom)]
    taken = [node for node in found if (node.module or "").partition(".")[0] == PACKAGE.name]
    assert {node.module for node in taken} <= doors
    named = {name for names in public().values() for name in names}
    assert {alias.name for node in taken for alias in node.names} <= named


AT_MOST_PRIVATE = 0


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


# ---- That these tests can fail ----

HOUSE = {
    "__init__.py": "",
    "world/__init__.py": "",
    "tools/__init__.py": "",
    "tools/view/__init__.py": "from house.model import Robot\n",
    "tools/view/command.py": "from ...model import Robot\nfrom .page import html\nfrom ...formats.page import data\n",
    "tools/view/page.py": "",
    "tools/package/__init__.py": "",
    "formats/page/__init__.py": "from ...world import kind\n",
}


@pytest.mark.parametrize(
    ("file", "line", "name"),
    [
        ("view/page.py", "from ...model.kinematics import chain", "model.kinematics.chain"),
        ("view/page.py", "from house.model import Actuator", "model.Actuator"),
        ("view/page.py", "from house import world\nworld.kind('a')", "world.kind"),
        ("view/page.py", "from ... import world as asked\n", "world"),
        ("view/page.py", "import house.world", "world"),
        ("view/page.py", "def f():\n    from ...world import kind", "world.kind"),
        ("view/page.py", "if TYPE_CHECKING:\n    from ...world import kind", "world.kind"),
        ("view/page.py", "from ...formats.page import kind", "world.kind"),
        ("view/page.py", "from importlib import import_module\nimport_module('house.world')", "world"),
        ("view/page.py", "import importlib\nimportlib.import_module('house.' + 'world')", "?"),
        ("package/page.py", "from ..view.page import html", "tools.view.page.html"),
        ("package/page.py", "from ...formats.page import html", "formats.page.html"),
    ],
)
def test_a_name_past_the_door_is_found(tmp_path: Path, file: str, line: str, name: str) -> None:
    for each, text in {**HOUSE, f"tools/{file}": line}.items():
        (tmp_path / "house" / each).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "house" / each).write_text(text, "utf-8")
    (taken,) = past_the_door(tmp_path / "house", {"model": ["Robot"]})
    assert (taken.package, taken.name) == (owner(f"tools.{file.partition('/')[0]}"), name)


if __name__ == "__main__":
    STILL_PRIVATE.write_text("".join(f"{package} {name}\n" for package, name in sorted(still())), "utf-8")
