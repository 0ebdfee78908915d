"""Bodies become links, with their inertials, sites, cameras and lights."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rosorin_compile.model import Link, Transform
from rosorin_compile.model.geometry import Rows
from rosorin_compile.model.link import limited_fields
from rosorin_compile.source.diagnostics import counted, first_of
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Element

from .masses import LEAST_EIGENVALUE
from .reading import Reading
from .values import (
    NO_POSE,
    full_inertia,
    is_unturned,
    placing,
    put,
    put_number,
    put_pose,
    put_source,
    put_words,
    rotation,
    shift,
    tidy,
    tidy_vector,
    transform,
)

GROUND = "ground"
NO_MASS = 1e-12  # kg: less than a grain of dust; MuJoCo loads no moving body without any
_SAME = 1e-9  # relative: MuJoCo's way through principal axes and back
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_POSED = ("name", "pos", "quat")
# The sections of marks in a link, with the tag of their elements and the form of their entries.
_MARKS = {"sites": ("site", "site"), "cameras": ("camera", "mjcf_camera"), "lights": ("light", "light")}


def name_links(reading: Reading) -> None:
    """Give every body the name of its link: its own, or one made of the joint or body that it is attached to."""
    bodies = reading.facts["bodies"]
    named = {index: body["name"] for index, body in enumerate(bodies) if index and body["name"]}
    reading.link_of = {index: reading.link_names.give(name) for index, name in named.items()}
    for index, name in named.items():
        link = reading.link_of[index]
        reading.rename("body", name, link)
        if link != name:
            message = f'the body "{name}" becomes the link "{link}": names hold no markup or quotes'
            reading.changed(message, reading.places.body(index).span)
    if reading.ground:
        reading.link_of[0] = reading.link_names.give(GROUND)
        reading.renamed.setdefault("body", {})["world"] = reading.link_of[0]
    for index, body in enumerate(bodies):
        if index and index not in named:
            joints = [reading.facts["joints"][at]["name"] for at in reading.joints_in.get(index, ())]
            above = reading.link_of.get(body["parent"], "")
            made_up = f"{joints[-1]}_link" if joints and joints[-1] else f"{above}_body" if above else "base_link"
            reading.link_of[index] = reading.link_names.give(made_up)


def add_links(reading: Reading) -> None:
    """Add a link for the ground, if it is one, and for every body, with its inertial."""
    if reading.ground:
        reading.add(reading.links, reading.link_of[0], reading.places.body(0))
    light = []
    for index, body in enumerate(reading.facts["bodies"]):
        if index == 0:
            continue
        element, name = reading.places.body(index), reading.link_of[index]
        link = reading.add(reading.links, name, element)
        if 0 < body["mass"] <= NO_MASS:
            light.append(index)
        elif body["mass"] > 0 or any(body["inertia"]):
            own = next((one for one in reading.markup.children(element) if one.tag == "inertial"), element)
            put(link, "inertial", _inertial(body, own))
        node = body["element"]
        more = {key: text for key, text in node["attributes"].items() if key not in _POSED}
        words = {formats["mjcf"]: key for key, formats in limited_fields(Link).items() if "mjcf" in formats}
        reading.put_words(link, more, "link", element, f'the body "{name}"', words)
        for inner in node["inner"]:
            reading.keep(inner, inner["tag"], element.span, name)
    if light:
        names = first_of([reading.link_of[index] for index in light], 5)
        message = f"what MuJoCo has for mass where there is none is left out ({names})"
        reading.changed(message, reading.places.body(light[0]).span)


def _inertial(body: Mapping[str, Any], element: Element) -> Map:
    """Return mass and inertia as the file has them, or as MuJoCo calculated them from the geoms."""
    entry, written = Map(element.span), body.get("said")
    put_number(entry, "mass", tidy(body["mass"]), element, "mass")
    place = tidy_vector(written["pos"] if written else body["ipos"])
    rows = rotation(body["iquat"])
    moments, pose = full_inertia(body["inertia"], rows), shift(place)
    if written and written["full"] is not None:
        full = dict(zip(_MOMENTS, written["full"], strict=True))
        # Settings of MuJoCo's compiler may bound or balance an inertia.
        most = _SAME * max(map(abs, moments.values()))
        moments = full if all(abs(full[key] - moments[key]) <= most for key in full) else moments
    elif _is_turned(rows) and (written or min(body["inertia"]) < LEAST_EIGENVALUE):
        moments, pose = full_inertia(body["inertia"], NO_POSE.rows), Transform(rows, place)
    put_pose(entry, pose, element)
    put(entry, "inertia", _moments(moments, element))
    if not written:
        put_source(entry, "calculated", "by MuJoCo from the geoms")
    return entry


def _is_turned(rows: Rows) -> bool:
    """Return True if the principal axes of an inertia are not the axes of its body."""
    return full_inertia((1.0, 2.0, 3.0), rows) != full_inertia((1.0, 2.0, 3.0), NO_POSE.rows)


def _moments(moments: Mapping[str, float], element: Element) -> Map:
    entry, order = Map(element.span), {"fullinertia": _MOMENTS, "diaginertia": _MOMENTS[:3]}
    attribute = next((word for word in order if word in element.attributes), "")
    for key, value in moments.items():
        if value or key in _MOMENTS[:3]:
            at = order[attribute].index(key) if attribute and key in order[attribute] else 99
            put_number(entry, key, value, element, attribute, at)
    return entry


def add_marks(reading: Reading) -> None:
    """Add the sites, cameras and lights of every link; those of the world are its scene, unless that is a link."""
    scene: dict[str, list[int]] = {}
    for kind in _MARKS:
        for index, thing in enumerate(reading.facts[kind]):
            if thing["body"] in reading.link_of:
                _add_mark(reading, kind, index, thing)
            else:
                scene.setdefault(kind, []).append(index)
    for kind, indices in scene.items():
        message = f"{counted(len(indices), kind[:-1])} of the world: the scene is no part of the robot"
        reading.ignored(message, reading.places.of(kind, indices[0]).span)


def _add_mark(reading: Reading, kind: str, index: int, thing: Mapping[str, Any]) -> None:
    """Add a site, a camera or a light to its link; one that the language cannot express is kept as it is."""
    tag, form = _MARKS[kind]
    link, element, node = reading.link_of[thing["body"]], reading.places.of(kind, index), thing["element"]
    place = transform(thing["pos"], thing.get("quat", (1, 0, 0, 0)))
    more = {key: text for key, text in node["attributes"].items() if key not in _POSED}
    is_plain = not more or (reading.is_ours and more.keys() == {"group"})
    is_frame = tidy_vector(thing["pos"]) == (0, 0, 0) and is_unturned(place) and is_plain
    if kind == "sites" and thing["name"] == link and is_frame:
        return  # the frame of the link itself, as the compiler writes it
    name = _mark_name(reading, tag, thing["name"], link, element)
    reading.given.setdefault(tag, {})[index] = name
    if kind == "lights" and "dir" in more:
        more["dir"] = " ".join(repr(tidy(value)) for value in thing["dir"])
    entry, kinds = Map(element.span), {"target": "body", "material": "material"}
    put_pose(entry, place, element)
    rest = put_words(entry, more, form, element, rename=lambda word, text: reading.called(kinds[word], text))
    if rest or node["inner"]:
        reading.keep({**node, "attributes": {"name": name, **more, **placing(place)}}, tag, element.span, link)
        return
    marks = reading.links[link].get(kind) or Map(element.span)
    marks.put(name, entry, element.span, element.span)
    put(reading.links[link], kind, marks)


def _mark_name(reading: Reading, tag: str, name: str, link: str, element: Element) -> str:
    """Return the name of a mark; a site has that of no link, for each link has a site of its own."""
    if tag == "site" and name in reading.link_names.taken:
        given = reading.name(tag, f"{name}_site")
        reading.rename(tag, name, given)
        reading.changed(f'the site "{name}" is called "{given}": a link has the name', element.span)
        return given
    return reading.name(tag, name, f"{link}_{tag}")
