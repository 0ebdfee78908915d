"""Import geoms as visuals, collision shapes, or both.

A geom that cannot collide (``contype`` and ``conaffinity`` 0) is a visual. Any other geom is a collision shape. It is
also a visual, unless it is in a group that viewers hide (3 to 5) or transparent, its class has "collision" in its name,
or its body has separate visuals and the model uses different groups for the two. Geoms, textures and materials
that a description cannot express are kept as XML.
"""

import posixpath
from collections import Counter
from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.markup import Element

from . import convert
from .import_state import ImportState
from .unsupported import texture_path

_PLANE, _HFIELD, _SPHERE, _CAPSULE, _ELLIPSOID, _CYLINDER, _BOX, _MESH, _SDF = range(9)
_WORDS = ("plane", "height field", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf")
_CARRIED = (_SPHERE, _CAPSULE, _ELLIPSOID, _CYLINDER, _BOX, _MESH)
_HIDDEN = 3  # the first group that viewers hide
_NO_COLOUR = [0.5, 0.5, 0.5, 1.0]  # MuJoCo's default; a geom of this colour has the colour of its material
# Geom attributes that are imported as the shape, pose or appearance, or as the mass of the link.
_READ = {"name", "type", "pos", "quat", "size", "fromto", "mesh", "hfield", "mass", "density", "shellinertia"}
_READ |= {"fitscale", "contype", "conaffinity", "rgba", "material", "group"}
_OF_CONTACT = ("friction", "condim", "priority", "solmix", "solref", "solimp", "margin", "gap")
_PLAIN_IMAGE = {"name", "type", "file", "colorspace", "content_type"}

ASSETS = ("texture", "material", "mesh", "hfield")
Thing = Mapping[str, Any]


def add_shapes(state: ImportState) -> None:
    """Add the shapes of all links, and the materials that they use."""
    geoms = state.facts["geoms"]
    carried = {index: geom for index, geom in enumerate(geoms) if _is_carried(state, geom)}
    only_seen = [geom for geom in carried.values() if not _collides(geom)]
    seen_groups, decorated = {geom["group"] for geom in only_seen}, {geom["bodyid"] for geom in only_seen}
    solid_groups = {geom["group"] for geom in carried.values() if _collides(geom)}
    are_apart = bool(seen_groups) and seen_groups.isdisjoint(solid_groups)
    purposes = dict[int, list[str]]()  # "visual", "collision" or both, for each geom
    for index, geom in carried.items():
        is_visible = geom["group"] < _HIDDEN and geom["rgba"][3] > 0 and "collision" not in geom["class"].lower()
        is_seen = not _collides(geom) or (is_visible and not (are_apart and geom["bodyid"] in decorated))
        purposes[index] = ["visual"] * is_seen + ["collision"] * _collides(geom)
    for purpose in ("visual", "collision"):  # the most common group is the default
        if counts := Counter(geoms[index]["group"] for index, found in purposes.items() if found[0] == purpose):
            state.groups[purpose] = counts.most_common(1)[0][0]
    held: dict[tuple[str, str], Seq] = {}
    for index, found in purposes.items():
        element, geom = state.places.place_of("geoms", index), geoms[index]
        for purpose in found:
            shape = _shape(state, geom, element)
            if purpose == "visual":
                _put_look(state, geom, shape, element)
            else:
                attributes, bits = geom["element"]["attributes"], ("contype", "conaffinity")
                contact = convert.map_entry({word: geom[word] for word in bits if geom[word] != 1}, element)
                own = {key: attributes[key] for key in _OF_CONTACT if key in attributes}
                state.put_words(contact, own, "contact", element, "a geom")
                convert.put_some(shape, "contact", contact)
            _put_more(state, geom, shape, element, found, purpose)
            held.setdefault((state.link_of[geom["bodyid"]], purpose), Seq(element.span)).put(shape, element.span)
    for (link, purpose), shapes in held.items():
        convert.put_value(state.links[link], purpose, shapes)
    for index, geom in enumerate(geoms):
        if geom["bodyid"] in state.link_of and index not in carried and not is_scene(geom):
            span, link = state.places.place_of("geoms", index).span, state.link_of[geom["bodyid"]]
            state.keep(whole_geom(state, geom), f"geom: {_WORDS[geom['type']]}", span, link)
    _add_unused(state)


def _put_more(state: ImportState, geom: Thing, shape: Map, element: Element, purposes: list[str], purpose: str) -> None:
    attributes = geom["element"]["attributes"]
    more = {key: text for key, text in attributes.items() if key not in (*_READ, *_OF_CONTACT)}
    if len(purposes) > 1:
        more = {key: text for key, text in more.items() if (key == "castshadow") == (purpose == "visual")}
    if purposes[0] == purpose and geom["group"] != state.groups[purpose]:
        more["group"] = str(geom["group"])
    elif purposes[0] != purpose and state.groups.get(purpose, _HIDDEN) != _HIDDEN:
        more["group"] = str(_HIDDEN)  # hidden, because viewers show the visual
    if purposes == ["collision"]:
        more |= {"rgba": " ".join(map(repr, _colour(geom)))} if "rgba" in attributes else {}
        more |= {"material": _material(state, geom["matid"])} if geom["matid"] >= 0 else {}
    inner = Map(element.span)
    state.put_words(inner, more, "mjcf_geom", element, f'a geom of link "{state.link_of[geom["bodyid"]]}"')
    for word, value in inner.items():
        convert.put_inner(shape, word, value)


def _colour(thing: Thing) -> list[float]:
    return [convert.tidy(round(value, 7)) for value in thing["rgba"]]


def whole_geom(state: ImportState, geom: Thing) -> convert.Node:
    """Return a geom without mass as an XML node; the pose of a mesh is that of its file, not of its principal axes."""
    node, place = geom["element"], convert.transform(geom["pos"], geom["quat"])
    attributes = {key: text for key, text in node["attributes"].items() if key not in ("mass", "density")}
    if geom["type"] in (_MESH, _SDF):
        mesh = state.facts["meshes"][geom["dataid"]]
        place = place.then(convert.transform(mesh["pos"], mesh["quat"]).inverse())
    return {**node, "attributes": {**attributes, **convert.pose_attributes(place), "density": "0"}}


def keep_asset(state: ImportState, kind: str, name: str, span: Span) -> None:
    """Keep an asset as XML, unless it is kept already; ``span`` is the position of the element that refers to it."""
    node = _asset(state, kind, name)
    if not node["attributes"] or (kind, name) in state.of_scene:
        return
    state.of_scene.add((kind, name))
    named = {word: text for word, text in node["attributes"].items() if word.startswith("file")}
    files = {word: state.markup.place_of(posixpath.normpath(text)) for word, text in named.items()}
    state.keep_in_section("asset", {**node, "attributes": node["attributes"] | files}, f"asset: {kind}", span)


def _asset(state: ImportState, kind: str, name: str) -> convert.Node:
    nodes: list[convert.Node] = state.facts["elements"][f"{kind}_assets"] if name else []
    return next((one for one in nodes if _asset_name(one) == name), {"tag": kind, "attributes": {}, "inner": []})


def _asset_name(asset: convert.Node) -> str:
    attributes = asset["attributes"]
    return attributes.get("name") or PurePosixPath(attributes.get("file", "")).stem


def _is_carried(state: ImportState, geom: Thing) -> bool:
    mesh = state.facts["meshes"][geom["dataid"]] if geom["type"] == _MESH else None
    if mesh and (not _mesh_file(mesh) or _asset(state, "mesh", mesh["name"])["inner"]):
        return False
    return geom["type"] in _CARRIED and geom["bodyid"] in state.link_of and not geom["element"]["inner"]  # no plugins


def is_scene(geom: Thing) -> bool:
    """Return True if a geom is part of the scene, not of the robot: a plane or height field of the world."""
    return geom["bodyid"] == 0 and geom["type"] in (_PLANE, _HFIELD)


def _collides(geom: Thing) -> bool:
    return bool(geom["contype"] or geom["conaffinity"])


def _shape(state: ImportState, geom: Thing, element: Element) -> Map:
    entry, sizes, place = Map(element.span), Map(element.span), convert.transform(geom["pos"], geom["quat"])
    kind, size = geom["type"], geom["size"]
    if kind == _MESH:
        mesh = state.facts["meshes"][geom["dataid"]]
        convert.put_value(sizes, "file", state.markup.place_of(_mesh_file(mesh)))
        if (scale := convert.tidy_vector(mesh["scale"])) != (1, 1, 1):
            asset = state.markup.find("asset", mesh["name"]) or element
            convert.put_value(sizes, "scale", convert.numbers(scale, asset, "scale"))
        convert.put_some(sizes, "inertia", mesh["taken"])
        attributes, more = _asset(state, "mesh", mesh["name"])["attributes"], Map(element.span)
        words = ("maxhullvert", "smoothnormal", *(() if PurePosixPath(mesh["file"]).suffix else ("content_type",)))
        convert.put_words(more, {key: attributes[key] for key in words if key in attributes}, "mjcf_mesh", element)
        convert.put_some(sizes, "mjcf", more)
        # MuJoCo subtracts ``refpos`` from the vertices, rotates them by ``refquat``, scales them, and then expresses
        # them in the frame of ``pos`` and ``quat``. Here, scaling comes first (see ``_mesh_file``).
        reference = convert.transform(mesh["reference"]["pos"], mesh["reference"]["quat"]).inverse()
        x, y, z = (a * b for a, b in zip(mesh["scale"], reference.xyz, strict=True))
        of_file = Transform(reference.rows, (x, y, z))
        place = place.then(convert.transform(mesh["pos"], mesh["quat"]).inverse().then(of_file))
    elif kind == _BOX:
        convert.put_value(sizes, "size", convert.numbers([convert.tidy(2 * half) for half in size], element))
    elif kind == _ELLIPSOID:
        convert.put_value(sizes, "radii", convert.numbers([convert.tidy(radius) for radius in size], element, "size"))
    else:
        convert.put_number(sizes, "radius", convert.tidy(size[0]), element, "size")
        if kind != _SPHERE:
            convert.put_number(sizes, "length", convert.tidy(2 * size[1]), element)
    convert.put_value(entry, _WORDS[kind], sizes)
    if geom["name"]:
        convert.put_value(entry, "name", convert.legal(geom["name"]))
    convert.put_pose(entry, place, element)
    return entry


def _mesh_file(mesh: Thing) -> str:
    """Return the file of a mesh, or "" if it has none or its rotation and nonuniform scale do not commute."""
    is_stretched = any(mesh["reference"]["quat"][1:]) and len(set(mesh["scale"])) > 1
    return posixpath.normpath(mesh["file"]) if mesh["file"] and not is_stretched else ""


def _put_look(state: ImportState, geom: Thing, shape: Map, element: Element) -> None:
    rgba, at = _colour(geom), geom["matid"]
    if at < 0:
        if rgba != _NO_COLOUR:
            convert.put_value(shape, "rgba", convert.numbers(rgba, element, "rgba"))
        return
    material = state.facts["materials"][at]
    is_layered, texture = bool(_asset(state, "material", material["name"])["inner"]), material["texture"]
    if rgba == _NO_COLOUR and not is_layered:
        convert.put_value(shape, "material", _material(state, at))
        return
    convert.put_value(
        shape, "rgba", convert.numbers(_colour(material) if rgba == _NO_COLOUR else rgba, element, "rgba")
    )
    convert.put_some(shape, "texture", texture and state.markup.place_of(texture))
    if texture or is_layered or _more_of_material(state, material):
        convert.put_inner(shape, "material", _material(state, at))


def _more_of_material(state: ImportState, material: Thing) -> dict[str, str]:
    attributes = _asset(state, "material", material["name"])["attributes"]
    texture = attributes.get("texture", "")
    image, written = _asset(state, "texture", texture)["attributes"], state.markup.find("asset", texture)
    is_plain = image.keys() <= _PLAIN_IMAGE and image.get("type") == "2d" and material["texture"]
    is_plain = is_plain and not (written and written.get("colorspace")) and texture_path(image.get("file", ""))
    known = ("name", "rgba", "texture") if is_plain else ("name", "rgba")
    return {key: text for key, text in attributes.items() if key not in known}


def _material(state: ImportState, index: int) -> str:
    """Return the name of a material after adding it to the description, or as XML if it has layers."""
    material = state.facts["materials"][index]
    name = str(material["name"])
    if index in state.material_of:
        return state.material_of[index]
    element = state.markup.find("asset", name) or state.markup.root
    if _asset(state, "material", name)["inner"]:
        keep_asset(state, "material", name, element.span)
        return name
    given = state.material_of[index] = state.name("material", name)
    state.renamed.setdefault("material", {})[name] = given
    more, file = _more_of_material(state, material), material["texture"]
    entry = convert.map_entry({"rgba": convert.numbers(_colour(material), element, "rgba")}, element)
    convert.put_some(entry, "texture", file and state.markup.place_of(file))
    texture = more.pop("texture", "")
    state.put_words(entry, more, "material", element, f'the material "{given}"')
    if texture:
        convert.put_inner(entry, "texture", texture)
        keep_asset(state, "texture", texture, element.span)
    convert.put_value(state.materials, given, entry)
    return given


def _add_unused(state: ImportState) -> None:
    geoms, markup, assets = state.facts["geoms"], state.markup, state.facts["elements"]
    left = {geom["matid"] for geom in geoms} - {geom["matid"] for geom in geoms if _is_carried(state, geom)} - {-1}
    for index in range(len(state.facts["materials"])):
        if index in left:
            state.scene.append(("material", markup.first("asset").span))
        else:
            _material(state, index)
    convert.put_some(state.tree, "materials", state.materials)
    textures = {name for kind, name in state.of_scene if kind == "texture"}
    for material in assets["material_assets"]:
        textures |= {one["attributes"].get("texture", "") for one in (material, *material["inner"])}
    for name in map(_asset_name, assets["texture_assets"]):
        if not name or name not in textures:
            state.scene.append(("texture", (markup.find("asset", name) or markup.first("asset")).span))
    shaped = {geom["dataid"] for geom in geoms if geom["type"] in (_MESH, _SDF)}
    for mesh in (mesh for index, mesh in enumerate(state.facts["meshes"]) if index not in shaped):
        keep_asset(state, "mesh", mesh["name"], (markup.find("asset", mesh["name"]) or markup.first("asset")).span)
    for index, geom in enumerate(geoms):
        if geom["bodyid"] not in state.link_of or is_scene(geom):
            state.scene.append(("geom", state.places.place_of("geoms", index).span))
