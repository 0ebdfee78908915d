"""Check the parameters of ros2_control controllers, in a description or a parameter file, against the robot."""

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from rosorin_compile.formats.format import Unsupported
from rosorin_compile.model import Output, Robot
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Suggestion, first_of, nearest, phrase, quote
from rosorin_compile.source.tree import Path, Seq, value_at

from ..node_kinds import DISTRIBUTIONS, MANAGER, Finding, Kind, against_kind, kinds, plugins
from ..parameter_files import distro_of, parameter_file
from ..ports import described_by, facts, full_type, interfaces_of
from ..sections.control import JOINT_WORDS, POSITION, VELOCITY, sensor_words
from .write import ControllerParameters, RobotParameters, edges_of, fill, is_whole, manager_parameters, view, write

_ENDS = (("odom_frame_id", "odom"), ("base_frame_id", "base_link"))
_TOLERANCE = 0.005  # relative tolerance of sizes: they are rounded, and tyres are compressed
_LEAST = 0.0005  # m: minimum tolerance of sizes
_JOINTS = re.compile(r"(?!extra_joints)(?:\w+_)?(?:joints?|joint_name|(?:wheels?|joints|dof|state)_names)")
_FRAMES = ("base_frame_id", "frame_id", "odom_frame_id")
_JOINT_STATES = "joint_state_broadcaster/JointStateBroadcaster"
_SIZES = ("radius", "separation", "wheelbase", "track", "width", "axis")


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Validate the controllers of a description for the ROS distribution of an output.

    Problems that do not depend on the distribution are reported only once.
    """
    robot, distribution, entry = case.robot, distro_of(output), ("outputs", output.name)
    is_first = output.name == next(one for one in robot.outputs if one.backend == output.backend).name
    if not robot.controllers:
        message = f'output "{output.name}" writes controllers, but the description has none'
        yield case.problem("controllers-none", message, entry, severity=WARNING, key=True)
    for found in against_kind(f"the {MANAGER}", kinds(distribution)[MANAGER], manager_parameters(output, distribution)):
        yield _placed(case, found, entry, "manager")
    if is_first:
        yield from _joint_states(case)
    blocks = {one.name: str(option) for one in robot.outputs if (option := one.options.get("control"))}
    if robot.control and blocks and described_by(distribution) not in map(described_by, blocks.values()):
        name, option = next(iter(blocks.items()))
        message = f'output "{output.name}" is for {distribution.capitalize()}, but the hardware blocks of output '
        message += f'"{name}" are for {option.capitalize()}'
        yield case.problem("controllers-distribution", message, case.value(entry, "distribution"), within=True)
    if not robot.is_tree or not is_whole(robot):
        return  # other rules report these errors
    owners: dict[tuple[str, str], str] = {}
    for one in fill(robot, distribution):
        findings = list(_findings(case, one, distribution))
        wrong = {found.key for found in findings}
        if one.kind is not None and one.kind.odometry and not wrong & {key for key, _ in _ENDS}:
            findings += _odometry(robot, one, str(output.options.get("namespace", "")))
        if is_first and not one.controller.inactive:
            findings += _claims(robot, one, owners)
        yield from (_placed(case, found, ("controllers", one.controller.name), "params") for found in findings)


def _claims(robot: Robot, one: ControllerParameters, owners: dict[tuple[str, str], str]) -> list[Finding]:
    """Report command interfaces that two controllers claim; ``owners`` maps claimed interfaces to controllers."""
    name, taken = one.controller.name, dict[tuple[str, str, str], list[str]]()
    for key, joints, words in _commands(one.type, one.values):
        for joint, word in ((joint, word) for joint in joints for word in words if "/" not in joint):
            if (owner := owners.setdefault((joint, word), name)) != name and joint in robot.joint:
                taken.setdefault((owner, word, key), []).append(joint)
    found = []
    for (owner, word, key), joints in list(taken.items())[:1]:
        message = f'controllers "{owner}" and "{name}" both claim the {word} of {quote(joints, most=4)}: '
        key = key if key in one.controller.params else ""
        found += [Finding("controller-interface", f"{message}the one that starts second fails", key, at_key=True)]
    return found


def _joint_states(case: Case) -> Iterator[Diagnostic]:
    rule, types = "controllers-joint-states", [full_type(one.type) for one in case.robot.controllers]
    components = [(block.name, joint) for block in case.robot.control for joint in block.joints]
    states = [(block, joint) for block, joint in components if joint.state]
    if types and states and _JOINT_STATES not in types:
        block, joint = states[0]
        message = f'no controller publishes the joint states of hardware block "{block}", such as that of '
        yield case.problem(rule, f'{message}"{joint.name}"', ("controllers",), key=True)
        return
    broadcaster = case.robot.controllers[types.index(_JOINT_STATES)].name if _JOINT_STATES in types else ""
    for still in case.robot.unmeasured_joints if types else ():
        blocks = [(block, joint) for block, joint in components if joint.name == still.name]
        why, path = "which no hardware block has", case.joint(still)
        help = f"in control: joints: {{{still.name}: {{state: [position]}}}}; or let a node publish the joint: "
        help += "publisher"
        if any(POSITION in joint.states for _, joint in blocks):
            why, path = f'which "params" of controller "{broadcaster}" exclude', ("controllers", broadcaster)
            help = 'remove "joints" and "interfaces" from "params"'
        elif blocks:
            why = f'which hardware block "{blocks[0][0]}" does not measure'
        message = f'no node publishes the position of joint "{still.name}", {why}: '
        message += f'"{still.child}" has no transform, and MoveIt waits for a complete state'
        yield case.problem(rule, message, path, help, key=True)


def _findings(case: Case, one: ControllerParameters, distribution: str) -> Iterator[Finding]:
    robot, controller, name = case.robot, one.controller, f'controller "{one.controller.name}"'
    wrong = of_type(controller.name, controller.type, distribution)
    yield from filter(None, [wrong])
    given = {key: one.values[key] for key in controller.params}
    lists = {key: value for key, value in one.values.items() if isinstance(value, list)}
    found = list(against_kind(name, one.kind, {**lists, **given} if one.kind else given))
    yield from found
    right = {key: value for key, value in one.values.items() if key not in {finding.key for finding in found}}
    named = list(against_robot(name, one.type, right, one.known, robot, WARNING))
    if controller.inactive:
        named = [found._replace(severity=WARNING) if found.rule == "controller-interface" else found for found in named]
    joints = (joint.name for block in robot.control for joint in block.joints)
    are_right = wrong is None and not any(found.unknown for found in named) and all(map(robot.joint.get, joints))
    if (
        needed := missing_parameters(one.kind, one.values) if are_right else []
    ):  # misspelt names make parameters seem missing
        blocks = [block.name for block in robot.control if any(joint.command for joint in block.joints)]
        if one.known.why_not:
            help = f'the values cannot be derived, because {one.known.why_not}, or write the values in "params"'
        elif blocks and not controller.hardware and "joints" in needed:
            block = blocks[0] if len(blocks) == 1 else f"NAME, one of {first_of(blocks, 4)}"
            help = f'name the hardware block whose joints the controller moves: "hardware: {block}"'
        else:
            examples = facts("ros2_controllers")["examples"]
            help = f"write params: {{{', '.join(f'{key}: {examples.get(key, key.upper())}' for key in needed)}}}"
        message = f"{name} will not start without {quote(needed, most=4)}"
        yield Finding("controller-missing", message, "", help)
    frames = {*robot.link, *(end for edge in robot.edges for end in (edge.parent, edge.child))}
    for key, value in given.items():
        last = key.rpartition(".")[2]
        known = {*frames, "map", "odom", "world", "earth"} if last == "odom_frame_id" else frames
        if last in _FRAMES and isinstance(value, str) and value and value.lstrip("/") not in known:
            message = f'"{key}" of {name} is "{value}", which is not a frame of the robot'
            yield Finding("controller-name", message, key, Suggestion(value, known), unknown=value, known=known)
    yield from named


def _odometry(robot: Robot, one: ControllerParameters, space: str) -> Iterator[Finding]:
    """Report a drive controller without an odometry transform, or with a transform that differs from ``edges``."""
    params, name = one.controller.params, f'controller "{one.controller.name}"'
    key = next((key for key in ("enable_odom_tf", "odom_frame_id", "base_frame_id") if key in params), "")
    mine = [f"{edge.parent} -> {edge.child}" for edge in edges_of(robot, one.controller)]
    parent, child = (one.values.get(key, default) for key, default in _ENDS)
    prefix = str(one.values.get("tf_frame_prefix") or space).strip("/")
    if prefix and one.values.get("tf_frame_prefix_enable"):
        key, parent, child = "tf_frame_prefix_enable", f"{prefix}/{parent}", f"{prefix}/{child}"
    into, edge = next((edge for edge in robot.edges if edge.child == child), None), f"{parent} -> {child}"
    if not one.values.get("enable_odom_tf"):
        if mine and "enable_odom_tf" in params:
            message = f'{name} has to publish {mine[0]}, but "enable_odom_tf" is false'
            yield Finding("parameters-no-owner", message, key, 'remove "enable_odom_tf"')
        elif not mine and into is None:
            message = f'{name} does not publish the transform to {child}: no entry of "edges" names it as publisher'
            help = f'add "{{parent: {parent}, child: {child}, publisher: {one.controller.name}}}" to "edges"'
            yield Finding("controllers-odometry", message, "", help, NOTE)
    elif mine and edge not in mine:
        message = f"{name} publishes {edge}, but the description has {mine[0]}"
        yield Finding("parameters-other-edge", message, key, f'remove "{key}": the frames come from the description')
    elif not mine and into is not None:
        message = f"{name} publishes {edge}, but in the description the publisher of {into.parent} -> {child} is "
        yield Finding("parameters-two-owners", message + into.publisher.name, key, 'remove "enable_odom_tf"')
    elif not mine:
        message = f'{name} publishes {edge}, which is not in "edges" of the description'
        yield Finding("parameters-other-edge", message, key, 'remove "enable_odom_tf", or add the transform to "edges"')


def _placed(case: Case, found: Finding, entry: Path, within: str) -> Diagnostic:
    path: Path = (*entry, within)
    rest, here = found.key, value_at(case.tree, path)
    # A parameter "a.b" can be written as "a: {b: ...}" or "a.b: ...".
    while isinstance(here, Mapping) and (names := [one for one in here if f"{rest}.".startswith(f"{one}.")]):
        name = max(names, key=len)
        path, rest, here = (*path, name), rest[len(name) + 1 :], here[name]
    path = (*entry, found.key) if found.key in (value_at(case.tree, entry) or {}) else path
    key = found.at_key or not found.key or path == (*entry, within)
    path = path if found.key else entry
    value = value_at(case.tree, path)
    path = (*path, value.index(found.unknown)) if isinstance(value, Seq) and found.unknown in value else path
    help = case.suggest(path, found.unknown, found.known) if found.known else found.help
    return case.problem(found.rule, found.message, path, help, severity=found.severity, key=key)


def of_type(name: str, kind: str, distribution: str) -> Finding | None:
    """Validate a controller type for a ROS distribution ("" for any); return the problem, or None if it is valid."""
    known, every, plugin = plugins(distribution), plugins(""), full_type(kind)
    if plugin in known:
        return None
    message = f'controller "{name}" has the type "{kind}"'
    if plugin in every:
        others = phrase(one.capitalize() for one in DISTRIBUTIONS if plugin in plugins(one))
        message += f", which exists only in {others}, not in {distribution.capitalize()}"
        return Finding("controller-type", message, "type", 'use another type, or another "distribution" in the output')
    short = facts("ros2_ports")["controllers"]["short"]
    words = [*known, *(word for word, of in short.items() if of in known)]
    package, packages = kind.partition("/")[0], {*every.values(), *(one.partition("/")[0] for one in every)}
    help = Suggestion(kind, words, instead=f"short words: {', '.join(short)}; any other is PACKAGE/CLASS")
    if "/" not in kind or package in packages:
        return Finding("controller-type", f"{message}, which does not exist", "type", help)
    meant = nearest(package, packages)  # no error: a package with a similar name may exist
    is_near = meant and abs(len(meant) - len(package)) < 2 and nearest(kind, words)
    message += " of an unknown package, so its parameters are not checked"
    return Finding("controller-type", message, "type", help if is_near else "", WARNING if is_near else NOTE)


def missing_parameters(kind: Kind | None, given: Iterable[str]) -> list[str]:
    """Return the required parameters that are not in ``given``, not even under a misspelt name."""
    if kind is None:
        return []
    meant = {nearest(key, kind.suggestions(key)) for key in given if kind.key(key) is None}  # misspelt keys
    return [key.name for key in kind.own_keys() if key.needed and key.name not in given and key.name not in meant]


def against_robot(
    name: str,
    kind: str,
    values: Mapping[str, Any],
    known: RobotParameters,
    robot: Robot,
    severity: str,
    others: Iterable[str] = (),
) -> Iterator[Finding]:
    """Report parameters of a controller that disagree with a robot.

    ``known`` are the parameters derived from the robot; ``severity`` is used for values that differ from them.
    ``others`` are controllers that are not in the description, but to whose joints "CONTROLLER/JOINT" may refer.
    """
    moving = {joint.name for joint in robot.joints if not joint.is_fixed}
    controllers = {*(controller.name for controller in robot.controllers), *others}
    for key, value in values.items():
        wrong = []
        for one in _texts(value) if _JOINTS.fullmatch(key) else ():
            _, slash, joint = one.rpartition("/")
            if slash and joint in moving and (one.partition("/")[0] in controllers or not robot.controllers):
                continue  # CONTROLLER/JOINT is a reference interface of a chained controller
            if one not in moving:
                what = "a fixed joint" if one in robot.joint else "which is not a joint of the robot"
                message, help = f'"{key}" of {name} lists "{one}", {what}', Suggestion(one, moving)
                wrong.append(Finding("controller-name", message, key, help, unknown=one, known=moving))
        yield from wrong
        if not wrong and key in known.values:
            yield from _differing(name, key, value, known.values[key], severity)
    if robot.control:
        yield from _interfaces(name, kind, values, robot)


def _texts(value: Any) -> list[str]:
    return [one for one in (value if isinstance(value, (list, tuple)) else [value]) if isinstance(one, str) and one]


def _differing(name: str, key: str, value: Any, expected: Any, severity: str) -> Iterator[Finding]:
    is_size = "multiplier" not in key and key.rpartition(".")[2].rpartition("_")[2].lower() in _SIZES
    if _JOINTS.fullmatch(key):
        claimed = sorted(one.rpartition("/")[2] for one in _texts(value))  # removes CONTROLLER/ of chained controllers
        if claimed != sorted(_texts(expected)) and key not in ("joints", "joint"):
            both = [quote(map(str, one)) if isinstance(one, (list, tuple)) else f'"{one}"' for one in (value, expected)]
            message = f'"{key}" of {name} is {both[0]}, but "drive" has {both[1]}'
            yield Finding("controller-differs", message, key, "correct one of the two", severity)
    elif (is_size or key.startswith("kinematics.base_frame_offset")) and isinstance(expected, float):
        allowed = max(_LEAST, _TOLERANCE * abs(expected))
        if isinstance(value, (int, float)) and abs(value - expected) > allowed:
            message = f'"{key}" of {name} is {value:.6g}, but the robot has {expected:.6g}'
            yield Finding("controller-differs", message, key, f"write {expected:.6g}, or correct the robot", severity)


def _commands(kind: str, values: Mapping[str, Any]) -> Iterator[tuple[str, list[str], list[str]]]:
    about = interfaces_of(kind)
    joints_key = about.get("joints", "joints")
    joints_key = about["instead"] if values.get(about.get("instead", "")) else joints_key
    for key, value in values.items():
        if "drive" in about and _JOINTS.fullmatch(key) and "state" not in key:
            front = key.startswith("front_wheels") == values.get("front_steering", True)
            steers = "steering" in key or (key in ("front_wheels_names", "rear_wheels_names") and front)
            words = [POSITION if steers else VELOCITY]
        elif key == joints_key:
            words = _texts(about.get("command")) or _texts(values.get(about.get("commands", "")))
        else:
            continue
        if words and (joints := list(dict.fromkeys(_texts(value)))):
            yield key, joints, words


def _interfaces(name: str, kind: str, values: Mapping[str, Any], robot: Robot) -> Iterator[Finding]:
    joints = [one for block in robot.control for one in block.joints]
    there = {(one.name, word) for one in joints for word in one.commands}
    about, reads = interfaces_of(kind), list[tuple[str, str, str]]()
    for key, names, every in _commands(kind, values):
        words = [word for word in every if word in JOINT_WORDS]
        if lacking := [one for one in names if one in robot.joint and any((one, word) not in there for word in words)]:
            message = f"{name} commands the {phrase(words)} of {quote(lacking, most=4)}, which no hardware block has"
            help = f'add "joints: {{{lacking[0]}: {{command: {words[0]}}}}}" to a block of "control"'
            yield Finding("controller-interface", message, key, help)
        if "drive" in about:
            by_position = every == [POSITION] or values.get("position_feedback", about["turning"] == POSITION)
            reads += [(key, joint, POSITION if by_position else VELOCITY) for joint in names]
    if "drive" not in about:
        key = about.get("joints", "joints")
        words = about.get("reads") or _texts(values.get(about.get("states", "")))
        reads = [(about.get("states", key), joint, word) for joint in _texts(values.get(key)) for word in words]
    states = {(one.name, word) for one in joints for word in one.states}
    for key, joint, word in reads:
        if joint in robot.joint and (joint, word) not in states:
            message = f'{name} reads the {word} of "{joint}", which no hardware block has: it does not become active'
            help = f"in control: joints: {{{joint}: {{state: [{word}]}}}}, if the hardware measures it"
            yield Finding("controller-interface", message, key, help)
            break
    sensors = {one.name: one.states for block in robot.control for one in block.sensors}
    chooses = any(key.startswith("interface_names.") for key in values)  # each interface has a parameter
    needed = () if chooses else sensor_words(about.get("sensor", ""))
    for sensor in [one for one in _texts(values.get("sensor_name")) if one in sensors]:
        if lacking := [f"{sensor}/{word}" for word in needed if word not in sensors[sensor]]:
            message = f"{name} reads {quote(lacking, most=4)}, which no hardware block has: it does not become active"
            help = f'remove "state" of sensor "{sensor}" in "control": it then has all interfaces of its type'
            yield Finding("controller-interface", message, "sensor_name", help)
    for sensor in [one for one in _texts(values.get("sensor_name")) if one not in sensors]:
        message = f'"sensor_name" of {name} is "{sensor}", but no hardware block has a sensor with this name'
        help_ = Suggestion(sensor, sensors, none=f'add "sensors: {{{sensor}: {{}}}}" to a block of "control"')
        found = Finding("controller-interface", message, "sensor_name", help_)
        yield found if about else found._replace(severity=WARNING)  # the parameter can have another meaning


FORMAT = parameter_file(
    "controllers",
    word="controllers.yaml",
    about="the parameters of ros2_control's controllers",
    rank=61,
    covers=("robot", "controllers", "drive"),
    unsupported={"controllers.*.inactive": Unsupported("the launch file of a package starts it so", quiet=True)},
    file="controllers.yaml",
    check=check,
    write=write,
    view=view,
)
