"""Read a generated MJCF without MuJoCo: links, joints and shapes as a robot, and the other elements by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from rosorin_compile import model
from rosorin_compile.model.geometry import pose_of, rotation_about, unit
from rosorin_compile.model.joint import Dynamics, Mimic
from rosorin_compile.model.robot import JointPose
from rosorin_compile.model.simulation import Actuator
from rosorin_compile.source.xml.elements import number_of, numbers_of, tree_of

from .bodies import COLLISION, FLOATING, PLANAR, TOUCHES, VISUAL, WORLD, collision_solids, is_free
from .engine import apply_classes
from .servos import is_clamped
from .unsupported import LEAST, position_range
from .write import base_name

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

Entries = Mapping[str, Mapping[str, Any]]  # by element name: attributes and their values

_FREE = 7
TOP = "the world of MuJoCo"  # the parent of the root
# Attributes of the equality constraint of a mimic joint, in the order of the export.
_FOLLOWS = ("name", "joint1", "joint2", "polycoef", "solref", "solimp")
# Sensor attributes with the name of the measured object.
_MEASURED = ("site", "objname", "camera", "body", "body1", "subtree1")


@dataclass(frozen=True)
class Mjcf:
    """The contents of an MJCF: a robot, attributes of elements by name, and pairs of links such as "arm - base"."""

    robot: model.Robot
    link: Entries = field(default_factory=dict)
    sensor: Entries = field(default_factory=dict)
    actuator: Entries = field(default_factory=dict)
    tendon: Entries = field(default_factory=dict)
    constraint: Entries = field(default_factory=dict)
    contact_pair: Entries = field(default_factory=dict)
    excluded_contacts: frozenset[str] = frozenset()
    contact_pairs: frozenset[str] = frozenset()
    contact_pairs_with_friction: frozenset[str] = frozenset()


def read(text: str) -> Mjcf:
    """Parse a generated MJCF. Raises ValueError if its contents are invalid."""
    root = tree_of(text)
    worldbody = root.find("worldbody")
    if root.tag != "mujoco" or worldbody is None:
        raise ValueError("there is no <worldbody>")
    return _Reader(root, worldbody).read()


def view(robot: model.Robot, output: model.Output) -> Mjcf:
    """Return the expected contents of the MJCF of a robot: frames, joint limits, masses and collision shapes."""
    links = []
    for link in robot.links:
        shapes = collision_solids(link, output)
        meshes = any(isinstance(shape.geometry, model.Mesh) for shape in shapes or ())
        bare = tuple(model.Shape(shape.geometry, shape.pose) for shape in shapes or ())
        inertial = link.inertial if link.inertial is not None and link.inertial.mass > LEAST else None
        links.append(model.Link(link.name, inertial, (), () if shapes is None or meshes else bare))
    return Mjcf(model.Robot("", tuple(links), tuple(_joint_view(joint, robot) for joint in robot.joints)))


def _joint_view(joint: model.Joint, robot: model.Robot) -> model.Joint:
    place = (joint.parent, joint.child, joint.origin)
    if not joint.moves:  # MJCF has no fixed joints, so their names are not in the file
        axis = joint.axis if joint.type == "planar" else (1.0, 0.0, 0.0)
        split = joint.type == "planar" or (joint.type == "floating" and not is_free(robot, joint))
        name = base_name(joint, robot) if split else "" if joint.is_fixed else joint.name
        return model.Joint(name, joint.type, *place, axis)
    reach = position_range(joint)
    kind = "continuous" if joint.type == "revolute" and reach is None else joint.type
    effort = joint.limit.known_value("effort") if joint.limit is not None else None
    lower, upper = reach or (None, None)
    if effort is not None and (effort <= 0 or "actuatorfrcrange" in joint.mjcf or is_clamped(robot, joint, effort)):
        effort = None  # this limit is in another attribute or in an actuator
    limit, mimic = model.Limit(lower, upper, effort), joint.mimic
    if mimic is not None and not robot.joint[mimic.joint].moves:  # a leader that never moves is written as a constant
        mimic = Mimic("", 0.0, mimic.offset)
    return model.Joint(joint.name, kind, *place, joint.axis, limit, mimic)


class _Reader:
    def __init__(self, root: Element, worldbody: Element) -> None:
        self.root = root
        self.links: list[model.Link] = []
        self.joints: dict[str, model.Joint] = {}  # joints by the name of their child link
        self.sections: dict[str, dict[str, dict[str, Any]]] = {}
        self.elements: dict[str, Element] = {}
        self.owners: dict[str, str] = {}  # link of each element that a sensor can refer to, by name
        self.geoms: dict[str, str] = {}
        self.free = False
        self.meshes = {mesh.get("name", ""): mesh for mesh in root.iterfind("asset/mesh")}
        apply_classes(root, complete_lists=False)
        colours = {one.get("name", ""): one.get("rgba") for one in root.iterfind("asset/material")}
        for element in worldbody.iter("geom"):  # copy the colour of the material to the geom
            if (colour := colours.get(element.get("material", ""))) is not None:
                element.attrib.setdefault("rgba", colour)
        waiting, site = [(body, TOP) for body in reversed(worldbody.findall("body"))], worldbody.find("site")
        if site is not None:  # a site in the world means that the root link is the world
            waiting = [(worldbody, TOP)]
            worldbody.set("name", site.get("name", ""))
        while waiting:
            body, parent = waiting.pop()
            called = _text(body, "name")
            # The body of a link "world" has a different name, because MuJoCo reserves "world".
            moved = called.startswith(f"{WORLD}_link") and any(s.get("name") == WORLD for s in body.iterfind("site"))
            name = WORLD if moved else called
            self.owners |= {called: name, name: name}
            self._body(body, name, parent)
            waiting += [(child, name) for child in reversed(body.findall("body"))]

    def read(self) -> Mjcf:
        for sensor in self.root.iterfind("sensor/*"):
            name = sensor.get("name", "")
            link = next((self.owners[sensor.attrib[key]] for key in _MEASURED if sensor.get(key) in self.owners), "")
            self._put(*(("link", link, f"{sensor.tag} {name}") if link else ("sensor", name, sensor.tag)), sensor)
        for kind, path in (("constraint", "equality"), ("actuator", "actuator"), ("tendon", "tendon")):
            for element in self.root.iterfind(f"{path}/*"):
                joint = element.get("joint1")
                named = element.get("name", joint) == joint or tuple(element.attrib) == _FOLLOWS
                if kind == "constraint" and element.tag == "joint" and named:
                    offset, factor = numbers_of(element.get("polycoef", "0 1 0 0 0"))[:2]
                    own, leads = (_reference(self.elements.get(element.get(end, ""))) for end in ("joint1", "joint2"))
                    # A constraint without joint2 holds joint1 at a constant position.
                    mimic = Mimic(element.get("joint2", ""), factor, offset + own - factor * leads)
                    self._replace(_text(element, "joint1"), mimic=mimic)
                elif kind == "actuator" and element.tag == "position" and "joint" in element.attrib:
                    name = element.attrib["joint"]
                    limit = next((joint.limit for joint in self.joints.values() if joint.name == name), None)
                    ends = numbers_of(element.get("ctrlrange", ""))
                    reach: Any = None if limit is None or ends in ((), (limit.lower, limit.upper)) else ends
                    kp, kv = (number_of(element.get(word, "0")) for word in ("kp", "kv"))
                    self._replace(name, actuator=Actuator(kp=kp, kv=kv, range=reach))
                else:
                    self._section(kind, element)
        kinds = ("excluded_contacts", "contact_pairs", "contact_pairs_with_friction")
        sets: dict[str, set[str]] = {kind: set() for kind in kinds}
        for pair in self.root.iterfind("contact/pair"):
            names = " - ".join(sorted(self.geoms.get(_text(pair, word), "") for word in ("geom1", "geom2")))
            sets["contact_pairs" if pair.get("condim") == "1" else "contact_pairs_with_friction"].add(names)
            if {key: text for key, text in pair.items() if key not in ("geom1", "geom2", "class")} not in TOUCHES:
                self._section("contact_pair", pair)
        for pair in self.root.iterfind("contact/exclude"):
            bodies = [_text(pair, word) for word in ("body1", "body2")]
            sets["excluded_contacts"].add(" - ".join(sorted(self.owners.get(name, name) for name in bodies)))
        poses = tuple(map(self._pose, self.root.iterfind("keyframe/key")))
        robot = model.Robot("", tuple(self.links), tuple(self.joints.values()), poses=poses)
        more: dict[str, Any] = {**self.sections, **{kind: frozenset(names) for kind, names in sets.items()}}
        return Mjcf(robot, **more)

    def _put(self, kind: str, name: str, path: str, element: Element) -> None:
        entry = self.sections.setdefault(kind, {}).setdefault(name, {})
        if not (attributes := {key: text for key, text in element.items() if key not in ("name", "class")}):
            entry[path] = element.tag
        for key, text in attributes.items():
            found: tuple[float, ...] = ()
            with suppress(ValueError):
                found = numbers_of(text)
            entry[f"{path} {key}"] = found[0] if len(found) == 1 else found or text

    def _section(self, kind: str, element: Element) -> None:
        name = element.get("name") or " ".join(value for key, value in element.items() if key.startswith("geom"))
        self._put(kind, name, element.tag, element)
        for number, inner in enumerate(element, 1):
            self._put(kind, name, f"{number} {inner.tag}", inner)

    def _body(self, body: Element, name: str, parent: str) -> None:
        joints = [one for one in body.iterfind("joint") if one.get("type") != "free"]
        free = [*body.iterfind("freejoint"), *(one for one in body.iterfind("joint") if one.get("type") == "free")]
        place, ref = _transform(body), _reference(joints[0]) if len(joints) == 1 else 0.0
        if ref:  # move the body to its pose at joint position zero; only single joints have ``ref``
            x, y, z = unit(numbers_of(joints[0].get("axis", "0 0 1"), 3))  # type: ignore[arg-type]
            slides = joints[0].get("type") == "slide"
            moved = model.Transform(xyz=(-ref * x, -ref * y, -ref * z))
            place = place.then(moved if slides else model.Transform(rotation_about((x, y, z), -ref)))
        self.elements |= {_text(joint, "name"): joint for joint in joints}
        self.joints[name] = _joint(joints, parent, name, pose_of(place))
        if free and parent == TOP:
            self.free = True
            self.sections.setdefault("link", {}).setdefault(name, {})["base"] = "free"
        elif free:
            called = _text(free[0], "name")
            self.elements[called] = free[0]
            self.joints[name] = model.Joint(called, "floating", parent, name, pose_of(place))
        waiting = [part for part in body if part.tag not in ("body", "joint", "freejoint", "inertial", "geom")]
        while waiting:  # sites, sensors and other elements, also nested
            part = waiting.pop(0)
            if part.tag == "site" and part.get("name") == name:
                self.sections.setdefault("link", {}).setdefault(name, {})["site"] = name
                continue
            names = [inner.get("name", "") for inner in part.iter() if inner.get("name")]
            self._put("link", name, " ".join([part.tag, *names[:1]]), part)
            self.owners.update(dict.fromkeys(names, name))
            waiting += list(part)
        shapes: dict[str, list[model.Shape]] = {COLLISION: [], VISUAL: []}
        for geom in body.iterfind("geom"):
            self.geoms[geom.get("name", "")] = name
            if purpose := next((one for one in shapes if geom.get("class", "").endswith(f"_{one}")), ""):
                rgba = numbers_of(geom.attrib["rgba"], 4) if purpose == VISUAL and "rgba" in geom.attrib else None
                shape = model.Shape(self._geometry(geom), pose_of(_transform(geom)), rgba=rgba)  # type: ignore[arg-type]
                shapes[purpose].append(shape)
        inertial = body.find("inertial")
        mass = _inertial(inertial) if inertial is not None else None
        self.links.append(model.Link(name, mass, tuple(shapes[VISUAL]), tuple(shapes[COLLISION])))

    def _geometry(self, geom: Element) -> Any:
        if (kind := geom.get("type", "sphere")) == "mesh":
            if (mesh := self.meshes.get(_text(geom, "mesh"))) is None:
                raise ValueError(f"there is no mesh {geom.get('mesh')}")
            return model.Mesh(mesh.get("file", ""), numbers_of(mesh.get("scale", "1 1 1"), 3))  # type: ignore[arg-type]
        counts = {"sphere": 1, "cylinder": 2, "capsule": 2, "box": 3, "ellipsoid": 3}
        if kind not in counts:
            return model.Mesh(f"{kind} {geom.get('hfield', '')}".strip())
        x, y, z = (*(numbers_of(geom.attrib["size"], counts[kind]) if "size" in geom.attrib else ()), 0.0, 0.0, 0.0)[:3]
        made = {"box": model.Box((-x, -y, -z), (x, y, z)), "ellipsoid": model.Ellipsoid((x, y, z))}
        made |= {"sphere": model.Sphere(x), "cylinder": model.Cylinder(x, 2 * y), "capsule": model.Capsule(x, 2 * y)}
        return made[kind]

    def _replace(self, name: str, **values: Any) -> None:
        if (joint := next((joint for joint in self.joints.values() if joint.name == name), None)) is None:
            raise ValueError(f"there is no joint {name}")
        self.joints[joint.child] = replace(joint, **values)

    def _pose(self, key: Element) -> JointPose:
        by_type = {"ball": 4, "free": _FREE}
        sizes = {name: by_type.get(joint.get("type", ""), 1) for name, joint in self.elements.items()}
        start, positions = _FREE if self.free else 0, dict[str, float]()
        length = start + sum(sizes.values())
        left = iter((numbers_of(key.attrib["qpos"], length) if "qpos" in key.attrib else (0.0,) * length)[start:])
        for name, size in sizes.items():
            values = [next(left) for _ in range(size)]
            if size == 1:
                positions[name] = values[0]
            elif size != _FREE:  # poses have no values for floating joints
                positions |= {f"{name} {letter}": value for letter, value in zip("wxyz", values, strict=True)}
        return JointPose(_text(key, "name"), positions)


def _joint(joints: Sequence[Element], parent: str, child: str, place: Any) -> model.Joint:
    """Return the joint of a body. Several MuJoCo joints can represent one planar or floating joint."""
    if not joints:
        return model.Joint("", "fixed", parent, child, place)
    joint, names = joints[0], [_text(joint, "name") for joint in joints]
    base = names[0].removesuffix(PLANAR[0])
    axis: Any = numbers_of(joints[-1].get("axis", "0 0 1"), 3)
    for kind, ends, last in (("planar", PLANAR, "hinge"), ("floating", FLOATING, "ball")):
        if names == [base + end for end in ends] and joints[-1].get("type", "hinge") == last:
            return model.Joint(base, kind, parent, child, place, axis if kind == "planar" else (1.0, 0.0, 0.0))
    if joint.get("type") == "ball":
        return model.Joint(names[0], "ball", parent, child, place)
    reach = numbers_of(joint.get("range", ""))
    kind = "prismatic" if joint.get("type") == "slide" else "revolute" if reach else "continuous"
    lower, upper = reach if len(reach) == 2 else (None, None)
    limit = model.Limit(lower, upper, (*numbers_of(joint.get("actuatorfrcrange", ""))[1:2], None)[0])
    held = ((*numbers_of(joint.get(key, "")), 0.0)[0] for key in ("damping", "frictionloss", "armature"))
    return model.Joint(names[0], kind, parent, child, place, axis, limit, None, Dynamics(*held))


def _text(element: Element, attribute: str) -> str:
    if (value := element.get(attribute)) is None:
        raise ValueError(f"<{element.tag}> has no {attribute}")
    return value


def _transform(element: Element) -> model.Transform:
    xyz: Any = numbers_of(element.get("pos", "0 0 0"), 3)
    quaternion = numbers_of(element.get("quat", "1 0 0 0"), 4)
    return model.Transform.of_quaternion(xyz, quaternion) if "quat" in element.attrib else model.Transform(xyz=xyz)


def _reference(joint: Element | None) -> float:
    return 0.0 if joint is None else number_of(joint.get("ref", "0"))


def _inertial(inertial: Element) -> model.Inertial | None:
    if (mass := number_of(_text(inertial, "mass"))) <= LEAST:
        return None
    diagonal = (*numbers_of(inertial.get("diaginertia", "0 0 0"), 3), 0.0, 0.0, 0.0)
    six = numbers_of(inertial.attrib["fullinertia"], 6) if "fullinertia" in inertial.attrib else diagonal
    return model.Inertial(mass, pose_of(_transform(inertial)), *six)
