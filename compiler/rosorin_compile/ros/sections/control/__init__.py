"""The section ``control``: hardware blocks, which become ``<ros2_control>`` elements for Humble or Jazzy.

Sources: ``ros-controls/ros2_control@{humble,jazzy}:hardware_interface/src/component_parser.cpp``,
``resource_manager.cpp`` and ``mock_components/generic_system.cpp``.
"""

import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from rosorin_compile.formats.format import HUMBLE
from rosorin_compile.formats.templating import Templates
from rosorin_compile.formats.urdf.write import joints_of
from rosorin_compile.language.lower import Problem, entries_of, record_of
from rosorin_compile.model import Joint, Output, Robot
from rosorin_compile.model.link import NO_SOURCE, Source
from rosorin_compile.model.sections import Section
from rosorin_compile.rules.case import Case, number
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, Help, Suggestion, first_of, quote
from rosorin_compile.source.numbers import NumberFormat
from rosorin_compile.source.rule_registry import Heading, rule
from rosorin_compile.source.tree import Map, Path, Seq, value_at
from rosorin_compile.source.units import Quantity, describe, parse_unit
from rosorin_compile.source.wording import suggest, swaps

from ...ports import described_by, facts

SYSTEM, ACTUATOR, SENSOR = "system", "actuator", "sensor"

POSITION, VELOCITY, EFFORT, ACCELERATION = "position", "velocity", "effort", "acceleration"
# From hardware_interface/types/hardware_interface_type_values.hpp in ros-controls/ros2_control@jazzy.
JOINT_WORDS = (POSITION, VELOCITY, ACCELERATION, EFFORT)

Words = Mapping[str, str | float | bool]
OPTION = "control"
# Synonyms that users write instead of the interface names of ros2_control.
_WORDS = {"pos": POSITION, "vel": VELOCITY, "speed": VELOCITY, "torque": EFFORT, "force": EFFORT, "acc": ACCELERATION}
_UNITS = {POSITION: ("rad", "m"), VELOCITY: ("rad/s", "m/s"), EFFORT: ("N*m", "N"), ACCELERATION: ("rad/s^2", "m/s^2")}
_LATER = {"group": "group", "rate": "rate", "is_async": "async", "thread_priority": "thread_priority"}


def sensor_words(kind: str) -> tuple[str, ...]:
    """Return the names of the state interfaces of a sensor type, or () for an unknown type."""
    return tuple(facts("ros2_ports")["sensor_interfaces"].get(kind, ()))


@dataclass(frozen=True)
class Interface:
    """A command or state interface of a joint, sensor or GPIO; ``min``, ``max`` and ``initial`` are None if not set."""

    name: str
    min: float | None = None
    max: float | None = None
    initial: float | None = None
    data_type: str = ""
    size: int | None = None
    params: Words = field(default_factory=dict)


@dataclass(frozen=True)
class Component:
    """A joint, sensor or GPIO of a hardware block, with its command and state interfaces.

    If ``limits`` is True, the limits of the joint are written to its command interfaces; "urdf" leaves them to the
    URDF, and False disables limits. If ``mimic`` is False, the hardware does not make a mimic joint follow its leader.
    """

    name: str
    command: tuple[Interface, ...] = ()
    state: tuple[Interface, ...] = ()
    params: Words = field(default_factory=dict)
    limits: bool | str = True
    mimic: bool | None = None

    @property
    def commands(self) -> tuple[str, ...]:
        return tuple(one.name for one in self.command)

    @property
    def states(self) -> tuple[str, ...]:
        return tuple(one.name for one in self.state)


@dataclass(frozen=True)
class End:
    """A joint or an actuator of a transmission; ``reduction`` and ``offset`` (rad or m) are None if not set."""

    name: str
    role: str = ""
    reduction: float | None = None
    offset: float | None = None


@dataclass(frozen=True)
class Transmission:
    """A transmission between actuators and joints."""

    name: str
    plugin: str
    joints: tuple[End, ...] = ()
    actuators: tuple[End, ...] = ()


@dataclass(frozen=True)
class Block:
    """A hardware block, which becomes a ``<ros2_control>`` element.

    ``pose`` is the pose with the initial joint positions, ``rate`` is the update rate (Hz). Humble does not support
    ``group``, ``rate``, ``is_async`` and ``thread_priority``.
    """

    name: str
    type: str
    plugin: str
    params: Words = field(default_factory=dict)
    joints: tuple[Component, ...] = ()
    sensors: tuple[Component, ...] = ()
    gpio: tuple[Component, ...] = ()
    transmissions: tuple[Transmission, ...] = ()
    pose: str = ""
    group: str = ""
    rate: int | None = None
    is_async: bool | None = None
    thread_priority: int | None = None
    source: Source = NO_SOURCE

    def components(self) -> Iterator[tuple[str, Component]]:
        """Yield (key, component) for each joint, sensor and GPIO; the key is "joints", "sensors" or "gpio"."""
        for section, found in (("joints", self.joints), ("sensors", self.sensors), ("gpio", self.gpio)):
            yield from ((section, one) for one in found)


def hardware_distro(output: Output) -> str:
    """Return "humble" or "jazzy", as in the option ``control`` of an output, or "" if the option is not set."""
    option = output.options.get(OPTION)
    return described_by(str(option)) if option else ""


def blocks(robot: Robot, output: Output, number: NumberFormat) -> list[str]:
    """Return the ``<ros2_control>`` elements of the hardware blocks, or [] if the output does not contain them."""
    distribution = hardware_distro(output)
    humble = distribution == HUMBLE

    def word(value: object) -> str:
        if isinstance(value, bool):
            return "true" if value else "false"
        return number(value) if isinstance(value, float) else str(value)

    def given(values: Mapping[str, Any]) -> dict[str, Any]:
        return {key: value for key, value in values.items() if value is not None}

    texts = []
    for block in robot.control if distribution else ():
        mimics: dict[str, dict[str, dict[str, Any]]] = {}
        for one in block.joints:
            joint, attributes, params = robot.joint[one.name], dict[str, Any](), dict[str, Any]()
            if joint.mimic is not None and not humble:
                attributes = {"mimic": follows(joint, one)}
            elif joint.mimic is not None and follows(joint, one):
                params = {"mimic": joint.mimic.joint, "multiplier": joint.mimic.multiplier}
            mimics[one.name] = {"attributes": attributes, "params": params}
        values = {"word": word, "given": given, "humble": humble, "block": block, "mimics": mimics}
        values["joints"] = [_joint(robot, block, one) for one in block.joints]
        later = {"rw_rate": block.rate, "is_async": block.is_async, "thread_priority": block.thread_priority}
        values["attributes"] = {} if humble else given(later)
        texts.append(Templates.own("ros/ros2_control.xml.jinja", values).rstrip("\n"))
    return texts


def _joint(robot: Robot, block: Block, one: Component) -> Component:
    """Set missing command limits from the joint, and the initial position from the pose of the block."""
    joint = robot.joint[one.name]

    def command(it: Interface) -> Interface:
        low, high = joint.limits_of(it.name) if one.limits is True else (None, None)
        return replace(it, min=low if it.min is None else it.min, max=high if it.max is None else it.max)

    def state(it: Interface) -> Interface:
        starts = it.name == POSITION and it.initial is None and block.pose
        return replace(it, initial=robot.position(joint, robot.positions(block.pose))) if starts else it

    return replace(one, command=tuple(map(command, one.command)), state=tuple(map(state, one.state)))


def follows(joint: Joint | None, component: Component) -> bool:
    """Return True if the joint mimics another joint and the hardware makes it follow."""
    return joint is not None and joint.mimic is not None and component.mimic is not False


def check_control(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Validate the hardware blocks for an output; problems that affect all outputs are reported only once."""
    if not case.robot.control:
        message = f'output "{output.name}" has the option "control", but the description has no hardware blocks'
        help = 'add "control: {NAME: {plugin: PLUGIN, joints: {JOINT: {command: position}}}}" to the description'
        yield case.problem("control-ignored", message, ("outputs", output.name, OPTION), help)
        return
    first = next((one for one in case.robot.outputs if one.backend == output.backend and hardware_distro(one)), None)
    if first is not None and first.name == output.name:
        owners: dict[tuple[str, str, str], Block] = {}
        for block in case.robot.control:
            yield from _block(case, block, owners)
    if not case.robot.is_tree:  # another rule reports this; joints_of requires a tree
        return
    carried = {joint.name for joint in joints_of(case.robot, output)}
    for block in case.robot.control:
        for one in block.joints:
            if one.name in case.robot.joint:  # unknown joints are reported by another rule
                yield from _check_joint(case, block, one, output, one.name in carried)
        if hardware_distro(output) != HUMBLE:
            continue
        unread: list[Path] = [(key,) for field, key in _LATER.items() if getattr(block, field) not in (None, "")]
        for section, one in block.components():
            for key, _, interface in _interfaces(one) if section != "gpio" else ():
                words = [word for word in ("data_type", "size") if getattr(interface, word) not in (None, "")]
                unread += [(section, one.name, key, interface.name, word) for word in words]
        for path in unread:
            message = f'Humble ignores "{path[-1]}"{" here" if path[1:] else ""}'
            yield _problem(case, block, "control-ignored", message, path, key=True)


def _problem(case: Case, block: Block, rule: str, message: str, path: Path, help: Help = "", **more: Any) -> Diagnostic:
    return case.problem(rule, f'hardware block "{block.name}": {message}', ("control", block.name, *path), help, **more)


def _interfaces(one: Component) -> Iterator[tuple[str, int, Interface]]:
    yield from (("command", *numbered) for numbered in enumerate(one.command))
    yield from (("state", *numbered) for numbered in enumerate(one.state))


def _block(case: Case, block: Block, owners: dict[tuple[str, str, str], Block]) -> Iterator[Diagnostic]:
    """Validate a block independently of outputs; ``owners`` maps each interface to the first block that has it."""
    problem = partial(_problem, case, block)
    if block.type == ACTUATOR and len(block.joints) != 1:
        message = f"a block of type actuator must have one joint, not {len(block.joints)}"
        yield problem("control-type", message, ("type",), 'write "type: system", or split the block')
    yield from _params(case, block, block.params, "the block", ())
    for section, one in block.components():
        path, of = (section, one.name), f'{section.removesuffix("s")} "{one.name}"'
        if one.command and block.type == SENSOR:
            message = f'"{one.name}" has commands, but a block of type sensor accepts none'
            yield problem("control-type", message, (*path, "command"), key=True)
        yield from _params(case, block, one.params, of, path)
        for name in [name for name in ("mimic", "multiplier") if section == "joints" and name in one.params]:
            message = f'{of} has a parameter "{name}", which is taken from "mimic" of the joint'
            yield problem("control-param", message, (*path, "params", name), f'remove "{name}" from "params"', key=True)
        yield from _words(case, block, section, one, of)
        if section == "joints" and one.name not in case.robot.joint:
            continue  # unknown joints are reported by another rule
        for key, _, interface in _interfaces(one) if section == "joints" else ():
            is_sliding, name = case.robot.joint[one.name].type == "prismatic", f'{interface.name} of joint "{one.name}"'
            wanted = _UNITS.get(interface.name, ("", ""))[is_sliding]
            unit = parse_unit(wanted) if wanted else None
            for place in [(*path, key, interface.name, word) for word in ("min", "max", "initial")]:
                value = value_at(case.tree, ("control", block.name, *place))
                if unit is not None and isinstance(value, Quantity) and value.dimension != unit[1]:
                    message = f"the {name} must be {describe(unit[1])}, but {value.text or number(value)} is "
                    yield problem("wrong-unit", message + describe(value.dimension), place, f"write it in {wanted}")
            low, high = interface.min, interface.max
            if low is not None and high is not None and low > high:
                message = f"min of the {name} is {number(low)}, above max {number(high)}"
                yield problem("control-limit", message, (*path, key, interface.name, "min"))
        for key, names in (("command", one.commands), ("state", one.states)):
            firsts = {name: owners.setdefault((key, one.name, name), block) for name in names}
            if taken := [name for name, first in firsts.items() if first is not block]:
                first = firsts[taken[0]]
                message = f'"{one.name}" has the {key} {quote(taken)}, which hardware block "{first.name}" also has'
                there = case.related_place("first defined here", ("control", first.name, section, one.name), key=True)
                yield problem("control-interface", message, path, related=[there], key=True)


def _params(case: Case, block: Block, params: Words, of: str, path: Path) -> Iterator[Diagnostic]:
    for name, value in params.items():
        if isinstance(value, str) and not value.strip():
            message = f'the parameter "{name}" of {of} is empty, so ros2_control cannot parse the URDF'
            yield _problem(case, block, "control-param", message, (*path, "params", name))


def _words(case: Case, block: Block, section: str, one: Component, of: str) -> Iterator[Diagnostic]:
    problem, path = partial(_problem, case, block, "control-interface"), (section, one.name)
    types = {sensor.name: sensor.type for sensor in case.robot.sensors}
    if not one.command and not one.state:
        details = "list the interfaces under " + ('"state"' if section == "sensors" else '"command" and "state"')
        help: Help = Suggestion(one.name, types, details=details) if section == "sensors" else details
        severity = ERROR if section == "sensors" else WARNING
        yield problem(f"{of} has no interface", path, help, severity=severity, key=True)
    known = {"joints": JOINT_WORDS, "sensors": sensor_words(types.get(one.name, ""))}.get(section, ())
    for key, index, interface in _interfaces(one):
        entry, word = value_at(case.tree, ("control", block.name, *path, key)), interface.name
        steps = {Map: (word,), Seq: (index,)}.get(type(entry), ())  # an entry that is a string has no items
        place: Path = (*path, key, *steps)
        if (near := _WORDS.get(word.casefold(), "")) not in known:
            near = next(iter(difflib.get_close_matches(word.casefold(), known, n=1, cutoff=0.8)), "")
        if near and word not in known:  # custom names are allowed, but not misspelt standard names
            severity = ERROR if near in swaps(word) else WARNING
            message = f'{of} has the {key} "{word}", which no controller claims'
            yield problem(message, place, suggest(near), severity=severity, key=place[-1] == word)
        yield from _params(case, block, interface.params, f'the {key} "{word}" of {of}', place)


def _check_joint(case: Case, block: Block, one: Component, output: Output, is_carried: bool) -> Iterator[Diagnostic]:
    humble, joint, path = hardware_distro(output) == HUMBLE, case.robot.joint[one.name], ("joints", one.name)
    problem = partial(
        _problem, case, block, related=[case.related_place("the joint", case.joint(joint), key=True)], key=True
    )
    name = f'joint "{one.name}"'
    if not joint.moves:
        message = f"{name} is {joint.type}, so it cannot be controlled"
        yield problem("control-joint", message, path, "remove it from the block")
        return
    if not is_carried:
        why = "Humble ignores this, but newer versions reject the URDF" if humble else "ros2_control rejects the URDF"
        severity = WARNING if humble else ERROR
        yield problem("control-joint", f"{name} is not in {output.file}: {why}", path, severity=severity)
    if one.mimic and joint.mimic is None:
        message = f'{name} has "mimic: true" here, but the joint itself has no "mimic"'
        yield problem("control-mimic", message, (*path, "mimic"), 'remove it, or add "mimic" to the joint', key=False)
    if not follows(joint, one) or joint.mimic is None:
        return
    name = f'{name} mimics "{joint.mimic.joint}"'
    mimic = case.related_place('"mimic" of the joint', case.joint(joint, "mimic"), key=True)
    problem = partial(problem, "control-mimic", related=[mimic])
    if one.command and not humble:
        yield problem(f"{name}, and from Jazzy on, a mimic joint must not have a command", (*path, "command"))
    if (leader := joint.mimic.joint) not in [other.name for other in block.joints]:
        yield problem(f"{name}, which is not in the block", path, f'add "{leader}" to it, or write "mimic: false"')
    if humble and joint.mimic.offset:
        help = 'remove "offset" from "mimic", or write "mimic: false" in the block'
        yield problem(f"{name} with an offset, which mock hardware of Humble ignores", path, help, severity=WARNING)


def control_of(tree: Mapping[str, Any], _: Problem) -> tuple[Block, ...]:
    """Parse the section ``control``; a sensor without interfaces gets the interfaces of its type."""
    types = {name: entry.get("type", "") for name, entry in (tree.get("sensors") or {}).items()}

    def complete(sensor: Component, entry: Mapping[str, Any] | None) -> Component:
        words = sensor_words(types.get(sensor.name, ""))
        return sensor if "state" in (entry or {}) else replace(sensor, state=tuple(map(Interface, words)))

    made = []
    for name, entry in entries_of(tree, "control"):
        block = record_of(Block, entry, name=name, type=entry.get("type", SYSTEM), is_async=entry.get("async"))
        sensors = tuple(complete(sensor, entry["sensors"][sensor.name]) for sensor in block.sensors)
        made.append(replace(block, sensors=sensors))
    return tuple(made)


@rule("control-unused", "A note: no output has the hardware blocks.", "`control: jazzy` in the URDF.", Heading.CONTROL)
def control_unused(case: Case) -> Iterator[Diagnostic]:
    """Report hardware blocks that no output requests with its option ``control``."""
    blocks = case.robot.control
    if blocks and not any(output.options.get("control") for output in case.robot.outputs):
        message = f"no output contains the hardware blocks ({first_of([one.name for one in blocks], 3)})"
        yield case.problem("control-unused", message, ("control",), 'add "control: jazzy" to a URDF output', key=True)


@rule("control-pose", "A hardware block starts in a pose that does not exist.", "Name one of `poses`.", Heading.CONTROL)
@rule(
    "control-transmission",
    "A transmission moves a joint that its block does not have, or has no joint or no actuator.",
    "Name a joint of the same block.",
    Heading.CONTROL,
)
def control_names(case: Case) -> Iterator[Diagnostic]:
    """Report hardware blocks that name an unknown pose, and transmissions that name an unknown joint."""
    poses = [pose.name for pose in case.robot.poses]
    for block in case.robot.control:
        called, own = f'hardware block "{block.name}"', [one.name for one in block.joints]
        if block.pose and block.pose not in poses:
            path: Path = ("control", block.name, "pose")
            message = f'{called} starts in pose "{block.pose}", which does not exist'
            help = case.suggest(path, block.pose, poses, none="the description has no poses")
            yield case.problem("control-pose", message, path, help)
        for one in block.transmissions:
            path = ("control", block.name, "transmissions", one.name)
            for key in [key for key in ("joints", "actuators") if not getattr(one, key)]:
                message = f'transmission "{one.name}" of {called} has no {key}'
                yield case.problem("control-transmission", message, (*path, key), f"list the {key}", key=True)
            for end in [end for end in one.joints if end.name not in own]:
                message = f'transmission "{one.name}" moves joint "{end.name}", which {called} does not have'
                help = case.suggest(path, end.name, own, "use a joint of the same block")
                yield case.problem("control-transmission", message, (*path, "joints", end.name), help, key=True)


SECTION: Section[tuple[Block, ...]] = Section(
    "control", lower=control_of, checks=(control_unused, control_names), urdf=blocks, check_urdf=check_control
)
