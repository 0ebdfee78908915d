"""MJCF: MuJoCo itself reads the file; what it made of it becomes the plain tree of a description.

So defaults, classes, includes, frames, replicas, units, euler sequences, ``fromto`` and inertias of geoms mean what
MuJoCo means by them. The text is read beside it, for the place of everything, for comments, and for what is left out.
"""

from __future__ import annotations

from pathlib import Path

from ...diagnostic import arrange, error
from ...registry import READING, Rule
from ...tree import Map
from ..accepting import accept
from ..imported import Imported
from ..markup import MarkupError
from ..options import ReadOptions
from . import joints, left_out, limits, links, sections, shapes
from .actuators import drives_of
from .comments import comments_of
from .planting import legal, put
from .process import ask
from .reading import Reading
from .refusals import before, place, refusal
from .source import Markup, Places

RULES = (Rule("mjcf-no-body", "An MJCF is a scene without a robot.", "Name the file that has the robot.", READING),)

_UNNAMED = "MuJoCo Model"


def read_mjcf(path: Path, options: ReadOptions) -> Imported:
    """Return the robot of an MJCF as a plain tree. Problems are diagnostics, never exceptions.

    ``outputs`` of the tree says ``{mjcf: {base: free}}`` where the base of the robot has a free joint; it is for the
    writer to add the files.
    """
    try:
        markup = Markup(path, options)
    except MarkupError as problem:
        return Imported(None, [problem.diagnostic], files=(path,))
    files = tuple(markup.files)
    if markup.root.tag != "mujoco":
        help = "an MJCF begins with <mujoco>"
        message = f"this is no robot: its root element is <{markup.root.tag}>"
        return Imported(None, [error("wrong-root", message, markup.root.span, help)], files=files)
    wrong = list(before(markup))
    if wrong:
        return Imported(None, wrong, files=files)
    answer = ask(path)
    if answer.facts is None:
        return Imported(None, [refusal(markup, answer)], files=files)
    files += tuple(file for name in answer.facts["assets"] if (file := path.parent / name).is_file())
    reading = Reading(markup, Places(markup, answer.facts), answer.facts)
    for message in answer.warnings:
        reading.warned(f"MuJoCo warns: {' '.join(message.split())}", place(markup, message))
    if not reading.tops:
        message = "the file has no body: it is a scene without a robot"
        help = "name the file that has the robot"
        return Imported(None, [error("mjcf-no-body", message, markup.root.span, help)], files=files)
    _read(reading, path)
    tree, said = accept(reading.tree, options.lenient)
    if tree is not None and reading.free_base:
        _say_free(tree)
    diagnostics = arrange([*reading.diagnostics, *said])
    return Imported(tree, diagnostics, comments_of(reading), files, tuple(reading.left_out))


def _read(reading: Reading, path: Path) -> None:
    """Fill the tree, in the order in which a person would read it."""
    tree, root = reading.tree, reading.markup.root
    name = legal(reading.facts["name"])
    said = root.attributes.get("model")
    put(tree, "robot", path.stem if name in ("", _UNNAMED) else name, said.span if said else None)
    origin = Map(root.span)
    put(origin, "status", "imported")
    put(origin, "note", f"from {path.name}")
    put(tree, "source", origin)
    links.name_links(reading)
    joints.name_joints(reading)
    links.add_links(reading)
    joints.add_joints(reading, drives_of(reading))
    links.add_frames(reading)
    shapes.add_shapes(reading)
    put(tree, "links", reading.links)
    put(tree, "joints", reading.joints)
    sections.add_mimics(reading)
    sections.add_contacts(reading)
    sections.add_poses(reading)
    sections.tell_of_free_joints(reading)
    limits.tell_of_zeros(reading)
    joints.tell_of_base(reading)
    left_out.tell(reading)


def _say_free(tree: Map) -> None:
    outputs, mjcf = Map(tree.span), Map(tree.span)
    put(mjcf, "file", "robot.xml")
    put(mjcf, "base", "free")
    put(outputs, "mjcf", mjcf)
    put(tree, "outputs", outputs)
