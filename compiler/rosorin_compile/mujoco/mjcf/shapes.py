"""Geoms become shapes that are seen, that collide, or both.

MuJoCo has no such difference; people say it in two ways. A geom that collides with nothing (``contype`` and
``conaffinity`` 0) is only there to be seen. One that collides is also seen, unless its model tells the two apart: it
is in a group that viewers hide (3 to 5), or transparent, or of a class with "collision" in its name, or its body has
geoms only to be seen and those have groups of their own in this model.

Whom a geom touches becomes layers. A geom that the language has no shape for is kept as it is.
"""

from __future__ import annotations

import posixpath
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath
from typing import Any, cast

from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import Span, counted
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.markup import Element

from .bodies import SHOWN, SHOWN_WHEEL
from .links import placing
from .omissions import texture_path
from .reading import Reading, legal, numbers, put, put_number, put_pose, tidy, tidy_vector, transform
from .worded import Node, listing, put_words

PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH, SDF = range(9)
_WORDS = ("plane", "height field", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf")
_CARRIED = (SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH)
_FIRST_HIDDEN_GROUP = _HIDDEN = 3
_NO_COLOUR = (0.5, 0.5, 0.5, 1.0)  # MuJoCo: a geom of this colour has that of its material


def add_shapes(reading: Reading) -> None:
    """Add the shapes of all links, and the materials that they use."""
    geoms = reading.facts["geoms"]
    purposes = _purposes(reading)
    looks = Looks(reading)
    layers = _Layers(reading, [index for index, found in purposes.items() if "collision" in found])
    reading.groups = _usual_groups(reading, purposes)
    held: dict[tuple[str, str], Seq] = {}
    for index, found in purposes.items():
        element = reading.places.of("geoms", index)
        for purpose in found:
            shape = _shape(reading, index, element)
            if purpose == "visual":
                looks.put(index, shape, element)
            else:
                layers.put(index, shape, element)
            _more(reading, looks, index, shape, purpose, found)
            held.setdefault((reading.link_of[geoms[index]["body"]], purpose), Seq(element.span)).put(
                shape, element.span
            )
    for (link, purpose), shapes in held.items():
        put(reading.links[link], purpose, shapes)
    _keep_others(reading)
    looks.finish()
    layers.finish()
    _tell(reading)


def _purposes(reading: Reading) -> dict[int, list[str]]:
    """Return what each geom that is carried is there for: to be seen, to collide, or both."""
    geoms = reading.facts["geoms"]
    carried = [index for index, geom in enumerate(geoms) if _is_carried(reading, geom)]
    apart = _groups_apart([geoms[index] for index in carried])
    decorated = {geoms[index]["body"] for index in carried if not _collides(geoms[index])}
    made = {}
    for index in carried:
        geom = geoms[index]
        made[index] = ["collision"] if _collides(geom) else ["visual"]
        if _collides(geom) and _is_seen(geom) and not (apart and geom["body"] in decorated):
            made[index] = ["visual", "collision"]
    return made


def _usual_groups(reading: Reading, purposes: Mapping[int, list[str]]) -> dict[str, int]:
    """Return the groups that most geoms have, of those that are seen and of those that collide and are not."""
    geoms, made = reading.facts["geoms"], {}
    for purpose in ("visual", "collision"):
        of_it = [geoms[index] for index, found in purposes.items() if found[0] == purpose]
        counts = Counter(geom["group"] for geom in of_it if not has_our_look(reading, geom))
        if counts:
            made[purpose] = counts.most_common(1)[0][0]
    return made


# What is said by the shape, its place, its layers and its looks, or has gone into the mass of the link.
_SAID = (
    *("name", "type", "pos", "quat", "size", "fromto", "mesh", "hfield", "mass", "density", "shellinertia"),
    *("fitscale", "contype", "conaffinity", "rgba", "material", "group"),
)
_OF_CONTACT = ("friction", "condim", "priority", "solmix", "solref", "solimp", "margin", "gap")
_LOOKS = ("castshadow",)


def _more(reading: Reading, looks: Looks, index: int, shape: Map, purpose: str, purposes: list[str]) -> None:
    """Set what a shape has for a simulation alone; of two that stand for one geom only one has it."""
    geom, element = reading.facts["geoms"][index], reading.places.of("geoms", index)
    said = {key: text for key, text in geom["element"]["attributes"].items() if key not in (*_SAID, *_OF_CONTACT)}
    if len(purposes) > 1:
        said = {key: text for key, text in said.items() if (key in _LOOKS) == (purpose == "visual")}
    ours = has_our_look(reading, geom)
    if purposes[0] == purpose and not ours and geom["group"] != reading.groups[purpose]:
        said["group"] = str(geom["group"])
    elif purposes[0] != purpose and reading.groups.get(purpose, _HIDDEN) != _HIDDEN:
        said["group"] = str(_HIDDEN)  # what is seen of it is the visual
    if purposes == ["collision"] and "rgba" in geom["element"]["attributes"]:
        said["rgba"] = " ".join(repr(tidy(round(value, 7))) for value in geom["rgba"])
    if purposes == ["collision"] and geom["material"] >= 0 and not ours:
        said["material"] = looks.material(geom["material"])
    inner = Map(element.span)
    for name in put_words(inner, said, "mjcf_geom", element):
        reading.lost(f'"{name}" of a geom of link "{reading.link_of[geom["body"]]}"', element.span)
    for word, value in inner.items():
        more = shape.get("mjcf") or Map(element.span)
        put(more, word, value)
        put(shape, "mjcf", more)


class _Layers:
    """Who may touch whom: a layer for each bit of the masks, and how a geom touches."""

    def __init__(self, reading: Reading, geoms: Iterable[int]) -> None:
        self.reading = reading
        masks = [reading.facts["geoms"][index][word] for index in geoms for word in ("contype", "conaffinity")]
        highest = max((_bits(mask)[-1] for mask in masks if mask), default=0)
        self.names = ["default", *(f"layer_{bit}" for bit in range(1, highest + 1))]

    def put(self, index: int, shape: Map, element: Element) -> None:
        """Set how a shape touches."""
        geom = self.reading.facts["geoms"][index]
        entry = Map(element.span)
        for word, key in (("contype", "layers"), ("conaffinity", "touches")):
            if geom[word] != 1:
                put(entry, key, listing([self.names[bit] for bit in _bits(geom[word])], element))
        attributes = geom["element"]["attributes"]
        said = {key: attributes[key] for key in _OF_CONTACT if key in attributes}
        for name in put_words(entry, said, "contact", element):
            self.reading.lost(f'"{name}" of a geom', element.span)
        if entry:
            put(shape, "contact", entry)

    def finish(self) -> None:
        """Set the layers, in the order of their bits."""
        if len(self.names) > 1:
            put(self.reading.tree, "contact_layers", listing(self.names, self.reading.markup.root))


def _bits(mask: int) -> list[int]:
    return [bit for bit in range(32) if mask & (1 << bit)]


def _keep_others(reading: Reading) -> None:
    """Keep the geoms of the robot that the language has no shape for, as they are, with what they name."""
    for index, geom in enumerate(reading.facts["geoms"]):
        if geom["body"] not in reading.link_of or _is_carried(reading, geom) or is_scene(geom):
            continue
        span, link = reading.places.of("geoms", index).span, reading.link_of[geom["body"]]
        reading.kept(whole_geom(reading, geom), f"geom: {_WORDS[geom['type']]}", span, link)


def whole_geom(reading: Reading, geom: Mapping[str, Any]) -> Node:
    """Return a geom as an element that is kept as it is, without mass, in the frame of its file."""
    node = geom["element"]
    said = {key: text for key, text in node["attributes"].items() if key not in ("mass", "density")}
    place = transform(geom["pos"], geom["quat"])
    if geom["type"] in (MESH, SDF):
        mesh = reading.facts["meshes"][geom["data"]]
        place = place.then(transform(mesh["pos"], mesh["quat"]).inverse())
    return {**node, "attributes": {**said, **placing(place), "density": "0"}}


def keep_assets(reading: Reading, node: Node, span: Span) -> None:
    """Keep the assets that an element names which is kept as it is, and those of what stands in it."""
    for kind in ("texture", "material", "mesh", "hfield"):
        _keep_asset(reading, kind, node["attributes"].get(kind, ""), span)
    for inner in node["inner"]:
        keep_assets(reading, inner, span)


def _keep_asset(reading: Reading, kind: str, name: str, span: Span) -> None:
    """Keep a mesh, a height field or a texture that something names which is kept as it is; once."""
    for node in reading.facts["elements"][f"{kind}_assets"]:
        said, called = node["attributes"], _called(node)
        if not name or called != name or (kind, name) in reading.of_scene:
            continue
        reading.of_scene.add((kind, name))
        folder = reading.facts["folders"].get(kind, {}).get(called, "")
        files = {
            word: reading.markup.place_of(posixpath.normpath(posixpath.join(folder, text.replace("\\", "/"))))
            for word, text in said.items()
            if word.startswith("file")
        }
        whole = {"tag": "asset", "attributes": {}, "inner": [{**node, "attributes": said | files}]}
        reading.kept(whole, f"asset: {kind}", span)


def _is_carried(reading: Reading, geom: Mapping[str, Any]) -> bool:
    more = geom["element"]["inner"]  # plugins
    if geom["type"] == MESH:
        mesh = reading.facts["meshes"][geom["data"]]
        more = more or _asset(reading, "mesh", mesh["name"])["inner"]
        if not mesh_file(mesh):
            return False
    return geom["type"] in _CARRIED and geom["body"] in reading.link_of and not more


def is_scene(geom: Mapping[str, Any]) -> bool:
    """Say whether a geom is ground that the robot stands on."""
    return geom["body"] == 0 and geom["type"] in (PLANE, HFIELD)


def has_our_look(reading: Reading, geom: Mapping[str, Any]) -> bool:
    """Say whether a geom collides and is seen in a colour that we have given it, for want of a visual."""
    return geom["class"] in [f"{reading.facts['name']}_{purpose}" for purpose in (SHOWN, SHOWN_WHEEL)]


def _collides(geom: Mapping[str, Any]) -> bool:
    return bool(geom["contype"] or geom["conaffinity"])


def _is_seen(geom: Mapping[str, Any]) -> bool:
    return geom["group"] < _FIRST_HIDDEN_GROUP and geom["rgba"][3] > 0 and "collision" not in geom["class"].lower()


def _groups_apart(geoms: list[Mapping[str, Any]]) -> bool:
    """Say whether the geoms that only are seen have groups of their own."""
    seen = {geom["group"] for geom in geoms if not _collides(geom)}
    return bool(seen) and seen.isdisjoint(geom["group"] for geom in geoms if _collides(geom))


def _shape(reading: Reading, index: int, element: Element) -> Map:
    """Return the entry of a shape."""
    geom = reading.facts["geoms"][index]
    entry = Map(element.span)
    place = transform(geom["pos"], geom["quat"])
    if geom["type"] == MESH:
        mesh = reading.facts["meshes"][geom["data"]]
        made = Map(element.span)
        put(made, "file", reading.markup.place_of(mesh_file(mesh)))
        scale = tidy_vector(mesh["scale"])
        if scale != (1, 1, 1):
            put(made, "scale", numbers(scale, reading.markup.named("asset", mesh["name"]) or element, "scale"))
        if mesh["taken"]:
            put(made, "inertia", mesh["taken"])
        more = Map(element.span)
        put_words(more, _of_mesh(reading, mesh), "mjcf_mesh", element)
        if more:
            put(made, "mjcf", more)
        put(entry, "mesh", made)
        place = place.then(frame_of_file(mesh))
    else:
        put(entry, _WORDS[geom["type"]], _sizes(geom["type"], geom["size"], element))
    if geom["name"]:
        put(entry, "name", legal(geom["name"]))
    put_pose(entry, place, element)
    return entry


def _of_mesh(reading: Reading, mesh: Mapping[str, Any]) -> dict[str, str]:
    """Return what a mesh says beside its file, its size and where it is counted from."""
    said = _asset(reading, "mesh", mesh["name"])["attributes"]
    wanted = ("maxhullvert", "smoothnormal", *(() if PurePosixPath(mesh["file"]).suffix else ("content_type",)))
    return {key: said[key] for key in wanted if key in said}


def _asset(reading: Reading, kind: str, name: str) -> Node:
    """Return the element of a mesh, a texture or a material by its name, which may be that of its file."""
    for node in reading.facts["elements"][f"{kind}_assets"]:
        if name and _called(node) == name:
            return cast("Node", node)
    return {"tag": kind, "attributes": {}, "inner": []}


def _called(asset: Node) -> str:
    """Return the name of a mesh, a texture or a material, which may be that of its file."""
    said = asset["attributes"]
    return said.get("name") or PurePosixPath(said.get("file", "")).stem


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


class Looks:
    """Colours and materials: those that shapes use, and what else the file says of them.

    What the language cannot say of a texture or a material is kept as it is, and the material names it.
    """

    def __init__(self, reading: Reading) -> None:
        self.reading = reading
        self.materials = Map(reading.markup.root.span)

    def put(self, index: int, shape: Map, element: Element) -> None:
        """Set the colour of a visual: its own, or its material."""
        geom = self.reading.facts["geoms"][index]
        rgba = tuple(tidy(round(value, 7)) for value in geom["rgba"])  # MuJoCo keeps colours with seven digits
        at = geom["material"]
        whole = at >= 0 and self._is_whole(at)
        if rgba == _NO_COLOUR and whole:
            rgba = tuple(tidy(round(value, 7)) for value in self.reading.facts["materials"][at]["rgba"])
        elif rgba == _NO_COLOUR:
            if at >= 0:
                put(shape, "material", self.material(at))
            return
        put(shape, "rgba", numbers(rgba, element, "rgba"))
        texture = self.reading.facts["materials"][at]["texture"] if at >= 0 else ""
        if texture:
            put(shape, "texture", self.reading.markup.place_of(texture))
        if at >= 0 and (texture or whole or self._said(at)):
            more = Map(element.span)
            put(more, "material", self.material(at))
            put(shape, "mjcf", more)

    def _is_whole(self, index: int) -> bool:
        """Say whether a material has layers of textures, for which it is kept as it is."""
        name = self.reading.facts["materials"][index]["name"]
        return bool(_asset(self.reading, "material", name)["inner"])

    def _said(self, index: int) -> dict[str, str]:
        """Return what a material says beside its colour, and an image that the language has words for."""
        material = self.reading.facts["materials"][index]
        said = _asset(self.reading, "material", material["name"])["attributes"]
        plain = material["texture"] and self._is_plain(said.get("texture", ""))
        known = ("name", "rgba", "texture") if plain else ("name", "rgba")
        return {key: text for key, text in said.items() if key not in known}

    def _is_plain(self, texture: str) -> bool:
        """Say whether a texture is an image and nothing else."""
        said = _asset(self.reading, "texture", texture)["attributes"]
        written = self.reading.markup.named("asset", texture)
        plain = said.keys() <= {"name", "type", "file", "colorspace", "content_type"} and said.get("type") == "2d"
        return bool(plain and not (written and written.get("colorspace")) and texture_path(said.get("file", "")))

    def material(self, index: int) -> str:
        """Return the name of a material, which the description has from now on."""
        reading = self.reading
        material = reading.facts["materials"][index]
        if index in reading.material_of:
            return reading.material_of[index]
        if self._is_whole(index):
            element = reading.markup.named("asset", material["name"]) or reading.markup.root
            _keep_asset(reading, "material", material["name"], element.span)
            return str(material["name"])
        own = material["name"].removeprefix(f"{reading.facts['name']}_" if reading.is_ours else "") or material["name"]
        known = reading.material_of[index] = reading.name("material", own)
        reading.renamed.setdefault("material", {})[material["name"]] = known
        element = reading.markup.named("asset", material["name"]) or reading.markup.root
        entry = Map(element.span)
        put(entry, "rgba", numbers([tidy(round(value, 7)) for value in material["rgba"]], element, "rgba"))
        if material["texture"]:
            put(entry, "texture", reading.markup.place_of(material["texture"]))
        said = self._said(index)
        made = said.pop("texture", "")
        for name in put_words(entry, said, "material", element):
            reading.lost(f'"{name}" of the material "{known}"', element.span)
        if made:
            more = entry.get("mjcf") or Map(element.span)
            put(more, "texture", made)
            put(entry, "mjcf", more)
            _keep_asset(reading, "texture", made, element.span)
        put(self.materials, known, entry)
        return known

    def finish(self) -> None:
        """Set the materials: those of shapes, and those that sites and tendons have, or nobody."""
        scene: set[int] = set()
        own: set[int] = set()
        ours: set[int] = set()
        for geom in self.reading.facts["geoms"]:
            carried = own if _is_carried(self.reading, geom) else scene
            (ours if has_our_look(self.reading, geom) else carried).add(geom["material"])
        indices = range(len(self.reading.facts["materials"]))
        for index in (at for at in indices if at in own or at not in scene | ours):
            self.material(index)
        if scene - own - {-1}:
            element = self.reading.markup.sections("asset")[:1] or [self.reading.markup.root]
            message = f"{counted(len(scene - own - {-1}), 'material')} of the world: the scene is no part of the robot"
            self.reading.ignored(message, element[0].span)
        _tell_of_textures(self.reading)
        if self.materials:
            put(self.reading.tree, "materials", self.materials)


def _tell_of_textures(reading: Reading) -> None:
    """Say which textures are not carried, for nothing has them but the scene, such as its sky."""
    assets = reading.facts["elements"]
    used = {name for kind, name in reading.of_scene if kind == "texture"}
    for material in assets["material_assets"]:
        used |= {one["attributes"].get("texture", "") for one in (material, *material["inner"])}
    names = [_called(texture) for texture in assets["texture_assets"]]
    unused = [name for name in names if not name or name not in used]
    if unused:
        elements = reading.markup.listed("asset", "texture") or [reading.markup.root]
        element = next((one for one in elements if one.get("name") == unused[0]), elements[0])
        message = f"{counted(len(unused), 'texture')} that no material has: the scene is no part of the robot"
        reading.ignored(message, element.span)


def _tell(reading: Reading) -> None:
    """Say which geoms are not carried, for they are those of the scene."""
    scene = []
    for index, geom in enumerate(reading.facts["geoms"]):
        if geom["body"] not in reading.link_of or is_scene(geom):
            scene.append(index)
    used = {geom["data"] for geom in reading.facts["geoms"] if geom["type"] in (MESH, SDF)}
    named = {site["element"]["attributes"].get("mesh") for site in reading.facts["sites"]}
    unused = [mesh for at, mesh in enumerate(reading.facts["meshes"]) if at not in used and mesh["name"] not in named]
    if unused:
        element = (
            reading.markup.named("asset", unused[0]["name"])
            or (reading.markup.sections("asset") or [reading.markup.root])[0]
        )
        reading.ignored(f"{counted(len(unused), 'mesh')} that no geom has", element.span)
    if scene:
        message = f"{counted(len(scene), 'geom')} of the world: the scene is no part of the robot"
        reading.ignored(message, reading.places.of("geoms", scene[0]).span)
