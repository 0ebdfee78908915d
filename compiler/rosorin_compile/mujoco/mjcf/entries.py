"""Sections of an MJCF besides its bodies: tendons, equalities, sensors, contacts, and what is kept as it is.

What an entry of the description cannot express keeps the whole element as it is. What an element names of the scene (a
site or a geom of the world, if that is no link) is kept with it.
"""

from __future__ import annotations

import posixpath
from collections.abc import Iterator, Mapping
from typing import Any

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
    put,
    put_number,
    put_pose,
    put_words,
    text_of,
    tidy,
    transform,
)

_BODY, _SITE, _GEOM, _JOINT, _TENDON = "body", "site", "geom", "joint", "tendon"
_OBJECTS = {"xbody": "link", "body": "inertial", "geom": "shape", "site": "site", "camera": "camera"}
_KINDS = {
    **dict.fromkeys(("body", "body1", "body2", "subtree1", "subtree2", "link", "inertial", "target"), _BODY),
    **dict.fromkeys(("site", "site1", "site2", "sidesite", "refsite"), _SITE),
    **dict.fromkeys(("geom", "geom1", "geom2", "shape"), _GEOM),
    **dict.fromkeys(("joint", "joint1", "joint2"), _JOINT),
    **dict.fromkeys(("tendon", "tendon1", "tendon2"), _TENDON),
    **{kind: kind for kind in ("actuator", "camera", "material")},
}
_OF_TENDON = {"springlength": "spring_length", "frictionloss": "friction", "actuatorfrcrange": "force"}
_OF_CONSTRAINT = {"torquescale": "torque_scale", "polycoef": "polynomial", "anchor": "at"}
_PAIRED = {"body": "links", "site": "sites", "joint": "joints", "tendon": "tendons"}
_MEASURED = ("joint", "tendon", "actuator", "site", "body", "camera", "geom", "mesh")
_OF_SENSOR = {"body": "link", "geom": "shape"} | {
    f"{word}{number}": f"{key}{number}" for word, key in (("body", "link"), ("geom", "shape")) for number in (1, 2)
}
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


def _keep_whole(reading: Reading, section: str, node: Node, name: str, span: Span) -> None:
    """Keep an element as it is, under its name in the description."""
    named = {**node, "attributes": {**node["attributes"], "name": name}} if name else node
    reading.keep_in_section(section, named, f"{section} <{node['tag']}>", span)


def add_tendons(reading: Reading) -> None:
    """Add the tendons, with the joints or along the path that they have."""
    nodes, tendons = reading.facts["elements"]["tendons"], Map(reading.markup.root.span)
    for index, (node, element) in enumerate(zip(nodes, reading.elements_of("tendon", nodes), strict=True)):
        name, entry = reading.name("tendon", node["attributes"].get("name", ""), "tendon", index), Map(element.span)
        _put_way(reading, entry, node, element)
        looks = ("width", "rgba", "material") if node["tag"] == "fixed" else ()  # which is not drawn
        attributes = {word: text for word, text in node["attributes"].items() if word not in looks}
        rest = put_words(
            entry, attributes, "tendon", element, _OF_TENDON, lambda word, text: called(reading, word, text)
        )
        if rest or len(entry.get("joints") or ()) != sum(one["tag"] == "joint" for one in node["inner"]):
            _keep_whole(reading, "tendon", node, name, element.span)
        else:
            tendons.put(name, entry, element.span, element.span)
    if tendons:
        put(reading.tree, "tendons", tendons)


def _put_way(reading: Reading, entry: Map, node: Node, element: Element) -> None:
    """Set the joints of a tendon with their factors, or the stops of its path."""
    joints, path = Map(element.span), []
    for one in node["inner"]:
        attributes = one["attributes"]
        if one["tag"] == "joint":
            factor = tidy(floats(attributes, "coef", [0])[0])
            put_number(joints, called(reading, "joint", attributes["joint"]), factor, element)
            continue
        stop = Map(element.span)
        for word, key in (("site", "site"), ("geom", "shape"), ("sidesite", "side_site")):
            if word in attributes:
                put(stop, key, called(reading, word, attributes[word]))
        if one["tag"] == "pulley":
            put_number(stop, "pulley", tidy(floats(attributes, "divisor", [1])[0]), element)
        path.append(stop)
    if joints:
        put(entry, "joints", joints)
    if path:
        put(entry, "path", listing(path, element))


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
        _keep_whole(reading, "equality", node, name, element.span)
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
        _keep_whole(reading, "equality", node, name, element.span)
    else:
        constraints.put(name, entry, element.span, element.span)


def add_sensors(reading: Reading) -> None:
    """Add the sensors of MuJoCo."""
    nodes, sensors = reading.facts["elements"]["sensors"], Map(reading.markup.root.span)
    kinds = set(forms_of("mjcf_sensor")["kind"]["enum"]) - {"plugin"}
    for index, (node, element) in enumerate(zip(nodes, reading.elements_of("sensor", nodes), strict=True)):
        attributes, entry = dict(node["attributes"]), Map(element.span)
        of = next(
            (attributes[word] for word in (*_MEASURED, "objname", "geom1", "body1") if word in attributes), "robot"
        )
        name = reading.name("sensor", attributes.get("name", ""), f"{of}_{node['tag']}", index)
        put(entry, "kind", node["tag"])
        for key, kind, word in (("object", "objtype", "objname"), ("reference", "reftype", "refname")):
            what = _OBJECTS.get(attributes.get(kind, ""), "")
            if what and word in attributes:
                inner = Map(element.span)
                put(inner, what, called(reading, what, attributes.pop(word)))
                del attributes[kind]
                put(entry, key, inner)
        rest = put_words(
            entry, attributes, "mjcf_sensor", element, _OF_SENSOR, lambda word, text: called(reading, word, text)
        )
        if rest or node["inner"] or node["tag"] not in kinds:
            _keep_whole(reading, "sensor", node, name, element.span)
        else:
            sensors.put(name, entry, element.span, element.span)
    if sensors:
        put(reading.tree, "mjcf_sensors", sensors)


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
    """Add the contact pairs; not those of ``implied``, which ours has by itself, unless they have more."""
    nodes, entries = reading.facts["elements"]["pairs"], []
    for node, element in zip(nodes, reading.elements_of("contact", nodes, "pair"), strict=True):
        attributes = dict(node["attributes"])
        both = [called(reading, word, attributes.pop(word)) for word in ("geom1", "geom2")]
        if attributes in TOUCHES and frozenset(both) in implied:
            continue
        entry = Map(element.span)
        if "name" in attributes:
            put(entry, "name", reading.name("pair", attributes["name"]))
        put(entry, "shapes", listing(both, element))
        if put_words(entry, attributes, "contact_pair", element):
            _keep_whole(reading, "contact", node, "", element.span)
        else:
            entries.append(entry)
    if entries:
        put(reading.tree, "contact_pairs", listing(entries, reading.markup.root))


def add_kept(reading: Reading) -> None:
    """Add what is kept as it is to the links and at the top, and report it.

    Whole sections are kept that have nothing of links and joints, such as numbers and texts for other programs.
    """
    for node in reading.facts["elements"]["whole"]:
        found = reading.markup.sections(node["tag"])
        reading.keep(_with_files(reading, node), node["tag"], (found[0] if found else reading.markup.root).span)
    for one in reading.elements:  # which grow: assets name others
        keep_assets(reading, one.node, one.span)
    by_link: dict[str, list[str]] = {}
    by_tag: dict[str, list[Span]] = {}
    for one in reading.elements:
        by_link.setdefault(one.link, []).append(text_of(_renamed(reading, one.node)))
        by_tag.setdefault(one.tag, []).append(one.span)
    for link, texts in by_link.items():
        put(reading.links[link] if link else reading.tree, "mjcf_elements", listing(texts, reading.markup.root))
    for tag, spans in by_tag.items():
        what = f"{counted(len(spans), 'element')} ({tag})" if len(spans) > 1 else f"an element ({tag})"
        message = f"{what}, for which the language has no word: kept in mjcf_elements"
        reading.note("import-verbatim", message, spans[0], others=spans[1:])


def _with_files(reading: Reading, node: Node) -> Node:
    """Return an element with its files as seen from the main file."""
    attributes = dict(node["attributes"])
    if "file" in attributes and node["tag"] == "skin":
        file = posixpath.join(reading.facts["folders"]["skin"][""], attributes["file"])
        attributes["file"] = reading.markup.place_of(file)
    return {**node, "attributes": attributes, "inner": [_with_files(reading, one) for one in node["inner"]]}


def _renamed(reading: Reading, node: Node) -> Node:
    """Return an element with the names that the description has for what it names."""
    attributes = dict(node["attributes"])
    for word, text in attributes.items():
        kind = _KINDS.get(word, "")
        if word in ("objname", "refname"):
            kind = _KINDS.get(_OBJECTS.get(attributes.get(f"{word[:3]}type", ""), ""), "")
        if kind and kind != "material":  # those are kept with it
            attributes[word] = reading.called(kind, text)
    return {**node, "attributes": attributes, "inner": [_renamed(reading, one) for one in node["inner"]]}
