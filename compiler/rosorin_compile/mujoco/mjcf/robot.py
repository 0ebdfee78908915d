"""Import an MJCF: MuJoCo compiles the file, and the compiled model is converted to a description.

MuJoCo thus handles defaults, classes, includes, frames, replicas, units, euler sequences, ``fromto`` and inertias of
geoms. The XML is parsed as well, for source positions, comments, and elements that are not imported.

This module has the sections other than links and joints: poses, sensors, constraints, contacts, and elements kept as
XML. If an element refers to a site or geom of the world, and the world is not a link, that is kept too.
"""

from __future__ import annotations

import posixpath
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.imported_robot import END, INSIDE, Comment, Imported, ReadOptions, comments_of
from rosorin_compile.formats.robot_files import accept
from rosorin_compile.language.element_names import kind_of_name
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span, count_of, error, phrase
from rosorin_compile.source.files import is_file
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.xml.markup import Element, MarkupError

from . import SETTINGS, convert, links, shapes
from .bodies import STIFF, shift_polynomial
from .process import ask
from .reading import BALL, FREE, HINGE, SLIDE, Markup, Places, Reading, check_source, place, refusal
from .shapes import ASSETS, is_scene, keep_asset, whole_geom

_UNNAMED = "MuJoCo Model"
_SIZES = {FREE: 7, BALL: 4}  # positions of a joint
_NEAR = 1e-12  # rad or m: rounding error
_NEAR_KEY = 1e-9  # rad or m: rounding error of a position computed from its leader
_OF_CONSTRAINT = {"torquescale": "torque_scale", "polycoef": "polynomial", "anchor": "at"}
_PAIRED = {"body": "links", "site": "sites", "joint": "joints"}
# Sensor types of the description by MuJoCo element, for sensors that other formats also support.
_TYPES = {"gyro": "imu", "accelerometer": "imu", "force": "force_torque", "torque": "force_torque"}
_TYPES |= {"touch": "contact", "rangefinder": "range_finder", "magnetometer": "magnetometer"}
_EQ_JOINT = 2  # mjEQ_JOINT
_DEFAULTS = {"solref": [], "solimp": [0.5, 2.0]}  # MuJoCo's defaults for the numbers that follow those of STIFF
_EXCLUDED = "excluded from contact in the MJCF"
_FILTERED = "MuJoCo keeps neighbours apart; here links without mass are between them"


def read_mjcf(path: Path, options: ReadOptions) -> Imported:
    """Import the robot of an MJCF. Problems are returned as diagnostics and never raised."""
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
    if answer.facts["rounded_by"]:
        rounded = f"MuJoCo {answer.facts['rounded_by']} writes actuators, sensors and options with six digits"
        warnings.append((f"{rounded}; newer versions with all", markup.root.span))
    reading.diagnostics += [Diagnostic("mjcf-warning", WARNING, message, span) for message, span in warnings]
    if not reading.tops:
        outside = next((element for element in markup.everything() if element.tag == "body"), markup.root)
        message, help = "the file has no body: it is a scene without a robot", "name the file that has the robot"
        if outside is not markup.root:
            message = "bodies outside of <worldbody>, which MuJoCo ignores: this is a part of an MJCF"
            help = "name the MJCF that includes it, or put them into a <worldbody>"
        return Imported(None, [error("mjcf-no-body", message, outside.span, help)], files=files)
    _read(reading, path)
    tree, about_meaning = accept(reading.tree, options.lenient)
    if tree is not None:
        convert.put(tree, "outputs", _outputs(reading))
    names = {"equality" if kind == "constraint" else kind: given for kind, given in reading.given.items()}
    names |= {"body": {index: name for index, name in reading.link_of.items() if index}}
    names |= {"joint": reading.joint_of | reading.ball_of, "material": reading.material_of}
    diagnostics = arrange([*reading.diagnostics, *about_meaning])
    return Imported(tree, diagnostics, _comments(reading), files, names={**names, "actuator": reading.actuator_of})


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
    tendons = reading.facts["elements"]["tendons"]
    for index, (node, element) in enumerate(zip(tendons, reading.elements_of("tendon", tendons), strict=True)):
        _keep_named(reading, "tendon", index, node, element)
    add_equalities(reading)
    _add_poses(reading)
    add_sensors(reading)
    add_contacts(reading)
    add_kept(reading)
    if reading.scene:
        counts = Counter(kind for kind, _ in reading.scene)
        what = phrase([count_of(count, kind) for kind, count in counts.items()])
        message = f"{what} of the world: the scene is not a part of the robot"
        reading.note("import-ignored", message, reading.scene[0][1])


def _outputs(reading: Reading) -> Map:
    root = reading.markup.root
    values = {
        "file": "robot.xml",
        "base": "free" if reading.free_base else "",
        "actuators": [] if reading.in_order else convert.listing(reading.actuator_of.values(), root),
        "sensors": convert.listing(reading.sensor_order, root),
        "contacts": "described",
        "visuals": "" if any("visual" in one for one in reading.links.values()) else "own",
        "groups": convert.mapping(reading.groups, root),
        "mesh_inertia": "legacy" if any(not one["taken"] for one in reading.facts["meshes"]) else "",
        "option": _settings(reading),
    }
    return convert.mapping({"mjcf": convert.mapping(values, root)}, root)


def _settings(reading: Reading) -> Map:
    """Return the simulation options of the file and of attached models."""
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
        if name.startswith("flag "):
            convert.put(flags, name.removeprefix("flag "), text, span)
        elif name not in SETTINGS:
            reading.lost(f'the setting "{name}"', root.span)
        elif name != "integrator" and (value := convert.value_of(text, SETTINGS[name], element, name)) is not None:
            convert.put(options, name, value, span)
    convert.put_some(options, "flag", flags)
    return options


def _add_poses(reading: Reading) -> None:
    """Add keyframes as poses: nonzero positions, the pose of a free base, and controls that differ from positions."""
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
        for which, name in sorted(reading.actuator_of.items()):  # by default, the control of a servo is the position
            fact, held = reading.facts["actuators"][which], reading.servos.get(which)
            control, usual = key["ctrl"][fact["ctrladr"]], 0.0
            if held is not None:
                usual = fact["gear"][0] * qpos[reading.facts["joints"][held]["qposadr"]]
            follows = held is not None and "mimic" in reading.joints[reading.joint_of[held]]
            if follows or abs(control - usual) > _NEAR:
                convert.put_number(controls, name, convert.tidy(control), element)
        convert.put_some(pose, "controls", controls)
        more = {word: text for word, text in attributes.items() if word not in ("name", "ctrl", "qpos")}
        if _is_beyond(reading, qpos, at):  # keep the complete qpos, in the order of the generated MJCF
            ends = [(one["qposadr"], _SIZES.get(one["type"], 1), one["type"]) for one in reading.facts["joints"]]
            values = ((value, kind != HINGE) for start, size, kind in ends for value in qpos[start : start + size])
            more["qpos"] = " ".join(repr(convert.tidy_position(value, slides)) for value, slides in values)
        reading.put_words(pose, more, "pose", element, "a key")
        convert.put(poses, reading.name("key", key["name"], f"key_{number}", number), pose, element.span)
    convert.put_some(reading.tree, "poses", poses)


def _is_beyond(reading: Reading, qpos: list[float], at: Mapping[str, float]) -> bool:
    """Return True if a pose cannot express a keyframe: a mimic joint off its leader, or a moved free or ball joint."""
    zero, floating = reading.facts["qpos0"], (BALL,) if reading.free_base else (BALL, FREE)
    loose = [(one["qposadr"], _SIZES[one["type"]]) for one in reading.facts["joints"] if one["type"] in floating]
    if any(abs(qpos[i] - zero[i]) > _NEAR for start, size in loose for i in range(start, start + size)):
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
        for element in document.root.iter():  # parents come before children
            above = paths[id(element.parent)] if element.parent is not None else ("robot",)
            paths[id(element)] = entries.get(element, above)
        for one in comments_of(document, paths):
            is_last = one.where == INSIDE and one.path == ("robot",)
            made.append(Comment(one.text, one.span, (), END) if is_last else one)
    return made


class _Measured(NamedTuple):
    """A sensor at a site, with its index in the file and its name in the description."""

    number: int
    name: str
    node: convert.Node
    element: Element
    site: Mapping[str, Any]


def _keep_named(reading: Reading, section: str, index: int, node: convert.Node, element: Element) -> None:
    own = node["attributes"].get("name", "")
    name = {"name": reading.name(section, own, index=index)} if own else {}
    reading.keep_in_section(section, {**node, "attributes": node["attributes"] | name}, section, element.span)


def _keep_of_scene(reading: Reading, kind: str, name: str) -> None:
    """Keep a site or geom of the world as XML if the robot refers to it and it is not imported otherwise."""
    for index, thing in enumerate(reading.facts[f"{kind}s"] if kind in ("site", "geom") else ()):
        is_left = not reading.ground or (kind == "geom" and is_scene(thing))
        if is_left and thing["name"] == name and thing["bodyid"] == 0 and (kind, name) not in reading.of_scene:
            reading.of_scene.add((kind, name))
            node = whole_geom(reading, thing) if kind == "geom" else thing["element"]
            span = reading.places.place_of(f"{kind}s", index).span
            reading.keep_in_section("worldbody", node, f"{kind} of the world", span)


def add_sensors(reading: Reading) -> None:
    """Add sensors that other formats support, merging those of one type at one site, and keep all others as XML."""
    nodes, sites = reading.facts["elements"]["sensors"], {site["name"]: site for site in reading.facts["sites"]}
    elements = reading.elements_of("sensor", nodes)
    groups: dict[tuple[str, str, str], list[_Measured]] = {}
    kept: list[int] = []
    for index, (node, element) in enumerate(zip(nodes, elements, strict=True)):
        kind, site = _TYPES.get(node["tag"], ""), sites.get(node["attributes"].get("site", ""))
        if not kind or site is None or site["bodyid"] not in reading.link_of or node["inner"]:
            _keep_named(reading, "sensor", index, node, element)
            kept.append(index)
            continue
        name = reading.name("sensor", node["attributes"].get("name", ""), f"{site['name']}_{node['tag']}", index)
        at = "" if kind == "range_finder" else site["name"]  # each ray of a lidar has a separate site
        group = groups.setdefault((reading.link_of[site["bodyid"]], kind, at), [])
        group.append(_Measured(index, name, node, element, site))
    sensors, taken = Map(reading.markup.root.span), {one.name for group in groups.values() for one in group}
    for (link, kind, _), group in groups.items():
        shared = posixpath.commonprefix([one.name for one in group]).rpartition("_")[0]
        if len(group) > 1 and shared and shared not in taken and shared not in sensors:
            convert.put(sensors, shared, _sensor(reading, link, kind, shared, group))
            continue
        for one in group:
            entry = _sensor(reading, link, kind, one.name, [one])
            if one is not group[0]:
                convert.put(entry, "gazebo", Seq(entry.span))  # only the first one becomes a Gazebo sensor
            convert.put(sensors, one.name, entry)
    convert.put_some(reading.tree, "sensors", sensors)
    order = [one.number for group in groups.values() for one in group] + kept
    names = reading.given.get("sensor", {})
    if order != sorted(order) and all(at in names and not nodes[at]["inner"] for at in order):
        reading.sensor_order = [names[at] for at in sorted(order)]
    elif order != sorted(order):
        message = "the sensors that other formats know come first: sensor data is in another order"
        reading.change(message, elements[order[0]].span)


def _sensor(reading: Reading, link: str, kind: str, name: str, members: Sequence[_Measured]) -> Map:
    """Return the entry of a sensor with its MuJoCo elements, and a Gazebo sensor at the site of the first element."""
    first, elements, more = members[0], [], {"contact": {"feels": "sensor"}, "force_torque": {"frame": "joint"}}
    for one in members:
        attributes: dict[str, Any] = {}
        for word, text in one.node["attributes"].items():
            site = reading.name_of("site", text)
            if word == "site" and site != link:
                attributes[word] = site
            elif word not in ("name", "site"):
                attributes[word] = convert.number_or_text(text)
        own = "" if one.name == name else one.name.removeprefix(f"{name}_")
        words = {"sensor": one.node["tag"], "name": own, "attributes": convert.mapping(attributes, one.element)}
        elements.append(convert.mapping(words, one.element))
    item = convert.mapping({"sensor": kind, **more.get(kind, {})}, first.element)
    if kind not in more:
        convert.put_pose(item, convert.transform(first.site["pos"], first.site["quat"]), first.element)
    entry = {"type": kind, "frame": link, "mjcf": convert.listing(elements, first.element)}
    made = convert.mapping(entry, first.element)
    # MuJoCo measures single rays, which do not define a scan for Gazebo.
    convert.put(made, "gazebo", convert.listing([] if kind == "range_finder" else [item], first.element))
    return made


def add_equalities(reading: Reading) -> None:
    """Import equalities as mimic joints if possible, else as constraints."""
    nodes, constraints = reading.facts["elements"]["equalities"], Map(reading.markup.root.span)
    elements, joints, zero = reading.elements_of("equality", nodes), reading.facts["joints"], reading.facts["qpos0"]
    for index, (fact, node, element) in enumerate(zip(reading.facts["equalities"], nodes, elements, strict=True)):
        # MuJoCo's polynomial is relative to the initial positions (rad or m).
        are_joints, ends = fact["type"] == _EQ_JOINT, (fact["obj1id"], fact["obj2id"])
        zeros = [zero[joints[at]["qposadr"]] if are_joints and at >= 0 else 0.0 for at in ends]
        if _is_mimic(reading, fact):
            follower = reading.joint_of[fact["obj1id"]]
            name, mimic = reading.name("constraint", fact["name"], follower, index), Map(element.span)
            leader, factor = element.attributes.get("joint2"), convert.tidy(fact["data"][1])
            convert.put(mimic, "joint", reading.joint_of[fact["obj2id"]], leader.span if leader else None)
            if factor != 1:
                convert.put_number(mimic, "multiplier", factor, element, "polycoef", 1)
            if offset := convert.tidy(fact["data"][0] + zeros[0] - factor * zeros[1]):
                convert.put_number(mimic, "offset", offset, element, "polycoef", 0)
            for word, usual in STIFF.items():
                values = [convert.tidy(value) for value in fact[word]]
                if tuple(values[: len(usual)]) != usual or values[len(usual) :] != _DEFAULTS[word]:
                    convert.put(mimic, word, convert.numbers(values, element, word))
            if name != follower:
                convert.put(mimic, "name", name)
            convert.put(reading.joints[follower], "mimic", mimic)
        else:
            _add_constraint(reading, constraints, index, zeros, node, element)
    convert.put_some(reading.tree, "constraints", constraints)


def _is_mimic(reading: Reading, fact: Mapping[str, Any]) -> bool:
    """Return True if an equality is a linear coupling of two joints that does not form a cycle of mimic joints."""
    follower, here = (reading.joint_of.get(fact[end], "") for end in ("obj1id", "obj2id"))
    if fact["type"] != _EQ_JOINT or not fact["active0"] or any(fact["data"][2:5]) or not (follower and here):
        return False
    while here and here != follower:
        here = (reading.joints[here].get("mimic") or {}).get("joint", "")
    return not here and "mimic" not in reading.joints[follower]


def _add_constraint(
    reading: Reading, constraints: Map, index: int, zeros: Sequence[float], node: convert.Node, element: Element
) -> None:
    """Add a connect, weld or joint equality as a constraint, or keep it as XML if a description cannot express it."""
    attributes, entry = node["attributes"], Map(element.span)
    ends = (attributes.get(f"{kind}1", "") for kind in ("body", "site", "joint", "tendon"))
    made_up = f"{next(filter(None, ends), 'robot')}_{node['tag']}"
    name = reading.name("constraint", attributes.get("name", ""), made_up, index)
    rest = dict(attributes)
    convert.put(entry, "type", node["tag"])
    for word, key in _PAIRED.items():
        names = [rest.pop(end) for end in (f"{word}1", f"{word}2") if end in rest]
        for one in names:
            _keep_of_scene(reading, word, one)
        if names:
            convert.put(entry, key, convert.listing([reading.name_of(word, one) for one in names], element))
    pose = convert.floats({"relpose": rest.pop("relpose", "")}, "relpose", [0, 1, 0, 0, 0, 0, 0])
    if any(pose[3:]):  # relpose; a zero quaternion means the initial relative pose
        convert.put(entry, "xyz", convert.numbers([convert.tidy(value) for value in pose[:3]], element))
        convert.put_pose(entry, convert.transform(pose[:3], pose[3:]), element)
    if any(zeros):
        offset, *others = shift_polynomial(convert.floats(rest, "polycoef", [0, 1, 0, 0, 0]), -zeros[1])
        rest["polycoef"] = " ".join(repr(convert.tidy(value)) for value in (offset + zeros[0], *others))
    known = node["tag"] in ("connect", "weld", "joint")
    if not known or convert.put_words(entry, rest, "constraint", element, _OF_CONSTRAINT):
        named = {**node, "attributes": {**attributes, "name": name}}
        reading.keep_in_section("equality", named, "equality", element.span)
    else:
        constraints.put(name, entry, element.span, element.span)


def add_contacts(reading: Reading) -> None:
    """Add the pairs of links that cannot collide in the file, and keep its contact pairs as XML."""
    nodes, root = reading.facts["elements"]["pairs"], reading.markup.root
    excludes = reading.markup.section_elements("contact", "exclude")
    written = {frozenset((element.get("body1"), element.get("body2"))): element for element in excludes}
    found: list[tuple[list[str], Element, str]] = []
    for signature in reading.facts["exclude_signature"]:
        bodies = (signature >> 16, signature & 0xFFFF)  # MuJoCo sorts the two ids
        names = [reading.link_of.get(index, "") for index in bodies]
        element = written.get(frozenset(reading.facts["bodies"][index]["name"] for index in bodies), root)
        if all(names):
            found.append((sorted(names, key=lambda name: name != element.get("body1")), element, _EXCLUDED))
        elif element not in reading.reported:
            reading.reported.add(element)
            what = "a contact with the world that is excluded: the scene is not a part of the robot"
            reading.note("import-ignored", what, element.span)
    found += list(_filtered(reading, {frozenset(names) for names, *_ in found}))
    pairs = Seq(root.span)
    for names, element, reason in found:
        entry, links = Map(element.span), Seq(element.span)
        spans = {attribute.value: attribute.span for attribute in element.attributes.values()}
        for name in names:
            links.put(name, spans.get(name, element.span))
        convert.put(entry, "links", links)
        convert.put(entry, "reason", reason)
        pairs.put(entry, element.span)
    convert.put_some(reading.tree, "disabled_contacts", pairs)
    for node, element in zip(nodes, reading.elements_of("contact", nodes, "pair"), strict=True):
        reading.keep_in_section("contact", node, "contact", element.span)


def _filtered(reading: Reading, excluded: set[frozenset[str]]) -> Iterator[tuple[list[str], Element, str]]:
    """Yield the pairs of links that MuJoCo's parent filter keeps apart in the file, but not after the import.

    MuJoCo filters contacts between a group of welded bodies and its parent group, unless that is the world. If several
    joints move a body, the import adds massless links, so that the parent group is no longer adjacent.
    """
    touching = {geom["bodyid"] for geom in reading.facts["geoms"] if geom["contype"] or geom["conaffinity"]}
    if reading.facts["elements"]["options"].get("flag filterparent") == "disable":
        return
    balls = {joint["bodyid"] for joint in reading.facts["joints"] if joint["type"] == BALL}
    top, groups = dict[int, int](), dict[int, list[int]]()  # topmost body of each welded group
    for index, body in enumerate(reading.facts["bodies"]):
        top[index] = index if not index or reading.joints_in.get(index) else top[body["parentid"]]
        groups.setdefault(top[index], []).append(index)
    for index, below in groups.items():
        above = top[reading.facts["bodies"][index]["parentid"]] if index else 0
        if above == 0 or (len(reading.joints_in.get(index, ())) < 2 and index not in balls):
            continue
        upper, lower = ([reading.link_of[at] for at in side if at in touching] for side in (groups[above], below))
        for names in ([one, other] for one in upper for other in lower):
            if frozenset(names) not in excluded:
                yield names, reading.places.body(index), _FILTERED


def add_kept(reading: Reading) -> None:
    """Add and report the elements kept as XML, in links and at the top level, with everything that they refer to."""
    for node in reading.facts["elements"]["whole"]:
        reading.keep(node, node["tag"], reading.markup.first(node["tag"]).span)
    by_link: dict[str, list[convert.Node]] = {}
    by_tag: dict[str, list[Span]] = {}
    for kept, tag, span, link in reading.elements:  # the list grows, because elements refer to others
        _keep_named_by(reading, kept, span)
        nodes, node = by_link.setdefault(link, []), _renamed(reading, kept)
        same = [each for each in nodes if each["tag"] == node["tag"] and not each["attributes"] | node["attributes"]]
        if link or not same:
            nodes.append(node)
        else:
            same[0]["inner"].extend(node["inner"])
        by_tag.setdefault(tag, []).append(span)
    for link, nodes in by_link.items():
        texts = convert.listing(map(convert.text_of, nodes), reading.markup.root)
        convert.put(reading.links[link] if link else reading.tree, "mjcf_elements" if link else "mjcf", texts)
    for tag, spans in by_tag.items():
        what = f"{count_of(len(spans), 'element')} ({tag})" if len(spans) > 1 else f"an element ({tag})"
        message = f"{what}, for which the language has no keys: kept as XML under mjcf"
        reading.note("import-verbatim", message, spans[0], others=spans[1:])


def _keep_named_by(reading: Reading, node: convert.Node, span: Span) -> None:
    """Keep the assets and world objects that an element and its descendants refer to."""
    for word, text in node["attributes"].items():
        _keep_of_scene(reading, kind_of_name(word, node["attributes"]), text)
        if word in ASSETS:
            keep_asset(reading, word, text, span)
    for inner in node["inner"]:
        _keep_named_by(reading, inner, span)


def _renamed(reading: Reading, node: convert.Node) -> convert.Node:
    """Return an element with references renamed as in the description, and keep the materials that it uses."""
    attributes = dict(node["attributes"])
    if node["tag"] == "skin" and "file" in attributes:
        attributes["file"] = reading.markup.place_of(attributes["file"])
    for word, text in attributes.items():
        kind = kind_of_name(word, attributes)
        if kind and kind != "material":
            attributes[word] = reading.name_of(kind, text)
    return {**node, "attributes": attributes, "inner": [_renamed(reading, one) for one in node["inner"]]}
