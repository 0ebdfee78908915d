"""Import bodies as links with inertials, sites, cameras and lights, and import joints and actuators.

In MuJoCo, a body can have several joints at any position; in a description, each joint moves one link. A URDF requires
limits that an MJCF may not have, so missing limits are replaced by placeholder values (``stand_ins``).

- If the ``pos`` of a joint is not the origin of its body, a link is added at ``pos``, and the body is fixed to it.
- Several joints in one body become a chain of massless links, in MuJoCo's order.
- If the position of a joint in the file (``ref``) is not zero, its origin is moved to where the joint is at zero.
- A free joint of the only top-level body becomes the output option ``base: free``. Other free joints are floating.

The first actuator of a joint is imported into the entry of the joint, all others into ``actuators``. MuJoCo compiles
``<position>``, ``<velocity>`` and ``<motor>`` to ``<general>``, which is converted back if the numbers match.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.model import Link, Transform, Vector
from rosorin_compile.model.geometry import rotation_about, unit
from rosorin_compile.model.link import limited_fields
from rosorin_compile.mujoco.sections import TARGETS
from rosorin_compile.source.diagnostics import first_of, phrase
from rosorin_compile.source.tree import Map
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.xml.markup import Element

from . import convert
from .import_state import BALL, FREE, HINGE, SLIDE, ImportState
from .unsupported import LEAST, LEAST_EIGENVALUE

NO_MASS = 1e-12  # kg: a smaller mass is imported as zero, because files use it to make MuJoCo accept massless bodies
_EFFORT, _VELOCITY, _TRAVEL = 1000.0, 10.0, 1000.0  # replace missing limits (N*m or N; rad/s or m/s; m)
_SAME = 1e-9  # relative tolerance for inertias, because MuJoCo diagonalizes them
_UNFELT = 1e6  # added massless links do not affect a body with an inertia that is larger by this factor
_POSED = ("name", "pos", "quat")
# For each of these keys of a link: MJCF tag of the entries, name of their definition in the schema.
_MARKS = {"sites": ("site", "site"), "cameras": ("camera", "mjcf_camera"), "lights": ("light", "light")}
# Joint attributes that are not copied from the XML, because they come from the compiled model or the joint type.
_READ = {"name", "type", "pos", "axis", "range", "limited", "ref", "springref"}
_READ |= {"actuatorfrcrange", "actuatorfrclimited"}
_OF_LIMITS = ("solreflimit", "solimplimit", "margin")
_OF_DYNAMICS = {"damping": "damping", "frictionloss": "friction", "armature": "armature", "stiffness": "stiffness"}
_ORIGIN: Vector = (0.0, 0.0, 0.0)


def name_all(state: ImportState) -> None:
    """Assign unique names to all links and joints; unnamed ones are named after an adjacent body or joint."""
    (_, *bodies), joints = enumerate(state.facts["bodies"]), state.facts["joints"]
    for index, body in ((index, body) for index, body in bodies if body["name"]):
        link = state.link_of[index] = state.unique("link", body["name"])
        state.rename("body", body["name"], link)
        if link != body["name"]:
            message = f'the body "{body["name"]}" becomes the link "{link}": names hold no markup or quotes'
            state.change(message, state.places.body(index).span)
    if state.ground:
        state.link_of[0] = state.unique("link", "ground")
        state.renamed.setdefault("body", {})["world"] = state.link_of[0]
    for index, body in ((index, body) for index, body in bodies if not body["name"]):
        names = [joints[at]["name"] for at in state.joints_in.get(index, ())]
        above = state.link_of.get(body["parentid"], "")
        made_up = f"{names[-1]}_link" if names and names[-1] else f"{above}_body" if above else "base_link"
        state.link_of[index] = state.unique("link", made_up)
    named = {BALL: state.ball_of, SLIDE: state.joint_of, HINGE: state.joint_of}
    for index, joint in sorted(enumerate(joints), key=lambda one: not one[1]["name"]):  # names in the file first
        if joint["type"] in named:
            name = state.unique("joint", joint["name"] or f"{state.link_of[joint['bodyid']]}_joint")
            named[joint["type"]][index] = name
            state.rename("joint", joint["name"], name)


def add_links(state: ImportState) -> None:
    """Add a link with its inertial for every body, and a link for the world if ``state.ground`` is true."""
    if state.ground:
        state.add(state.links, state.link_of[0], state.places.body(0))
    light = []
    words = {formats["mjcf"]: key for key, formats in limited_fields(Link).items() if "mjcf" in formats}
    for index, body in list(enumerate(state.facts["bodies"]))[1:]:
        element, name = state.places.body(index), state.link_of[index]
        link = state.add(state.links, name, element)
        if 0 < body["mass"] <= NO_MASS:
            light.append(index)
        elif body["mass"] > 0 or any(body["inertia"]):
            own = next((one for one in state.markup.child_elements(element) if one.tag == "inertial"), element)
            convert.put_value(link, "inertial", _inertial(body, own))
        more = {key: text for key, text in body["element"]["attributes"].items() if key not in _POSED}
        state.put_words(link, more, "link", element, f'the body "{name}"', words)
        for inner in body["element"]["inner"]:
            state.keep(inner, inner["tag"], element.span, name)
    if light:
        names = first_of([state.link_of[index] for index in light], 5)
        message = f"what MuJoCo has for mass where there is none is left out ({names})"
        state.change(message, state.places.body(light[0]).span)


def _inertial(body: Mapping[str, Any], element: Element) -> Map:
    entry, written = Map(element.span), body.get("written")
    convert.put_number(entry, "mass", convert.tidy(body["mass"]), element, "mass")
    place, rows = convert.tidy_vector(written["pos"] if written else body["ipos"]), convert.rotation(body["iquat"])
    moments, pose = convert.full_inertia(body["inertia"], rows), convert.transform(place)
    is_turned = list(convert.full_inertia((1.0, 2.0, 3.0), rows).values()) != [1, 2, 3, 0, 0, 0]
    if written and written["full"] is not None:
        full = dict(zip(convert.MOMENTS, written["full"], strict=True))
        # Use the inertia in the file, unless compiler settings such as balanceinertia changed it.
        most = _SAME * max(map(abs, moments.values()))
        moments = full if all(abs(full[key] - moments[key]) <= most for key in full) else moments
    elif is_turned and (written or min(body["inertia"]) < LEAST_EIGENVALUE):
        moments, pose = convert.full_inertia(body["inertia"], convert.NO_POSE.rows), Transform(rows, place)
    convert.put_pose(entry, pose, element)
    inertia = Map(element.span)
    attribute = next((word for word in ("fullinertia", "diaginertia") if word in element.attributes), "")
    for at, (key, value) in enumerate(moments.items()):
        if value or at < 3:
            convert.put_number(inertia, key, value, element, attribute, at)
    convert.put_value(entry, "inertia", inertia)
    if not written:
        convert.put_source(entry, "calculated", "by MuJoCo from the geoms")
    return entry


def add_marks(state: ImportState) -> None:
    """Add the sites, cameras and lights of all links, or keep them as XML if no entry can express them."""
    marks = [(kind, index, thing) for kind in _MARKS for index, thing in enumerate(state.facts[kind])]
    for kind, index, thing in marks:
        (tag, form), node, element = _MARKS[kind], thing["element"], state.places.place_of(kind, index)
        if thing["bodyid"] not in state.link_of:
            state.scene.append((tag, element.span))
            continue
        link, name = state.link_of[thing["bodyid"]], thing["name"]
        place = convert.transform(thing["pos"], thing.get("quat"))
        more = {key: text for key, text in node["attributes"].items() if key not in _POSED}
        is_at_origin = convert.tidy_vector(place.xyz) == _ORIGIN and convert.is_unturned(place)
        if kind == "sites" and name == link and is_at_origin and more.keys() <= {"group"}:
            continue  # the export adds this site to every link
        clashes = tag == "site" and name in state.taken["link"]
        called = state.name(tag, f"{name}_site" if clashes else name, f"{link}_{tag}", index)
        if clashes:
            state.rename(tag, name, called)
            state.change(f'the site "{name}" is called "{called}": a link has the name', element.span)
        if kind == "lights" and "dir" in more:
            more["dir"] = " ".join(repr(convert.tidy(value)) for value in thing["dir"])
        entry, kinds = Map(element.span), {"target": "body", "material": "material"}
        convert.put_pose(entry, place, element)
        named = {word: state.name_of(kinds[word], text) if word in kinds else text for word, text in more.items()}
        if convert.put_words(entry, named, form, element) or node["inner"]:
            whole = {**node, "attributes": {"name": called, **more, **convert.pose_attributes(place)}}
            state.keep(whole, tag, element.span, link)
            continue
        section = state.links[link].get(kind) or Map(element.span)
        section.put(called, entry, element.span, element.span)
        convert.put_value(state.links[link], kind, section)


def add_joints(state: ImportState) -> None:
    """Add the joints between each body and its parent; report placeholder limits and very light bodies."""
    light, drives = [], _drives_of(state)
    for index, body in enumerate(state.facts["bodies"]):
        if index == 0 or body["parentid"] not in state.link_of:
            continue
        held = [(at, state.facts["joints"][at]) for at in state.joints_in.get(index, ())]
        light += [index] if len(held) > 1 and 0 < min(body["inertia"]) < LEAST * _UNFELT else []
        ends = state.link_of[body["parentid"]], state.link_of[index]
        place, element = convert.transform(body["pos"], body["quat"]), state.places.body(index)
        if held and held[0][1]["type"] != FREE:
            _add_chain(state, index, place, held, drives)
            continue
        own = state.places.place_of("joints", held[0][0]) if held else element
        name = held[0][1]["name"] if held and held[0][1]["name"] else f"{ends[1]}_joint"
        joint = state.add_joint(state.unique("joint", name), "floating" if held else "fixed", *ends, own)
        convert.put_pose(joint, place, element)
        if held:
            rest = _put_dynamics(joint, held[0][1]["element"]["attributes"], own)
            state.put_words(joint, rest, "joint", own, f'the joint "{name}"')
    for word in ("range", "effort", "velocity"):
        if entries := state.stand_ins.get(word):
            names = list(dict.fromkeys(name for name, _, _ in entries))
            numbers = phrase(list(dict.fromkeys(f"{value:g}" for _, value, _ in entries)))
            message = f"no {word} limit in the MJCF, stand-in {numbers} used for {first_of(names, 3)}"
            state.note("import-stand-in", message, entries[0][2], "put in what the robot really has")
    if light:
        which = first_of([state.link_of[index] for index in light], 3)
        message = f"{which}: the links between joints get {LEAST:g} kg*m^2, so parts this small move a little otherwise"
        state.change(message, state.places.body(light[0]).span)


def add_root(state: ImportState) -> None:
    """Add the section ``root``: ``world: true`` if the root is the world, else the pose and free joint of the root."""
    if state.ground:
        convert.put_value(state.tree, "root", convert.map_entry({"world": True}, state.places.body(0)))
        return
    top = state.tops[0]
    body, element = state.facts["bodies"][top], state.places.body(top)
    entry, place = Map(element.span), convert.transform(body["pos"], body["quat"])
    if state.free_base:  # write even zero, because the default is a robot that stands on the floor
        convert.put_value(entry, "xyz", convert.numbers(convert.tidy_vector(place.xyz), element, "pos"))
    convert.put_pose(entry, place, element)
    if state.free_base:
        index = state.joints_in[top][0]
        joint, own = state.facts["joints"][index], state.places.place_of("joints", index)
        if joint["name"]:
            convert.put_value(entry, "joint", state.unique("joint", joint["name"]))
        more = {key: text for key, text in joint["element"]["attributes"].items() if key not in (*_READ, *_OF_LIMITS)}
        state.put_words(entry, more, "root", own, "the free joint", {"frictionloss": "friction"})
    convert.put_some(state.tree, "root", entry)


def _add_chain(
    state: ImportState, index: int, place: Transform, held: Sequence[tuple[int, Any]], drives: Mapping[int, Drive]
) -> None:
    """Add the joints of a body, with massless links between them; ``place`` is its pose in its parent."""
    body, element = state.link_of[index], state.places.body(index)
    above = state.link_of[state.facts["bodies"][index]["parentid"]]
    at = _ORIGIN  # position (m) of the last link of the chain in the frame of the body
    for number, (which, joint) in enumerate(held, 1):
        kind, span = joint["type"], state.places.place_of("joints", which)
        name = (state.ball_of if kind == BALL else state.joint_of)[which]
        axis = convert.tidy_vector(unit(joint["axis"]))
        anchor, child = (at if kind == SLIDE else convert.tidy_vector(joint["pos"])), body
        if number < len(held) or anchor != _ORIGIN:
            is_anchor = kind != SLIDE and any(anchor)
            child = state.unique("link", f"{name}_{'anchor' if is_anchor else 'link'}")
            state.add(state.links, child, span)
        origin = place.then(convert.transform([a - b for a, b in zip(anchor, at, strict=True)]))
        ref = convert.tidy_position(state.facts["qpos0"][joint["qposadr"]], kind == SLIDE) if kind != BALL else 0.0
        if ref:  # move the origin to the pose at joint position zero
            back = convert.transform([-ref * part for part in axis]) if kind == SLIDE else None
            origin = origin.then(back or Transform(rotation_about(axis, -ref)))
        types = {HINGE: "revolute" if joint["limited"] else "continuous", SLIDE: "prismatic", BALL: "ball"}
        entry = state.add_joint(name, types[kind], above, child, span)
        convert.put_pose(entry, origin, element if number == 1 and anchor == _ORIGIN else span)
        if kind != BALL:
            convert.put_value(entry, "axis", convert.numbers(axis, span, "axis"))
        _put_details(state, which, entry, span, ref, drives.get(which, Drive()))
        above, at, place = child, anchor, convert.NO_POSE
    if above != body:
        entry = state.add_joint(state.unique("joint", f"{body}_joint"), "fixed", above, body, element)
        convert.put_pose(entry, convert.transform([-value for value in at]), element)


def _put_details(state: ImportState, which: int, entry: Map, element: Element, ref: float, drive: Drive) -> None:
    """Set limit, dynamics and actuator of a joint; ``ref`` is its position (rad or m) at the pose in the file."""
    joint = state.facts["joints"][which]
    name, attributes, kind = (state.ball_of | state.joint_of)[which], joint["element"]["attributes"], joint["type"]
    limit, missing, slides = Map(element.span), list[str](), kind == SLIDE
    if kind == BALL:
        rest = _put_dynamics(entry, attributes, element)
        rest |= {"range": f"0 {joint['range'][1]!r}"} if joint["limited"] else {}
        state.put_words(entry, rest, "joint", element, f'the joint "{name}"')
        return
    for at, (key, sign) in enumerate({"lower": "-", "upper": ""}.items()):
        if joint["limited"]:
            convert.put_number(limit, key, convert.tidy_position(joint["range"][at], slides), element, "range", at)
        elif slides:
            missing.append(key)
            convert.put_value(limit, key, Quantity.parse(f"{sign}{_TRAVEL:g} m"))
    effort = convert.tidy(max(map(abs, joint["actfrcrange"]))) if joint["actfrclimited"] else drive.effort
    if effort is not None or drive.speed is not None or limit:  # URDF requires effort and velocity in a limit
        of_effort = ("effort", effort, _EFFORT, "actuatorfrcrange")
        for key, value, stand_in, word in (of_effort, ("velocity", drive.speed, _VELOCITY, "")):
            convert.put_number(limit, key, stand_in if value is None else convert.tidy(value), element, word, 1)
            missing += [key] if value is None else []
    if missing:
        convert.put_value(limit, "stand_ins", convert.list_entry(missing, element))
        verb, them = ("is a stand-in", "it") if len(missing) == 1 else ("are stand-ins", "them")
        convert.put_source(limit, "stand_in", f"{phrase(missing)} {verb}: the MJCF does not limit {them}")
    for key in missing:
        word = "range" if key in ("lower", "upper") else key
        state.stand_ins.setdefault(word, []).append((name, limit[key], element.span))
    convert.put_some(entry, "limit", limit)
    rest = _put_dynamics(entry, attributes, element)
    at_rest = convert.tidy_position(float(attributes.get("springref", 0)), slides)
    if {"stiffness", "springdamper"} & attributes.keys() and at_rest:
        dynamics = entry.get("dynamics") or Map(element.span)
        convert.put_value(entry, "dynamics", dynamics)
        convert.put_number(dynamics, "spring_reference", at_rest, element, "springref")
    if drive.entry is not None:
        convert.put_value(entry, "actuator", drive.entry)
    low, high = joint["actfrcrange"]
    # Keep a range that is asymmetric, or that the export would omit because the actuator has the same limit.
    is_repeated = drive.effort is not None and math.isclose(drive.effort, high, rel_tol=1e-9)
    if joint["actfrclimited"] and (low != -high or is_repeated):
        rest["actuatorfrcrange"] = f"{low!r} {high!r}"
    rest |= {"ref": repr(ref)} if ref else {}
    state.put_words(entry, rest, "joint", element, f'the joint "{name}"')


def _put_dynamics(entry: Map, attributes: Mapping[str, str], element: Element) -> dict[str, str]:
    dynamics, pair = Map(element.span), convert.floats(attributes, "springdamper")
    # A positive springdamper overrides damping and stiffness.
    known = ("frictionloss", "armature") if pair and min(pair) > 0 else _OF_DYNAMICS
    words = {key: text for key, text in attributes.items() if key in known and any(map(float, text.split()))}
    rest = convert.put_words(dynamics, words, "dynamics", element, _OF_DYNAMICS)
    convert.put_some(entry, "dynamics", dynamics)
    return rest | {key: text for key, text in attributes.items() if key not in _READ and key not in _OF_DYNAMICS}


_FIXED_GAIN, _NO_BIAS = 0, 0  # mjtGain, mjtBias
_TARGETS = tuple(TARGETS.values())
_KINDS = {"joint": "joint", "jointinparent": "joint", "tendon": "tendon", "body": "body"}  # default: site
_ACTUATOR_WORDS = {word: key for key, word in TARGETS.items()} | {"forcerange": "force"}
# Attributes that determine the type of an actuator, and attributes that are read from the compiled model.
_OF_KIND = ("gaintype", "gainprm", "biastype", "biasprm", "dyntype", "dynprm", "input")
_ACTUATOR_READ = ("name", "ctrlrange", "ctrllimited", "forcerange", "forcelimited", *_TARGETS)


class Drive(NamedTuple):
    """A joint's actuator: maximum effort (N*m or N), its entry, and velocity limit of the joint (rad/s or m/s)."""

    effort: float | None = None
    entry: Map | None = None
    speed: float | None = None


def _drives_of(state: ImportState) -> dict[int, Drive]:
    """Return the first actuator of each joint by joint id, and add all others to the section ``actuators``."""
    nodes, drives = state.facts["elements"]["actuators"], dict[int, Drive]()
    others, in_joints, kept = Map(state.markup.root.span), list[int](), list[Element]()
    elements = state.elements_of("actuator", nodes)
    for number, (fact, node, element) in enumerate(zip(state.facts["actuators"], nodes, elements, strict=True)):
        attributes, entry = node["attributes"], Map(element.span)
        if {"plugin", "instance"} & attributes.keys() or node["inner"]:
            state.keep_in_section("actuator", node, f"actuator <{element.tag}>", element.span)
            kept.append(element)
            continue
        if kept and kept[0] not in state.reported:
            state.reported.add(kept[0])
            what = f"the actuator <{kept[0].tag}> is behind those that the language has words for"
            state.change(f"{what}: its control is not where it was", kept[0].span)
        index = fact["trnid"][0] if "joint" in attributes and fact["trnid"][0] in state.joint_of else None
        if index is not None and index not in drives:
            joint = state.joint_of[index]
            name = state.name("actuator", fact["name"], joint)
            _fill(state, entry, "actuator", fact, attributes, element, index)
            convert.put_some(entry, "name", name if name != joint else "")
            in_joints.append(index)
        else:
            targets = {word: attributes[word] for word in _TARGETS if word in attributes}
            name = state.name("actuator", fact["name"], f"{next(iter(targets.values()), 'robot')}_{element.tag}")
            targets = {word: state.name_of(_KINDS.get(word, "site"), text) for word, text in targets.items()}
            convert.put_words(entry, targets, "other_actuator", element, _ACTUATOR_WORDS)
            _fill(state, entry, "other_actuator", fact, attributes, element, index)
            others.put(name, entry, element.span, element.span)
        state.actuator_of[number] = name
        if index is None:
            continue
        if entry.get("type") is None:
            state.servos[number] = index
        arrays = (fact["gear"][:1], fact["forcerange"], fact["ctrlrange"])
        gear, force, control = (float(max(map(abs, values))) for values in arrays)
        effort = gear * force if fact["forcelimited"] else None
        if effort is None and (fact["gaintype"], fact["biastype"]) == (_FIXED_GAIN, _NO_BIAS) and fact["ctrllimited"]:
            effort = gear * abs(float(fact["gainprm"][0])) * control
        if index in drives:
            total = drives[index].effort
            total = None if total is None or effort is None else total + effort
            drives[index] = drives[index]._replace(effort=total)
            continue
        # A symmetric control range of a velocity servo becomes the velocity limit of the joint.
        (low, high), turns, limit = fact["ctrlrange"], float(fact["gear"][0]), None
        speed = convert.tidy(high / turns) if turns > 0 else 0.0
        is_servo = entry.get("type") == "velocity" and fact["ctrllimited"]
        if is_servo and low == -high and speed > 0 and turns * speed == high:
            entry.pop("range", None)
            limit = speed
        drives[index] = Drive(effort, entry, limit)
    convert.put_some(state.tree, "actuators", others)
    names = list(state.actuator_of.values())
    ordered = [*(name for name in names if name not in others), *others]
    state.in_order = in_joints == sorted(in_joints) and names == ordered
    return drives


def _fill(
    state: ImportState, entry: Map, form: str, fact: Any, words: Mapping[str, str], element: Element, index: int | None
) -> None:
    kind, gains, more = _kind(words)
    if kind != "position":
        convert.put_value(entry, "type", kind)
    for word, value in gains.items():
        convert.put_number(entry, word, convert.tidy(value), element, word)
    rest = {key: text for key, text in more.items() if key not in _ACTUATOR_READ}
    joint = state.facts["joints"][index] if index is not None else None
    inherits = float(words.get("inheritrange", 0)) and kind in ("position", "general")
    is_position, limits = kind == "position", joint["range"] if joint is not None and joint["limited"] else None
    if not inherits and (fact["ctrllimited"] or "ctrlrange" in words):
        # By default, the control range of a position servo is the range of its joint.
        is_usual = limits is not None and [fact["gear"][0] * end for end in limits] == fact["ctrlrange"]
        if not (is_usual and is_position and fact["ctrllimited"]):
            slides = not is_position or joint is None or joint["type"] == SLIDE
            values = [convert.tidy_position(value, slides) for value in fact["ctrlrange"]]
            convert.put_value(entry, "range", convert.numbers(values, element, "ctrlrange"))
        rest |= {} if fact["ctrllimited"] else {"ctrllimited": "false"}
    elif not inherits and is_position and limits is not None:
        convert.put_value(entry, "unlimited", True)
    if fact["forcelimited"] or "forcerange" in words:
        convert.put_value(
            entry, "force", convert.list_entry([convert.tidy(value) for value in fact["forcerange"]], element)
        )
        rest |= {} if fact["forcelimited"] else {"forcelimited": "false"}
    state.put_words(entry, rest, form, element, f"the actuator <{element.tag}>", _ACTUATOR_WORDS)


def _kind(attributes: Mapping[str, str]) -> tuple[str, Mapping[str, float], Mapping[str, str]]:
    """Return (type, gains, other attributes) of the actuator that is equivalent to a <general> with ``attributes``."""
    (kp, *gain), bias = convert.floats(attributes, "gainprm", [1, 0, 0]), convert.floats(attributes, "biasprm", [0] * 3)
    gains, dynamics = attributes.get("gaintype", "fixed"), attributes.get("dyntype", "none")
    attributes = {key: text for key, text in attributes.items() if key != "inheritrange" or float(text)}  # 0: off
    if gains != "fixed" or dynamics not in ("none", "filterexact") or any(gain) or any(bias[3:]):
        return "general", {}, attributes
    plain = {key: text for key, text in attributes.items() if key not in _OF_KIND}
    no_servo = {key: text for key, text in plain.items() if key != "inheritrange"}
    filtered = {"timeconst": attributes.get("dynprm", "1").split()[0]} if dynamics == "filterexact" else {}
    is_affine = attributes.get("biastype", "none") == "affine" and kp > 0
    is_plain = attributes.get("biastype", "none") == "none" and not filtered
    if is_affine and bias[:2] == [0, -kp]:
        word = "kv" if bias[2] <= 0 else "damping_ratio"
        return "position", {"kp": kp} | ({word: abs(bias[2])} if bias[2] else {}), plain | filtered
    if is_affine and bias[:3] == [0, 0, -kp] and not filtered:
        return "velocity", {"kv": kp}, no_servo
    if is_plain and "body" in attributes:
        return "adhesion", {}, no_servo | ({"gain": repr(kp)} if kp != 1 else {})
    return ("motor", {}, no_servo) if is_plain and kp == 1 else ("general", {}, attributes)
