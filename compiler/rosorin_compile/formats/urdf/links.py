"""Links of URDF: inertial, visuals and collisions as entries of ``links`` (http://wiki.ros.org/urdf/XML/link)."""

from __future__ import annotations

from collections.abc import Callable

from ...diagnostics import NOTE, Diagnostic
from ...diagnostics.registry import READING, Rule
from ...diagnostics.wording import counted, listed, plural, quoted
from ...frontend.tree import Map, Path, Seq
from ...xml.markup import Element
from .materials import put_material
from .reading import NAME, Reading, named, put
from .values import LENGTHS, PLAIN, need_numbers, number_of, put_number, put_numbers, put_origin, shortened

RULES = (
    Rule("missing-element", "An element lacks another that the specification asks for.", "Add it.", READING),
    Rule("import-kept", "A note: a shape of another kind is kept as it is.", topic=READING),
)

_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_PRODUCTS = ("ixy", "ixz", "iyz")
_SHAPES = ("box", "cylinder", "sphere", "capsule", "mesh")


def read_link(element: Element, path: Path, reading: Reading) -> Map:
    """Return the entry of a <link>."""
    entry = Map(element.span)
    inertial = reading.single(element, "inertial")
    if inertial is not None:
        _inertial(inertial, entry, path, reading)
    for purpose in ("visual", "collision"):
        for child in element.children:
            if child.tag == purpose:
                _solid(child, entry, path, reading)
    reading.known(element, ("inertial", "visual", "collision"), ("name",), entry)
    return entry


def _inertial(element: Element, link: Map, path: Path, reading: Reading) -> None:
    """Set the inertial of a link. Mass and all six moments have to be there, as for urdfdom.

    Leniently, one that cannot be read is left out, as urdfdom does; products that are not said are 0.
    """
    entry = Map(element.span)
    reading.paths[id(element)] = (*path, "inertial")
    before = len(reading.diagnostics)
    mass = _one(element, "mass", reading)
    inertia = _one(element, "inertia", reading)
    if mass is not None:
        reading.known(mass, (), ("value",), None)
        reading.need(mass, "value")
        put_number(entry, "mass", mass, "value", PLAIN, reading)
        reading.paths[id(mass)] = (*path, "inertial", "mass")
    put_origin(entry, element, (*path, "inertial"), reading)
    if inertia is not None:
        put(entry, "inertia", _inertia(inertia, reading), inertia)
        reading.paths[id(inertia)] = (*path, "inertial", "inertia")
    reading.known(element, ("origin", "mass", "inertia"), (), None)
    if mass is not None and inertia is not None and not reading.spoilt(element, "the inertial", before):
        put(link, "inertial", entry, element)


def _inertia(element: Element, reading: Reading) -> Map:
    """Return the moments of an <inertia>."""
    moments = Map(element.span)
    reading.known(element, (), (*_MOMENTS, *_mirrored(element, reading)), None)
    missing = reading.missing(element, *_MOMENTS)
    need_numbers(moments, element, [name for name in _MOMENTS if name in element.attributes], PLAIN, reading)
    if missing and all(name in _PRODUCTS for name in missing):
        message = f"{named(element)} lacks the {plural('attribute', len(missing))} {quoted(missing)}"
        help = "add " + " ".join(f'{name}="0"' for name in missing) + ", if that is meant"
        if reading.lenient("missing-attribute", message, element.span, help, "takes 0"):
            for name in missing:
                moments.put(name, 0, element.span, element.span)
    elif missing:
        reading.need(element, *_MOMENTS)
    return moments


def _mirrored(inertia: Element, reading: Reading) -> list[str]:
    """Return the products that say again, as iyx, what ixy says."""
    names: list[str] = []
    for name in ("iyx", "izx", "izy"):
        if name in inertia.attributes and inertia.get(name) == inertia.get(f"i{name[2]}{name[1]}"):
            reading.ignored("iyx, izx and izy of <inertia> say again what ixy, ixz and iyz say", inertia.span)
            names.append(name)
    return names


def _one(element: Element, tag: str, reading: Reading) -> Element | None:
    """Return a child of an inertial that has to be there."""
    inner = reading.single(element, tag)
    if inner is None and reading.options.lenient:
        reading.cannot_carry(f"{named(element)}, which lacks <{tag}>,", element.span)
    elif inner is None:
        message = f"{named(element)} lacks <{tag}>"
        help = f"add <{tag}>, or remove <inertial> of a frame without mass; --lenient leaves the inertial out"
        reading.error("missing-element", message, element.span, help)
    return inner


def _solid(element: Element, link: Map, path: Path, reading: Reading) -> None:
    """Add a <visual> or a <collision> to its list; kept whole where the language has no word for its geometry."""
    geometry = reading.single(element, "geometry")
    if geometry is None:
        message = f"{named(element)} has no <geometry>"
        if reading.lenient("missing-element", message, element.span, "add one, or remove it", "keeps it as it is"):
            reading.keep(element, link)
        return
    entry = Map(element.span)
    shape = _shape(geometry, entry, reading)
    if shape is None:
        return
    if shape is geometry:
        what = listed(f"<{child.tag}>" for child in geometry.children)
        message = f"{what} of {named(element)} is a shape of its own kind: kept as it is"
        reading.diagnostics.append(Diagnostic("import-kept", NOTE, message, geometry.span))
        reading.keep(element, link)
        return
    _solid_name(element, entry, reading)
    if element.tag not in link:
        put(link, element.tag, Seq(element.span), element)
    own = (*path, element.tag, len(link[element.tag]))
    reading.paths[id(element)] = own
    reading.paths[id(geometry)] = reading.paths[id(shape)] = (*own, shape.tag)
    put_origin(entry, element, own, reading)
    words = ["origin", "geometry"]
    if element.tag == "visual":
        words.append("material")
        material = reading.single(element, "material")
        if material is not None:
            reading.paths[id(material)] = (*own, "material")
            put_material(entry, material, reading)
    reading.known(element, words, ("name",), entry)
    link[element.tag].put(entry, element.span)


def _solid_name(element: Element, entry: Map, reading: Reading) -> None:
    attribute = element.attributes.get("name")
    if attribute is None or not attribute.value:
        return
    if NAME.match(attribute.value):
        entry.put("name", attribute.value, attribute.name_span, attribute.span)
    else:
        reading.cannot_carry(f"the name {shortened(attribute.value)} of <{element.tag}>", attribute.span)


def _shape(geometry: Element, entry: Map, reading: Reading) -> Element | None:
    """Set the shape of an entry and return its element; None after an error, the geometry if no reader knows it."""
    known = [child for child in geometry.children if child.tag in _SHAPES]
    if len(known) > 1:
        message = f"{named(geometry)} has {listed(f'<{child.tag}>' for child in known)}; it takes one"
        reading.error("duplicate-element", message, known[1].span, "make a second <visual> or <collision> of it")
        return None
    if not known and geometry.children:
        before = len(reading.diagnostics)
        reading.known(geometry, _SHAPES, (), Map(geometry.span))
        broken = any(diagnostic.severity == "error" for diagnostic in reading.diagnostics[before:])
        return None if broken else geometry
    if not known:
        message = f"{named(geometry)} is empty"
        reading.error("missing-element", message, geometry.span, f"it takes one of {', '.join(_SHAPES)}")
        return None
    reading.known(geometry, _SHAPES, (), None)
    shape = known[0]
    made = Map(shape.span)
    _READERS[shape.tag](shape, made, reading)
    put(entry, shape.tag, made, shape)
    return shape


def _box(shape: Element, made: Map, reading: Reading) -> None:
    reading.known(shape, (), ("size",), None)
    if reading.attribute(shape, "size") is not None:
        put_numbers(made, "size", shape, "size", 3, LENGTHS, reading)


def _round(shape: Element, made: Map, reading: Reading) -> None:
    names = ("radius",) if shape.tag == "sphere" else ("radius", "length")
    reading.known(shape, (), names, None)
    need_numbers(made, shape, names, LENGTHS, reading)


def _mesh(shape: Element, made: Map, reading: Reading) -> None:
    reading.known(shape, (), ("filename", "scale"), None)
    file = reading.attribute(shape, "filename")
    if file is not None:
        attribute = shape.attributes["filename"]
        made.put("file", file, attribute.name_span, attribute.span)
        if not file.strip():
            reading.error("missing-attribute", f"filename of {named(shape)} is empty", attribute.span, "name a mesh")
    if len(shape.attributes["scale"].words() if "scale" in shape.attributes else ()) in (0, 3):
        put_numbers(made, "scale", shape, "scale", 3, PLAIN, reading)
    else:
        _other_scale(shape, made, reading)


def _other_scale(shape: Element, made: Map, reading: Reading) -> None:
    """Set a scale of one number, which stands for all three, or of more than three; a URDF has three."""
    attribute = shape.attributes["scale"]
    words = attribute.words()
    values = [number_of(word, PLAIN, shape, "scale", reading) for word in words]
    if None in values:
        return
    instead = "takes the first three" if len(words) > 1 else "takes it for all three"
    message = f"scale of {named(shape)} has {counted(len(words), 'number')}; it takes 3"
    if len(words) == 2:
        reading.error("wrong-count", message, attribute.span, "give 3")
    elif reading.lenient("wrong-count", message, attribute.span, "give 3", instead):
        scale = Seq(attribute.span)
        for value, word in zip((values * 3)[:3], (words * 3)[:3], strict=True):
            scale.put(value, word.span)
        made.put("scale", scale, attribute.name_span, attribute.span)


_READERS: dict[str, Callable[[Element, Map, Reading], None]] = {
    "box": _box,
    "cylinder": _round,
    "capsule": _round,
    "sphere": _round,
    "mesh": _mesh,
}
