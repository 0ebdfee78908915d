"""Entries: tendons, constraints, sensors of MuJoCo and contact pairs, and whole sections that are kept as they are.

What an entry of the description cannot say keeps the whole element as it is. What an element names of the scene (a
site or a geom of the world, where that is no link) is kept with it.
"""

from __future__ import annotations

import posixpath
from collections.abc import Mapping, Sequence

from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Element

from .bodies import TOUCHES, shifted
from .reading import Reading, numbers, put, put_number, put_pose, tidy, transform
from .shapes import is_scene, keep_assets, whole_geom
from .worded import Node, floats, forms_of, listing, put_words, text_of

_BODY, _SITE, _GEOM, _JOINT, _TENDON = "body", "site", "geom", "joint", "tendon"
_OBJECTS = {"xbody": "link", "body": "inertial", "geom": "shape", "site": "site", "camera": "camera"}
_KINDS = {
    **dict.fromkeys(("body", "body1", "body2", "subtree1", "subtree2", "link", "inertial"), _BODY),
    **dict.fromkeys(("site", "site1", "site2", "sidesite"), _SITE),
    **dict.fromkeys(("geom", "geom1", "geom2", "shape"), _GEOM),
    **dict.fromkeys(("joint", "joint1", "joint2"), _JOINT),
    **dict.fromkeys(("tendon", "tendon1", "tendon2"), _TENDON),
    **{kind: kind for kind in ("actuator", "camera", "material")},
    "target": _BODY,
    "refsite": _SITE,
}


def called(reading: Reading, attribute: str, name: str) -> str:
    """Return the name that the description has for what an attribute names."""
    kind = _KINDS.get(attribute, "")
    if kind in (_SITE, _GEOM):
        _keep_of_scene(reading, kind, name)
    return reading.called(kind, name)


def _keep_of_scene(reading: Reading, kind: str, name: str) -> None:
    """Keep a site or geom of the world that something of the robot names, where the tree does not have it."""
    for index, thing in enumerate(reading.facts[f"{kind}s"]):
        if reading.ground and not (kind == _GEOM and is_scene(thing)):
            continue
        if thing["name"] == name and thing["body"] == 0 and (kind, name) not in reading.of_scene:
            reading.of_scene.add((kind, name))
            span = reading.places.of(f"{kind}s", index).span
            node = whole_geom(reading, thing) if kind == _GEOM else thing["element"]
            whole = {"tag": "worldbody", "attributes": {}, "inner": [node]}
            reading.kept(whole, f"{kind} of the world", span)


def _elements(reading: Reading, section: str, nodes: Sequence[Node], tag: str = "") -> list[Element]:
    """Return where each element of a section stands in the text."""
    found = reading.markup.listed(section, tag)
    if len(found) == len(nodes):
        return found
    return [reading.markup.named(section, node["attributes"].get("name", "")) or reading.markup.root for node in nodes]


def _whole(reading: Reading, section: str, node: Node, span: Span) -> None:
    """Keep an element as it is, in its section."""
    whole = {"tag": section, "attributes": {}, "inner": [node]}
    reading.kept(whole, f"{section} <{node['tag']}>", span)


_OF_TENDON = {"springlength": "spring_length", "frictionloss": "friction", "actuatorfrcrange": "force"}


def add_tendons(reading: Reading) -> None:
    """Add the tendons, with the joints or along the path that they have."""
    nodes = reading.facts["elements"]["tendons"]
    made = Map(reading.markup.root.span)
    for index, (node, element) in enumerate(zip(nodes, _elements(reading, "tendon", nodes), strict=True)):
        name = reading.name("tendon", node["attributes"].get("name", ""), "tendon", index)
        entry = Map(element.span)
        _put_way(reading, entry, node, element)
        said = _of_tendon(node)
        rest = put_words(entry, said, "tendon", element, _OF_TENDON, lambda word, text: called(reading, word, text))
        if rest or len(entry.get("joints") or ()) != sum(one["tag"] == "joint" for one in node["inner"]):
            _whole(reading, "tendon", {**node, "attributes": {**node["attributes"], "name": name}}, element.span)
        else:
            made.put(name, entry, element.span, element.span)
    if made:
        put(reading.tree, "tendons", made)


def _put_way(reading: Reading, entry: Map, node: Node, element: Element) -> None:
    """Set the joints of a tendon with their factors, or the stops of its path."""
    joints, path = Map(element.span), []
    for one in node["inner"]:
        said = one["attributes"]
        if one["tag"] == "joint":
            put_number(joints, called(reading, "joint", said["joint"]), tidy(floats(said, "coef", [0])[0]), element)
            continue
        stop = Map(element.span)
        for word, key in (("site", "site"), ("geom", "shape"), ("sidesite", "side_site")):
            if word in said:
                put(stop, key, called(reading, word, said[word]))
        if one["tag"] == "pulley":
            put_number(stop, "pulley", tidy(floats(said, "divisor", [1])[0]), element)
        path.append(stop)
    if joints:
        put(entry, "joints", joints)
    if path:
        put(entry, "path", listing(path, element))


def _of_tendon(node: Node) -> dict[str, str]:
    """Return the attributes of a tendon; a fixed one is not drawn, whatever its class says."""
    looks = ("width", "rgba", "material") if node["tag"] == "fixed" else ()
    return {word: text for word, text in node["attributes"].items() if word not in looks}


_OF_CONSTRAINT = {"torquescale": "torque_scale", "polycoef": "polynomial", "anchor": "at"}
_PAIRED = {"body": "links", "site": "sites", "joint": "joints", "tendon": "tendons"}


def add_constraint(reading: Reading, constraints: Map, index: int, node: Node, element: Element) -> None:
    """Add an equality that is no joint following another."""
    said = node["attributes"]
    of = next((said[word] for word in ("body1", "site1", "joint1", "tendon1") if word in said), "robot")
    name = reading.name("constraint", said.get("name", ""), f"{of}_{node['tag']}", index)
    entry = Map(element.span)
    if node["tag"] not in forms_of("constraint")["type"]["enum"]:
        _whole(reading, "equality", {**node, "attributes": {**said, "name": name}}, element.span)
        return
    put(entry, "type", node["tag"])
    for word, key in _PAIRED.items():
        both = [called(reading, word, said[one]) for one in (f"{word}1", f"{word}2") if one in said]
        if both:
            put(entry, key, listing(both, element))
    paired = {f"{word}{number}" for word in _PAIRED for number in (1, 2)}
    rest = {key: text for key, text in said.items() if key not in paired}
    _put_relative(entry, rest, element)
    if node["tag"] == _JOINT:
        rest |= _from_zero(reading, index, rest)
    if put_words(entry, rest, "constraint", element, _OF_CONSTRAINT):
        _whole(reading, "equality", {**node, "attributes": {**said, "name": name}}, element.span)
        return
    constraints.put(name, entry, element.span, element.span)


def _from_zero(reading: Reading, index: int, said: Mapping[str, str]) -> dict[str, str]:
    """Return the polynomial of an equality of joints, counted from zero; nothing where MuJoCo counts so, too."""
    equality, joints = reading.facts["equalities"][index], reading.facts["joints"]
    both = (equality["first"], equality["second"])
    first, second = (reading.facts["zero"][joints[joint]["address"]] if joint >= 0 else 0.0 for joint in both)
    if not first and not second:
        return {}
    offset, *others = shifted(floats(said, "polycoef", [0, 1, 0, 0, 0]), -second)
    return {"polycoef": " ".join(repr(tidy(value)) for value in (offset + first, *others))}


def _put_relative(entry: Map, said: dict[str, str], element: Element) -> None:
    """Set how one link of a weld is to stand in the other, where the file says it: by a quaternion that is one."""
    pose = floats({"relpose": said.pop("relpose", "")}, "relpose", [0, 1, 0, 0, 0, 0, 0])
    if any(pose[3:]):
        place: Transform = transform(pose[:3], pose[3:])
        put(entry, "xyz", numbers([tidy(value) for value in place.xyz], element))
        put_pose(entry, place, element)


def add_sensors(reading: Reading) -> None:
    """Add the sensors of MuJoCo."""
    nodes = reading.facts["elements"]["sensors"]
    kinds = forms_of("mjcf_sensor")["kind"]["enum"]
    made = Map(reading.markup.root.span)
    for index, (node, element) in enumerate(zip(nodes, _elements(reading, "sensor", nodes), strict=True)):
        said = node["attributes"]
        of = next((said[word] for word in (*_MEASURED, "objname", "geom1", "body1") if word in said), "robot")
        name = reading.name("sensor", said.get("name", ""), f"{of}_{node['tag']}", index)
        entry = Map(element.span)
        put(entry, "kind", node["tag"])
        rest = _put_measured(reading, entry, node, element)
        if rest or node["inner"] or node["tag"] not in kinds or node["tag"] == "plugin":
            _whole(reading, "sensor", {**node, "attributes": {**said, "name": name}}, element.span)
        else:
            made.put(name, entry, element.span, element.span)
    if made:
        put(reading.tree, "mjcf_sensors", made)


_MEASURED = ("joint", "tendon", "actuator", "site", "body", "camera", "geom", "mesh")
_OF_SENSOR = {"body": "link", "geom": "shape"} | {
    f"{word}{number}": f"{key}{number}" for word, key in (("body", "link"), ("geom", "shape")) for number in (1, 2)
}


def _put_measured(reading: Reading, entry: Map, node: Node, element: Element) -> Mapping[str, str]:
    """Set what a sensor measures, and how; return the attributes that no key can say."""
    said = dict(node["attributes"])
    for key, kind, word in (("object", "objtype", "objname"), ("reference", "reftype", "refname")):
        what = _OBJECTS.get(said.get(kind, ""), "")
        if what and word in said:
            inner = Map(element.span)
            put(inner, what, called(reading, what, said.pop(word)))
            del said[kind]
            put(entry, key, inner)
    return put_words(entry, said, "mjcf_sensor", element, _OF_SENSOR, lambda word, text: called(reading, word, text))


def add_pairs(reading: Reading, implied: set[frozenset[str]]) -> None:
    """Add the contact pairs; not those of ``implied``, which ours has by itself, unless they say more."""
    nodes = reading.facts["elements"]["pairs"]
    made = []
    for node, element in zip(nodes, _elements(reading, "contact", nodes, "pair"), strict=True):
        said = dict(node["attributes"])
        both = [called(reading, word, said.pop(word)) for word in ("geom1", "geom2")]
        if said in TOUCHES and frozenset(both) in implied:
            continue
        entry = Map(element.span)
        if "name" in said:
            put(entry, "name", reading.name("pair", said["name"]))
        put(entry, "shapes", listing(both, element))
        if put_words(entry, said, "contact_pair", element):
            _whole(reading, "contact", node, element.span)
        else:
            made.append(entry)
    if made:
        put(reading.tree, "contact_pairs", listing(made, reading.markup.root))


def add_whole(reading: Reading) -> None:
    """Keep the sections that say nothing of links and joints, such as numbers and texts for other programs."""
    for node in reading.facts["elements"]["whole"]:
        found = reading.markup.sections(node["tag"])
        span = (found[0] if found else reading.markup.root).span
        reading.kept(_with_files(reading, node), node["tag"], span)


def _with_files(reading: Reading, node: Node) -> Node:
    """Return an element with its files as seen from the main file."""
    said = dict(node["attributes"])
    if "file" in said and node["tag"] == "skin":
        said["file"] = reading.markup.place_of(posixpath.join(reading.facts["folders"]["skin"][""], said["file"]))
    return {**node, "attributes": said, "inner": [_with_files(reading, one) for one in node["inner"]]}


def _renamed(reading: Reading, node: Node) -> Node:
    """Return an element with the names that the description has for what it names."""
    said = dict(node["attributes"])
    for word, text in said.items():
        kind = _KINDS.get(word, "")
        if word in ("objname", "refname"):
            kind = _KINDS.get(_OBJECTS.get(said.get(f"{word[:3]}type", ""), ""), "")
        if kind and kind != "material":  # those are kept with it
            said[word] = reading.called(kind, text)
    return {**node, "attributes": said, "inner": [_renamed(reading, one) for one in node["inner"]]}


def put_elements(reading: Reading) -> None:
    """Set what is kept as it is, in the links and at the top, and list it."""
    from rosorin_compile.source.diagnostics import counted

    for one in reading.elements:  # which grow: assets name others
        keep_assets(reading, one.node, one.span)
    by_link: dict[str, list[str]] = {}
    by_tag: dict[str, list[Span]] = {}
    for one in reading.elements:
        by_link.setdefault(one.link, []).append(text_of(_renamed(reading, one.node)))
        by_tag.setdefault(one.tag, []).append(one.span)
    for link, texts in by_link.items():
        owner = reading.links[link] if link else reading.tree
        put(owner, "mjcf_elements", listing(texts, reading.markup.root))
    for tag, spans in by_tag.items():
        what = f"{counted(len(spans), 'element')} ({tag})" if len(spans) > 1 else f"an element ({tag})"
        reading.kept_as_is(f"{what}, for which the language has no word: kept in mjcf_elements", spans)
