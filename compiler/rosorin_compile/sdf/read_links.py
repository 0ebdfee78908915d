"""Links of an SDF as entries of ``links``: inertials, visuals, collisions and how they look."""

from __future__ import annotations

import os
from typing import Any

from rosorin_compile.formats.format import Placed
from rosorin_compile.formats.urdf.reading import NAME
from rosorin_compile.model import Transform
from rosorin_compile.rules.urdf_elements import sdf_elements
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, counted, first_of, listed
from rosorin_compile.source.xml.describing import correction, named
from rosorin_compile.source.xml.markup import Element

from .elements import OF_LINK, keep, wrapped
from .models import FRAME, LINK, Node, relative_to
from .read_joints import Bodies, Entries
from .values import WrittenPose, is_true

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


class Links:
    """Reads the links of a model into entries."""

    def __init__(self, bodies: Bodies, entries: Entries) -> None:
        self.bodies, self.entries, self.reading = bodies, entries, bodies.reading

    def read(self) -> None:
        """Fill the entries of all links."""
        for link in self.bodies.links:
            element = link.element
            self._inertial(link)
            for child in element.children:
                if child.tag in ("visual", "collision"):
                    self._shape(child, link)
            for child in self.reading.rest(element, ("pose", "inertial", "visual", "collision"), ("name",)):
                if child.tag in OF_LINK:
                    pose = self.reading.single(child, "pose")
                    owner = self._owner(pose, link)
                    text = self.reading.text_of(child, link.scope, None if owner is link else pose)
                    self.entries.gazebo.setdefault(owner.called, []).append((child, text))
                else:
                    self._keep(child, link)
        massless = [link for link in self.bodies.links if all(one.tag != "inertial" for one in link.element.children)]
        if massless:
            names = [node.called for node in massless]
            which = f'link "{names[0]}" has' if len(names) == 1 else f"{counted(len(names), 'link')} have"
            which += f" no <inertial> ({first_of(names, 3)})" if len(names) > 1 else " no <inertial>"
            message = f"{which}: readers of SDF take 1 kg, and so does the description"
            self.reading.note("import-converted", message, massless[0].element.span)

    def _keep(self, element: Element, link: Node) -> None:
        text = wrapped("sdf", [self.reading.text_of(element, link.scope)])
        index = keep(self.entries.links[link.called], element, text)
        self.reading.paths[id(element)] = ("links", link.called, "urdf_elements", index)

    def _inertial(self, link: Node) -> None:
        """Set the inertial; the defaults are 1 kg, and 1 kg*m^2 about each axis."""
        reading = self.reading
        element = reading.single(link.element, "inertial")
        span = (element or link.element).span
        made: dict[str, Any] = {"mass": 1, "inertia": {key: Placed(1, span) for key in _INERTIA[:3]}}
        if element is not None:
            reading.paths[id(element)] = ("links", link.called, "inertial")
        if element is not None and is_true(element.get("auto")):
            made = {"of": "collision", "density": reading.one(element, "density") or Placed(_WATER, span)}
            reading.check(element, ("density",), ("auto",), None)
            for child in link.element.children:
                for part in child.children if child.tag == "collision" else ():
                    if part.tag in ("density", "auto_inertia_params"):
                        reading.cannot_carry(f"<{part.tag}> of {named(child)}", part.span)
        elif element is not None:
            inertia = reading.single(element, "inertia")
            at = (inertia or element).span
            default = {"ixx": Placed(1, at), "iyy": Placed(1, at), "izz": Placed(1, at)}
            moments = {key: reading.one(inertia, key) or default.get(key) for key in _INERTIA}
            if inertia is not None:
                reading.check(inertia, _INERTIA, (), None)
            made = {"mass": reading.one(element, "mass") or Placed(1, span)}
            made |= self._pose_in(link, reading.single(element, "pose"), link).entry(span)
            made["inertia"] = Placed({key: one for key, one in moments.items() if one is not None}, at)
            reading.check(element, ("pose", "mass", "inertia"), ("auto",), None)
        self.entries.links[link.called]["inertial"] = Placed(made, span)

    def _pose_in(self, owner: Node, pose: Element | None, link: Node) -> WrittenPose:
        """Return a pose of something in a link relative to its owner, whatever it is written relative to."""
        written, base = self.reading.pose(pose), self._base(pose, link)
        if base is None or base is owner:
            return written
        here = self.bodies.pose(owner).inverse().then(self.bodies.pose(base))
        return written if here == Transform() else WrittenPose(here.then(written.transform), element=pose)

    def _base(self, pose: Element | None, link: Node) -> Node | None:
        """Return what a pose in a link is relative to, or None for the link, and after an error."""
        attribute = relative_to(pose)
        if attribute is None or pose is None:
            return None
        return self.reading.require(link.scope, attribute.value, attribute.span, f"relative_to of {named(pose)}")

    def _owner(self, pose: Element | None, link: Node) -> Node:
        """Return the frame of a body that a pose in its link is relative to, or the link."""
        base = self._base(pose, link)
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
            message = f"a <{element.tag}> of {named(link.element)} has no name"
            reading.lenient("missing-attribute", message, element.span, 'add name="..."', "takes it without")
        elif not NAME.match(attribute.value):
            reading.cannot_carry(f'the name "{attribute.value}" of <{element.tag}>', attribute.span)
        elif attribute.value != f"{owner.called}_{element.tag}_{len(shapes) + 1}":  # as we name shapes without a name
            made["name"] = Placed(attribute.value, attribute.span)
        made |= self._pose_in(owner, pose, link).entry(element.span)
        self._details(element, solid, made, link)
        shapes.append(Placed(made, element.span))

    def _details(self, element: Element, solid: Element, made: dict[str, Any], link: Node) -> None:
        """Set the look and the friction of a shape, and keep what the language has no key for."""
        reading, rest = self.reading, list[str]()

        def texts(elements: list[Element]) -> list[str]:
            return [reading.text_of(child, link.scope) for child in elements]

        inner = reading.rest(solid, (*_SOLIDS[solid.tag], "uri"), ("optimization",))
        if inner:
            rest.append(wrapped(solid.tag, texts(inner)))
            if any(child.tag == "submesh" for child in inner):
                message = f"the submesh of {named(element)} is kept for SDF alone: other formats have the whole mesh"
                reading.note("import-converted", message, solid.span)
        material = reading.single(element, "material")
        if material is not None and element.tag == "collision":
            reading.ignored("the material of a collision: what collides is not seen", material.span)
        elif material is not None and (look := self._look(material, made, link)):
            rest.append(wrapped("material", texts(look)))
        for child in reading.rest(element, ("pose", "geometry", "material"), ("name",)):
            friction = self._friction(child) if child.tag == "surface" else None
            if friction is not None:
                made["contact"] = Placed({"friction": Placed([friction], friction.span)}, child.span)
            else:
                rest += texts([child])
        if rest:
            keep(made, element, wrapped("sdf", rest))

    def _friction(self, surface: Element) -> Placed | None:
        """Return the coefficient of a surface that has nothing else, equal in both directions."""
        ode = _only_descendant(surface, "friction", "ode")
        found = {child.tag: self.reading.one(ode, child.tag) for child in ode.children} if ode is not None else {}
        mu, other = found.get("mu"), found.get("mu2")
        same = other is None or (mu is not None and mu.value == other.value)
        return mu if found.keys() <= {"mu", "mu2"} and same else None

    def _look(self, material: Element, made: dict[str, Any], link: Node) -> list[Element]:
        """Set the colour and the image of a visual; return what else its material has."""
        diffuse, ambient = (self._colour(material, tag) for tag in ("diffuse", "ambient"))
        read = ["diffuse"]
        if diffuse is not None:
            made["rgba"] = diffuse
            if ambient is not None and [one.value for one in ambient.value] == [one.value for one in diffuse.value]:
                read.append("ambient")
        rest = []
        for child in self.reading.rest(material, read):
            image = _only_descendant(child, "metal", "albedo_map") if child.tag == "pbr" else None
            if image is not None and image.text:
                made["texture"] = Placed(self._address(image.text, link), image.span)
            else:
                rest.append(child)
        return rest

    def _colour(self, material: Element, tag: str) -> Placed | None:
        """Return a colour; three numbers are opaque."""
        child = self.reading.single(material, tag)
        values = None if child is None else self.reading.all_of(child, 3 if len(child.text.split()) == 3 else 4)
        return None if values is None or child is None else Placed([*values, Placed(1, child.span)][:4], child.span)

    def _solid(self, geometry: Element, made: dict[str, Any], link: Node) -> Element | None:
        """Set the shape of an entry and return its element; None after an error."""
        reading = self.reading
        children = [child for child in geometry.children if child.tag != "empty"] or geometry.children
        if len(children) > 1 and {child.tag for child in children} != {_OUTLINE}:
            message = f"{named(geometry)} has {listed(f'<{child.tag}>' for child in children)}; it takes one"
            reading.error("duplicate-element", message, children[1].span, "make a second shape of it")
            return None
        if not children:
            help = f"it takes one of {', '.join(_SOLIDS)}"
            reading.error("missing-element", f"{named(geometry)} is empty", geometry.span, help)
            return None
        solid, before = children[0], len(reading.diagnostics)
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
        return solid if len(reading.diagnostics) == before else None

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
