"""Sections of an MJCF besides its bodies: equalities, contacts, and what is kept as it is, such as tendons and sensors.

What an element names of the scene (a site or a geom of the world, if that is no link) is kept with it.
"""

from __future__ import annotations

import posixpath
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Span, counted
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.markup import Element

from .bodies import STIFF, TOUCHES, shifted
from .contacts import Contacts, contacts
from .reading import Reading
from .shapes import is_scene, keep_assets, whole_geom
from .values import (
    Node,
    floats,
    forms_of,
    listing,
    numbers,
    plain,
    put,
    put_number,
    put_pose,
    put_words,
    text_of,
    tidy,
    transform,
)

_BODY, _SITE, _GEOM, _JOINT, _TENDON = "body", "site", "geom", "joint", "tendon"
_KINDS = {
    **dict.fromkeys(("body", "xbody", "body1", "body2", "subtree1", "subtree2", "target"), _BODY),
    **dict.fromkeys(("site", "site1", "site2", "sidesite", "refsite"), _SITE),
    **dict.fromkeys(("geom", "geom1", "geom2"), _GEOM),
    **dict.fromkeys(("joint", "joint1", "joint2"), _JOINT),
    **dict.fromkeys(("tendon", "tendon1", "tendon2"), _TENDON),
    **{kind: kind for kind in ("actuator", "camera", "material")},
}
_OF_CONSTRAINT = {"torquescale": "torque_scale", "polycoef": "polynomial", "anchor": "at"}
_PAIRED = {"body": "links", "site": "sites", "joint": "joints"}
# The types of sensors that other formats know, by the element of MuJoCo.
_TYPES = {"gyro": "imu", "accelerometer": "imu", "force": "force_torque", "torque": "force_torque"}
_TYPES |= {"touch": "contact", "rangefinder": "range_finder", "magnetometer": "magnetometer"}
_EQ_JOINT = 2  # mjEQ_JOINT
_DEFAULTS = {"solref": [], "solimp": [0.5, 2.0]}  # MuJoCo's own for the numbers after those of STIFF
_EXCLUDED = "excluded from contact in the MJCF"
_FILTERED = "MuJoCo keeps neighbours apart; here links without mass are between them"


def called(reading: Reading, attribute: str, name: str) -> str:
    """Return the name that the description has for what an attribute names."""
    kind = _KINDS.get(attribute, "")
    if kind in (_SITE, _GEOM):
        _keep_of_scene(reading, kind, name)
    return reading.called(kind, name)


def _keep_of_scene(reading: Reading, kind: str, name: str) -> None:
    """Keep a site or geom of the world that something of the robot names, if the tree does not have it."""
    for index, thing in enumerate(reading.facts[f"{kind}s"]):
        if reading.ground and not (kind == _GEOM and is_scene(thing)):
            continue
        if thing["name"] == name and thing["body"] == 0 and (kind, name) not in reading.of_scene:
            reading.of_scene.add((kind, name))
            span = reading.places.of(f"{kind}s", index).span
            node = whole_geom(reading, thing) if kind == _GEOM else thing["element"]
            reading.keep_in_section("worldbody", node, f"{kind} of the world", span)


def _keep_whole(reading: Reading, section: str, node: Node, span: Span) -> None:
    """Keep an element of a section as it is, with what it names of the scene."""
    waiting = [node]
    while waiting:
        attributes = waiting[-1]["attributes"]
        waiting += waiting.pop()["inner"]
        for word, text in attributes.items():
            kind = _kind_of(word, attributes)
            if kind in (_SITE, _GEOM):
                _keep_of_scene(reading, kind, text)
    reading.keep_in_section(section, node, section, span)


def keep_tendons(reading: Reading) -> None:
    """Keep all tendons."""
    nodes = reading.facts["elements"]["tendons"]
    for index, (node, element) in enumerate(zip(nodes, reading.elements_of("tendon", nodes), strict=True)):
        _keep_named(reading, "tendon", index, node, element)


def _keep_named(reading: Reading, section: str, index: int, node: Node, element: Element) -> None:
    own = node["attributes"].get("name", "")
    named = {"name": reading.name(section, own, index=index)} if own else {}
    _keep_whole(reading, section, {**node, "attributes": {**node["attributes"], **named}}, element.span)


def add_sensors(reading: Reading) -> None:
    """Add the sensors that other formats know, those of one type at one site as one entry; keep all others."""
    nodes, sites = reading.facts["elements"]["sensors"], {site["name"]: site for site in reading.facts["sites"]}
    groups: dict[tuple[str, str, str], list[Measured]] = {}
    kept: list[int] = []
    for index, (node, element) in enumerate(zip(nodes, reading.elements_of("sensor", nodes), strict=True)):
        kind, site = _TYPES.get(node["tag"], ""), sites.get(node["attributes"].get("site", ""))
        if not kind or site is None or site["body"] not in reading.link_of or node["inner"]:
            _keep_named(reading, "sensor", index, node, element)
            kept.append(index)
            continue
        name = reading.name("sensor", node["attributes"].get("name", ""), f"{site['name']}_{node['tag']}", index)
        measured = Measured(index, name, node, element, site)
        at = "" if kind == "range_finder" else site["name"]  # the rays of a lidar have a site each
        groups.setdefault((reading.link_of[site["body"]], kind, at), []).append(measured)
    sensors = Map(reading.markup.root.span)
    taken = {one.name for some in groups.values() for one in some}
    for (link, kind, _), some in groups.items():
        shared = _shared([one.name for one in some])
        is_one = len(some) == 1 or (shared and shared not in taken and shared not in sensors)
        for name, members in [(shared, some)] if is_one else [(one.name, [one]) for one in some]:
            entry = _sensor(reading, link, kind, name, members)
            if members[0] is not some[0]:
                put(entry, "gazebo", Seq(entry.span))  # the first of the group has its sensor of Gazebo
            sensors.put(name, entry, entry.span, entry.span)
    if sensors:
        put(reading.tree, "sensors", sensors)
    order = [one.number for some in groups.values() for one in some] + kept
    if order != sorted(order):
        first = reading.elements_of("sensor", nodes)[order[0]]
        reading.changed("the sensors that other formats know come first: sensor data is in another order", first.span)


class Measured(NamedTuple):
    """A sensor at a site: its number in the file and its name in the description; ``element`` is its place."""

    number: int
    name: str
    node: Node
    element: Element
    site: Mapping[str, Any]


def _shared(names: Sequence[str]) -> str:
    """Return the common start of names up to an underscore: "imu" for imu_gyro and imu_accelerometer."""
    if len(names) == 1:
        return names[0]
    first, last = min(names), max(names)
    length = next((at for at, pair in enumerate(zip(first, last, strict=False)) if pair[0] != pair[1]), len(first))
    return first[:length].rpartition("_")[0]


def _number_or_text(text: str) -> float | int | str:
    try:
        return plain(float(text))
    except (ValueError, OverflowError):
        return text


def _sensor(reading: Reading, link: str, kind: str, name: str, members: Sequence[Measured]) -> Map:
    """Return the entry of a sensor: its elements in MuJoCo, and one sensor in Gazebo at the site of the first."""
    entry, elements = Map(members[0].element.span), []
    put(entry, "type", kind)
    put(entry, "frame", link)
    for one in members:
        item, attributes = Map(one.element.span), Map(one.element.span)
        put(item, "sensor", one.node["tag"])
        if one.name != name:
            put(item, "name", one.name.removeprefix(f"{name}_"))
        for word, text in one.node["attributes"].items():
            if word == "site" and reading.called(_SITE, text) != link:
                put(attributes, word, reading.called(_SITE, text))
            elif word not in ("name", "site"):
                put(attributes, word, _number_or_text(text))
        if attributes:
            put(item, "attributes", attributes)
        elements.append(item)
    put(entry, "mjcf", listing(elements, members[0].element))
    item, place = Map(entry.span), transform(members[0].site["pos"], members[0].site["quat"])
    put(item, "sensor", kind)
    if kind == "contact":
        put(item, "feels", "sensor")
    elif kind == "force_torque":
        put(item, "frame", "joint")
    else:
        put_pose(item, place, members[0].element)
    # MuJoCo has single rays, from which no scan of Gazebo follows.
    put(entry, "gazebo", listing([] if kind == "range_finder" else [item], members[0].element))
    return entry


def add_equalities(reading: Reading) -> None:
    """Let joints follow others where an equality couples them; add the other equalities as constraints."""
    nodes, constraints = reading.facts["elements"]["equalities"], Map(reading.markup.root.span)
    elements = reading.elements_of("equality", nodes)
    for index, (fact, node, element) in enumerate(zip(reading.facts["equalities"], nodes, elements, strict=True)):
        if _is_mimic(reading, fact):
            follower = reading.joint_of[fact["first"]]
            name, mimic = reading.name("constraint", fact["name"], follower, index), _mimic(reading, fact, element)
            if name != follower:
                put(mimic, "name", name)
            put(reading.joints[follower], "mimic", mimic)
        else:
            _add_constraint(reading, constraints, index, node, element)
    if constraints:
        put(reading.tree, "constraints", constraints)


def _is_mimic(reading: Reading, fact: Mapping[str, Any]) -> bool:
    """Return True if an equality lets one joint follow another in proportion, and neither leads to a circle."""
    first, second = fact["first"], fact["second"]
    if fact["type"] != _EQ_JOINT or not fact["active"] or any(fact["data"][2:5]):
        return False
    if first not in reading.joint_of or second not in reading.joint_of:
        return False
    follower = reading.joint_of[first]
    here: str | None = reading.joint_of[second]
    while here is not None and here != follower:
        mimic = reading.joints[here].get("mimic")
        here = mimic["joint"] if mimic else None
    return here is None and "mimic" not in reading.joints[follower]


def _zeros(reading: Reading, fact: Mapping[str, Any]) -> tuple[float, float]:
    """Return the positions (rad or m) at which the file has the two joints of an equality; MuJoCo counts from there."""
    first, second = (fact[word] for word in ("first", "second"))
    zero, joints = reading.facts["zero"], reading.facts["joints"]
    return (
        zero[joints[first]["address"]] if first >= 0 else 0.0,
        zero[joints[second]["address"]] if second >= 0 else 0.0,
    )


def _mimic(reading: Reading, fact: Mapping[str, Any], element: Element) -> Map:
    """Return the entry of a joint that follows another."""
    mimic, leader = Map(element.span), element.attributes.get("joint2")
    put(mimic, "joint", reading.joint_of[fact["second"]], leader.span if leader else None)
    first, second = _zeros(reading, fact)
    factor = tidy(fact["data"][1])
    offset = tidy(fact["data"][0] + first - factor * second)
    if factor != 1:
        put_number(mimic, "multiplier", factor, element, "polycoef", 1)
    if offset:
        put_number(mimic, "offset", offset, element, "polycoef", 0)
    for word, usual in STIFF.items():
        values = [tidy(value) for value in fact[word]]
        if tuple(values[: len(usual)]) != usual or values[len(usual) :] != _DEFAULTS[word]:
            put(mimic, word, numbers(values, element, word))
    return mimic


def _add_constraint(reading: Reading, constraints: Map, index: int, node: Node, element: Element) -> None:
    """Add an equality that is no joint following another."""
    attributes, entry = node["attributes"], Map(element.span)
    of = next((attributes[word] for word in ("body1", "site1", "joint1", "tendon1") if word in attributes), "robot")
    name = reading.name("constraint", attributes.get("name", ""), f"{of}_{node['tag']}", index)
    if node["tag"] not in forms_of("constraint")["type"]["enum"]:
        _keep_whole(reading, "equality", {**node, "attributes": {**attributes, "name": name}}, element.span)
        return
    put(entry, "type", node["tag"])
    for word, key in _PAIRED.items():
        both = [called(reading, word, attributes[one]) for one in (f"{word}1", f"{word}2") if one in attributes]
        if both:
            put(entry, key, listing(both, element))
    paired = {f"{word}{number}" for word in _PAIRED for number in (1, 2)}
    rest = {key: text for key, text in attributes.items() if key not in paired}
    pose = floats({"relpose": rest.pop("relpose", "")}, "relpose", [0, 1, 0, 0, 0, 0, 0])
    if any(pose[3:]):  # where one link of a weld is in the other; a quaternion of zeros is the first pose
        put(entry, "xyz", numbers([tidy(value) for value in pose[:3]], element))
        put_pose(entry, transform(pose[:3], pose[3:]), element)
    first, second = _zeros(reading, reading.facts["equalities"][index]) if node["tag"] == _JOINT else (0.0, 0.0)
    if first or second:
        offset, *others = shifted(floats(rest, "polycoef", [0, 1, 0, 0, 0]), -second)
        rest["polycoef"] = " ".join(repr(tidy(value)) for value in (offset + first, *others))
    if put_words(entry, rest, "constraint", element, _OF_CONSTRAINT):
        _keep_whole(reading, "equality", {**node, "attributes": {**attributes, "name": name}}, element.span)
    else:
        constraints.put(name, entry, element.span, element.span)


def add_contacts(reading: Reading) -> None:
    """Add the pairs of links that do not touch in the file, and the contact pairs that it has.

    An MJCF of ours excludes and pairs by itself (``contacts``). If the file has these too, only the rest of it is in
    the tree; if not, the tree has all that the file has, and no more is written: ``contacts: described``.
    """
    from rosorin_compile.language.lower import lower

    touching = {geom["body"] for geom in reading.facts["geoms"] if geom["contype"] or geom["conaffinity"]}
    robot = lower(reading.tree).robot if touching or reading.facts["excludes"] else None
    ours = contacts(robot) if robot else Contacts([], [], [])
    excludes = list(_excludes(reading))
    excluded = {frozenset(names) for names, _ in excludes}
    named = {frozenset((one.solid.shape.name, other.solid.shape.name)) for one, other in ours.pairs}
    paired = {
        frozenset(reading.called("geom", node["attributes"][word]) for word in ("geom1", "geom2"))
        for node in reading.facts["elements"]["pairs"]
    }
    implied = set(map(frozenset, ours.excluded))
    reading.implied_contacts = implied <= excluded and named <= paired
    if not reading.implied_contacts:
        implied, named = set(), set()
    pairs = Seq(reading.markup.root.span)
    for names, element in excludes:
        if frozenset(names) not in implied:
            ordered = sorted(names, key=lambda name: name != element.get("body1"))
            pairs.put(_link_pair(ordered, element, _EXCLUDED), element.span)
    if touching:
        for names, element in _filtered(reading, touching, excluded | implied):
            pairs.put(_link_pair(names, element, _FILTERED), element.span)
    if pairs:
        put(reading.tree, "disabled_contacts", pairs)
    _add_pairs(reading, named)


def _excludes(reading: Reading) -> Iterator[tuple[list[str], Element]]:
    """Yield the links that the file excludes from contact with each other."""
    written = {frozenset((e.get("body1"), e.get("body2"))): e for e in reading.markup.listed("contact", "exclude")}
    for signature in reading.facts["excludes"]:
        bodies = (signature >> 16, signature & 0xFFFF)  # mjModel.exclude_signature, which MuJoCo has sorted
        names = [reading.link_of.get(index, "") for index in bodies]
        in_file = frozenset(reading.facts["bodies"][index]["name"] for index in bodies)
        element = written.get(in_file, reading.markup.root)
        if all(names):
            yield names, element
        elif element not in reading.reported:
            reading.reported.add(element)
            what = "a contact with the world that is excluded: the scene is no part of the robot"
            reading.ignored(what, element.span)


def _filtered(
    reading: Reading, touching: set[int], excluded: set[frozenset[str]]
) -> Iterator[tuple[list[str], Element]]:
    """Yield the links that are neighbours in the file and not here, since several joints move one of them.

    MuJoCo lets nothing that is welded to a body touch what is welded to the body that it moves in, unless that is the
    world. Where several joints move a body it is attached here to links without mass, which are its neighbours instead.
    """
    if reading.facts["elements"]["options"].get("flag filterparent") == "disable":
        return
    top: dict[int, int] = {}  # the topmost body of those that are welded together
    groups: dict[int, list[int]] = {}
    for index, body in enumerate(reading.facts["bodies"]):
        top[index] = index if not index or reading.joints_in.get(index) else top[body["parent"]]
        groups.setdefault(top[index], []).append(index)
    for index, below in groups.items():
        above = top[reading.facts["bodies"][index]["parent"]] if index else 0
        if above == 0 or (len(reading.joints_in.get(index, ())) < 2 and index not in reading.balls_on):
            continue
        upper, lower = ([reading.link_of[at] for at in side if at in touching] for side in (groups[above], below))
        for names in ([one, other] for one in upper for other in lower):
            if frozenset(names) not in excluded:
                yield names, reading.places.body(index)


def _link_pair(names: list[str], element: Element, reason: str) -> Map:
    """Return the entry for a pair of links that do not touch."""
    entry, links = Map(element.span), Seq(element.span)
    spans = {attribute.value: attribute.span for attribute in element.attributes.values()}
    for name in names:
        links.put(name, spans.get(name, element.span))
    put(entry, "links", links)
    put(entry, "reason", reason)
    return entry


def _add_pairs(reading: Reading, implied: set[frozenset[str]]) -> None:
    """Keep the contact pairs; not those of ``implied``, which ours has by itself, unless they have more."""
    nodes = reading.facts["elements"]["pairs"]
    for node, element in zip(nodes, reading.elements_of("contact", nodes, "pair"), strict=True):
        attributes = dict(node["attributes"])
        both = [reading.called(_GEOM, attributes.pop(word)) for word in ("geom1", "geom2")]
        if attributes not in TOUCHES or frozenset(both) not in implied:
            _keep_whole(reading, "contact", node, element.span)


def add_kept(reading: Reading) -> None:
    """Add what is kept as it is to the links and at the top, and report it.

    Whole sections are kept that have nothing of links and joints, such as numbers and texts for other programs.
    """
    for node in reading.facts["elements"]["whole"]:
        found = reading.markup.sections(node["tag"])
        reading.keep(_with_files(reading, node), node["tag"], (found[0] if found else reading.markup.root).span)
    for one in reading.elements:  # which grow: assets name others
        keep_assets(reading, one.node, one.span)
    by_link: dict[str, list[Node]] = {}
    by_tag: dict[str, list[Span]] = {}
    for one in reading.elements:
        nodes = by_link.setdefault(one.link, [])
        node = _renamed(reading, one.node)
        section = next((each for each in nodes if not one.link and _is_same_section(each, node)), None)
        if section is None:
            nodes.append(node)
        else:
            section["inner"].extend(node["inner"])
        by_tag.setdefault(one.tag, []).append(one.span)
    for link, nodes in by_link.items():
        texts = listing(map(text_of, nodes), reading.markup.root)
        put(reading.links[link] if link else reading.tree, "mjcf_elements" if link else "mjcf", texts)
    for tag, spans in by_tag.items():
        what = f"{counted(len(spans), 'element')} ({tag})" if len(spans) > 1 else f"an element ({tag})"
        message = f"{what}, for which the language has no keys: kept as XML under mjcf"
        reading.note("import-verbatim", message, spans[0], others=spans[1:])


def _is_same_section(one: Node, other: Node) -> bool:
    return bool(one["tag"] == other["tag"] and not one["attributes"] and not other["attributes"])


def _with_files(reading: Reading, node: Node) -> Node:
    """Return an element with its files as seen from the main file."""
    attributes = dict(node["attributes"])
    if "file" in attributes and node["tag"] == "skin":
        file = posixpath.join(reading.facts["folders"]["skin"][""], attributes["file"])
        attributes["file"] = reading.markup.place_of(file)
    return {**node, "attributes": attributes, "inner": [_with_files(reading, one) for one in node["inner"]]}


def _kind_of(word: str, attributes: Mapping[str, str]) -> str:
    """Return the kind of what an attribute names; empty if it names nothing of the robot."""
    if word in ("objname", "refname"):
        word = attributes.get(f"{word[:3]}type", "")
    return _KINDS.get(word, "")


def _renamed(reading: Reading, node: Node) -> Node:
    """Return an element with the names that the description has for what it names."""
    attributes = dict(node["attributes"])
    for word, text in attributes.items():
        kind = _kind_of(word, attributes)
        if kind and kind != "material":  # those are kept with it
            attributes[word] = reading.called(kind, text)
    return {**node, "attributes": attributes, "inner": [_renamed(reading, one) for one in node["inner"]]}
