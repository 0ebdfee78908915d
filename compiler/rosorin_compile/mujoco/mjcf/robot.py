"""Import an MJCF: MuJoCo compiles the file, and the compiled model is converted to a description.

MuJoCo thus handles defaults, classes, includes, frames, replicas, units, euler sequences, ``fromto`` and inertias of
geoms. The XML is parsed as well, for source positions, comments, and elements that are not imported.

This module imports poses, sensors, constraints and contacts, and keeps other elements as XML. If such an element
refers to a site or geom of the world, the site or geom is kept as well, unless the world is a link.
"""

import posixpath
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.imported_robot import END, INSIDE, Comment, ImportedRobot, ReadOptions, comments_of
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
from .import_state import BALL, FREE, HINGE, SLIDE, ImportState, Markup, Places, check_source, place, refusal
from .process import ask
from .shapes import ASSETS, is_scene, keep_asset, whole_geom

_SIZES = {FREE: 7, BALL: 4}  # number of qpos values by joint type
_NEAR = 1e-12  # rad or m: tolerance for rounding errors
_OF_CONSTRAINT = {"torquescale": "torque_scale", "polycoef": "polynomial", "anchor": "at"}
# Sensor types of the description by MuJoCo element, for sensors that other formats also support.
_TYPES = {"gyro": "imu", "accelerometer": "imu", "force": "force_torque", "torque": "force_torque"}
_TYPES |= {"touch": "contact", "rangefinder": "range_finder", "magnetometer": "magnetometer"}
_EQ_JOINT = 2  # mjEQ_JOINT
_DEFAULTS = {"solref": [], "solimp": [0.5, 2.0]}  # MuJoCo's defaults for further numbers after those in STIFF
_FILTERED = "MuJoCo keeps neighbours apart; here links without mass are between them"


def read_mjcf(path: Path, options: ReadOptions) -> ImportedRobot:
    """Import the robot of an MJCF. Return problems as diagnostics instead of raising."""
    try:
        markup = Markup(path, options)
    except MarkupError as problem:
        return ImportedRobot(None, [problem.diagnostic], files=(path,))
    files = tuple(markup.files)
    if markup.root.tag != "mujoco":
        help = "an MJCF begins with <mujoco>"
        message = f"this is not a robot: its root element is <{markup.root.tag}>"
        return ImportedRobot(None, [error("wrong-root", message, markup.root.span, help)], files=files)
    if wrong := list(check_source(markup)):
        return ImportedRobot(None, wrong, files=files)
    answer = ask(path)
    if answer.facts is None:
        return ImportedRobot(None, [refusal(markup, answer)], files=files)
    named = (path.parent / markup.place_of(name) for name in answer.facts["assets"])
    files += tuple(file for file in named if is_file(file))
    state = ImportState(markup, Places(markup, answer.facts), answer.facts)
    warnings = [(f"MuJoCo warns: {' '.join(text.split())}", place(markup, text)) for text in answer.warnings]
    if answer.facts["rounded_by"]:
        rounded = f"MuJoCo {answer.facts['rounded_by']} writes actuators, sensors and options with six digits"
        warnings.append((f"{rounded}; newer versions with all", markup.root.span))
    state.diagnostics += [Diagnostic("mjcf-warning", WARNING, message, span) for message, span in warnings]
    if not state.tops:
        outside = next((element for element in markup.all_elements() if element.tag == "body"), markup.root)
        message, help = "the file has no body: it is a scene without a robot", "name the file that has the robot"
        if outside is not markup.root:
            message = "bodies outside of <worldbody>, which MuJoCo ignores: this is a part of an MJCF"
            help = "name the MJCF that includes it, or put them into a <worldbody>"
        return ImportedRobot(None, [error("mjcf-no-body", message, outside.span, help)], files=files)
    _read(state, path)
    tree, about_meaning = accept(state.tree, options.lenient)
    if tree is not None:
        convert.put_value(tree, "outputs", _outputs(state))
    names = {"equality" if kind == "constraint" else kind: given for kind, given in state.given.items()}
    names |= {"body": {index: name for index, name in state.link_of.items() if index}}
    names |= {"joint": state.joint_of | state.ball_of, "material": state.material_of}
    diagnostics = arrange([*state.diagnostics, *about_meaning])
    return ImportedRobot(tree, diagnostics, _comments(state), files, names={**names, "actuator": state.actuator_of})


def _read(state: ImportState, path: Path) -> None:
    tree, root = state.tree, state.markup.root
    name, model = convert.legal(state.facts["name"]), root.attributes.get("model")
    convert.put_value(tree, "robot", path.stem if name in ("", "MuJoCo Model") else name, model.span if model else None)
    convert.put_source(tree, "imported", f"from {path.name}")
    links.name_all(state)
    links.add_links(state)
    links.add_joints(state)
    links.add_marks(state)
    shapes.add_shapes(state)
    convert.put_value(tree, "links", state.links)
    convert.put_value(tree, "joints", state.joints)
    links.add_root(state)
    tendons = state.facts["elements"]["tendons"]
    for index, (node, element) in enumerate(zip(tendons, state.elements_of("tendon", tendons), strict=True)):
        _keep_named(state, "tendon", index, node, element)
    add_equalities(state)
    _add_poses(state)
    add_sensors(state)
    add_contacts(state)
    add_kept(state)
    if state.scene:
        what = phrase([count_of(count, kind) for kind, count in Counter(kind for kind, _ in state.scene).items()])
        state.note("import-ignored", f"{what} of the world: the scene is not a part of the robot", state.scene[0][1])


def _outputs(state: ImportState) -> Map:
    root = state.markup.root
    values = {
        "file": "robot.xml",
        "base": "free" if state.free_base else "",
        "actuators": [] if state.in_order else convert.list_entry(state.actuator_of.values(), root),
        "sensors": convert.list_entry(state.sensor_order, root),
        "contacts": "described",
        "visuals": "" if any("visual" in one for one in state.links.values()) else "own",
        "groups": convert.map_entry(state.groups, root),
        "mesh_inertia": "legacy" if any(not one["taken"] for one in state.facts["meshes"]) else "",
        "option": _settings(state),
    }
    return convert.map_entry({"mjcf": convert.map_entry(values, root)}, root)


def _settings(state: ImportState) -> Map:
    root = state.markup.root
    options, flags, found = Map(root.span), Map(root.span), dict[str, tuple[str, Element, Span]]()
    for element in state.markup.sections("option"):
        for one in (element, *state.markup.child_elements(element)):
            prefix = "" if one is element else f"{one.tag} "
            found |= {prefix + name: (own.value, one, own.span) for name, own in one.attributes.items()}
    for name, text in state.facts["elements"]["options"].items():
        found.setdefault(name, (text, root, root.span))
    convert.put_value(options, "integrator", state.facts["integrator"])
    for name, (text, element, span) in found.items():
        if name.startswith("flag "):
            convert.put_value(flags, name.removeprefix("flag "), text, span)
        elif name not in SETTINGS:
            state.report_lost(f'the setting "{name}"', root.span)
        elif name != "integrator" and (value := convert.value_of(text, SETTINGS[name], element, name)) is not None:
            convert.put_value(options, name, value, span)
    convert.put_some(options, "flag", flags)
    return options


def _add_poses(state: ImportState) -> None:
    elements, keys = state.markup.section_elements("keyframe", "key"), state.facts["keys"]
    poses = Map(state.markup.root.span)
    for number, (key, attributes) in enumerate(zip(keys, state.facts["elements"]["keys"], strict=False)):
        element = elements[number] if number < len(elements) else state.markup.root
        positions, pose, controls, qpos = Map(element.span), Map(element.span), Map(element.span), key["qpos"]
        at = {}
        for index, name in sorted(state.joint_of.items()):
            joint = state.facts["joints"][index]
            at[name] = convert.tidy_position(qpos[joint["qposadr"]], joint["type"] == SLIDE)
            if at[name] and "mimic" not in state.joints[name]:
                convert.put_number(positions, name, at[name], element)
        convert.put_value(pose, "positions", positions)
        if state.free_base:
            base = convert.map_entry(
                {"xyz": convert.numbers([convert.tidy(one) for one in qpos[:3]], element)}, element
            )
            convert.put_pose(base, convert.transform(qpos[:3], qpos[3:7]), element)
            convert.put_value(pose, "base", base)
        for which, name in sorted(state.actuator_of.items()):  # by default, the control of a servo is its position
            fact, held = state.facts["actuators"][which], state.servos.get(which)
            control = key["ctrl"][fact["ctrladr"]]
            usual = 0.0 if held is None else fact["gear"][0] * qpos[state.facts["joints"][held]["qposadr"]]
            follows = held is not None and "mimic" in state.joints[state.joint_of[held]]
            if follows or abs(control - usual) > _NEAR:
                convert.put_number(controls, name, convert.tidy(control), element)
        convert.put_some(pose, "controls", controls)
        more = {word: text for word, text in attributes.items() if word not in ("name", "ctrl", "qpos")}
        if _is_beyond(state, qpos, at):  # keep the complete qpos, in the joint order of the export
            ends = [(one["qposadr"], _SIZES.get(one["type"], 1), one["type"]) for one in state.facts["joints"]]
            values = ((value, kind != HINGE) for start, size, kind in ends for value in qpos[start : start + size])
            more["qpos"] = " ".join(repr(convert.tidy_position(value, slides)) for value, slides in values)
        state.put_words(pose, more, "pose", element, "a key")
        convert.put_value(poses, state.name("key", key["name"], f"key_{number}", number), pose, element.span)
    convert.put_some(state.tree, "poses", poses)


def _is_beyond(state: ImportState, qpos: list[float], at: Mapping[str, float]) -> bool:
    """Return True if a pose needs the key ``qpos``: a mimic joint deviates, or a ball or floating joint has moved."""
    zero, floating = state.facts["qpos0"], (BALL,) if state.free_base else (BALL, FREE)
    loose = [(one["qposadr"], _SIZES[one["type"]]) for one in state.facts["joints"] if one["type"] in floating]
    if any(abs(qpos[i] - zero[i]) > _NEAR for start, size in loose for i in range(start, start + size)):
        return True
    mimics = ((state.joints[name]["mimic"], value) for name, value in at.items() if "mimic" in state.joints[name])
    led = ((one.get("multiplier", 1) * at.get(one["joint"], 0.0) + one.get("offset", 0), to) for one, to in mimics)
    return any(abs(position - value) > 1e-9 for position, value in led)  # tolerance for rounding errors


def _comments(state: ImportState) -> list[Comment]:
    found = [(state.places.body(index), ("links", name)) for index, name in state.link_of.items() if index]
    found += [(state.places.place_of("joints", index), ("joints", name)) for index, name in state.joint_of.items()]
    entries: dict[Element, TreePath] = dict(reversed(found))  # reversed, because the first entry has priority
    made: list[Comment] = []
    for document in state.markup.documents:
        paths: dict[int, TreePath] = {}
        for element in document.root.iter():  # parents come before children
            above = paths[id(element.parent)] if element.parent is not None else ("robot",)
            paths[id(element)] = entries.get(element, above)
        for one in comments_of(document, paths):
            made.append(Comment(one.text, one.span, (), END) if (one.where, one.path) == (INSIDE, ("robot",)) else one)
    return made


class _Measured(NamedTuple):
    number: int
    name: str
    node: convert.Node
    element: Element
    site: Mapping[str, Any]


def _keep_named(state: ImportState, section: str, index: int, node: convert.Node, element: Element) -> None:
    own = node["attributes"].get("name", "")
    name = {"name": state.name(section, own, index=index)} if own else {}
    state.keep_in_section(section, {**node, "attributes": node["attributes"] | name}, section, element.span)


def _keep_of_scene(state: ImportState, kind: str, name: str) -> None:
    """If the robot refers to a site or geom of the world that is not imported, keep it as XML."""
    for index, thing in enumerate(state.facts[f"{kind}s"] if kind in ("site", "geom") else ()):
        is_left = not state.ground or (kind == "geom" and is_scene(thing))
        if is_left and thing["name"] == name and thing["bodyid"] == 0 and (kind, name) not in state.of_scene:
            state.of_scene.add((kind, name))
            node = whole_geom(state, thing) if kind == "geom" else thing["element"]
            span = state.places.place_of(f"{kind}s", index).span
            state.keep_in_section("worldbody", node, f"{kind} of the world", span)


def add_sensors(state: ImportState) -> None:
    """Import sensors, with one entry per type and site, and keep sensors of unsupported types as XML."""
    nodes, sites = state.facts["elements"]["sensors"], {site["name"]: site for site in state.facts["sites"]}
    elements = state.elements_of("sensor", nodes)
    groups: dict[tuple[str, str, str], list[_Measured]] = {}
    kept: list[int] = []
    for index, (node, element) in enumerate(zip(nodes, elements, strict=True)):
        kind, site = _TYPES.get(node["tag"], ""), sites.get(node["attributes"].get("site", ""))
        if not kind or site is None or site["bodyid"] not in state.link_of or node["inner"]:
            _keep_named(state, "sensor", index, node, element)
            kept.append(index)
            continue
        name = state.name("sensor", node["attributes"].get("name", ""), f"{site['name']}_{node['tag']}", index)
        at = "" if kind == "range_finder" else site["name"]  # each ray of a lidar has a separate site
        group = groups.setdefault((state.link_of[site["bodyid"]], kind, at), [])
        group.append(_Measured(index, name, node, element, site))
    sensors, taken = Map(state.markup.root.span), {one.name for group in groups.values() for one in group}
    for (link, kind, _), group in groups.items():
        shared = posixpath.commonprefix([one.name for one in group]).rpartition("_")[0]
        if len(group) > 1 and shared and shared not in taken and shared not in sensors:
            convert.put_value(sensors, shared, _sensor(state, link, kind, shared, group))
            continue
        for one in group:
            entry = _sensor(state, link, kind, one.name, [one])
            if one is not group[0]:
                convert.put_value(entry, "gazebo", Seq(entry.span))  # Gazebo gets one sensor per group
            convert.put_value(sensors, one.name, entry)
    convert.put_some(state.tree, "sensors", sensors)
    order = [one.number for group in groups.values() for one in group] + kept
    names = state.given.get("sensor", {})
    if order != sorted(order) and all(at in names and not nodes[at]["inner"] for at in order):
        state.sensor_order = [names[at] for at in sorted(order)]
    elif order != sorted(order):
        message = "the sensors that other formats know come first: sensor data is in another order"
        state.change(message, elements[order[0]].span)


def _sensor(state: ImportState, link: str, kind: str, name: str, members: Sequence[_Measured]) -> Map:
    first, elements, more = members[0], [], {"contact": {"feels": "sensor"}, "force_torque": {"frame": "joint"}}
    for one in members:
        attributes: dict[str, Any] = {}
        for word, text in one.node["attributes"].items():
            site = state.name_of("site", text)
            if word == "site" and site != link:
                attributes[word] = site
            elif word not in ("name", "site"):
                attributes[word] = convert.number_or_text(text)
        own = "" if one.name == name else one.name.removeprefix(f"{name}_")
        words = {"sensor": one.node["tag"], "name": own, "attributes": convert.map_entry(attributes, one.element)}
        elements.append(convert.map_entry(words, one.element))
    item = convert.map_entry({"sensor": kind, **more.get(kind, {})}, first.element)
    if kind not in more:
        convert.put_pose(item, convert.transform(first.site["pos"], first.site["quat"]), first.element)
    entry = {"type": kind, "frame": link, "mjcf": convert.list_entry(elements, first.element)}
    made = convert.map_entry(entry, first.element)
    # MuJoCo's rangefinder measures a single ray, which does not define the scan of a Gazebo sensor.
    convert.put_value(made, "gazebo", convert.list_entry([] if kind == "range_finder" else [item], first.element))
    return made


def add_equalities(state: ImportState) -> None:
    """Import equality constraints, as mimic joints if possible."""
    nodes, constraints = state.facts["elements"]["equalities"], Map(state.markup.root.span)
    elements, joints, zero = state.elements_of("equality", nodes), state.facts["joints"], state.facts["qpos0"]
    for index, (fact, node, element) in enumerate(zip(state.facts["equalities"], nodes, elements, strict=True)):
        # MuJoCo's polynomial is relative to the initial positions (rad or m).
        are_joints, ends = fact["type"] == _EQ_JOINT, (fact["obj1id"], fact["obj2id"])
        zeros = [zero[joints[at]["qposadr"]] if are_joints and at >= 0 else 0.0 for at in ends]
        if _is_mimic(state, fact):
            follower = state.joint_of[fact["obj1id"]]
            name, mimic = state.name("constraint", fact["name"], follower, index), Map(element.span)
            leader, factor = element.attributes.get("joint2"), convert.tidy(fact["data"][1])
            convert.put_value(mimic, "joint", state.joint_of[fact["obj2id"]], leader.span if leader else None)
            if factor != 1:
                convert.put_number(mimic, "multiplier", factor, element, "polycoef", 1)
            if offset := convert.tidy(fact["data"][0] + zeros[0] - factor * zeros[1]):
                convert.put_number(mimic, "offset", offset, element, "polycoef", 0)
            for word, usual in STIFF.items():
                values = [convert.tidy(value) for value in fact[word]]
                if tuple(values[: len(usual)]) != usual or values[len(usual) :] != _DEFAULTS[word]:
                    convert.put_value(mimic, word, convert.numbers(values, element, word))
            if name != follower:
                convert.put_value(mimic, "name", name)
            convert.put_value(state.joints[follower], "mimic", mimic)
        else:
            _add_constraint(state, constraints, index, zeros, node, element)
    convert.put_some(state.tree, "constraints", constraints)


def _is_mimic(state: ImportState, fact: Mapping[str, Any]) -> bool:
    """Return True if an equality couples two joints linearly, and does not close a cycle of mimic joints."""
    follower, here = (state.joint_of.get(fact[end], "") for end in ("obj1id", "obj2id"))
    if fact["type"] != _EQ_JOINT or not fact["active0"] or any(fact["data"][2:5]) or not (follower and here):
        return False
    while here and here != follower:
        here = (state.joints[here].get("mimic") or {}).get("joint", "")
    return not here and "mimic" not in state.joints[follower]


def _add_constraint(
    state: ImportState, constraints: Map, index: int, zeros: Sequence[float], node: convert.Node, element: Element
) -> None:
    attributes, entry = node["attributes"], Map(element.span)
    ends = (attributes.get(f"{kind}1", "") for kind in ("body", "site", "joint", "tendon"))
    made_up = f"{next(filter(None, ends), 'robot')}_{node['tag']}"
    name, rest = state.name("constraint", attributes.get("name", ""), made_up, index), dict(attributes)
    convert.put_value(entry, "type", node["tag"])
    for word, key in (("body", "links"), ("site", "sites"), ("joint", "joints")):
        names = [rest.pop(end) for end in (f"{word}1", f"{word}2") if end in rest]
        for one in names:
            _keep_of_scene(state, word, one)
        if names:
            convert.put_value(entry, key, convert.list_entry([state.name_of(word, one) for one in names], element))
    pose = convert.floats({"relpose": rest.pop("relpose", "")}, "relpose", [0, 1, 0, 0, 0, 0, 0])
    if any(pose[3:]):  # a zero quaternion in relpose means the initial relative pose
        convert.put_value(entry, "xyz", convert.numbers([convert.tidy(value) for value in pose[:3]], element))
        convert.put_pose(entry, convert.transform(pose[:3], pose[3:]), element)
    if any(zeros):
        offset, *others = shift_polynomial(convert.floats(rest, "polycoef", [0, 1, 0, 0, 0]), -zeros[1])
        rest["polycoef"] = " ".join(repr(convert.tidy(value)) for value in (offset + zeros[0], *others))
    known = node["tag"] in ("connect", "weld", "joint")
    if not known or convert.put_words(entry, rest, "constraint", element, _OF_CONSTRAINT):
        named = {**node, "attributes": {**attributes, "name": name}}
        state.keep_in_section("equality", named, "equality", element.span)
    else:
        constraints.put(name, entry, element.span, element.span)


def add_contacts(state: ImportState) -> None:
    """Import the pairs of links that cannot collide in MuJoCo, and keep <pair> elements as XML."""
    nodes, root = state.facts["elements"]["pairs"], state.markup.root
    excludes = state.markup.section_elements("contact", "exclude")
    written = {frozenset((element.get("body1"), element.get("body2"))): element for element in excludes}
    found: list[tuple[list[str], Element, str]] = []
    for signature in state.facts["exclude_signature"]:
        bodies = (signature >> 16, signature & 0xFFFF)  # a signature has both body ids, sorted
        names = [state.link_of.get(index, "") for index in bodies]
        element = written.get(frozenset(state.facts["bodies"][index]["name"] for index in bodies), root)
        if all(names):
            names.sort(key=lambda name: name != element.get("body1"))
            found.append((names, element, "excluded from contact in the MJCF"))
        elif element not in state.reported:
            state.reported.add(element)
            what = "a contact with the world that is excluded: the scene is not a part of the robot"
            state.note("import-ignored", what, element.span)
    found += list(_filtered(state, {frozenset(names) for names, *_ in found}))
    pairs = Seq(root.span)
    for names, element, reason in found:
        links, spans = Seq(element.span), {attribute.value: attribute.span for attribute in element.attributes.values()}
        for name in names:
            links.put(name, spans.get(name, element.span))
        pairs.put(convert.map_entry({"links": links, "reason": reason}, element), element.span)
    convert.put_some(state.tree, "disabled_contacts", pairs)
    for node, element in zip(nodes, state.elements_of("contact", nodes, "pair"), strict=True):
        state.keep_in_section("contact", node, "contact", element.span)


def _filtered(state: ImportState, excluded: set[frozenset[str]]) -> Iterator[tuple[list[str], Element, str]]:
    """Yield pairs of links that MuJoCo's parent filter keeps from colliding in the source, but not after the import.

    MuJoCo filters contacts between welded bodies and their parent group, unless that is the world. For a body with
    several joints, the import adds massless links, so the groups are no longer adjacent.
    """
    touching = {geom["bodyid"] for geom in state.facts["geoms"] if geom["contype"] or geom["conaffinity"]}
    if state.facts["elements"]["options"].get("flag filterparent") == "disable":
        return
    balls = {joint["bodyid"] for joint in state.facts["joints"] if joint["type"] == BALL}
    top, groups = dict[int, int](), dict[int, list[int]]()  # topmost body of each welded group
    for index, body in enumerate(state.facts["bodies"]):
        top[index] = index if not index or state.joints_in.get(index) else top[body["parentid"]]
        groups.setdefault(top[index], []).append(index)
    for index, below in groups.items():
        above = top[state.facts["bodies"][index]["parentid"]] if index else 0
        if above == 0 or (len(state.joints_in.get(index, ())) < 2 and index not in balls):
            continue
        upper, lower = ([state.link_of[at] for at in side if at in touching] for side in (groups[above], below))
        for names in ([one, other] for one in upper for other in lower):
            if frozenset(names) not in excluded:
                yield names, state.places.body(index), _FILTERED


def add_kept(state: ImportState) -> None:
    """Add all elements kept as XML to links or the top level, with the objects that they refer to, and report them."""
    for node in state.facts["elements"]["whole"]:
        state.keep(node, node["tag"], state.markup.first(node["tag"]).span)
    by_link: dict[str, list[convert.Node]] = {}
    by_tag: dict[str, list[Span]] = {}
    for kept, tag, span, link in state.elements:  # the loop appends the objects that elements refer to
        _keep_named_by(state, kept, span)
        nodes, node = by_link.setdefault(link, []), _renamed(state, kept)
        same = [each for each in nodes if each["tag"] == node["tag"] and not each["attributes"] | node["attributes"]]
        if link or not same:
            nodes.append(node)
        else:
            same[0]["inner"].extend(node["inner"])
        by_tag.setdefault(tag, []).append(span)
    for link, nodes in by_link.items():
        texts = convert.list_entry(map(convert.text_of, nodes), state.markup.root)
        convert.put_value(state.links[link] if link else state.tree, "mjcf_elements" if link else "mjcf", texts)
    for tag, spans in by_tag.items():
        what = f"{count_of(len(spans), 'element')} ({tag})" if len(spans) > 1 else f"an element ({tag})"
        message = f"{what}, for which the language has no keys: kept as XML under mjcf"
        state.note("import-verbatim", message, spans[0], others=spans[1:])


def _keep_named_by(state: ImportState, node: convert.Node, span: Span) -> None:
    for word, text in node["attributes"].items():
        _keep_of_scene(state, kind_of_name(word, node["attributes"]), text)
        if word in ASSETS:
            keep_asset(state, word, text, span)
    for inner in node["inner"]:
        _keep_named_by(state, inner, span)


def _renamed(state: ImportState, node: convert.Node) -> convert.Node:
    attributes = dict(node["attributes"])
    if node["tag"] == "skin" and "file" in attributes:
        attributes["file"] = state.markup.place_of(attributes["file"])
    for word, text in attributes.items():
        if (kind := kind_of_name(word, attributes)) and kind != "material":
            attributes[word] = state.name_of(kind, text)
    return {**node, "attributes": attributes, "inner": [_renamed(state, one) for one in node["inner"]]}
