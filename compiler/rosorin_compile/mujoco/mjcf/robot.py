"""MJCF: MuJoCo itself reads the file, and the compiled model becomes the plain tree of a description.

So defaults, classes, includes, frames, replicas, units, euler sequences, ``fromto`` and inertias of geoms mean what
MuJoCo means by them. The text is read as well, for positions, for what is left out, and for comments.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from rosorin_compile.formats.imported_robot import END, INSIDE, Comment, Imported, ReadOptions, comments_of
from rosorin_compile.formats.robot_files import accept
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span, count_of, error, phrase
from rosorin_compile.source.files import is_file
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.tree import Map
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.xml.markup import Element, MarkupError

from . import SETTINGS, convert, entries, links, shapes
from .process import ask
from .reading import BALL, FREE, SLIDE, Markup, Places, Reading, check_source, place, refusal

_UNNAMED = "MuJoCo Model"
_SIZES = {FREE: 7, BALL: 4}  # positions of a joint
_NEAR = 1e-12  # rad or m: rounding
_NEAR_KEY = 1e-9  # rad or m: of two that are the same but for rounding


def read_mjcf(path: Path, options: ReadOptions) -> Imported:
    """Return the robot of an MJCF as a plain tree. Problems are diagnostics, never exceptions."""
    try:
        markup = Markup(path, options)
    except MarkupError as problem:
        return Imported(None, [problem.diagnostic], files=(path,))
    files = tuple(markup.files)
    if markup.root.tag != "mujoco":
        help = "an MJCF begins with <mujoco>"
        message = f"this is not a robot: its root element is <{markup.root.tag}>"
        return Imported(None, [error("wrong-root", message, markup.root.span, help)], files=files)
    wrong = list(check_source(markup))
    if wrong:
        return Imported(None, wrong, files=files)
    answer = ask(path)
    if answer.facts is None:
        return Imported(None, [refusal(markup, answer)], files=files)
    named = (path.parent / markup.place_of(name) for name in answer.facts["assets"])
    files += tuple(file for file in named if is_file(file))
    reading = Reading(markup, Places(markup, answer.facts), answer.facts)
    warnings = [(f"MuJoCo warns: {' '.join(text.split())}", place(markup, text)) for text in answer.warnings]
    if "rounded_by" in answer.facts:
        rounded = f"MuJoCo {answer.facts['rounded_by']} writes actuators, sensors and options with six digits"
        warnings.append((f"{rounded}; newer versions with all", markup.root.span))
    reading.diagnostics += [Diagnostic("mjcf-warning", WARNING, message, span) for message, span in warnings]
    if not reading.tops:
        outside = next((element for element in markup.everything() if element.tag == "body"), None)
        message, help = "the file has no body: it is a scene without a robot", "name the file that has the robot"
        if outside is not None:
            message = "bodies outside of <worldbody>, which MuJoCo ignores: this is a part of an MJCF"
            help = "name the MJCF that includes it, or put them into a <worldbody>"
        nothing = error("mjcf-no-body", message, (outside or markup.root).span, help)
        return Imported(None, [nothing], files=files)
    _read(reading, path)
    tree, about_meaning = accept(reading.tree, options.lenient)
    if tree is not None:
        convert.put(tree, "outputs", _outputs(reading))
    bodies = {index: name for index, name in reading.link_of.items() if index}
    names = {"body": bodies, "joint": reading.joint_of | reading.ball_of, "material": reading.material_of}
    names |= {"actuator": reading.actuator_of}
    names |= {"equality" if kind == "constraint" else kind: given for kind, given in reading.given.items()}
    diagnostics = arrange([*reading.diagnostics, *about_meaning])
    return Imported(tree, diagnostics, _comments(reading), files, names=names)


def _read(reading: Reading, path: Path) -> None:
    tree, root = reading.tree, reading.markup.root
    name, model = convert.legal(reading.facts["name"]), root.attributes.get("model")
    convert.put(tree, "robot", path.stem if name in ("", _UNNAMED) else name, model.span if model else None)
    convert.put_source(tree, "imported", f"from {path.name}")
    links.name_all(reading)
    links.add_links(reading)
    links.add_joints(reading)
    links.add_marks(reading)
    shapes.add_shapes(reading)
    convert.put(tree, "links", reading.links)
    convert.put(tree, "joints", reading.joints)
    links.add_root(reading)
    entries.keep_tendons(reading)
    entries.add_equalities(reading)
    _add_poses(reading)
    entries.add_sensors(reading)
    entries.add_contacts(reading)
    entries.add_kept(reading)
    if reading.scene:
        counts = Counter(kind for kind, _ in reading.scene)
        what = phrase([count_of(count, kind) for kind, count in counts.items()])
        message = f"{what} of the world: the scene is not a part of the robot"
        reading.note("import-ignored", message, reading.scene[0][1])


def _outputs(reading: Reading) -> Map:
    outputs, mjcf, groups, root = *(Map(reading.tree.span) for _ in range(3)), reading.markup.root
    for purpose, group in reading.groups.items():
        convert.put(groups, purpose, group)
    has_look = any("visual" in one for one in reading.links.values())
    is_legacy = any(not one["taken"] for one in reading.facts["meshes"])
    values = {
        "file": "robot.xml",
        "base": "free" if reading.free_base else "",
        "actuators": [] if reading.in_order else convert.listing(reading.actuator_of.values(), root),
        "sensors": convert.listing(reading.sensor_order, root),
        "contacts": "described",
        "visuals": "" if has_look else "own",
        "groups": groups,
        "mesh_inertia": "legacy" if is_legacy else "",
        "option": _settings(reading),
    }
    for key, value in values.items():
        convert.put_some(mjcf, key, value)
    convert.put(outputs, "mjcf", mjcf)
    return outputs


def _settings(reading: Reading) -> Map:
    """Return the settings of the simulation: those of the file, and of models that are attached to it."""
    root = reading.markup.root
    options, flags, found = Map(root.span), Map(root.span), dict[str, tuple[str, Element, Span]]()
    for element in reading.markup.sections("option"):
        for one in (element, *reading.markup.child_elements(element)):
            prefix = "" if one is element else f"{one.tag} "
            found |= {prefix + name: (own.value, one, own.span) for name, own in one.attributes.items()}
    for name, text in reading.facts["elements"]["options"].items():
        found.setdefault(name, (text, root, root.span))
    convert.put(options, "integrator", reading.facts["integrator"])
    for name, (text, element, span) in found.items():
        flag = name.removeprefix("flag ")
        if flag != name:
            convert.put(flags, flag, text, span)
        elif name not in SETTINGS:
            reading.lost(f'the setting "{name}"', root.span)
        elif name != "integrator" and (value := convert.value_of(text, SETTINGS[name], element, name)) is not None:
            convert.put(options, name, value, span)
    convert.put_some(options, "flag", flags)
    return options


def _add_poses(reading: Reading) -> None:
    """Add the keyframes: positions other than zero, where a free base is, and controls that these do not imply."""
    elements, keys = reading.markup.section_elements("keyframe", "key"), reading.facts["keys"]
    poses = Map(reading.markup.root.span)
    for number, (key, attributes) in enumerate(zip(keys, reading.facts["elements"]["keys"], strict=False)):
        element = elements[number] if number < len(elements) else reading.markup.root
        positions, pose, controls, qpos = Map(element.span), Map(element.span), Map(element.span), key["qpos"]
        at = {}
        for index, name in sorted(reading.joint_of.items()):
            joint = reading.facts["joints"][index]
            at[name] = convert.tidy_position(qpos[joint["qposadr"]], joint["type"] == SLIDE)
            if at[name] and "mimic" not in reading.joints[name]:
                convert.put_number(positions, name, at[name], element)
        convert.put(pose, "positions", positions)
        if reading.free_base:
            base = Map(element.span)
            convert.put(base, "xyz", convert.numbers([convert.tidy(value) for value in qpos[:3]], element))
            convert.put_pose(base, convert.transform(qpos[:3], qpos[3:7]), element)
            convert.put(pose, "base", base)
        for which, name in sorted(reading.actuator_of.items()):  # those that are not what a pose implies
            fact, held = reading.facts["actuators"][which], reading.servos.get(which)
            control, usual, follows = key["ctrl"][fact["ctrladr"]], 0.0, False
            if held is not None:
                usual = fact["gear"][0] * qpos[reading.facts["joints"][held]["qposadr"]]
                follows = "mimic" in reading.joints[reading.joint_of[held]]
            if follows or abs(control - usual) > _NEAR:
                convert.put_number(controls, name, convert.tidy(control), element)
        convert.put_some(pose, "controls", controls)
        more = {word: text for word, text in attributes.items() if word not in ("name", "ctrl", "qpos")}
        if _is_beyond(reading, qpos, at):  # all, as an MJCF of ours counts them
            texts = []
            for joint in reading.facts["joints"]:
                slides, start = joint["type"] in (FREE, BALL, SLIDE), joint["qposadr"]
                values = qpos[start : start + _SIZES.get(joint["type"], 1)]
                texts += [repr(convert.tidy_position(value, slides)) for value in values]
            more["qpos"] = " ".join(texts)
        reading.put_words(pose, more, "pose", element, "a key")
        convert.put(poses, reading.name("key", key["name"], f"key_{number}", number), pose, element.span)
    convert.put_some(reading.tree, "poses", poses)


def _is_beyond(reading: Reading, qpos: list[float], at: Mapping[str, float]) -> bool:
    """Return True if a pose cannot express a keyframe: a mimic joint off its leader, or a moved free or ball joint."""
    zero, floating = reading.facts["qpos0"], (BALL,) if reading.free_base else (BALL, FREE)
    for joint in (joint for joint in reading.facts["joints"] if joint["type"] in floating):
        place = range(joint["qposadr"], joint["qposadr"] + _SIZES[joint["type"]])
        if any(abs(qpos[i] - zero[i]) > _NEAR for i in place):
            return True
    for name, value in at.items():
        if mimic := reading.joints[name].get("mimic"):
            led = mimic.get("multiplier", 1) * at.get(mimic["joint"], 0.0) + mimic.get("offset", 0)
            if abs(led - value) > _NEAR_KEY:
                return True
    return False


def _comments(reading: Reading) -> list[Comment]:
    entries: dict[Element, TreePath] = {}
    for index, name in reading.link_of.items():
        if index:
            entries.setdefault(reading.places.body(index), ("links", name))
    for index, name in reading.joint_of.items():
        entries.setdefault(reading.places.place_of("joints", index), ("joints", name))
    made: list[Comment] = []
    for document in reading.markup.documents:
        paths: dict[int, TreePath] = {}
        for element in document.root.iter():  # what holds others comes first
            above = paths[id(element.parent)] if element.parent is not None else ("robot",)
            paths[id(element)] = entries.get(element, above)
        for one in comments_of(document, paths):
            is_last = one.where == INSIDE and one.path == ("robot",)
            made.append(Comment(one.text, one.span, (), END) if is_last else one)
    return made
