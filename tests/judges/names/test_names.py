"""At each place of the schema that holds a name five tests are made; what is different today is listed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile.commands.completion import robot_names
from rosorin_compile.diagnostics import has_errors
from rosorin_compile.formats.imported import Imported, Outputs
from rosorin_compile.frontend.expand import expand
from rosorin_compile.frontend.lower import lower
from rosorin_compile.frontend.tree import Map
from rosorin_compile.meaning.diff import compare_robots
from rosorin_compile.meaning.difference import YAML, Side
from rosorin_compile.model import Robot
from rosorin_compile.pipeline import compile_robot
from rosorin_compile_import.description import write
from rosorin_compile_import.repeats import with_parts
from support import naming
from support.naming import FOLDER, Place, dumped, marked, places, plain, swapped, twice, with_name, with_words

PLACES = {place.path: place for place in places()}
DIFFERENT: dict[str, dict[str, dict[str, str]]] = yaml.safe_load((FOLDER / "different.yaml").read_text("utf-8"))
NEW = "zebra"  # what a thing is called anew

# What a shell calls a list of names, by the kind of thing.
_OFFERED = {
    "link": "links",
    "joint": "joints",
    "sensor": "sensors",
    "pose": "poses",
    "mode": "modes",
    "output": "outputs",
    "publisher": "nodes",
    "link or joint": "things",
}


def tree_of(folder: Path, description: dict[str, Any]) -> Map:
    """Return the tree of a description, its parts placed."""
    made = expand(dumped(folder, description), {}, None)
    assert made.tree is not None
    assert not has_errors(made.diagnostics), [str(one) for one in made.diagnostics]
    return made.tree


def robot_of(folder: Path, description: dict[str, Any]) -> Robot | None:
    """Return the robot of a description; None for one that has errors."""
    made = expand(dumped(folder, description), {}, None)
    if made.tree is None or has_errors(made.diagnostics):
        return None
    lowered = lower(made.tree)
    return None if has_errors(lowered.diagnostics) else lowered.robot


def placed(place: Place, folder: Path) -> str:
    """In a part used twice, once mirrored: each use names its own thing."""
    found = list(_names(place, tree_of(folder, twice(place.fragment))))
    uses = ("right_",) if place.path.startswith("drive.") else ("left_", "right_")
    if all(f"{prefix}{place.name}" in found for prefix in uses) and place.name not in found:
        return "its own"
    if not naming.in_parts(place.path):
        return "in no part"
    return "as it is written" if place.name in found else f"lost: {found}"


def unknown(place: Place, folder: Path) -> str:
    """Two letters swapped: told at its line and column, with the right name."""
    return _misspelt(place, folder, plain(place.fragment), ())


def unknown_in_part(place: Place, folder: Path) -> str:
    """The same in a part that is used twice: told once or for each use, at the line of the part, in its words."""
    within = ("use", "other", "content") if place.path.startswith("drive.") else ("parts", "arm")
    return _misspelt(place, folder, twice(place.fragment), within)


def _misspelt(place: Place, folder: Path, whole: Any, within: naming.Concrete) -> str:
    inner = whole
    for step in within:
        inner = inner[step]
    found_at = (at for at, name in naming.reached(inner, naming.steps(place.path)) if name == place.name)
    at = (*within, *next(found_at))
    wrong = swapped(place.name)
    path = dumped(folder, with_name(whole, at, place.is_key, wrong))
    line, column = marked(path.read_text("utf-8"), (*at[:-1], wrong) if place.is_key else at, place.is_key)
    found = [one for one in compile_robot(path).diagnostics if one.span is not None and wrong in one.message]
    here = [one for one in found if one.span and (one.span.line, one.span.column) == (line, column)]
    if any(f'did you mean "{place.name}"' in one.help for one in here):
        return "told"
    return "without a way out" if here else "elsewhere" if found else "not told"


def renamed(place: Place, folder: Path) -> str:
    """The thing renamed everywhere: diff tells of a new name, and of nothing else."""
    whole = plain(place.fragment)
    one, other = robot_of(folder, whole), robot_of(folder, with_words(whole, {place.name: NEW}))
    assert one is not None
    if other is None:
        return "no other name"
    items = compare_robots(Side("a", YAML, one), Side("b", YAML, other)).items
    if not items:
        return "not told"
    texts = [item.text for item in items]
    as_name = re.compile(rf"{place.name}(\w*) renamed to {NEW}\1").search  # FRAME_joint follows from FRAME
    if all(map(as_name, texts)):
        return "renamed"
    if any(map(as_name, texts)):
        return "renamed and more"
    gone = any(text.startswith("removed: ") or "-> none" in text for text in texts)
    return "as two things" if gone else "as a change"


def completed(place: Place, folder: Path) -> str:
    """What completes a line in a shell knows the name."""
    path = dumped(folder, plain(place.fragment))
    of = _OFFERED.get(place.kind)
    return (
        "offered"
        if of and place.name in robot_names.names(robot_names.Subject((str(path),), {}, {}), of)
        else "not offered"
    )


def written(place: Place, folder: Path) -> str:
    """Written as import does, what repeats as a part, and read again: each name is as it was."""
    tree = tree_of(folder, twice(place.fragment))
    texts = write(with_parts(Imported(tree, [])), Outputs(_plain(tree["outputs"]), {}, {}), split=False)
    path = folder / "again.yaml"
    path.write_text(next(iter(texts.values())), "utf-8")
    again = expand(path, {}, None)
    if again.tree is None or has_errors(again.diagnostics):
        return f"refused: {next(str(one) for one in again.diagnostics if one.severity == 'error')}"
    before, after = (sorted(_names(place, one)) for one in (tree, again.tree))
    return "equal" if before == after else f"changed: {before} {after}"


def _names(place: Place, tree: Map) -> Iterator[str]:
    return (name for _, name in naming.reached(tree, naming.steps(naming.unsided(place.path))))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list) else value


Check = Callable[[Place, Path], str]
CHECKS: dict[str, tuple[Check, str]] = {
    "placed": (placed, "its own"),
    "unknown": (unknown, "told"),
    "unknown in a part": (unknown_in_part, "told"),
    "renamed": (renamed, "renamed"),
    "completed": (completed, "offered"),
    "written": (written, "equal"),
}


def asked(check: str, place: Place) -> bool:
    """Say whether a check is one for a place: where a thing gets its name, no name is wrong, and none is offered."""
    if check == "unknown in a part" and not naming.in_parts(place.path):
        return False
    return not (place.gives and check in ("unknown", "unknown in a part", "completed"))


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the completion take its time: a machine may be busy."""
    monkeypatch.setattr(robot_names, "PATIENCE", 60)


def test_each_text_of_the_schema_is_a_place_or_no_name() -> None:
    no_names = naming.no_names()
    of_schema = list(naming.texts())
    assert [path for path in of_schema if (path in PLACES) == no_names.hold(path)] == []
    assert [path for path in PLACES if path not in of_schema] == []
    assert no_names.idle(of_schema) == []


@pytest.mark.parametrize("path", PLACES)
def test_its_fragment_is_a_robot(path: str, tmp_path: Path) -> None:
    place = PLACES[path]
    found = compile_robot(dumped(tmp_path, plain(place.fragment))).diagnostics
    told = [str(one) for one in found if one.severity == "error" and not one.rule.startswith("drive-")]
    assert told == []  # the joints of the part are wheels in name alone
    assert place.gives or place.name in naming.things(place.kind)


@pytest.mark.parametrize(
    ("check", "path"),
    [(check, path) for check in CHECKS for path, place in PLACES.items() if asked(check, place)],
)
def test_a_name(check: str, path: str, tmp_path: Path) -> None:
    made, right = CHECKS[check]
    different = DIFFERENT[check].get(path)
    assert made(PLACES[path], tmp_path) == (different["today"] if different else right)


def test_what_is_different_is_so_for_a_reason() -> None:
    for check, listed in DIFFERENT.items():
        for path, one in listed.items():
            assert asked(check, PLACES[path]), (check, path)
            assert one["today"] != CHECKS[check][1], (check, path)
            assert one["why"], (check, path)
