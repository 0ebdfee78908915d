"""Whatever was edited in a description and whatever changed in its source: each new line of both is in the result."""

from __future__ import annotations

import re
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile.formats.reading import outputs_of, read_robot
from rosorin_compile.importing.description import write
from rosorin_compile.importing.reimport import Request, import_again, record_of, recorded
from rosorin_compile.importing.repeats import with_parts
from rosorin_compile.source.diagnostics import has_errors

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
    return write(with_parts(imported), outputs_of(imported))


def saved(folder: Path, files: dict[str, str]) -> Path:
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_each_new_line_of_both_sides_is_there(data: st.DataObject) -> None:
    with TemporaryDirectory() as name:
        home = Path(name)
        base = files_of(home, robot := data.draw(ROBOT))
        theirs = files_of(home, data.draw(newer(robot)))
        ours = {**base, "robot.yaml": data.draw(edited(base["robot.yaml"]))}
        folder = saved(home / "d", {**record_of(base, WORDS), **ours})
        record = recorded(folder, WORDS)
        assert record is not None
        assert record.files == base
        merged = import_again(folder, record, theirs, Request(WORDS))
        saved(folder, merged.files)
        lines, old = (one.splitlines() for one in ((folder / "robot.yaml").read_text(), base["robot.yaml"]))
        for side in (ours, theirs):
            assert [line for line in side["robot.yaml"].splitlines() if line not in old and line not in lines] == []
        conflicts = [line for line in lines if line.startswith(("<<<<<<<", "|||||||", ">>>>>>>"))]
        assert bool(conflicts) == has_errors(merged.diagnostics)
        if ours == base:
            assert "\n".join(lines) == theirs["robot.yaml"].rstrip("\n")
        again = recorded(folder, WORDS)
        assert again is not None
        assert again.files == theirs
        second = import_again(folder, again, theirs, Request(WORDS))
        assert second.refused == bool(conflicts)
        assert second.files == ({} if conflicts else record_of(theirs, WORDS))
