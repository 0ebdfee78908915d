"""Links of URDF: inertial, visuals and collisions as entries of ``links`` (http://wiki.ros.org/urdf/XML/link)."""

from __future__ import annotations

from rosorin_compile.source.diagnostics import NOTE, Diagnostic
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.tree import Map, Path, Seq
from rosorin_compile.source.wording import counted, listed, plural, quoted
from rosorin_compile.source.xml.markup import Element

from .grammar import NUMBERS, SHAPES, attributes
from .materials import put_material
from .reading import NAME, Reading, check_element, named, put
from .values import PLAIN, number_of, put_all, put_numbers, put_origin, shortened

RULES = (
    Rule("missing-element", "An element lacks another that the specification asks for.", "Add it.", READING),
    Rule("import-kept", "A note: a shape of another kind is kept as it is.", topic=READING),
)

_PRODUCTS = ("ixy", "ixz", "iyz")


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
    check_element(element, reading, entry)
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
        check_element(mass, reading)
        reading.need(mass, "value")
        put_numbers(entry, mass, "value", reading, "mass")
        reading.paths[id(mass)] = (*path, "inertial", "mass")
    put_origin(entry, element, (*path, "inertial"), reading)
    if inertia is not None:
        put(entry, "inertia", _inertia(inertia, reading), inertia)
        reading.paths[id(inertia)] = (*path, "inertial", "inertia")
    check_element(element, reading)
    if mass is not None and inertia is not None and not reading.spoilt(element, "the inertial", before):
        put(link, "inertial", entry, element)


def _inertia(element: Element, reading: Reading) -> Map:
    """Return the moments of an <inertia>."""
    moments = Map(element.span)
    reading.check(element, (), (*NUMBERS["inertia"], *_mirrored(element, reading)), None)
    missing = reading.missing(element, *NUMBERS["inertia"])
    put_all(moments, element, reading)
    if missing and all(name in _PRODUCTS for name in missing):
        message = f"{named(element)} lacks the {plural('attribute', len(missing))} {quoted(missing)}"
        help = "add " + " ".join(f'{name}="0"' for name in missing) + ", if that is meant"
        if reading.lenient("missing-attribute", message, element.span, help, "takes 0"):
            for name in missing:
                moments.put(name, 0, element.span, element.span)
    elif missing:
        reading.need(element, *NUMBERS["inertia"])
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
    material = reading.single(element, "material") if element.tag == "visual" else None
    if material is not None:
        reading.paths[id(material)] = (*own, "material")
        put_material(entry, material, reading)
    check_element(element, reading, entry)
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
    solids = [child for child in geometry.children if child.tag in SHAPES]
    if len(solids) > 1:
        message = f"{named(geometry)} has {listed(f'<{child.tag}>' for child in solids)}; it takes one"
        reading.error("duplicate-element", message, solids[1].span, "make a second <visual> or <collision> of it")
        return None
    if not solids and geometry.children:
        before = len(reading.diagnostics)
        check_element(geometry, reading, Map(geometry.span))
        broken = any(diagnostic.severity == "error" for diagnostic in reading.diagnostics[before:])
        return None if broken else geometry
    if not solids:
        message = f"{named(geometry)} is empty"
        reading.error("missing-element", message, geometry.span, f"it takes one of {', '.join(SHAPES)}")
        return None
    check_element(geometry, reading)
    shape = solids[0]
    made = Map(shape.span)
    check_element(shape, reading)
    if shape.tag == "mesh":
        _mesh(shape, made, reading)
    else:
        reading.need(shape, *attributes(shape.tag))
        put_all(made, shape, reading)
    put(entry, shape.tag, made, shape)
    return shape


def _mesh(shape: Element, made: Map, reading: Reading) -> None:
    file = reading.attribute(shape, "filename")
    if file is not None:
        attribute = shape.attributes["filename"]
        made.put("file", file, attribute.name_span, attribute.span)
        if not file.strip():
            reading.error("missing-attribute", f"filename of {named(shape)} is empty", attribute.span, "name a mesh")
    if len(shape.attributes["scale"].words() if "scale" in shape.attributes else ()) in (0, 3):
        put_numbers(made, shape, "scale", reading)
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
