"""Bodies become links, and so do the frames that cameras and sites have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...diagnostics.wording import counted, first_of
from ...frontend.tree import Map
from ...model import Transform
from ...xml.markup import Element
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

GROUND = "ground"
NO_MASS = 1e-12  # kg: less than a grain of dust; MuJoCo loads no moving body without any
_FIXED_CAMERA = 0
_SAME = 1e-9  # relative: MuJoCo's way through principal axes and back
_UNIT_ROWS = Transform().rows


def name_links(reading: Reading) -> None:
    """Give every body the name of its link: its own, or one made of what it hangs on."""
    bodies = reading.facts["bodies"]
    named = {index: body["name"] for index, body in enumerate(bodies) if index and body["name"]}
    reading.link_of = {index: reading.link_names.give(name) for index, name in named.items()}
    for index, name in named.items():
        if reading.link_of[index] != name:
            message = f'the body "{name}" becomes the link "{reading.link_of[index]}": names hold no markup or quotes'
            reading.changed(message, reading.places.body(index).span)
    if reading.ground:
        reading.link_of[0] = reading.link_names.give(GROUND)
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
    if light:
        names = first_of([reading.link_of[index] for index in light], 5)
        message = f"what MuJoCo has for mass where there is none is left out ({names})"
        reading.changed(message, reading.places.body(light[0]).span)


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
    elif said and full_inertia((1.0, 2.0, 3.0), rows) != full_inertia((1.0, 2.0, 3.0), _UNIT_ROWS):
        moments = full_inertia(body["inertia"], _UNIT_ROWS)
        pose = Transform(rows, place)
    put_pose(entry, pose, element)
    put(entry, "inertia", _moments(moments, element))
    if not said:
        source(entry, "calculated", "by MuJoCo from the geoms")
    return entry


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


def add_frames(reading: Reading) -> None:
    """Add a link without mass, fixed to its body, for every named site and every camera that keeps its place."""
    scene = dict.fromkeys(("sites", "cameras"), 0)
    for kind in ("sites", "cameras"):
        for index, thing in enumerate(reading.facts[kind]):
            element = reading.places.of(kind, index)
            if thing["body"] not in reading.link_of:
                scene[kind] += 1
            elif kind == "cameras" and thing["mode"] != _FIXED_CAMERA:
                word = element.get("mode") or "tracking"
                name = thing["name"] or "without a name"
                reading.lost(f'the camera {name}, which turns by itself (mode="{word}"),', element.span)
            elif thing["name"] or kind == "cameras":
                _add_frame(reading, kind, index, element)
    _tell(reading, scene)


def _add_frame(reading: Reading, kind: str, index: int, element: Element) -> None:
    thing = reading.facts[kind][index]
    place = transform(thing["pos"], thing["quat"])
    above = reading.link_of[thing["body"]]
    is_identity = tidy_vector(thing["pos"]) == (0, 0, 0) and _is_unturned(place)
    if kind == "sites" and thing["name"] == above and is_identity:
        return  # the frame of the link itself, as the compiler writes it
    word = "site" if kind == "sites" else "camera"
    name = thing["name"] or f"{above}_{word}"
    if name in reading.link_names.taken:
        given = reading.link_names.give(f"{name}_{word}")
        reading.changed(f'the {word} "{name}" becomes the link "{given}": there is a link of its name', element.span)
    else:
        given = reading.link_names.give(name)
    if kind == "sites":
        reading.site_of[index] = given
    reading.new_link(given, element)
    joint = reading.new_joint(reading.joint_names.give(f"{given}_joint"), "fixed", above, given, element)
    put_pose(joint, place, element)


def _is_unturned(place: Transform) -> bool:
    return all(
        abs(a - b) < 1e-12 for r, s in zip(place.rows, _UNIT_ROWS, strict=True) for a, b in zip(r, s, strict=True)
    )


def _tell(reading: Reading, scene: Mapping[str, int]) -> None:
    """Say once what became of cameras, of sites without a name, and of both in the scene."""
    sites = [(at, s) for at, s in enumerate(reading.facts["sites"]) if not s["name"] and s["body"] in reading.link_of]
    if sites:
        span = reading.places.of("sites", sites[0][0]).span
        reading.ignored(f"{counted(len(sites), 'site')} without a name: nobody can ask for such a frame", span)
    for kind, count in scene.items():
        if count:
            first = next(at for at, t in enumerate(reading.facts[kind]) if t["body"] not in reading.link_of)
            message = f"{counted(count, kind[:-1])} of the world: the scene is no part of the robot"
            reading.ignored(message, reading.places.of(kind, first).span)
