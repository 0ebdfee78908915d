"""Rules about joints: the kinematic tree, axes, limits, and keys that have no effect or contradict each other."""

import math
from collections.abc import Iterable, Iterator, Mapping

from rosorin_compile.language.lower import owner_of_frame
from rosorin_compile.language.schema import joint_unit, subject
from rosorin_compile.language.symbols import MOUNT, Symbol
from rosorin_compile.model import Cylinder, Joint, Robot
from rosorin_compile.model.geometry import dot, norm, unit
from rosorin_compile.model.joint import Dynamics, Limit
from rosorin_compile.source.diagnostics import Diagnostic, Help, Suggestion, nearest
from rosorin_compile.source.rule_registry import JOINTS, SIMULATED, Check, rule
from rosorin_compile.source.tree import exists, has, value_at
from rosorin_compile.source.units import Quantity, describe, parse_unit
from rosorin_compile.source.wording import first_of, phrase, quote

from .case import Case, number

AXIS_TOLERANCE = 1e-3  # axes that are printed with five digits have a length of 1 within about 1e-5
ZERO_AXIS = 1e-9
DEFAULT_AXIS = (1.0, 0.0, 0.0)
ALONG = 0.9  # cosine: an axle within 25 degrees of a joint axis counts as parallel to it
SHOWN = 8
ROUNDING = 1e-6  # relative difference up to which numbers in an imported file count as equal
_SEVERAL = ("axis", "limit", "actuator", "calibration", "safety_controller")
_WITHOUT_EFFECT = {"fixed": (*_SEVERAL, "dynamics"), "floating": _SEVERAL, "ball": _SEVERAL, "planar": ("actuator",)}
# World frames (REP 105): localisation publishes them, and a description must not define them.
WORLD_FRAMES = ("earth", "map", "odom")
MAX_NAMED = 20
_WITH_UNITS = ("limit", "dynamics", "actuator", "mimic", "calibration", "safety_controller")
_POSITIVE = [("dynamics", key) for key in ("damping", "friction", "armature", "stiffness")]
_POSITIVE += [("actuator", key) for key in ("damping", "kp", "kv")]
_OWN_FRAME = 'write "frame: NAME" with a new name, or remove "parent" if the sensor is on that link'


def pieces(pairs: Iterable[tuple[str, str]]) -> list[set[str]]:
    """Return the connected components of a graph as sets of names; ``pairs`` are its edges."""
    piece_of: dict[str, set[str]] = {}
    for parent, child in pairs:
        first, second = piece_of.setdefault(parent, {parent}), piece_of.setdefault(child, {child})
        if first is not second:
            if len(first) < len(second):  # merge the smaller set into the larger set, which avoids quadratic time
                first, second = second, first
            first |= second
            piece_of.update(dict.fromkeys(second, first))
    return list({id(piece): piece for piece in piece_of.values()}.values())


def circles(above: Mapping[str, str]) -> Iterator[list[str]]:
    """Yield each cycle of a graph as a list of names; ``above`` maps names to parent names."""
    done: set[str] = set()
    for start in above:
        chain, here = list[str](), start
        while here in above and here not in done:
            done.add(here)
            chain.append(here)
            here = above[here]
        if here in chain:
            yield chain[chain.index(here) :]


@rule("no-links", "The robot has no link at all.", "Add `links: {base_link: {}}`.", JOINTS)
@rule("unknown-link", "There is no link or frame of a name.", "Correct the name, or add the link.", JOINTS)
@rule("unknown-joint", "There is no joint of a name.", "Correct the name, or add the joint.", JOINTS)
def known_names(case: Case) -> Iterator[Diagnostic]:
    """Report unknown names of links and joints, except in ``mimic``, which another rule checks."""
    robot = case.robot
    if not robot.links:
        yield case.problem("no-links", f'the robot "{robot.name}" has no links', ("robot",))
    for kind, option, real in (("link", "rename", robot.link), ("joint", "joints", robot.joint)):
        # Report names in the robot first, then names in the section ``moveit``, then names in options of outputs.
        uses = sorted((one for one in case.mentions(kind) if not one.among), key=lambda one: one.path[0] == "moveit")
        for output in robot.outputs:
            for index, name in enumerate(output.options.get(option, ())):
                what, key = f'in "{option}" of output "{output.name}"', name if kind == "link" else index
                uses.append(Symbol(kind, name, ("outputs", output.name, option, key), kind == "link", what))
        by_name: dict[str, list[Symbol]] = {}
        for use in uses:
            if use.name not in real and (kind == "joint" or use.name not in WORLD_FRAMES):
                by_name.setdefault(use.name, []).append(use)
        for name, uses in by_name.items():
            otherwise, own = f'add "{name}" to "{kind}s", or use an existing {kind}', (MOUNT,) if kind == "link" else ()
            frame = next((sensor.frame for sensor in robot.sensors if sensor.name == name), "")
            help: Help = case.suggest(uses[0].path, name, real, otherwise, own)
            if kind == "joint" and name in robot.joint_to:
                help = f'"{name}" is a link; its joint is "{robot.joint_to[name].name}"'
            elif kind == "link" and (frame or name in robot.joint):
                what, child = ("sensor; its frame", frame) if frame else ("joint; its child", robot.joint[name].child)
                help = f'"{name}" is a {what} is "{child}"'
            yield from case.unknown(f"unknown-{kind}", f'there is no {kind} "{name}"', uses, help)


@rule("two-parents", help="Correct `child` of one joint, or remove a joint.", topic=JOINTS)
def one_parent(case: Case) -> Iterator[Diagnostic]:
    """A link is the child of two joints."""
    for child, joints in _children(case.robot).items() if not case.robot.is_tree else ():
        if len(joints) < 2 or child not in {*case.robot.link, *WORLD_FRAMES}:  # another rule reports unknown links
            continue
        left, ends = _orphans(case), [case.end(joint, "child") for joint in joints]
        message = f'link "{child}" is the child of {len(joints)} joints, {quote(one.name for one in joints)}'
        help = f'correct "child" of one joint (links without a parent joint: {quote(left)})' if left else ""
        if any(end[0] == "sensors" for end in ends):
            message, help = f'several entries define frame "{child}": {phrase(map(owner_of_frame, ends))}', _OWN_FRAME
        related = [(f'attached here by joint "{joint.name}"', case.end(joint, "child")) for joint in joints[:-1]]
        yield case.problem("two-parents", message, ends[-1], help, related=related)


def _orphans(case: Case) -> list[str]:
    """Return links that have no parent, probably because a joint names a wrong child, which then has two parents."""
    robot = case.robot
    doubles = [joints for joints in _children(robot).values() if len(joints) > 1]
    roots = [name for name in robot.link if name not in robot.joint_to and name not in WORLD_FRAMES]
    is_one = len(doubles) == 1 and len(doubles[0]) == len(roots) == 2
    if not is_one or any(case.joint(joint)[0] == "sensors" for joint in doubles[0]):
        return []
    return [name for name in roots if name not in robot.joints_from] or roots


def _children(robot: Robot) -> dict[str, list[Joint]]:
    above: dict[str, list[Joint]] = {}
    for joint in robot.joints:
        above.setdefault(joint.child, []).append(joint)
    return above


@rule("joint-cycle", help="Correct `parent` or `child` of a joint in the loop.", topic=JOINTS)
def no_cycle(case: Case) -> Iterator[Diagnostic]:
    """Joints form a cycle; cycles through a link with two parents are reported as `two-parents`."""
    above = {child: joints[0] for child, joints in _children(case.robot).items() if len(joints) == 1}
    order = {name: index for index, name in enumerate(case.robot.joint)}
    for names in circles({child: joint.parent for child, joint in above.items()}) if not case.robot.is_tree else ():
        circle = [above[name] for name in reversed(names)]
        last = max(circle, key=lambda joint: order[joint.name])
        chain = " -> ".join([circle[0].parent, *(joint.child for joint in circle)])
        message = f'joint "{last.name}" closes a loop: {chain}'
        path, help, frame = case.end(last, "parent"), "", case.end(last, "child")
        if frame[0] == "sensors":
            path, of = frame, "" if "optical" in frame else "the frame of "
            message = f'{of}{owner_of_frame(frame)} has the name of link "{last.child}", to which it is itself attached'
            help = _OWN_FRAME if of else 'write "optical: {frame: NAME}" with a new name'
        others = [joint for joint in circle if joint is not last]
        related = [(f'joint "{joint.name}" is part of the loop', case.end(joint, "child")) for joint in others]
        yield case.problem("joint-cycle", message, path, help, related=related)


@rule("several-roots", "More than one link has no parent.", "Attach all but one.", JOINTS)
@rule("unreached-link", "No joint names this link.", "Attach it with a joint, or remove it.", JOINTS)
def one_root(case: Case) -> Iterator[Diagnostic]:
    """Report several roots and unconnected links, except roots that a misspelt child name explains."""
    robot = case.robot
    roots = [name for name in robot.link if name not in robot.joint_to and name not in WORLD_FRAMES]
    if robot.is_tree:
        return
    for child in [one.child for one in robot.joints if one.child not in {*robot.link, *WORLD_FRAMES}]:
        if (suggestion := nearest(child, roots)) is None:
            return
        roots.remove(suggestion)
    left = _orphans(case)
    alone = [name for name in roots if name not in left and name not in robot.joints_from]
    carrying = [name for name in roots if name not in left and name in robot.joints_from]
    if not carrying:
        carrying, alone = alone, []
    if len(carrying) > 1:
        main = max(carrying, key=lambda name: (len(robot.subtree(name)), name.startswith("base")))
        others = [name for name in carrying if name != main]
        message = f"the robot has {len(carrying)} roots, {quote([main, *others], MAX_NAMED)}, but must have one"
        also = (main, *others[1:MAX_NAMED])
        related = [case.related_place("also a root", case.link(name), key=True) for name in also]
        help = " and ".join(f'a joint with "child: {name}"' for name in others[:MAX_NAMED])
        yield case.problem("several-roots", message, case.link(others[0]), f"add {help}", related=related, key=True)
    frames = {sensor.frame for sensor in robot.sensors} - set(case.section("links"))
    for name in alone:
        near = Suggestion(name, frames, details=f'add a joint with "child: {name}", or remove the link')
        yield case.problem("unreached-link", f'no joint connects link "{name}"', case.link(name), near, key=True)


@rule("axis-zero", "An axis is zero: no direction.", "Write a direction, such as `[0, 0, 1]`.", JOINTS)
@rule("axis-not-unit", "An axis is not of unit length.", "Scale it to length 1.", JOINTS, "joint", "always")
def axes(case: Case) -> Iterator[Diagnostic]:
    """Report axes that are zero or not of unit length, because some URDF readers do not normalise them."""
    for joint in case.robot.joints:
        length, path = norm(joint.axis), case.joint(joint, "axis")
        if joint.is_fixed or joint.is_axleless or abs(length - 1) <= AXIS_TOLERANCE:
            continue
        if length < ZERO_AXIS:
            yield case.problem("axis-zero", f'the axis of joint "{joint.name}" is zero, which is not a direction', path)
        else:
            direction = ", ".join(number(c / length + 0.0) for c in joint.axis)
            message = f'the axis of joint "{joint.name}" has length {number(length)}, not 1'
            yield case.problem("axis-not-unit", message, path, f"write the same direction with length 1: [{direction}]")


@rule("limit-missing", "A joint has no `lower` and `upper` limit.", "Add them.", JOINTS, "joint", "lenient")
@rule("limit-incomplete", "A limit lacks `effort` or `velocity`.", "Add them.", JOINTS, "joint", "lenient")
@rule("limit-swapped", "`lower` is above `upper`.", "Swap or correct the limits.", JOINTS, "joint", "lenient")
@rule("limit-equal", "`lower` is `upper`: MuJoCo does not lock it.", "Use `type: fixed`.", JOINTS, "joint", "always")
@rule("limit-negative", "`effort` or `velocity` is below zero.", "Remove the minus sign.", JOINTS, "joint", "lenient")
@rule("limit-zero", "`effort` or `velocity` is zero.", "Write the real value.", JOINTS, "joint", "always")
@rule("limit-on-continuous", "A continuous joint has limits.", "Make the joint revolute.", JOINTS, "joint", "always")
def limits(case: Case) -> Iterator[Diagnostic]:
    """Report joint limits that are missing, incomplete or impossible."""
    for joint in case.robot.joints:
        path, limit, unit, called = case.joint(joint, "limit"), joint.limit, joint.unit, f'joint "{joint.name}"'
        is_bounded = joint.type in ("revolute", "prismatic")
        if limit is None and is_bounded:
            help = 'add "limit: {lower: ..., upper: ..., effort: ..., velocity: ...}", or make the joint continuous'
            yield case.problem("limit-missing", f"{called} is {joint.type} and has no limit", path, help)
        if limit is None or not (joint.moves or joint.type == "planar"):
            continue
        keys = ("lower", "upper", "effort", "velocity") if is_bounded else ("effort", "velocity")
        if missing := [key for key in keys if getattr(limit, key) is None]:
            id = "limit-missing" if {"lower", "upper"} & set(missing) else "limit-incomplete"
            effect = "require" if id == "limit-incomplete" else "require or take as 0"
            message = f"the limit of {called} lacks {phrase(missing)}, which URDF parsers {effect}"
            yield case.problem(id, message, path, f"add {phrase(missing)}", within=True)
        lower, upper = limit.lower, limit.upper
        if joint.type == "continuous":
            for key in [key for key in ("lower", "upper") if getattr(limit, key) is not None][:1]:
                message = f"{called} is continuous, so it cannot have a {key} limit"
                yield case.problem("limit-on-continuous", message, (*path, key), key=True)
        elif lower is not None and upper is not None and lower >= upper:
            id, what = ("limit-swapped", "above") if lower > upper else ("limit-equal", "equal to")
            message = f"the lower limit {number(lower)} {unit} of {called} is {what} its upper limit {number(upper)}"
            yield case.problem(id, message, (*path, "lower"), related=[("the upper limit", (*path, "upper"))])
        for key in ("effort", "velocity"):
            if (value := getattr(limit, key)) is not None and value <= 0:
                message = f"the {key} limit of {called} is {number(value)}, but must be above zero"
                yield case.problem("limit-negative" if value < 0 else "limit-zero", message, (*path, key))


@Check
def units(case: Case) -> Iterator[Diagnostic]:
    """Report values with a unit that does not match the joint type, such as radians for a prismatic joint."""
    for joint in (joint for joint in case.robot.joints if joint.moves):
        entry = value_at(case.tree, case.joint(joint))
        paths = [case.joint(joint, part, key) for part in _WITH_UNITS if has(entry, part) for key in entry[part] or ()]
        posed = [one.name for one in case.robot.poses if joint.name in one.positions]
        paths += [("poses", name, "positions", joint.name) for name in posed]
        leader = case.robot.joint.get(joint.mimic.joint) if joint.mimic is not None else None
        for path, value in ((path, value_at(case.tree, path)) for path in paths):
            if not isinstance(value, Quantity):
                continue
            expected = joint_unit(path, joint.type == "prismatic", leader.type == "prismatic" if leader else None)
            parsed = parse_unit(expected) if expected is not None else None
            if parsed is not None and parsed[1] != value.dimension:
                message = f"{subject(list(path))} must be {describe(parsed[1])} for a {joint.type} joint, but "
                message += f"{value.text or number(value)} is {describe(value.dimension)}"
                way = f"in {expected}" if expected else "without a unit"
                yield case.problem("wrong-unit", message, path, f"write it {way}, or correct the type of the joint")


@rule("ignored-key", help="Remove the key, or correct the type of the joint.", topic=JOINTS)
def without_effect(case: Case) -> Iterator[Diagnostic]:
    """A warning: a key has no effect, such as the axis of a fixed joint."""
    for joint in case.robot.joints:
        path = case.joint(joint)
        keys = _WITHOUT_EFFECT.get(joint.type, ()) if path[0] == "joints" else ()
        for key in (key for key in keys if exists(case.tree, (*path, key))):
            message = f'joint "{joint.name}" is {joint.type}: its {key} has no effect'
            yield case.problem("ignored-key", message, (*path, key), key=True)
    for link in case.robot.links:
        path = case.link(link.name, "inertial", "of")
        shapes = value_at(case.tree, path)
        for index, shape in enumerate(shapes if isinstance(shapes, list) else ()):
            for key in [key for key in ("contact", "mjcf", "urdf_elements") if key in shape]:
                message = f'a shape of the inertial of link "{link.name}" only has a mass: its {key} has no effect'
                yield case.problem("ignored-key", message, (*path, index, key), "move it to another shape", key=True)


@rule("dynamics-negative", "Damping, friction or a gain is below 0.", "Correct the sign.", JOINTS, "joint", "always")
def negative(case: Case) -> Iterator[Diagnostic]:
    """Report damping, friction, stiffness and gains that are negative."""
    for joint in case.robot.joints:
        if joint.limit is not None and min(joint.limit.effort or 0, joint.limit.velocity or 0) < 0:
            continue  # another rule reports these limits; gains computed from them are negative, too
        numbers = [(part, key, getattr(getattr(joint, part), key, 0.0) or 0.0) for part, key in _POSITIVE]
        numbers.append(("mjcf", "springyield", joint.mjcf.get("springyield", 0.0)))
        pair = _numbers(joint, "springdamper")
        wrong = [("mjcf", "springdamper", min(pair))] if any(pair) and min(pair) <= 0 else []
        for part, key, value in (*(one for one in numbers if one[2] < 0), *wrong):
            path = case.joint(joint, part, key)
            why, help = ("not above 0", "write values above zero") if key == "springdamper" else ("below 0", "")
            message = f'the {key} of joint "{joint.name}" is {number(value)}{case.stand_in(path)}, {why}'
            yield case.problem("dynamics-negative", message, path, help)


@rule("axis-missing", "A note: moving joints have no axis.", "Write the axis, such as `axis: [0, 0, 1]`.", JOINTS)
@rule("axis-across", "A warning: a joint axis is across its wheel.", "Correct the axis.", JOINTS, "joint", "always")
def missing_axes(case: Case) -> Iterator[Diagnostic]:
    """Report joints without an axis in one note, and wheels that would not turn about their axle."""
    others = []
    for joint in case.robot.joints:
        is_default = (joint.moves or joint.type == "planar") and joint.axis == DEFAULT_AXIS
        if is_default and not exists(case.tree, case.joint(joint, "axis")):
            if joint.type == "continuous" and lies_across(case, joint):
                message = f'joint "{joint.name}" has no axis, so it turns wheel "{joint.child}" about x, not its axle'
                yield case.problem("axis-across", message, case.joint(joint), 'add "axis" along the axle', key=True)
            else:
                others.append(joint)
    if others:
        names = first_of([f'"{joint.name}"' for joint in others], SHOWN)
        message = f"joints without an axis turn about x or slide along x, [1, 0, 0]: {names}"
        yield case.problem("axis-missing", message, case.joint(others[0]), key=True)


def lies_across(case: Case, joint: Joint) -> bool:
    """Return True if the child of a joint is a disc (a flat cylinder) whose axle is not parallel to the joint axis."""
    link = case.robot.link.get(joint.child)
    shapes = (link.collision or link.visual) if link is not None else ()
    if len(shapes) != 1 or not isinstance(shapes[0].geometry, Cylinder) or not any(joint.axis):
        return False
    disc, rows = shapes[0].geometry, shapes[0].pose.transform().rows
    return disc.length < 2 * disc.radius and abs(dot(unit(joint.axis), (rows[0][2], rows[1][2], rows[2][2]))) < ALONG


@rule("joint-word", help="Remove one of the two.", topic=SIMULATED)
def contradictions(case: Case) -> Iterator[Diagnostic]:
    """The `mjcf` of a joint contradicts its other keys, so artifacts would have different values."""
    for joint in case.robot.joints:
        path = case.joint(joint)
        for word, other in _contradictions(joint) if joint.mjcf and not joint.is_fixed else ():
            message = f'"mjcf.{word}" of joint "{joint.name}" conflicts with {".".join(other)}'
            related = [("the other value", (*path, *other))]
            yield case.problem("joint-word", message, (*path, "mjcf", word), related=related, key=True)
        if joint.type == "continuous" and "range" in joint.mjcf:
            message = f'joint "{joint.name}" is continuous, but has "mjcf.range"'
            yield case.problem("joint-word", message, (*path, "mjcf", "range"), 'remove "range"', key=True)


def _contradictions(joint: Joint) -> Iterator[tuple[str, tuple[str, str]]]:
    force, pair = _numbers(joint, "actuatorfrcrange"), _numbers(joint, "springdamper")
    owner = "actuator" if joint.actuator and joint.actuator.damping else "dynamics"
    stiffness = (joint.dynamics or Dynamics()).stiffness
    for word, part, value in (("stiffness", "dynamics", stiffness), ("damping", owner, joint.total_damping)):
        values, other = _numbers(joint, word), (part, word)
        if value and values and not _same(values[0], value):
            yield word, other
        if value and pair and min(pair) > 0:  # MuJoCo computes stiffness and damping from springdamper
            yield "springdamper", other
    limit = joint.limit if joint.moves and joint.limit else Limit()
    ends = (limit.lower, limit.upper) if joint.type != "continuous" else (None, None)
    pairs = zip(_numbers(joint, "range"), ends, ("lower", "upper"), strict=False)
    different = [key for mine, end, key in pairs if end is not None and not _same(mine, end)]
    yield from [("range", ("limit", key)) for key in different[:1]]
    if force and limit.effort is not None and not _same(max(map(abs, force)), limit.effort):
        yield "actuatorfrcrange", ("limit", "effort")


def _numbers(joint: Joint, word: str) -> tuple[float, ...]:
    value = joint.mjcf.get(word)
    return tuple(map(float, value)) if isinstance(value, tuple) else ()


def _same(value: float, other: float) -> bool:
    return math.isclose(value, other, rel_tol=ROUNDING, abs_tol=ROUNDING**2)
