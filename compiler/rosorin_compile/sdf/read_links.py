"""Links of an SDF as entries of ``links``: inertials, visuals, collisions and how they look."""

from __future__ import annotations

import os
from typing import Any, NamedTuple

from rosorin_compile.formats.format import Placed
from rosorin_compile.formats.urdf.reading import NAME
from rosorin_compile.model import Transform
from rosorin_compile.rules.urdf_elements import sdf_elements
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, counted, first_of, has_errors, listed
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.xml.markup import Element, correction, named

from .bodies import Bodies
from .elements import OF_LINK, keep, wrapped
from .models import FRAME, LINK, Node, Scope, relative_to
from .reading import WrittenPose, is_true

RULES = (Rule("sdf-inertia", "An inertial is to be computed from meshes.", "Say mass and inertia.", Heading.READING),)

_INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
# The sizes of solids, with how many numbers each is.
_SOLIDS = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "ellipsoid": {"radii": 3},
    "mesh": {"scale": 3},
}
_OUTLINE = "polyline"  # a geometry may have several: one within another is a hole in it
_WATER = 1000  # kg/m^3, the density of an inertial that is to be computed and has none


class Entries(NamedTuple):
    """The entries of links and joints by name, and elements for Gazebo by the link or joint that they refer to."""

    links: dict[str, dict[str, Any]]
    joints: dict[str, Placed]
    gazebo: dict[str, list[tuple[Element, str]]]


class Links:
    """Reads the links of a model into entries."""

    def __init__(self, bodies: Bodies, entries: Entries) -> None:
        self.bodies, self.entries = bodies, entries
        self.models, self.reading = bodies.models, bodies.reading
        self.without_mass: list[Node] = []

    def read(self) -> None:
        """Fill the entries of all links."""
        for link in self.bodies.links:
            element = link.element
            self._inertial(link, self.entries.links[link.called])
            for child in element.children:
                if child.tag in ("visual", "collision"):
                    self._shape(child, link)
            for child in self.reading.rest(element, ("pose", "inertial", "visual", "collision"), ("name",)):
                if child.tag in OF_LINK:
                    pose = self.reading.single(child, "pose")
                    owner = self._owner(pose, link)
                    text = self.models.text_of(child, link.scope, None if owner is link else pose)
                    self.entries.gazebo.setdefault(owner.called, []).append((child, text))
                else:
                    self._keep(child, link)
        names = [node.called for node in self.without_mass]
        if names:
            which = f'link "{names[0]}" has' if len(names) == 1 else f"{counted(len(names), 'link')} have"
            message = (
                f"{which} no <inertial>{f' ({first_of(names, 3)})' if len(names) > 1 else ''}: readers of SDF take"
            )
            message += " 1 kg, and so does the description"
            self.reading.note("import-converted", message, self.without_mass[0].element.span)

    def _keep(self, element: Element, link: Node) -> None:
        text = wrapped("sdf", [self.models.text_of(element, link.scope)])
        index = keep(self.entries.links[link.called], element, text)
        self.reading.paths[id(element)] = ("links", link.called, "urdf_elements", index)

    def _inertial(self, link: Node, entry: dict[str, Any]) -> None:
        """Set the inertial; the defaults are 1 kg, and 1 kg*m^2 about each axis."""
        reading = self.reading
        element = reading.single(link.element, "inertial")
        span = (element or link.element).span
        if element is None:
            self.without_mass.append(link)
        else:
            reading.paths[id(element)] = ("links", link.called, "inertial")
        is_automatic = element is not None and is_true(element.get("auto"))
        if element is None or (is_automatic and not self._can_be_computed(element, link)):
            entry["inertial"] = Placed({"mass": 1, "inertia": {key: Placed(1, span) for key in _INERTIA[:3]}}, span)
            return
        if is_automatic:
            density = reading.one(element, "density") or Placed(_WATER, span)
            entry["inertial"] = Placed({"of": "collision", "density": density}, span)
            reading.check(element, ("density",), ("auto",), None)
            return
        inertia = reading.single(element, "inertia")
        at = (inertia or element).span
        moments = {key: reading.one(inertia, key) or (Placed(1, at) if key[1] == key[2] else None) for key in _INERTIA}
        if inertia is not None:
            reading.check(inertia, _INERTIA, (), None)
        made: dict[str, Any] = {"mass": reading.one(element, "mass") or Placed(1, span)}
        made |= self._pose_in(link, reading.single(element, "pose"), link.scope).entry(span)
        made["inertia"] = Placed({key: one for key, one in moments.items() if one is not None}, at)
        reading.check(element, ("pose", "mass", "inertia"), ("auto",), None)
        entry["inertial"] = Placed(made, span)

    def _can_be_computed(self, element: Element, link: Node) -> bool:
        """Return True if the inertial follows from the collision shapes; else report it."""
        parts = [part for child in link.element.children if child.tag == "collision" for part in child.children]
        shapes = {inner.tag for part in parts if part.tag == "geometry" for inner in part.children}
        uneven = any(part.tag in ("density", "auto_inertia_params") for part in parts)
        if shapes and shapes <= _SOLIDS.keys() - {"mesh"} and not uneven:
            return True
        message = f"the inertial of {named(link.element)} is to be computed: that is done of solids of one density, and"
        help = "say mass and inertia"
        self.reading.lenient("sdf-inertia", f"{message} no meshes", element.span, help, "takes 1 kg")
        return False

    def _pose_in(self, owner: Node, pose: Element | None, scope: Scope) -> WrittenPose:
        """Return a pose relative to a link or frame, whatever it is written relative to."""
        written, base = self.reading.pose(pose), self._base(pose, scope)
        if base is None or base is owner:
            return written
        here = self.bodies.pose(owner).inverse().then(self.bodies.pose(base))
        return written if here == Transform() else WrittenPose(here.then(written.transform), element=pose)

    def _base(self, pose: Element | None, scope: Scope) -> Node | None:
        """Return what a pose in a link is relative to, or None for the link, and after an error."""
        attribute = relative_to(pose)
        if attribute is None or pose is None:
            return None
        return self.models.require(scope, attribute.value, attribute.span, f"relative_to of {named(pose)}")

    def _owner(self, pose: Element | None, link: Node) -> Node:
        """Return the frame of a body that a pose in its link is relative to, or the link."""
        base = self._base(pose, link.scope)
        is_in_body = base is not None and base.kind in (LINK, FRAME) and self.bodies.body_of(base) is link
        return base if base is not None and is_in_body else link

    def _shape(self, element: Element, link: Node) -> None:
        """Add a visual or a collision to the entry of a frame of the body or of the link."""
        reading = self.reading
        pose = reading.single(element, "pose")
        owner = self._owner(pose, link)
        geometry = reading.single(element, "geometry")
        if geometry is None:
            reading.error("missing-element", f"{named(element)} has no <geometry>", element.span, "add one")
            return
        made: dict[str, Any] = {}
        solid = self._solid(geometry, made, link)
        if solid is None:
            return
        if solid.tag not in _SOLIDS:
            message = f"<{solid.tag}> of {named(element)} is a shape of its own kind: kept as it is"
            reading.diagnostics.append(Diagnostic("import-kept", NOTE, message, solid.span))
            self._keep(element, link)
            return
        shapes = self.entries.links[owner.called].setdefault(element.tag, [])
        reading.paths[id(element)] = ("links", owner.called, element.tag, len(shapes))
        attribute = element.attributes.get("name")
        if attribute is None or not attribute.value:
            message = f"a <{element.tag}> of {named(element.parent or element)} has no name"
            reading.lenient("missing-attribute", message, element.span, 'add name="..."', "takes it without")
        elif not NAME.match(attribute.value):
            reading.cannot_carry(f'the name "{attribute.value}" of <{element.tag}>', attribute.span)
        elif attribute.value != f"{owner.called}_{element.tag}_{len(shapes) + 1}":  # as we name shapes without a name
            made["name"] = Placed(attribute.value, attribute.span)
        made |= self._pose_in(owner, pose, link.scope).entry(element.span)
        self._details(element, solid, made, link)
        shapes.append(Placed(made, element.span))

    def _details(self, element: Element, solid: Element, made: dict[str, Any], link: Node) -> None:
        """Set the look and the friction of a shape, and keep what the language has no key for."""
        reading = self.reading

        def text(child: Element) -> str:
            return self.models.text_of(child, link.scope)

        rest: list[str] = []
        inner = reading.rest(
            solid, (*_SOLIDS[solid.tag], *(("uri",) if solid.tag == "mesh" else ())), ("optimization",)
        )
        if inner:
            rest.append(wrapped(solid.tag, [text(child) for child in inner]))
            if any(child.tag == "submesh" for child in inner):
                message = f"the submesh of {named(element)} is kept for SDF alone: other formats have the whole mesh"
                reading.note("import-converted", message, solid.span)
        material = reading.single(element, "material")
        if material is not None and element.tag == "collision":
            reading.ignored("the material of a collision: what collides is not seen", material.span)
        elif material is not None:
            looks = [text(child) for child in self._look(material, made, link)]
            rest += [wrapped("material", looks)] if looks else []
        for child in reading.rest(element, ("pose", "geometry", "material"), ("name",)):
            friction = self._friction(child) if child.tag == "surface" else None
            if friction is not None:
                made["contact"] = Placed({"friction": Placed([friction], friction.span)}, child.span)
            else:
                rest.append(text(child))
        if rest:
            keep(made, element, wrapped("sdf", rest))

    def _friction(self, surface: Element) -> Placed | None:
        """Return the coefficient of a surface that has nothing else, equal in both directions."""
        ode = _only_descendant(surface, "friction", "ode")
        if ode is None:
            return None
        found = {child.tag: self.reading.one(ode, child.tag) for child in ode.children}
        mu, other = found.get("mu"), found.get("mu2")
        same = other is None or (mu is not None and mu.value == other.value)
        return mu if found.keys() <= {"mu", "mu2"} and same else None

    def _look(self, material: Element, made: dict[str, Any], link: Node) -> list[Element]:
        """Set the colour and the image of a visual; return what else its material has."""
        diffuse, ambient = (self._colour(material, tag) for tag in ("diffuse", "ambient"))
        if diffuse is not None:
            made["rgba"] = diffuse
        same = diffuse is not None and ambient is not None and _values(ambient) == _values(diffuse)
        rest = []
        for child in self.reading.rest(material, ("diffuse", "ambient") if same else ("diffuse",)):
            image = _only_descendant(child, "metal", "albedo_map") if child.tag == "pbr" else None
            if image is not None and image.text:
                made["texture"] = Placed(self._address(image.text, link), image.span)
            else:
                rest.append(child)
        return rest

    def _colour(self, material: Element, tag: str) -> Placed | None:
        """Return a colour; three numbers are opaque."""
        child = self.reading.single(material, tag)
        if child is None:
            return None
        count = 3 if len(child.text.split()) == 3 else 4
        values = self.reading.all_of(child, count)
        return None if values is None else Placed([*values, Placed(1, child.span)][:4], child.span)

    def _solid(self, geometry: Element, made: dict[str, Any], link: Node) -> Element | None:
        """Set the shape of an entry and return its element; None after an error."""
        reading = self.reading
        children = [child for child in geometry.children if child.tag != "empty"]
        if len(children) > 1 and {child.tag for child in children} != {_OUTLINE}:
            message = f"{named(geometry)} has {listed(f'<{child.tag}>' for child in children)}; it takes one"
            reading.error("duplicate-element", message, children[1].span, "make a second shape of it")
            return None
        if not geometry.children:
            help = f"it takes one of {', '.join(_SOLIDS)}"
            reading.error("missing-element", f"{named(geometry)} is empty", geometry.span, help)
            return None
        solid, before = (children or geometry.children)[0], len(reading.diagnostics)
        if solid.tag not in _SOLIDS:
            known = sdf_elements()["geometry"]
            near = None if solid.tag in known or reading.options.lenient else correction(solid.tag, known)
            if near is not None:
                reading.misspelt(f"<{solid.tag}>", f"<{near}>", geometry, solid.span)
            return solid if near is None else None
        sizes: dict[str, Any] = {}
        uri = reading.text(solid, "uri") if solid.tag == "mesh" else None
        if uri is not None and uri.value != "__default__":
            sizes["file"] = Placed(self._address(str(uri.value), link), uri.span)
        elif solid.tag == "mesh":
            reading.error("missing-element", f"{named(solid)} has no <uri>", solid.span, "name the mesh")
        for key, count in _SOLIDS[solid.tag].items():
            child = reading.single(solid, key)
            if child is None and key != "scale":
                reading.error("missing-element", f"{named(solid)} has no <{key}>", solid.span, f"add <{key}>")
            values = None if child is None else reading.all_of(child, count, "" if key == "scale" else "m")
            if child is not None and values and (key != "scale" or [one.value for one in values] != [1, 1, 1]):
                sizes[key] = values[0] if count == 1 else Placed(values, child.span)
        made[solid.tag] = Placed(sizes, solid.span)
        return None if has_errors(reading.diagnostics[before:]) else solid

    def _address(self, uri: str, link: Node) -> str:
        """Return an address relative to the file that is imported, for one in a file that it includes."""
        first, own = self.reading.files[0], link.scope.file
        if "://" in uri or uri.startswith("/") or first.parent == own.parent:
            return uri
        return os.path.relpath(own.parent / uri, first.parent).replace(os.sep, "/")


def _only_descendant(element: Element, *tags: str) -> Element | None:
    """Return the element at the end of a path of tags, if nothing else is in the elements on the way."""
    for tag in tags:
        if [child.tag for child in element.children] != [tag]:
            return None
        element = element.children[0]
    return element


def _values(colour: Placed) -> list[float]:
    return [float(number.value) for number in colour.value]
