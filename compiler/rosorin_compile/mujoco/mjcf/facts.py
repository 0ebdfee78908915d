"""Reads an MJCF of ours back as facts, in the terms in which the other artifacts say the same (see ``formats.facts``).

Only the MJCF has: joint "kp", "kv", "ctrl lower|upper"; link "base" (free), "site" (the link whose frame a site of that
name marks), "contact with NAME" (excluded), "pairs with NAME" and "rubs with NAME" (shapes of both may touch, without
friction and with it); and the poses:
Fact("pose", name of the pose, name of the joint).

What sensors are made of is said of the link that it sits in, attribute by attribute: "camera front fovy", "gyro
imu_gyro site", "replicate lidar_site count"; numbers of a list one by one: "camera front resolution 2". A sensor that
no link is known of is said by itself: Fact("sensor", name, "clock ...").
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rosorin_compile.formats.facts import COLLISION, VISUAL, FactSheet, Six, number_of
from rosorin_compile.formats.format import Fact, Facts
from rosorin_compile.model import Transform
from rosorin_compile.model.geometry import rotation_about, unit

from .bodies import FLOATING, PLANAR, TOUCHES, WORLD
from .masses import LEAST

if TYPE_CHECKING:
    from collections.abc import Sequence
    from xml.etree.ElementTree import Element

    from rosorin_compile.formats.expectation import Expectation
    from rosorin_compile.formats.facts import Block, Deviations
    from rosorin_compile.formats.format import Value

_FREE = 7
_SIZES = {"ball": 4, "free": _FREE}
# Where the top of the tree stands.
_TOP = "the world of MuJoCo"
_COLOUR = ("red", "green", "blue", "alpha")
_NO_TURN = (1.0, 0.0, 0.0, 0.0)
# The attributes of a joint that follows another, in their order.
_FOLLOWS = ("name", "joint1", "joint2", "polycoef", "solref", "solimp")
# What a body has beside what sensors are made of.
_PLAIN = ("body", "joint", "freejoint", "inertial", "geom")
# The attributes of a sensor that name what it measures at.
_MEASURED = ("site", "objname", "camera", "body", "body1", "subtree1")
_PAIRED = ("geom1", "geom2")
_CALLED = ("name", "class")


def read(text: str) -> Facts:
    """Return what an MJCF says. Raises ValueError if it is damaged."""
    return _read(FactSheet(text, "mujoco")).facts


def against(text: str, known: Expectation) -> Deviations:
    """Return what an MJCF says that is not known. Raises ValueError if it is damaged."""
    return _read(FactSheet(text, "mujoco", known)).deviations()


def _read(sheet: FactSheet) -> FactSheet:
    worldbody = sheet.root.find("worldbody")
    if worldbody is None:
        raise ValueError("there is no <worldbody>")
    _root_is_world(worldbody)
    _fill(sheet.root)
    scales = {mesh.get("name", ""): mesh for mesh in sheet.root.iterfind("asset/mesh")}
    joints: dict[str, Element] = {}
    owners: dict[str, str] = {}
    if sheet.known is not None:
        for material in sheet.root.iterfind("asset/material"):  # not each of them is that of a shape that is read
            sheet.vector(material, "rgba", 4, ())
    free = _bodies(sheet, worldbody, scales, joints, owners)
    for section in sheet.root.iterfind("sensor"):
        for sensor in section:
            _sensor(sheet, sensor, owners)
    _drives(sheet, joints)
    _contacts(sheet, owners)
    _pairs(sheet, worldbody, owners)
    for key in sheet.root.iterfind("keyframe/key"):
        _key(sheet, key, joints, free)
    return sheet


def _drives(sheet: FactSheet, joints: dict[str, Element]) -> None:
    """Add what joints follow and are moved by: constraints, actuators, tendons."""
    for constraint in sheet.root.iterfind("equality/*"):
        if _follows(constraint):
            _mimic(sheet, constraint, joints)
        else:
            _entry(sheet, "constraint", constraint)
    for actuator in sheet.root.iterfind("actuator/*"):
        if actuator.tag == "position" and "joint" in actuator.attrib:
            _actuator(sheet, actuator, joints)
        else:
            _entry(sheet, "actuator", actuator)
    for tendon in sheet.root.iterfind("tendon/*"):
        _entry(sheet, "tendon", tendon)


def _contacts(sheet: FactSheet, owners: dict[str, str]) -> None:
    """Add who touches whom whatever the layers say, and who never does."""
    for pair in sheet.root.iterfind("contact/pair"):
        if {name: text for name, text in pair.items() if name not in ("geom1", "geom2", "class")} in TOUCHES:
            continue  # that they touch is all of it, which is told of their links
        _entry(sheet, "contact pair", pair)
    for pair in sheet.root.iterfind("contact/exclude"):
        one, other = (owners.get(name, name) for name in (sheet.text(pair, "body1"), sheet.text(pair, "body2")))
        sheet.add(Fact("link", one, f"contact with {other}"), "excluded")


def _root_is_world(worldbody: Element) -> None:
    """Put what stands in the world itself into a body, where the root link is the world: it has a site there."""
    site = worldbody.find("site")
    if site is not None:
        body = worldbody.makeelement("body", {"name": site.get("name", "")})
        body.extend(list(worldbody))
        worldbody[:] = [body]


def _fill(root: Element) -> None:
    """Give each element the attributes of its class, and visuals the colour of their material, where it has no own."""
    classes: dict[str, dict[str, dict[str, str]]] = {}
    waiting: list[tuple[Element, dict[str, dict[str, str]]]] = [(one, {}) for one in root.iterfind("default")]
    while waiting:
        default, above = waiting.pop()
        own = {part.tag: above.get(part.tag, {}) | part.attrib for part in default if part.tag != "default"}
        classes[default.get("class", "main")] = above | own
        waiting += [(inner, above | own) for inner in default.iterfind("default")]
    colours = {one.get("name", ""): one.get("rgba") for one in root.iterfind("asset/material")}
    said = {(name, tag): own.items() for name, parts in classes.items() for tag, own in parts.items()}
    for section in ("worldbody", "actuator"):
        for element in (inner for top in root.iterfind(section) for inner in top.iter()):
            attributes = element.attrib
            for key, text in said.get((attributes.get("class", ""), element.tag), ()):
                attributes.setdefault(key, text)
            if "material" in attributes and (colour := colours.get(attributes["material"])) is not None:
                attributes.setdefault("rgba", colour)


def _bodies(
    sheet: FactSheet,
    top: Element,
    scales: dict[str, Element],
    joints: dict[str, Element],
    owners: dict[str, str],
) -> bool:
    """Take down the bodies below ``top``, collect their joints in order, and say whether the base floats.

    ``owners`` collects the link of each named thing that a sensor may measure at.
    """
    free, kept = False, sheet.root.find("contact/pair") is not None
    waiting = [(body, _TOP) for body in reversed(top.findall("body"))]
    while waiting:
        body, parent = waiting.pop()
        parts: dict[str, list[Element]] = {}
        for part in body:
            parts.setdefault("freejoint" if part.get("type") == "free" else part.tag, []).append(part)
        called = sheet.text(body, "name")
        # The body of a link "world" has another name, for MuJoCo has a body of that name.
        moved = called.startswith(f"{WORLD}_link") and any(s.get("name") == WORLD for s in parts.get("site", ()))
        name = WORLD if moved else called
        owners[called] = name
        sheet.add_frame(name, parent, _at_zero(sheet, _transform(sheet, body), parts.get("joint", ())))
        for joint in parts.get("freejoint", ()):
            if parent != _TOP:
                sheet.add(Fact("joint", sheet.text(joint, "name"), "type"), "floating")
                sheet.add(Fact("joint", sheet.text(joint, "name"), "child"), name)
                joints[sheet.text(joint, "name")] = joint
                continue
            free = True
            sheet.add(Fact("link", name, "base"), "free")
        own = {sheet.text(joint, "name"): joint for joint in parts.get("joint", ())}
        joints |= own
        _joints(sheet, own, name)
        owners[name] = name
        _others(sheet, name, body, owners)
        for inertial in parts.get("inertial", ()):
            _inertial(sheet, name, inertial)
        _shapes(sheet, name, parts.get("geom", []), scales)
        waiting += [(child, name) for child in reversed(parts.get("body", ()))]
        if not kept:  # of thousands of bodies it would be half of the memory
            body.clear()
    return free


def _others(sheet: FactSheet, link: str, body: Element, owners: dict[str, str]) -> None:
    """Take down the site of a link, and what sensors are made of."""
    for part in body:
        if part.tag == "site" and part.get("name") == link:
            sheet.add(Fact("link", link, "site"), link)
        elif part.tag not in _PLAIN:
            _part(sheet, link, part, owners)


def _pairs(sheet: FactSheet, worldbody: Element, owners: dict[str, str]) -> None:
    """Take down the links of which shapes may touch where MuJoCo would not let them."""
    pairs = sheet.root.findall("contact/pair")
    if not pairs:
        return
    bodies = ((body.get("name", ""), body.iterfind("geom")) for body in worldbody.iter("body"))
    links = {geom.get("name", ""): owners.get(name, name) for name, geoms in bodies for geom in geoms}
    for pair in pairs:
        one, other = (links.get(sheet.text(pair, word), "") for word in _PAIRED)
        how = "pairs" if pair.get("condim") == "1" else "rubs"
        sheet.add(Fact("link", one, f"{how} with {other}"), "may touch")


def _part(sheet: FactSheet, link: str, part: Element, owners: dict[str, str]) -> None:
    """Take down an element of a sensor in a body, and what is in it."""
    names = [inner.get("name", "") for inner in part.iter() if inner.get("name")]
    _attributes(sheet, Fact("link", link, " ".join([part.tag, *names[:1]])), part)
    for inner in part:
        _part(sheet, link, inner, owners)
    owners.update(dict.fromkeys(names, link))


def _sensor(sheet: FactSheet, sensor: Element, owners: dict[str, str]) -> None:
    """Take down an entry of the list of sensors, with the link that it measures at."""
    name = sensor.get("name", "")
    link = next((owners[sensor.attrib[key]] for key in _MEASURED if sensor.get(key, "") in owners), "")
    fact = Fact("link", link, f"{sensor.tag} {name}") if link else Fact("sensor", name, sensor.tag)
    _attributes(sheet, fact, sensor)


def _entry(sheet: FactSheet, kind: str, element: Element) -> None:
    """Take down an entry of a section for simulation, and what stands in it."""
    name = element.get("name") or " ".join(value for key, value in element.items() if key.startswith("geom"))
    _attributes(sheet, Fact(kind, name, element.tag), element)
    for number, inner in enumerate(element, 1):
        _attributes(sheet, Fact(kind, name, f"{number} {inner.tag}"), inner)


def _attributes(sheet: FactSheet, fact: Fact, element: Element) -> None:
    """Take down the attributes of an element, numbers as numbers; an element without any by its name."""
    attributes = {name: text for name, text in element.items() if name not in ("name", "class")}
    if not attributes:
        sheet.add(fact, element.tag)
    for name, text in attributes.items():
        numbers = _numbers(text)
        for index, number in enumerate(numbers, start=1):
            which = f" {index}" if len(numbers) > 1 else ""
            sheet.add(Fact(fact.kind, fact.name, f"{fact.quantity} {name}{which}"), number)
        if not numbers:
            sheet.add(Fact(fact.kind, fact.name, f"{fact.quantity} {name}"), text)


def _numbers(text: str) -> list[float]:
    """Return the numbers of an attribute; none if it is anything else."""
    try:
        return [number_of(token) for token in text.split()]
    except ValueError:
        return []


def _transform(sheet: FactSheet, element: Element) -> Transform:
    return sheet.once(("at", element.get("pos"), element.get("quat")), lambda: _placed(sheet, element))


def _placed(sheet: FactSheet, element: Element) -> Transform:
    if "quat" not in element.attrib:
        return Transform(xyz=sheet.vector3(element, "pos"))
    return Transform.of_quaternion(sheet.vector3(element, "pos"), sheet.vector(element, "quat", 4, _NO_TURN))


def _joints(sheet: FactSheet, joints: dict[str, Element], child: str) -> None:
    """Take down the joints of a body: those that together are a planar or a floating joint as that."""
    first = next(iter(joints), "")
    base = first.removesuffix(PLANAR[0])
    for kind, ends, last in (("planar", PLANAR, "hinge"), ("floating", FLOATING, "ball")):
        if (
            len(joints) == len(ends)
            and list(joints) == [base + end for end in ends]
            and joints[base + ends[-1]].get("type", "hinge") == last
        ):
            sheet.add(Fact("joint", base, "type"), kind)
            sheet.add(Fact("joint", base, "child"), child)
            if kind == "planar":
                _axis(sheet, base, joints[base + ends[-1]])
            return
    for name, joint in joints.items():
        if joint.get("type") == "ball":
            sheet.add(Fact("joint", name, "type"), "ball")
            sheet.add(Fact("joint", name, "child"), child)
        else:
            _joint(sheet, joint, child)


def _reference(sheet: FactSheet, joint: Element | None) -> float:
    """Return the position (rad or m) of a joint at which the file has its body."""
    return 0.0 if joint is None or "ref" not in joint.attrib else sheet.number(joint, "ref")


def _at_zero(sheet: FactSheet, place: Transform, joints: Sequence[Element]) -> Transform:
    """Return where a body is with its joint at zero; only one that is alone in a body has a reference."""
    ref = _reference(sheet, joints[0]) if len(joints) == 1 else 0.0
    if not ref:
        return place
    axis = unit(sheet.vector3(joints[0], "axis", (0.0, 0.0, 1.0)))
    if joints[0].get("type") == "slide":
        x, y, z = (-ref * part for part in axis)
        return place.then(Transform(xyz=(x, y, z)))
    return place.then(Transform(rotation_about(axis, -ref)))


def _axis(sheet: FactSheet, name: str, joint: Element) -> None:
    for quantity, value in sheet.axis(sheet.vector3(joint, "axis", (0.0, 0.0, 1.0))).items():
        sheet.take("joint", name, quantity, value)


def _joint(sheet: FactSheet, joint: Element, child: str) -> None:
    said = [pair for pair in joint.items() if pair[0] not in _CALLED]  # it has the attributes of its class
    motion = sheet.once(("joint", *said), lambda: _motion(sheet, joint))
    sheet.add_joint(sheet.text(joint, "name"), child, motion)


def _motion(sheet: FactSheet, joint: Element) -> Block:
    """Return what is said of a joint but where it sits."""
    kind = joint.get("type", "hinge")
    slides = kind == "slide"
    unit, force = ("m", "N") if slides else ("rad", "N*m")
    ends = sheet.vector(joint, "range", 2, ())
    if not slides:
        kind = "revolute" if ends else "continuous"
    said: dict[str, Value] = {"type": sheet.value("prismatic" if slides else kind)}
    said |= sheet.axis(sheet.vector3(joint, "axis", (0.0, 0.0, 1.0)))
    for quantity, value in zip(("lower", "upper"), ends, strict=False):
        said[quantity] = sheet.value(value, unit)
    for effort in sheet.vector(joint, "actuatorfrcrange", 2, ())[1:]:
        said["effort"] = sheet.value(effort, force)
    dynamics = (
        ("damping", "damping", f"{force}*s/{unit}"),
        ("friction", "frictionloss", force),
        ("armature", "armature", "kg" if slides else "kg*m^2"),
    )
    for quantity, attribute, dimension in dynamics:
        if attribute in joint.attrib:
            number = _linear(sheet, joint) if quantity == "damping" else sheet.number(joint, attribute)
            said[quantity] = sheet.value(number, dimension)
    return said


def _linear(sheet: FactSheet, joint: Element) -> float:
    """Return the damping of a joint; of one that MuJoCo takes for a polynomial of the speed what is linear."""
    first, *more = sheet.text(joint, "damping").split() or [""]
    for number in more:
        number_of(number)
    return number_of(first)


def _inertial(sheet: FactSheet, name: str, inertial: Element) -> None:
    said = sheet.once(("inertial", *inertial.items()), lambda: _inertia(sheet, inertial))
    if said is not None:
        sheet.add_inertial(name, *said)


def _inertia(sheet: FactSheet, inertial: Element) -> tuple[float, Transform, Six] | None:
    """Return a mass, its frame, and the inertia along that; None for what a link without mass has."""
    mass = sheet.number(inertial, "mass")
    if mass <= LEAST:
        return None
    frame = _transform(sheet, inertial)
    diagonal = sheet.vector3(inertial, "diaginertia")
    xx, yy, zz, xy, xz, yz = sheet.vector(inertial, "fullinertia", 6, (*diagonal, 0.0, 0.0, 0.0))
    return mass, frame, (xx, yy, zz, xy, xz, yz)


def _shapes(sheet: FactSheet, name: str, geoms: list[Element], scales: dict[str, Element]) -> None:
    """Take down the geoms of a body: what they are for stands at the end of their class."""
    for purpose in (COLLISION, VISUAL):
        ours = [geom for geom in geoms if geom.get("class", "").endswith(f"_{purpose}")]
        if sheet.known is None:
            sheet.add(Fact("link", name, f"{purpose} shapes"), float(len(ours)), tolerance=0.0)
        for index, geom in enumerate(ours, start=1):
            kind = geom.get("type", "sphere")
            key = ("geom", kind, geom.get("size"), geom.get("mesh"))
            sizes = sheet.once(key, partial(_full_sizes, sheet, geom, kind, scales))
            sheet.add_shape(name, f"{purpose} {index}", kind, sizes, _transform(sheet, geom))
            look = () if purpose == COLLISION else sheet.vector(geom, "rgba", 4, ())
            for part, value in zip(_COLOUR, look, strict=False):
                sheet.add_of_shape(name, f"{purpose} {index}", part, value)


def _full_sizes(sheet: FactSheet, geom: Element, kind: str, scales: dict[str, Element]) -> tuple[float, ...]:
    """Return the sizes of a geom as full extents and full lengths (m); of a mesh its scale."""
    if kind == "mesh":
        mesh = scales.get(sheet.text(geom, "mesh"))
        if mesh is None:
            raise ValueError(f"there is no mesh {geom.get('mesh')}")
        return sheet.vector3(mesh, "scale", (1.0, 1.0, 1.0))
    if kind in ("box", "ellipsoid"):
        x, y, z = sheet.vector3(geom, "size")
        return (2 * x, 2 * y, 2 * z)
    if kind == "sphere":
        return (sheet.number(geom, "size"),)
    radius, half = sheet.vector(geom, "size", 2, (0.0, 0.0))
    return (radius, 2 * half)


def _follows(constraint: Element) -> bool:
    """Say whether a constraint is one joint that follows another: as it, or as a mimic with a name of its own."""
    joint = constraint.get("joint1")
    return constraint.tag == "joint" and (constraint.get("name", joint) == joint or (*constraint.attrib,) == _FOLLOWS)


def _mimic(sheet: FactSheet, follower: Element, joints: dict[str, Element]) -> None:
    name = sheet.text(follower, "joint1")
    offset, multiplier, *_ = sheet.vector(follower, "polycoef", 5, (0.0, 1.0, 0.0, 0.0, 0.0))
    own, leads = (_reference(sheet, joints.get(follower.get(word, ""))) for word in ("joint1", "joint2"))
    offset += own - multiplier * leads
    if "joint2" in follower.attrib:  # without it the joint is held at an angle
        sheet.add(Fact("joint", name, "mimic joint"), sheet.text(follower, "joint2"))
        sheet.add(Fact("joint", name, "mimic multiplier"), multiplier)
    sheet.add(Fact("joint", name, "mimic offset"), offset, _unit(joints, name))


def _actuator(sheet: FactSheet, actuator: Element, joints: dict[str, Element]) -> None:
    name = sheet.text(actuator, "joint")
    unit = _unit(joints, name)
    force = "N*m" if unit == "rad" else "N"
    sheet.add(Fact("joint", name, "kp"), sheet.number(actuator, "kp"), f"{force}/{unit}")
    if "kv" in actuator.attrib:
        sheet.add(Fact("joint", name, "kv"), sheet.number(actuator, "kv"), f"{force}*s/{unit}")
    for quantity, value in zip(("lower", "upper"), sheet.vector(actuator, "ctrlrange", 2, ()), strict=False):
        sheet.add(Fact("joint", name, f"ctrl {quantity}"), value, unit)


def _key(sheet: FactSheet, key: Element, joints: dict[str, Element], free: bool) -> None:
    sizes = [_SIZES.get(joint.get("type", ""), 1) for joint in joints.values()]
    length = sum(sizes) + (_FREE if free else 0)
    positions = iter(sheet.vector(key, "qpos", length, (0.0,) * length)[length - sum(sizes) :])
    for name, size in zip(joints, sizes, strict=True):
        for index in range(size):
            if size == _FREE:  # where it floats, no pose says
                next(positions)
                continue
            which = name if size == 1 else f"{name} {'wxyz'[index]}"
            unit = _unit(joints, name) if size == 1 else ""
            sheet.add(Fact("pose", sheet.text(key, "name"), which), next(positions), unit)


def _unit(joints: dict[str, Element], name: str) -> str:
    """Return the unit of the position of a joint. Raises ValueError if there is no such joint."""
    if name not in joints:
        raise ValueError(f"there is no joint {name}")
    return "m" if joints[name].get("type") == "slide" else "rad"
