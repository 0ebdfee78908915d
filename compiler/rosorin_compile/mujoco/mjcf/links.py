"""Bodies become links, and have the sites, cameras and lights that stand in them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rosorin_compile.model import Transform
from rosorin_compile.model.geometry import Rows
from rosorin_compile.source.diagnostics import counted, first_of
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Element

from .masses import LEAST_EIGENVALUE
from .reading import (
    Reading,
    full_inertia,
    plain,
    put,
    put_number,
    put_pose,
    rotation,
    shift,
    source,
    tidy,
    tidy_vector,
    transform,
)
from .worded import put_words

GROUND = "ground"
NO_MASS = 1e-12  # kg: less than a grain of dust; MuJoCo loads no moving body without any
_SAME = 1e-9  # relative: MuJoCo's way through principal axes and back
_UNIT_ROWS = Transform().rows


def name_links(reading: Reading) -> None:
    """Give every body the name of its link: its own, or one made of what it hangs on."""
    bodies = reading.facts["bodies"]
    named = {index: body["name"] for index, body in enumerate(bodies) if index and body["name"]}
    reading.link_of = {index: reading.link_names.give(name) for index, name in named.items()}
    for index, name in named.items():
        if reading.link_of[index] != name:
            reading.renamed.setdefault("body", {})[name] = reading.link_of[index]
            message = f'the body "{name}" becomes the link "{reading.link_of[index]}": names hold no markup or quotes'
            reading.changed(message, reading.places.body(index).span)
    if reading.ground:
        reading.link_of[0] = reading.link_names.give(GROUND)
        reading.renamed.setdefault("body", {})["world"] = reading.link_of[0]
    for index, body in enumerate(bodies):
        if index and index not in named:
            reading.link_of[index] = reading.link_names.give(_made_up(reading, index, body))


def _made_up(reading: Reading, index: int, body: Mapping[str, Any]) -> str:
    """Return a name for a body without one: after its joint, its only named geom, or the body that it sits on."""
    joints = [reading.facts["joints"][at]["name"] for at in reading.joints_in.get(index, ())]
    if joints and joints[-1]:
        return f"{joints[-1]}_link"
    above = reading.link_of.get(body["parent"], "")
    return f"{above}_body" if above else "base_link"


def add_links(reading: Reading) -> None:
    """Add a link for the ground, if it is one, and for every body, with its inertial."""
    if reading.ground:
        reading.new_link(reading.link_of[0], reading.places.body(0))
    light = []
    for index, body in enumerate(reading.facts["bodies"]):
        if index == 0:
            continue
        element = reading.places.body(index)
        link = reading.new_link(reading.link_of[index], element)
        if 0 < body["mass"] <= NO_MASS:
            light.append(index)
        elif body["mass"] > 0 or any(body["inertia"]):
            own = next((e for e in reading.markup.children(element) if e.tag == "inertial"), element)
            put(link, "inertial", _inertial(body, own))
        _add_more(reading, index, link, element)
    if light:
        names = first_of([reading.link_of[index] for index in light], 5)
        message = f"what MuJoCo has for mass where there is none is left out ({names})"
        reading.changed(message, reading.places.body(light[0]).span)


_OF_BODY = {"gravcomp": "gravity_compensation"}


def _add_more(reading: Reading, index: int, link: Map, element: Element) -> None:
    """Add what a body has for a simulation alone; what has no word is kept as it is."""
    node = reading.facts["bodies"][index]["element"]
    said = {key: text for key, text in node["attributes"].items() if key not in _POSED}
    for name in put_words(link, said, "link", element, _OF_BODY):
        reading.lost(f'"{name}" of the body "{reading.link_of[index]}"', element.span)
    for one in node["inner"]:
        reading.kept(one, one["tag"], element.span, reading.link_of[index])


def _inertial(body: Mapping[str, Any], element: Element) -> Map:
    """Return mass and inertia as the file says them, or as MuJoCo calculated them from the geoms."""
    entry = Map(element.span)
    put_number(entry, "mass", tidy(body["mass"]), element, "mass")
    said = body.get("said")
    place = tidy_vector(said["pos"] if said else body["ipos"])
    rows = rotation(body["iquat"])
    moments = full_inertia(body["inertia"], rows)
    pose = shift(place)
    if said and said["full"] is not None:
        written = dict(zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), said["full"], strict=True))
        moments = written if _agree(written, moments) else moments
    elif _is_turned(rows) and (said or min(body["inertia"]) < LEAST_EIGENVALUE):
        moments = full_inertia(body["inertia"], _UNIT_ROWS)
        pose = Transform(rows, place)
    put_pose(entry, pose, element)
    put(entry, "inertia", _moments(moments, element))
    if not said:
        source(entry, "calculated", "by MuJoCo from the geoms")
    return entry


def _is_turned(rows: Rows) -> bool:
    """Say whether the principal axes of an inertia are not the axes of its body."""
    return full_inertia((1.0, 2.0, 3.0), rows) != full_inertia((1.0, 2.0, 3.0), _UNIT_ROWS)


def _agree(written: Mapping[str, float], compiled: Mapping[str, float]) -> bool:
    """Say whether MuJoCo left a written inertia as it is; settings of its compiler may bound or balance it."""
    largest = max(abs(value) for value in compiled.values())
    return all(abs(written[key] - compiled[key]) <= _SAME * largest for key in written)


def _moments(moments: Mapping[str, float], element: Element) -> Map:
    entry = Map(element.span)
    order = {"fullinertia": ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), "diaginertia": ("ixx", "iyy", "izz")}
    first = next((word for word in order if word in element.attributes), "")
    for key, value in moments.items():
        if value or key in ("ixx", "iyy", "izz"):
            at = order[first].index(key) if first and key in order[first] else 99
            put_number(entry, key, plain(value), element, first, at)
    return entry


_SECTIONS = {"sites": ("site", "site"), "cameras": ("camera", "mjcf_camera"), "lights": ("light", "light")}
_POSED = ("name", "pos", "quat")


def add_marks(reading: Reading) -> None:
    """Add the sites, cameras and lights of every link; those of the world are its scene, unless that is a link."""
    scene = dict.fromkeys(_SECTIONS, 0)
    for kind in _SECTIONS:
        for index, thing in enumerate(reading.facts[kind]):
            if thing["body"] not in reading.link_of:
                scene[kind] += 1
            else:
                _add_mark(reading, kind, index, thing)
    for kind, count in scene.items():
        if count:
            first = next(at for at, t in enumerate(reading.facts[kind]) if t["body"] not in reading.link_of)
            message = f"{counted(count, kind[:-1])} of the world: the scene is no part of the robot"
            reading.ignored(message, reading.places.of(kind, first).span)


def _add_mark(reading: Reading, kind: str, index: int, thing: Mapping[str, Any]) -> None:
    """Add a site, a camera or a light to its link; what the language cannot say of it keeps it as it is."""
    tag, form = _SECTIONS[kind]
    link, element, node = reading.link_of[thing["body"]], reading.places.of(kind, index), thing["element"]
    place = transform(thing["pos"], thing.get("quat", (1, 0, 0, 0)))
    said = {key: text for key, text in node["attributes"].items() if key not in _POSED}
    plain = not said or (reading.is_ours and said.keys() == {"group"})
    is_frame = tidy_vector(thing["pos"]) == (0, 0, 0) and _is_unturned(place) and plain
    if kind == "sites" and thing["name"] == link and is_frame:
        return  # the frame of the link itself, as the compiler writes it
    name = _mark_name(reading, tag, thing["name"], link, element)
    reading.given.setdefault(tag, {})[index] = name
    if kind == "lights" and "dir" in said:
        said["dir"] = " ".join(repr(tidy(value)) for value in thing["dir"])
    entry = Map(element.span)
    put_pose(entry, place, element)
    rest = put_words(entry, said, form, element, rename=lambda word, text: reading.called(_OF[word], text))
    if rest or node["inner"]:
        placed = {"name": name, **said, **placing(place)}
        reading.kept({**node, "attributes": placed}, tag, element.span, link)
        return
    marks = reading.links[link].get(kind) or Map(element.span)
    marks.put(name, entry, element.span, element.span)
    put(reading.links[link], kind, marks)


_OF = {"target": "body", "material": "material"}


def _mark_name(reading: Reading, tag: str, name: str, link: str, element: Element) -> str:
    """Return the name of a mark; a site has that of no link, for each link has a site of its own."""
    if tag == "site" and name in reading.link_names.taken:
        given = reading.name(tag, f"{name}_site")
        reading.renamed.setdefault(tag, {})[name] = given
        reading.changed(f'the site "{name}" is called "{given}": a link has the name', element.span)
        return given
    return reading.name(tag, name, f"{link}_{tag}")


def placing(place: Transform) -> dict[str, str]:
    """Return position and quaternion as attributes of MuJoCo."""
    quaternion = place.quaternion()
    made = {"pos": " ".join(repr(plain(tidy(value))) for value in place.xyz)}
    return made if _is_unturned(place) else made | {"quat": " ".join(map(repr, quaternion))}


def _is_unturned(place: Transform) -> bool:
    return all(
        abs(a - b) < 1e-12 for r, s in zip(place.rows, _UNIT_ROWS, strict=True) for a, b in zip(r, s, strict=True)
    )
