"""Geoms become shapes that are seen, that collide, or both.

MuJoCo has no such difference; people say it in two ways. A geom that collides with nothing (``contype`` and
``conaffinity`` 0) is only there to be seen. One that collides is also seen, unless its model tells the two apart: it
is in a group that viewers hide (3 to 5), or transparent, or of a class with "collision" in its name, or its body has
geoms only to be seen and those have groups of their own in this model.
"""

from __future__ import annotations

import posixpath
from collections.abc import Mapping
from typing import Any

from ...diagnostics.wording import counted, first_of
from ...frontend.tree import Map, Seq
from ...model import Transform
from ...xml.markup import Element
from .bodies import COLLISION_GROUP, SHOWN, VISUAL_GROUP
from .reading import Reading, legal, numbers, put, put_number, put_pose, tidy, tidy_vector, transform

PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH, SDF = range(9)
_WORDS = ("plane", "height field", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf")
_CARRIED = (SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH)
_FIRST_HIDDEN_GROUP = 3
_NO_COLOUR = (0.5, 0.5, 0.5, 1.0)  # MuJoCo: a geom of this colour has that of its material


def add_shapes(reading: Reading) -> None:
    """Add the shapes of all links, and the materials that they use."""
    geoms = reading.facts["geoms"]
    carried = [index for index, geom in enumerate(geoms) if _is_carried(reading, geom)]
    apart = _groups_apart([geoms[index] for index in carried])
    decorated = {geoms[index]["body"] for index in carried if not _collides(geoms[index])}
    materials = Map(reading.markup.root.span)
    held: dict[tuple[str, str], Seq] = {}
    for index in carried:
        geom = geoms[index]
        element = reading.places.of("geoms", index)
        link = reading.link_of[geom["body"]]
        purposes = ["collision"] if _collides(geom) else ["visual"]
        if purposes == ["collision"] and _is_seen(geom) and not (apart and geom["body"] in decorated):
            purposes = ["visual", "collision"]
        for purpose in purposes:
            shape = _shape(reading, index, element)
            if shape is None:
                break
            if purpose == "visual":
                _colour(reading, geom, element, shape, materials)
            held.setdefault((link, purpose), Seq(element.span)).put(shape, element.span)
    for (link, purpose), shapes in held.items():
        put(reading.links[link], purpose, shapes)
    if materials:
        put(reading.tree, "materials", materials)
    _tell(reading)


def _is_carried(reading: Reading, geom: Mapping[str, Any]) -> bool:
    made_up = geom["class"] == f"{reading.facts['name']}_{SHOWN}"  # ours: it shows what collides, and is nothing else
    return geom["type"] in _CARRIED and geom["body"] in reading.link_of and not made_up


def _collides(geom: Mapping[str, Any]) -> bool:
    return bool(geom["contype"] or geom["conaffinity"])


def _is_seen(geom: Mapping[str, Any]) -> bool:
    return geom["group"] < _FIRST_HIDDEN_GROUP and geom["rgba"][3] > 0 and "collision" not in geom["class"].lower()


def _groups_apart(geoms: list[Mapping[str, Any]]) -> bool:
    """Say whether the geoms that only are seen have groups of their own."""
    seen = {geom["group"] for geom in geoms if not _collides(geom)}
    return bool(seen) and seen.isdisjoint(geom["group"] for geom in geoms if _collides(geom))


def _shape(reading: Reading, index: int, element: Element) -> Map | None:
    """Return the entry of a shape; None for a mesh that is in no file."""
    geom = reading.facts["geoms"][index]
    entry = Map(element.span)
    place = transform(geom["pos"], geom["quat"])
    if geom["type"] == MESH:
        mesh = reading.facts["meshes"][geom["data"]]
        file = mesh_file(mesh)
        if not file:
            return None
        made = Map(element.span)
        put(made, "file", reading.markup.place_of(file))
        scale = tidy_vector(mesh["scale"])
        if scale != (1, 1, 1):
            put(made, "scale", numbers(scale, reading.markup.named("asset", mesh["name"]) or element, "scale"))
        if mesh["taken"]:
            put(made, "inertia", mesh["taken"])
        put(entry, "mesh", made)
        place = place.then(frame_of_file(mesh))
    else:
        put(entry, _WORDS[geom["type"]], _sizes(geom["type"], geom["size"], element))
    if geom["name"]:
        put(entry, "name", legal(geom["name"]))
    put_pose(entry, place, element)
    return entry


def _sizes(kind: int, size: list[float], element: Element) -> Map:
    """Return the sizes of a primitive: full extents and lengths, where MuJoCo has halves."""
    made = Map(element.span)
    if kind == BOX:
        put(made, "size", numbers([tidy(2 * half) for half in size], element))
        return made
    if kind == ELLIPSOID:
        put(made, "radii", numbers([tidy(radius) for radius in size], element, "size"))
        return made
    put_number(made, "radius", tidy(size[0]), element, "size")
    if kind != SPHERE:
        put_number(made, "length", tidy(2 * size[1]), element)
    return made


def frame_of_file(mesh: Mapping[str, Any]) -> Transform:
    """Return where the scaled mesh of the file is in the frame of its geom, which MuJoCo moves to the mesh's own axes.

    MuJoCo takes ``refpos`` from the vertices of the file, turns them by ``refquat``, scales them, and then moves them
    to the axes ``pos`` and ``quat``. Here they are scaled first; ``is_stretched`` says where that is another mesh.
    """
    own = transform(mesh["pos"], mesh["quat"])
    reference = transform(mesh["reference"]["pos"], mesh["reference"]["quat"]).inverse()
    x, y, z = (a * b for a, b in zip(mesh["scale"], reference.xyz, strict=True))
    return own.inverse().then(Transform(reference.rows, (x, y, z)))


def is_stretched(mesh: Mapping[str, Any]) -> bool:
    """Say whether a mesh is turned before it is scaled by another factor along each axis."""
    return any(mesh["reference"]["quat"][1:]) and len(set(mesh["scale"])) > 1


def mesh_file(mesh: Mapping[str, Any]) -> str:
    """Return the file of a mesh as it is found from the folder of the MJCF; empty if no file has it as it is."""
    file: str = "" if is_stretched(mesh) else mesh["file"]
    return posixpath.normpath(posixpath.join(mesh["folder"], file.replace("\\", "/"))) if file else ""


def _colour(reading: Reading, geom: Mapping[str, Any], element: Element, shape: Map, materials: Map) -> None:
    """Set the colour of a visual: its own, or its material."""
    rgba = tuple(tidy(round(value, 7)) for value in geom["rgba"])  # MuJoCo keeps colours with seven digits
    if rgba == _NO_COLOUR:
        if geom["material"] >= 0:
            put(shape, "material", _material(reading, geom["material"], materials))
        return
    put(shape, "rgba", numbers(rgba, element, "rgba"))
    texture = reading.facts["materials"][geom["material"]]["texture"] if geom["material"] >= 0 else ""
    if texture:
        put(shape, "texture", reading.markup.place_of(texture))


def _material(reading: Reading, index: int, materials: Map) -> str:
    """Return the name of a material, which the description has from now on."""
    material = reading.facts["materials"][index]
    known = reading.material_of.get(index)
    if known is None:
        own = material["name"].removeprefix(f"{reading.facts['name']}_" if reading.is_ours else "")
        known = reading.material_of[index] = reading.material_names.give(own or material["name"])
        element = reading.markup.named("asset", material["name"]) or reading.markup.root
        entry = Map(element.span)
        put(entry, "rgba", numbers([tidy(round(value, 7)) for value in material["rgba"]], element, "rgba"))
        if material["texture"]:
            put(entry, "texture", reading.markup.place_of(material["texture"]))
        put(materials, known, entry)
    return known


def _tell(reading: Reading) -> None:
    """List the geoms that are not carried: those of the robot by their kind, those of the scene together."""
    kinds: dict[str, list[int]] = {}
    scene = []
    for index, geom in enumerate(reading.facts["geoms"]):
        inline = geom["type"] == MESH and not mesh_file(reading.facts["meshes"][geom["data"]])
        if geom["body"] not in reading.link_of or (geom["body"] == 0 and geom["type"] in (PLANE, HFIELD)):
            scene.append(index)
        elif geom["type"] not in _CARRIED or inline:
            kinds.setdefault("mesh that no file has" if inline else _WORDS[geom["type"]], []).append(index)
    groups = {(_collides(g), g["group"]) for g in reading.facts["geoms"] if _is_carried(reading, g)}
    ours = {True: (0, COLLISION_GROUP), False: (VISUAL_GROUP,)}
    strange = sorted({group for collides, group in groups if group not in ours[collides]})
    if strange:
        first = next(at for at, g in enumerate(reading.facts["geoms"]) if g["group"] in strange)
        message = f"groups of geoms ({', '.join(map(str, strange))}): ours has visuals in {VISUAL_GROUP} and collisions"
        message += f" in {COLLISION_GROUP}"
        reading.changed(message, reading.places.of("geoms", first).span)
    for word, geoms in kinds.items():
        links = sorted({reading.link_of[reading.facts["geoms"][index]["body"]] for index in geoms})
        on = first_of(links, 5)
        many = len(geoms) > 1
        what = f"a geom of link {on} ({word})" if not many else f"{counted(len(geoms), 'geom')} ({word}) of {on}"
        spans = [reading.places.of("geoms", index).span for index in geoms]
        reading.lost(what, spans[0], "the language has no such shape", many, spans[1:])
    if scene:
        message = f"{counted(len(scene), 'geom')} of the world: the scene is no part of the robot"
        reading.ignored(message, reading.places.of("geoms", scene[0]).span)
