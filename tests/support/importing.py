"""Random robots written as URDF: all types of joint, shapes, numbers of many forms, elements in any order."""

import re
from pathlib import Path
from typing import Any

from hypothesis import strategies as st

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.imported_robot import ImportedRobot, ReadOptions, as_tree
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.formats.templating import Templates
from rosorin_compile.language.lower import lower
from rosorin_compile.source.diagnostics import ERROR, has_errors
from rosorin_compile.source.diagnostics import text as report
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.tree import Map, Seq

NAMES = ("base", "arm one", "ns/hand", "größe", "a-b.c", "finger", "Rad_3")
TYPES = ("fixed", "revolute", "continuous", "prismatic", "floating", "planar")

_small = st.floats(-3, 3, allow_nan=False).map(lambda value: 0.0 if abs(value) < 1e-9 else value)
_size = st.floats(1e-4, 15, allow_nan=False)
_forms = st.sampled_from(("{!r}", "{:+.17g}", "{:.17e}", "{:.3f}", "{:.0f}."))


def number(values: st.SearchStrategy[float] = _small) -> st.SearchStrategy[str]:
    return st.builds(str.format, _forms, values)


def vector() -> st.SearchStrategy[str]:
    return st.lists(number(), min_size=3, max_size=3).map("  ".join)


size = number(_size).map(lambda text: text if float(text) > 0 else "0.5")
sizes = st.lists(size, min_size=3, max_size=3).map(" ".join)


@st.composite
def origin(draw: st.DrawFn) -> list[str]:
    parts = [f'{key}="{draw(vector())}"' for key in draw(st.sets(st.sampled_from(("xyz", "rpy"))))]
    return draw(st.sampled_from(([], [f"<origin {' '.join(parts)}/>"])))


@st.composite
def geometry(draw: st.DrawFn) -> str:
    kind = draw(st.sampled_from(("box", "sphere", "cylinder", "capsule", "mesh")))
    if kind == "box":
        return f'<box size="{draw(sizes)}"/>'
    if kind == "mesh":
        scale = draw(st.sampled_from(("", ' scale="0.001 0.001 1e-3"', ' scale="1 -1 1"')))
        return f'<mesh filename="package://some_robot/meshes/ä b.stl"{scale}/>'
    length = "" if kind == "sphere" else f' length="{draw(size)}"'
    return f'<{kind} radius="{draw(size)}"{length}/>'


@st.composite
def solid(draw: st.DrawFn, tag: str) -> str:
    parts = [f"<geometry>{draw(geometry())}</geometry>", *draw(origin())]
    if tag == "visual" and draw(st.booleans()):
        color = draw(st.sampled_from(("", '<color rgba="0 .5 1 1"/>', '<texture filename="t.png"/>')))
        name = {"": "red", '<texture filename="t.png"/>': "own"}.get(color, draw(st.sampled_from(("blue", ""))))
        parts.append(f'<material name="{name}">{color}</material>')
    if draw(st.booleans()):
        parts.append('<sim:extra a="1 &lt; 2"/>')
    name = draw(st.sampled_from(("", f' name="{tag} 1"')))
    return f"<{tag}{name}>{''.join(draw(st.permutations(parts)))}</{tag}>"


@st.composite
def link(draw: st.DrawFn, name: str) -> str:
    parts = [draw(solid(tag)) for tag in draw(st.lists(st.sampled_from(("visual", "collision")), max_size=3))]
    if draw(st.booleans()):
        inertia = f'<inertia ixx="{draw(size)}" iyy="1" izz="1." ixy="0" ixz="{draw(number())}" iyz="-0"/>'
        inertial = [f'<mass value="{draw(size)}"/>', inertia, *draw(origin())]
        parts.append(f"<inertial>{''.join(draw(st.permutations(inertial)))}</inertial>")
    if draw(st.booleans()):
        parts.append("<self_collision>\n      <on/>\n    </self_collision>")
    return f'<link name="{name}">{"".join(parts)}</link>'


@st.composite
def joint(draw: st.DrawFn, name: str, parent: str, child: str, leader: str) -> str:
    kind = draw(st.sampled_from(TYPES))
    parts = [f'<parent link="{parent}"/>', f'<child link="{child}"/>', *draw(origin())]
    if kind in ("revolute", "prismatic", "continuous", "planar"):
        parts += [draw(st.sampled_from(('<axis xyz="0 0 1"/>', '<axis xyz="0.6 0 -0.8"/>', '<axis xyz="1 1 0"/>')))]
    if kind in ("revolute", "prismatic"):
        lower, upper = sorted((draw(_small), draw(_small)))
        ends = draw(st.sampled_from(("", f'lower="{lower!r}" upper="{upper!r}" ', 'upper="6.5" ')))
        parts.append(f'<limit {ends}effort="{draw(size)}" velocity="{draw(size)}"/>')
    if kind in ("revolute", "prismatic", "continuous"):
        parts += draw(_more(leader))
    return f'<joint name="{name}" type="{kind}">{"".join(draw(st.permutations(parts)))}</joint>'


@st.composite
def _more(draw: st.DrawFn, leader: str) -> list[str]:
    choices = [
        f'<dynamics damping="{draw(size)}" friction="{draw(size)}"/>',
        f'<calibration rising="{draw(number())}"/>',
        f'<safety_controller k_velocity="{draw(size)}" soft_lower_limit="-1"/>',
        "<hardwareInterface>Effort\n  here</hardwareInterface>",
    ]
    if leader:
        choices.append(f'<mimic joint="{leader}" multiplier="{draw(number())}" offset="{draw(number())}"/>')
    return [choice for choice in choices if draw(st.booleans())]


@st.composite
def robot(draw: st.DrawFn) -> str:
    """Return the text of a URDF that has nothing wrong."""
    count = draw(st.integers(1, len(NAMES)))
    names = NAMES[:count]
    parts: list[Any] = [draw(link(name)) for name in names]
    for index in range(1, count):
        parent = names[draw(st.integers(0, index - 1))]
        parts.append(draw(joint(f"to {names[index]}", parent, names[index], f"to {names[1]}" if index > 1 else "")))
    parts.append('<material name="red"><color rgba="1 0 0 1"/></material>')
    extras = ['<gazebo reference="base"><x y="&amp;"/></gazebo>', "<sim:block>one\ntwo</sim:block>", "<!-- c -->"]
    parts += [extra for extra in extras if draw(st.booleans())]
    between = draw(st.sampled_from(("", "\n  ")))
    return f'<robot name="made">\n  {between.join(draw(st.permutations(parts)))}\n</robot>\n'


# Round: an imported tree compiled to a URDF, that read again, and what of two trees has to be alike.


DEFAULTS: dict[str, Any] = {
    "xyz": [0, 0, 0],
    "rpy": [0, 0, 0],
    "scale": [1, 1, 1],
    "multiplier": 1,
    "offset": 0,
    "urdf_elements": [],
    "soft_lower_limit": 0,
    "soft_upper_limit": 0,
    "k_position": 0,
    "damping": 0,
    "friction": 0,
    "dynamics": {},
}


def urdf_of(tree: Map) -> str:
    """Return the URDF of an imported tree, with all digits of its numbers."""
    output = {"file": "robot.urdf", "version": "1.2", "number_format": "exact"}
    whole = as_tree({**tree, "outputs": {"urdf": output}}, tree.span)
    robot = lower(whole).robot
    assert robot is not None
    text, said = FORMATS["urdf"].write(robot, robot.outputs[0], Templates(Path()))
    assert not [d for d in said if d.severity == "error"], said
    return text


def meaning(tree: Any) -> Any:
    """Return a tree as what it means: without places, defaults and where it came from."""
    if isinstance(tree, Map):
        kept = {key: meaning(value) for key, value in tree.items() if key not in ("source", "accept")}
        if kept.get("axis") == [1, 0, 0]:
            del kept["axis"]
        if re.fullmatch(r".*_\d+", kept.get("material", "")) and "rgba" in kept:  # a look needs a name in a URDF
            del kept["material"]
        return {key: value for key, value in kept.items() if DEFAULTS.get(key) != value}
    if isinstance(tree, Seq):
        return [meaning(value) for value in tree]
    return float(tree) + 0.0 if isinstance(tree, (int, float)) else str(tree)


def accepted(tree: Map) -> set[tuple[str, str]]:
    """Return what a tree accepts: pairs of rule and name."""
    return {(entry["rule"], name) for entry in tree.get("accept", ()) for name in entry["of"]}


def read_any(text: str | bytes, path: Path, lenient: bool = False) -> ImportedRobot:
    """Write any text to a file, and read it; check what holds always: a tree or an error, and places that exist."""
    path.write_bytes(text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text)
    imported = read_robot(path, ReadOptions(lenient=lenient, environment={}))
    assert (imported.tree is None) == has_errors(imported.diagnostics)
    report(arrange(imported.diagnostics))
    for one in imported.diagnostics:
        assert one.severity != ERROR or one.span is not None or one.rule in ("file-empty", "not-text")
        if one.span is not None:
            assert 1 <= one.span.column <= len(one.span.source.line(one.span.line)) + 1, one
    for comment in imported.comments:
        assert imported.tree is not None
        imported.tree.locate(comment.path)
    return imported
