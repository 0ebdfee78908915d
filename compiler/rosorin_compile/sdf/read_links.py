"""Links of an SDF as entries of ``links``: inertials, visuals, collisions and how they look."""

from __future__ import annotations

import os
from typing import Any, NamedTuple

from rosorin_compile.formats.format import Placed
from rosorin_compile.formats.urdf.reading import NAME, Reading, named
from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, counted, first_of, listed
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.xml.markup import Element

from .reading import Numbers, Said, converted, entry_of, others
from .scopes import FRAME, LINK, Models, Node, Scope
from .trees import Tree
from .verbatim import keep, text_of, wrapped
from .words import INERTIA, OF_LINK, PARTS_OF_LINK, SOLIDS

RULES = (
    Rule(
        "sdf-inertia",
        "An inertial of an SDF is to be computed, and of what it is not done here: meshes, several densities.",
        "Say mass and inertia; `--lenient` takes 1 kg.",
        Heading.READING,
    ),
)

_OF_COLOUR = ("ambient", "diffuse", "specular", "emissive")
_OF_SHAPE = ("pose", "geometry", "material")
_OF_MESH = ("uri", "scale")
_KEPT_OF_SHAPE = (
    *("surface", "laser_retro", "max_contacts", "cast_shadows", "transparency", "meta", "plugin"),
    *("visibility_flags", "density", "auto_inertia_params"),
)
_KEPT_OF_MATERIAL = ("script", "shader", "render_order", "lighting", "double_sided", "shininess", "pbr")
_OPAQUE = 1
_WATER = 1000  # kg/m^3, the density of an inertial that is to be computed and says none


class Entries(NamedTuple):
    """The entries that are made, by name, and those for Gazebo by the link or joint that they refer to."""

    links: dict[str, dict[str, Any]]
    gazebo: dict[str, list[tuple[Element, str]]]


class Links:
    """Reads the links of a tree into entries."""

    def __init__(self, tree: Tree, entries: Entries) -> None:
        self.tree = tree
        self.models: Models = tree.models
        self.reading: Reading = tree.reading
        self.numbers: Numbers = tree.models.numbers
        self.entries = entries
        self.without_mass: list[Node] = []

    def read(self) -> None:
        """Fill the entries of all links."""
        for link in self.tree.links:
            self._link(link)
        if self.without_mass:
            self._told_of_mass()

    def _told_of_mass(self) -> None:
        nodes = self.without_mass
        what = f'link "{nodes[0].called}" has' if len(nodes) == 1 else f"{counted(len(nodes), 'link')} have"
        which = "" if len(nodes) == 1 else f" ({first_of([one.called for one in nodes], 3)})"
        message = f"{what} no <inertial>{which}: readers of SDF take 1 kg, and so does the description"
        converted(self.reading, message, nodes[0].element.span)

    def _link(self, node: Node) -> None:
        element = node.element
        self._inertial(node, self.entries.links[node.called])
        for child in element.children:
            if child.tag in ("visual", "collision"):
                self._shape(child, node)
            elif child.tag in OF_LINK:
                self.entries.gazebo.setdefault(node.called, []).append((child, self._text(child, node)))
        for child in others(self.reading, element, (*PARTS_OF_LINK, *OF_LINK), ("name",)):
            self._keep(child, node)

    def _keep(self, element: Element, node: Node) -> None:
        """Keep an element of a link unchanged."""
        entry = self.entries.links[node.called]
        keep(entry, element, wrapped("sdf", [self._text(element, node)]))
        self.reading.paths[id(element)] = ("links", node.called, "urdf_elements", len(entry["urdf_elements"]) - 1)

    def _text(self, element: Element, node: Node) -> str:
        return text_of(element, node.scope, self.models)

    def _inertial(self, node: Node, entry: dict[str, Any]) -> None:
        """Set the inertial; the defaults are 1 kg, and 1 kg*m^2 about each axis."""
        element = self.reading.single(node.element, "inertial")
        span = (element or node.element).span
        default = Placed({"mass": 1, "inertia": {key: Placed(1, span) for key in INERTIA[:3]}}, span)
        if element is None:
            self.without_mass.append(node)
            entry["inertial"] = default
            return
        self.reading.paths[id(element)] = ("links", node.called, "inertial")
        if element.get("auto").lower() in ("true", "1"):
            if self._can_be_computed(element, node):
                density = self.numbers.one(element, "density") or Placed(_WATER, span)
                entry["inertial"] = Placed({"of": "collision", "density": density}, span)
                self.reading.check(element, ("density",), ("auto",), None)
            else:
                entry["inertial"] = default
            return
        made: dict[str, Any] = {"mass": self.numbers.one(element, "mass") or Placed(1, span)}
        made |= entry_of(self._seen_from(self.reading.single(element, "pose"), node.scope, node), span)
        inertia = self.reading.single(element, "inertia")
        at = (inertia or element).span
        moments = {key: self.numbers.one(inertia, key) if inertia is not None else None for key in INERTIA}
        moments |= {key: Placed(1, at) for key in INERTIA[:3] if moments[key] is None}
        if inertia is not None:
            self.reading.check(inertia, INERTIA, (), None)
        made["inertia"] = Placed({key: one for key, one in moments.items() if one is not None}, at)
        self.reading.check(element, ("pose", "mass", "inertia"), ("auto",), None)
        entry["inertial"] = Placed(made, span)

    def _can_be_computed(self, element: Element, node: Node) -> bool:
        """Return True if the inertial follows from collision shapes; else report it."""
        own = [child for child in node.element.children if child.tag == "collision"]
        parts = [part for child in own for part in child.children]
        shapes = {inner.tag for part in parts if part.tag == "geometry" for inner in part.children}
        uneven = any(part.tag in ("density", "auto_inertia_params") for part in parts)
        if shapes and shapes <= SOLIDS.keys() - {"mesh"} and not uneven:
            return True
        what = "that is done of solids of one density, and no meshes" if shapes else "there is no shape to do that of"
        message = f"the inertial of {named(node.element)} is to be computed: {what}"
        self.reading.lenient("sdf-inertia", message, element.span, "say mass and inertia", "takes 1 kg")
        return False

    def _seen_from(self, pose: Element | None, scope: Scope, link: Node, owner: Node | None = None) -> Said:
        """Return a pose as seen from a link, or from ``owner``, whatever it was relative to."""
        said = self.numbers.pose(pose)
        seen = self._relative_to(pose, scope)
        if seen is None or seen is (owner or link):
            return said
        here = self.tree.pose(owner or link).inverse().then(self.tree.pose(seen))
        return said if here == Transform() else Said(here.then(said.transform), element=pose)

    def _relative_to(self, pose: Element | None, scope: Scope) -> Node | None:
        """Return what a pose in a link is relative to; None for the link, and after an error."""
        attribute = None if pose is None else pose.attributes.get("relative_to") or pose.attributes.get("frame")
        if attribute is None or not attribute.value:
            return None
        what = f"relative_to of {named(pose)}" if pose is not None else ""
        return self.models.asked(scope, attribute.value, attribute.span, what)

    def _shape(self, element: Element, link: Node) -> None:
        """Add a visual or a collision to what it is placed in, a frame of the body or the link."""
        pose = self.reading.single(element, "pose")
        seen = self._relative_to(pose, link.scope)
        of_body = seen is not None and seen.kind in (LINK, FRAME) and self.tree.body_of(seen) is link
        owner = seen if of_body and seen is not None else link
        entry = self.entries.links[owner.called]
        geometry = self.reading.single(element, "geometry")
        if geometry is None:
            self.reading.error("missing-element", f"{named(element)} has no <geometry>", element.span, "add one")
            return
        made: dict[str, Any] = {}
        solid = self._solid(geometry, made, link)
        if solid is None:
            return
        if solid.tag not in SOLIDS:
            message = f"<{solid.tag}> of {named(element)} is a shape of its own kind: kept as it is"
            self.reading.diagnostics.append(Diagnostic("import-kept", NOTE, message, solid.span))
            self._keep(element, link)
            return
        shapes = entry.setdefault(element.tag, [])
        self.reading.paths[id(element)] = ("links", owner.called, element.tag, len(shapes))
        self._name(element, owner, len(shapes) + 1, made)
        made |= entry_of(self._seen_from(pose, link.scope, link, owner), element.span)
        self._more(element, solid, made, link)
        shapes.append(Placed(made, element.span))

    def _name(self, element: Element, owner: Node, number: int, made: dict[str, Any]) -> None:
        attribute = element.attributes.get("name")
        if attribute is None or not attribute.value:
            message = f"a <{element.tag}> of {named(element.parent or element)} has no name"
            help = 'add name="..."'
            self.reading.lenient("missing-attribute", message, element.span, help, "takes it without")
        elif attribute.value == f"{owner.called}_{element.tag}_{number}":
            return  # what the SDF of a description calls a shape without a name
        elif NAME.match(attribute.value):
            made["name"] = Placed(attribute.value, attribute.span)
        else:
            self.reading.cannot_carry(f'the name "{attribute.value}" of <{element.tag}>', attribute.span)

    def _more(self, element: Element, solid: Element, made: dict[str, Any], link: Node) -> None:
        """Set the looks of a shape, and keep what the language has no word for."""
        rest: list[str] = []
        inner = others(self.reading, solid, _OF_MESH if solid.tag == "mesh" else SOLIDS[solid.tag], ("optimization",))
        if inner:
            rest.append(wrapped(solid.tag, [self._text(child, link) for child in inner]))
            if any(child.tag == "submesh" for child in inner):
                message = f"the submesh of {named(element)} is kept for SDF alone: other formats have the whole mesh"
                converted(self.reading, message, solid.span)
        material = self.reading.single(element, "material")
        if material is not None and element.tag == "collision":
            self.reading.ignored("the material of a collision: what collides is not seen", material.span)
        elif material is not None:
            looks = self._looks(material, made, link)
            rest += [wrapped("material", looks)] if looks else []
        more = others(self.reading, element, (*_OF_SHAPE, *_KEPT_OF_SHAPE), ("name",))
        for child in element.children:
            friction = self._friction(child) if child.tag == "surface" else None
            if friction is not None:
                made["contact"] = Placed({"friction": Placed([friction], friction.span)}, child.span)
            elif child.tag in _KEPT_OF_SHAPE or child in more:
                rest.append(self._text(child, link))
        if rest:
            keep(made, element, wrapped("sdf", rest))

    def _friction(self, surface: Element) -> Placed | None:
        """Return the coefficient of friction of a surface that says nothing else, the same in both directions."""
        here = surface
        for tag in ("friction", "ode"):
            if [child.tag for child in here.children] != [tag]:
                return None
            here = here.children[0]
        found = {child.tag: self.numbers.one(here, child.tag) for child in here.children}
        mu, other = found.get("mu"), found.get("mu2")
        same = other is None or (mu is not None and mu.value == other.value)
        return mu if found.keys() <= {"mu", "mu2"} and same else None

    def _looks(self, material: Element, made: dict[str, Any], link: Node) -> list[str]:
        """Set colour and image of a visual; return what else is said of its surface."""
        colours = {tag: self._colour(material, tag) for tag in _OF_COLOUR}
        diffuse = colours["diffuse"]
        if diffuse is not None:
            made["rgba"] = diffuse
        rest = []
        others(self.reading, material, (*_OF_COLOUR, *_KEPT_OF_MATERIAL), ())
        for child in material.children:
            if child.tag == "diffuse":
                continue
            colour = colours.get(child.tag)
            if child.tag == "ambient" and diffuse is not None and colour is not None and _same(colour, diffuse):
                continue
            image = _only_image(child)
            if image is not None:
                made["texture"] = Placed(self._address(image.text, link), image.span)
            else:
                rest.append(self._text(child, link))
        return rest

    def _colour(self, material: Element, tag: str) -> Placed | None:
        """Return a colour; three numbers are opaque."""
        child = self.reading.single(material, tag)
        if child is None:
            return None
        count = 3 if len(child.text.split()) == 3 else 4
        values = self.numbers.all_of(child, count)
        if values is None:
            return None
        return Placed(values if count == 4 else [*values, Placed(_OPAQUE, child.span)], child.span)

    def _solid(self, geometry: Element, made: dict[str, Any], link: Node) -> Element | None:
        """Set the shape of an entry and return its element; None after an error."""
        children = [child for child in geometry.children if child.tag != "empty"]
        if len(children) > 1 and {child.tag for child in children} != {_OUTLINE}:
            message = f"{named(geometry)} has {listed(f'<{child.tag}>' for child in children)}; it takes one"
            self.reading.error("duplicate-element", message, children[1].span, "make a second shape of it")
            return None
        if not geometry.children:
            message = f"{named(geometry)} is empty"
            help = f"it takes one of {', '.join(SOLIDS)}"
            self.reading.error("missing-element", message, geometry.span, help)
            return None
        solid = (children or geometry.children)[0]
        if solid.tag not in SOLIDS:
            before = len(self.reading.diagnostics)
            self.reading.check(geometry, (*SOLIDS, *_OTHER_SHAPES), (), None)
            broken = any(one.rule == "misspelt" for one in self.reading.diagnostics[before:])
            del self.reading.diagnostics[before if not broken else len(self.reading.diagnostics) :]
            return None if broken else solid
        before = len(self.reading.diagnostics)
        sizes = self._mesh(solid, link) if solid.tag == "mesh" else self._sizes(solid)
        if any(one.severity == "error" for one in self.reading.diagnostics[before:]):
            return None
        made[solid.tag] = Placed(sizes, solid.span)
        return solid

    def _sizes(self, solid: Element) -> dict[str, Any]:
        """Return the sizes of a solid, by the words that both languages have."""
        sizes: dict[str, Any] = {}
        for key, count in SOLIDS[solid.tag].items():
            child = self.reading.single(solid, key)
            if child is None:
                message = f"{named(solid)} has no <{key}>"
                self.reading.error("missing-element", message, solid.span, f"add <{key}>")
                continue
            values = self.numbers.all_of(child, count, "m")
            if values is not None:
                sizes[key] = values[0] if count == 1 else Placed(values, child.span)
        return sizes

    def _mesh(self, solid: Element, link: Node) -> dict[str, Any]:
        made: dict[str, Any] = {}
        uri = self.numbers.text(solid, "uri")
        if uri is None or uri.value == "__default__":
            self.reading.error("missing-element", f"{named(solid)} has no <uri>", solid.span, "name the mesh")
            return made
        made["file"] = Placed(self._address(str(uri.value), link), uri.span)
        scale = self.reading.single(solid, "scale")
        if scale is not None:
            values = self.numbers.all_of(scale, SOLIDS["mesh"]["scale"])
            if values is not None and [float(one.value) for one in values] != [1.0, 1.0, 1.0]:
                made["scale"] = Placed(values, scale.span)
        return made

    def _address(self, uri: str, link: Node) -> str:
        """Return an address as seen from the file that is imported, for one in a file that it includes."""
        first, own = self.models.included.files[0], link.scope.file
        if "://" in uri or uri.startswith("/") or first.parent == own.parent:
            return uri
        return os.path.relpath(own.parent / uri, first.parent).replace(os.sep, "/")


_OUTLINE = "polyline"  # a geometry may have several: one within another is a hole in it
_OTHER_SHAPES = ("plane", _OUTLINE, "heightmap", "image", "empty", "cone")


def _only_image(pbr: Element) -> Element | None:
    """Return the image of a <pbr> that says nothing else."""
    here, way = pbr, ["pbr", "metal", "albedo_map"]
    while here.tag == way[0] and len(way) > 1 and len(here.children) == 1:
        here, way = here.children[0], way[1:]
    return here if [here.tag] == way and here.text else None


def _same(one: Placed, other: Placed) -> bool:
    return [float(number.value) for number in one.value] == [float(number.value) for number in other.value]
