"""MJCF: MuJoCo itself reads the file; what it made of it becomes the plain tree of a description.

So defaults, classes, includes, frames, replicas, units, euler sequences, ``fromto`` and inertias of geoms mean what
MuJoCo means by them. The text is read beside it, for the place of everything, for what is left out, and for comments:
each goes with the entry of the tree that it stands before or in.
"""

from __future__ import annotations

from pathlib import Path

from rosorin_compile.formats.imported import BEFORE, BESIDE, END, INSIDE, Comment, Imported, ReadOptions
from rosorin_compile.formats.reading import accept
from rosorin_compile.source.diagnostics import Diagnostic, error
from rosorin_compile.source.files import is_file
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Map
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.xml.markup import COMMENT, Document, Element, MarkupError, Remark

from . import entries, joints, links, poses, shapes
from .actuators import drives_of
from .broken import before, place, refusal
from .process import ask
from .reading import Reading
from .source import Markup, Places
from .values import legal, listing, put

RULES = (
    Rule("mjcf-no-body", "An MJCF is a scene without a robot.", "Name the file that has the robot.", Heading.READING),
)


_UNNAMED = "MuJoCo Model"


def read_mjcf(path: Path, options: ReadOptions) -> Imported:
    """Return the robot of an MJCF as a plain tree. Problems are diagnostics, never exceptions.

    ``outputs`` of the tree says ``{mjcf: {base: free}}`` where the base of the robot has a free joint, and the settings
    of the simulation; it is for the writer to add the files.
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
    named = (path.parent / markup.place_of(name) for name in answer.facts["assets"])
    assets = tuple(file for file in named if is_file(file))
    files += assets
    reading = Reading(markup, Places(markup, answer.facts), answer.facts)
    for message in answer.warnings:
        reading.warned(f"MuJoCo warns: {' '.join(message.split())}", place(markup, message))
    if "rounded_by" in answer.facts:
        rounded = f"MuJoCo {answer.facts['rounded_by']} tells actuators, sensors and options with six digits"
        reading.warned(f"{rounded}; MuJoCo 4 with all", markup.root.span)
    if not reading.tops:
        return Imported(None, [_no_body(markup)], files=files)
    _read(reading, path)
    tree, about_meaning = accept(reading.tree, options.lenient)
    if tree is not None:
        put(tree, "outputs", _outputs(reading))
    diagnostics = arrange([*reading.diagnostics, *about_meaning])
    return Imported(tree, diagnostics, comments_of(reading), files, names=_names(reading))


def _no_body(markup: Markup) -> Diagnostic:
    """Return the error about a file of which MuJoCo makes no body."""
    outside = [element for element in markup.everything() if element.tag == "body"]
    if outside:
        count = "its body stands" if len(outside) == 1 else f"its {len(outside)} bodies stand"
        message = f"{count} outside of <worldbody>, where MuJoCo passes over them: this is a part of an MJCF"
        help = "name the MJCF that includes it, or put them into a <worldbody>"
        return error("mjcf-no-body", message, outside[0].span, help)
    message = "the file has no body: it is a scene without a robot"
    return error("mjcf-no-body", message, markup.root.span, "name the file that has the robot")


def _read(reading: Reading, path: Path) -> None:
    """Fill the tree, in the order in which a person would read it."""
    tree, root = reading.tree, reading.markup.root
    name = legal(reading.facts["name"])
    model = root.attributes.get("model")
    put(tree, "robot", path.stem if name in ("", _UNNAMED) else name, model.span if model else None)
    origin = Map(root.span)
    put(origin, "status", "imported")
    put(origin, "note", f"from {path.name}")
    put(tree, "source", origin)
    links.name_links(reading)
    joints.name_joints(reading)
    links.add_links(reading)
    joints.add_joints(reading, drives_of(reading))
    links.add_marks(reading)
    shapes.add_shapes(reading)
    put(tree, "links", reading.links)
    put(tree, "joints", reading.joints)
    joints.add_root(reading)
    entries.keep_tendons(reading)
    entries.add_equalities(reading)
    poses.add_poses(reading)
    entries.add_sensors(reading)
    entries.add_contacts(reading)
    entries.add_kept(reading)
    joints.report_stand_ins(reading)
    joints.report_light_bodies(reading)


def _names(reading: Reading) -> dict[str, dict[int, str]]:
    """Return the names that objects got, by kind and index."""
    bodies = {index: name for index, name in reading.link_of.items() if index}
    names = {"body": bodies, "joint": reading.joint_of | reading.ball_of, "material": dict(reading.material_of)}
    return (
        names
        | {"actuator": dict(reading.actuator_of)}
        | {"equality" if kind == "constraint" else kind: given for kind, given in reading.given.items()}
    )


def _outputs(reading: Reading) -> Map:
    """Return how the robot stands in the world, and with which settings it is simulated."""
    outputs, mjcf = Map(reading.tree.span), Map(reading.tree.span)
    put(mjcf, "file", "robot.xml")
    if reading.free_base:
        put(mjcf, "base", "free")
    if not reading.in_order:
        put(mjcf, "actuators", listing(reading.actuators, reading.markup.root))
    if not reading.implied_contacts:
        put(mjcf, "contacts", "described")
    seen = any("visual" in link for link in reading.links.values())
    shown = any(shapes.has_our_look(reading, geom) for geom in reading.facts["geoms"])
    if seen == shown:  # else it is as usual: collision shapes are shown where there is no visual
        put(mjcf, "visuals", "from_collision" if shown else "own")
    groups = Map(reading.tree.span)
    for purpose, group in reading.groups.items():
        put(groups, purpose, group)
    if groups:
        put(mjcf, "groups", groups)
    if any(not mesh["taken"] for mesh in reading.facts["meshes"]):
        put(mjcf, "mesh_inertia", "legacy")
    put(mjcf, "option", poses.settings(reading))
    put(outputs, "mjcf", mjcf)
    return outputs


def comments_of(reading: Reading) -> list[Comment]:
    """Return all comments, in the order of the files and their text."""
    paths: dict[Element, TreePath] = {}
    for index, name in reading.link_of.items():
        if index:
            paths.setdefault(reading.places.body(index), ("links", name))
    for index, name in reading.joint_of.items():
        paths.setdefault(reading.places.of("joints", index), ("joints", name))
    made: list[Comment] = []
    for document in reading.markup.documents:
        made += [_made(document, remark, ("robot",), BEFORE) for remark in document.before if remark.kind == COMMENT]
        inner = [comment for element in document.root.iter() for comment in _inside(element, paths)]
        made += sorted(inner, key=lambda comment: (comment.span.line, comment.span.column))
        made += [_made(document, remark, (), END) for remark in document.after if remark.kind == COMMENT]
    return made


def _inside(element: Element, paths: dict[Element, TreePath]) -> list[Comment]:
    """Return the comments directly in an element: before or beside what stands there, or at its end."""
    made = []
    document = element.document
    for position, item in enumerate(element.content):
        if isinstance(item, Element) or item.kind != COMMENT:
            continue
        before = next((e for e in reversed(element.content[:position]) if isinstance(e, Element)), None)
        after = next((e for e in element.content[position:] if isinstance(e, Element)), None)
        own_line = "\n" in document.source.text[(before.end if before else element.opened) : item.start]
        if before is not None and not own_line:
            made.append(_made(document, item, _path(before, paths), BESIDE))
        elif after is not None:
            made.append(_made(document, item, _path(after, paths), BEFORE))
        else:
            made.append(_made(document, item, _path(element, paths), INSIDE if element.parent else END))
    return made


def _path(element: Element, paths: dict[Element, TreePath]) -> TreePath:
    """Return the entry of an element, or of what it stands in; the robot as a whole for all else."""
    here: Element | None = element
    while here is not None:
        if here in paths:
            return paths[here]
        here = here.parent
    return ("robot",)


def _made(document: Document, remark: Remark, path: TreePath, where: str) -> Comment:
    if where in (INSIDE, END) and path == ("robot",):
        path, where = (), END
    return Comment(remark.text, document.span(remark.start, remark.end - remark.start), path, where)
