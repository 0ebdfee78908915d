"""Whatever somebody changed in a description and whatever changed in its source: each change is there, or is told.

The judge is no three-way merge of trees: each value of the robot that comes out has to be that of the side that changed
it, or nothing is written.
"""

from __future__ import annotations

import re
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile.diagnostics import has_errors
from rosorin_compile.formats.reading import read_robot
from rosorin_compile.frontend.expand import expand
from rosorin_compile.pipeline import compile_robot
from rosorin_compile_import.description import write
from rosorin_compile_import.merging import record
from rosorin_compile_import.merging.reimport import Wanted, imported_again, recorded
from rosorin_compile_import.repeats import with_parts

WORDS = ["robot.urdf"]
Robot = dict[str, dict[str, Any]]


def urdf(robot: Robot) -> str:
    """Return a robot as a URDF: links by name, each with its mass, sizes of shapes and place below the base."""
    pieces = ['<link name="base"><inertial><mass value="5"/>' + INERTIA + "</inertial></link>"]
    for name, link in robot.items():
        shapes = "".join(f'<visual><geometry><box size="{size} 1 1"/></geometry></visual>' for size in link["sizes"])
        inertial = f'<inertial><mass value="{link["mass"]}"/>{INERTIA}</inertial>'
        pieces.append(f'<link name="{name}">{inertial}{shapes}</link>')
        limit = f'<limit effort="5" velocity="{link["velocity"]}"/>' if link["velocity"] else ""
        kind = "continuous" if link["velocity"] else "fixed"
        pieces.append(
            f'<joint name="{name}_joint" type="{kind}"><parent link="base"/><child link="{name}"/>'
            f'<origin xyz="{link["x"]} 0 0"/><axis xyz="0 1 0"/>{limit}</joint>'
        )
    return f'<robot name="any">{"".join(pieces)}</robot>'


INERTIA = '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>'
NAMES = ["arm", "left_wheel", "right_wheel", "rear_wheel", "lid", "foot"]
LINK = st.fixed_dictionaries(
    {
        "mass": st.sampled_from([1, 1, 2, 3.5]),
        "sizes": st.lists(st.sampled_from([0.25, 0.5]), max_size=2),
        "velocity": st.sampled_from([0, 3, 4]),
        "x": st.sampled_from([0, 0.5, -0.5]),
    }
)
ROBOT = st.dictionaries(st.sampled_from(NAMES), LINK, min_size=2, max_size=5)


@st.composite
def newer(draw: st.DrawFn, robot: Robot) -> Robot:
    """Return a robot with some links changed, renamed, removed and added."""
    made = {name: dict(link) for name, link in robot.items()}
    for _ in range(draw(st.integers(0, 3))):
        name, how = draw(st.sampled_from(NAMES)), draw(st.integers(0, 3))
        if how == 0 and len(made) > 1:
            made.pop(name, None)
        elif how == 1 or name not in made:
            made[name] = draw(LINK)
        else:
            key = draw(st.sampled_from(["mass", "sizes", "velocity", "x"]))
            made[name][key] = draw(LINK)[key]
    return made


ADDED = "sensors:\n  mine: {type: imu, frame: base}  # my own\n\noutputs:"


@st.composite
def edited(draw: st.DrawFn, text: str) -> str:
    """Return a description as somebody may have changed it: numbers, comments, layout, entries."""
    for _ in range(draw(st.integers(0, 3))):
        how = draw(st.integers(0, 5))
        numbers = [found for found in re.finditer(r"(?<=[ :\[])[0-9.]+(?=[,}\]\n])", text) if found.start() > 80]
        if how == 0 and numbers:
            at = draw(st.sampled_from(numbers))
            text = f"{text[: at.start()]}{float(at[0]) + draw(st.sampled_from([0.125, 0.5]))}{text[at.end() :]}"
        elif how == 1:
            lines = text.split("\n")
            place = draw(st.integers(1, len(lines) - 1))
            text = "\n".join([*lines[:place], f"# remark {draw(st.integers(0, 99))}", *lines[place:]])
        elif how == 2:
            text = re.sub("^( +)", r"\1\1", text, flags=re.MULTILINE) if "  # " not in text else text
        elif how == 3 and "mine:" not in text:
            text = text.replace("outputs:", ADDED)
        elif how == 4:
            text = text.replace(": {", ":   { ")
        else:
            joints = list(re.finditer(r"^ +(\w+)_joint: +\{.*\d\]\}\n", text, re.MULTILINE))
            if joints:
                at = draw(st.sampled_from(joints))
                text = text.replace(at[0], at[0].replace("}\n", ", source: {status: measured, note: me}}\n"))
    return text


def files_of(folder: Path, robot: Robot) -> dict[str, str]:
    """Return what the importer writes of a robot."""
    source = folder / "robot.urdf"
    source.write_text(urdf(robot))
    imported = read_robot(source)
    assert imported.tree is not None
    return write(with_parts(imported), imported.outputs())


def facts(folder: Path) -> dict[tuple[str, ...], Any]:
    """Return the values of a description by their paths; a list that holds no mapping is one value, and a tensor."""
    tree = expand(folder / "robot.yaml", {}, None).tree
    assert tree is not None
    found: dict[tuple[str, ...], Any] = {}
    waiting: list[tuple[tuple[str, ...], Any]] = [((), tree)]
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, dict) and path[-1:] != ("inertia",):
            found[path] = "a mapping"
            waiting += [((*path, key), item) for key, item in value.items()]
        elif isinstance(value, list) and any(isinstance(item, dict) for item in value):
            found[path] = len(value)
            waiting += [((*path, str(number)), item) for number, item in enumerate(value)]
        else:
            found[path] = value
    return found


def entries(one: dict[tuple[str, ...], Any], other: dict[tuple[str, ...], Any]) -> set[tuple[str, ...]]:
    """Return the entries of sections in which two robots differ."""
    return {path[:2] for path in one.keys() | other.keys() if one.get(path) != other.get(path)}


def saved(folder: Path, files: dict[str, str]) -> Path:
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


@settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_each_change_is_there_or_told(data: st.DataObject) -> None:
    with TemporaryDirectory() as name:
        home = Path(name)
        robot = data.draw(ROBOT)
        base, theirs = files_of(home, robot), files_of(home, data.draw(newer(robot)))
        ours = {**base, "robot.yaml": data.draw(edited(base["robot.yaml"]))}
        folder = saved(home / "d", {**record.of(base, WORDS), **ours})
        known = recorded(folder, WORDS)
        assert known is not None
        assert known.files == base
        sides = [facts(saved(home / name, files)) for name, files in (("b", base), ("o", ours), ("t", theirs))]
        before, here, there = sides
        again = imported_again(folder, known, theirs, Wanted(WORDS))
        if again.refused:
            if has_errors(compile_robot(home / "o" / "robot.yaml").diagnostics):
                return  # it was broken before
            told = " ".join(one.message for one in again.diagnostics)
            both = entries(before, here) & entries(before, there)
            assert both or "the comment" in told, told
            return
        now = facts(saved(folder, again.files))
        for path in {*before, *here, *there, *now}:
            was, own, new = (side.get(path) for side in sides)
            wanted = new if own == was else own
            assert new in (was, own) or own == was, (path, "both have changed it, and nobody was told")
            assert now.get(path) == wanted, path
        text = (folder / "robot.yaml").read_text()
        assert all(remark in text for remark in re.findall(r"# remark \d+|# my own", ours["robot.yaml"]))
        twice = recorded(folder, WORDS)
        assert twice is not None
        assert imported_again(folder, twice, theirs, Wanted(WORDS)).files == record.of(theirs, WORDS)
