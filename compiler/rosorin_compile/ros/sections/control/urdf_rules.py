"""What a hardware block may not be: by itself, and in one URDF, as the parser of one distribution takes it.

Where the sources of these rules are, ``control`` says.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rosorin_compile.formats.format import HUMBLE
from rosorin_compile.formats.urdf.write import joints_of
from rosorin_compile.model import Joint, Output
from rosorin_compile.ros.sections.control.hardware import (
    ACCELERATION,
    ACTUATOR,
    EFFORT,
    JOINT_WORDS,
    POSITION,
    SENSOR,
    SENSOR_WORDS,
    VELOCITY,
    Block,
    Component,
    Interface,
    Words,
)
from rosorin_compile.rules.case import Case, number
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, Help, Suggestion, counted, quoted
from rosorin_compile.source.tree import Path, at
from rosorin_compile.source.units import Quantity, describe, parse_unit
from rosorin_compile.source.wording import suggest, swaps

from .urdf import OPTION, asked, follows

# What other tools and people write for the words of ros2_control.
_WORDS = {"pos": POSITION, "vel": VELOCITY, "speed": VELOCITY, "torque": EFFORT, "force": EFFORT, "acc": ACCELERATION}
_ALIKE = 0.8
_UNITS = {POSITION: ("rad", "m"), VELOCITY: ("rad/s", "m/s"), EFFORT: ("N*m", "N"), ACCELERATION: ("rad/s^2", "m/s^2")}
_LATER = {"group": "group", "rate": "rate", "is_async": "async", "thread_priority": "thread_priority"}


def check_control(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find what is wrong with the hardware blocks of an output; what holds for all outputs is reported once."""
    if not case.robot.control:
        message = f'output "{output.name}" asks for hardware blocks, and the description has none'
        path: Path = ("outputs", output.name, OPTION)
        help = "describe one: control: {NAME: {plugin: PLUGIN, joints: {JOINT: {command: position}}}}"
        yield case.problem("control-ignored", message, path, help)
        return
    first = next((one for one in case.robot.outputs if one.backend == output.backend and asked(one)), None)
    if first is not None and first.name == output.name:
        for block in case.robot.control:
            yield from _block(case, block)
        yield from _shared(case)
    if not case.robot.is_tree:  # the cause of the rest, and no output knows its links
        return
    carried = {joint.name for joint in joints_of(case.robot, output)}
    for block in case.robot.control:
        yield from _joints(case, block, output, carried)
        if asked(output) == HUMBLE:
            yield from _unread(case, block)


def _path(block: Block, *rest: str | int) -> Path:
    return ("control", block.name, *rest)


def _name(block: Block) -> str:
    return f'hardware block "{block.name}"'


def _interfaces(one: Component) -> Iterator[tuple[str, int, Interface]]:
    """Yield the interfaces of a component with the key and the place in the list."""
    for key, interfaces in (("command", one.command), ("state", one.state)):
        yield from ((key, index, interface) for index, interface in enumerate(interfaces))


def _block(case: Case, block: Block) -> Iterator[Diagnostic]:
    """Yield what is wrong with a block, whatever output has it."""
    if block.type == ACTUATOR and len(block.joints) != 1:
        has = counted(len(block.joints), "joint") if block.joints else "no joint"
        message = f"{_name(block)} is an actuator and has {has}: an actuator has one"
        yield case.problem("control-type", message, _path(block, "type"), "write type: system, or split it")
    for section, one in block.components() if block.type == SENSOR else ():
        if one.command:
            message = f'{_name(block)} is a sensor, and "{one.name}" has commands: a sensor takes none'
            path = _path(block, section, one.name, "command")
            yield case.problem("control-type", message, path, "leave them out, or write type: system", key=True)
    yield from _params(case, block.params, _name(block), _path(block, "params"))
    for section, one in block.components():
        yield from _component(case, block, section, one)
    for one in block.joints:
        if one.name in case.robot.joint:
            yield from _limits(case, block, case.robot.joint[one.name], one)


def _params(case: Case, params: Words, of: str, path: Path) -> Iterator[Diagnostic]:
    for name, value in params.items():
        if isinstance(value, str) and not value.strip():
            message = f'the parameter "{name}" of {of} is empty: ros2_control does not read the URDF then'
            yield case.problem("control-param", message, (*path, name), "give it a value, or leave it out")


def _component(case: Case, block: Block, section: str, one: Component) -> Iterator[Diagnostic]:
    """Yield what is wrong with the interfaces and parameters of a joint, a sensor or gpio."""
    path, of = _path(block, section, one.name), f'{section.removesuffix("s")} "{one.name}" of {_name(block)}'
    yield from _params(case, one.params, of, (*path, "params"))
    for name in ("mimic", "multiplier") if section == "joints" else ():
        if name in one.params:
            message = f'{of} has a parameter "{name}", which comes from the mimic of the joint'
            yield case.problem("control-param", message, (*path, "params", name), "leave it out", key=True)
    if not one.command and not one.state:
        severity = WARNING
        help: Help = "list its command and state interfaces: command, state"
        if section == "sensors":
            severity = ERROR
            details = "list its state interfaces: state; or give it the name of a sensor of the description"
            help = Suggestion(one.name, [sensor.name for sensor in case.robot.sensors], details=details)
        yield case.problem("control-interface", f"{of} has no interface", path, help, severity=severity, key=True)
    known: tuple[str, ...] = JOINT_WORDS if section == "joints" else ()
    if section == "sensors":
        kind = next((sensor.type for sensor in case.robot.sensors if sensor.name == one.name), "")
        known = SENSOR_WORDS.get(kind, ())
    for key, index, interface in _interfaces(one):
        written = at(case.tree, (*path, key))  # one word, a list, or a mapping
        place = (*path, key, interface.name) if isinstance(written, Mapping) else (*path, key)
        place = (*place, index) if isinstance(written, list) else place
        meant = _meant(interface.name, known)
        if meant:
            message = f'{of} has the {key} "{interface.name}", which no controller asks for'
            severity = ERROR if meant in swaps(interface.name) else WARNING  # two letters swapped are no other word
            by_key, help = place[-1] == interface.name, suggest(meant)
            yield case.problem("control-interface", message, place, help, severity=severity, key=by_key)
        yield from _params(case, interface.params, f'the {key} "{interface.name}" of {of}', (*place, "params"))


def _meant(word: str, known: tuple[str, ...]) -> str:
    """Return the word of ros2_control that another one nearly is, or ""; hardware may have words of its own."""
    import difflib

    folded = word.casefold()
    if not known or word in known:
        return ""
    if _WORDS.get(folded) in known:
        return _WORDS[folded]
    return next(iter(difflib.get_close_matches(folded, known, n=1, cutoff=_ALIKE)), "")


def _limits(case: Case, block: Block, joint: Joint, one: Component) -> Iterator[Diagnostic]:
    """Yield wrong units of the numbers of interfaces, and limits in the wrong order."""
    for section, _, interface in _interfaces(one):
        path = _path(block, "joints", one.name, section, interface.name)
        wanted = _UNITS.get(interface.name, ("", ""))[joint.type == "prismatic"]
        unit = parse_unit(wanted) if wanted else None
        for key in ("min", "max", "initial"):
            value = at(case.tree, (*path, key))
            if unit is not None and isinstance(value, Quantity) and value.dimension != unit[1]:
                message = f'the {interface.name} of joint "{joint.name}" is {describe(unit[1])}, but '
                message += f"{value.text or number(value)} is {describe(value.dimension)}"
                yield case.problem("wrong-unit", message, (*path, key), f"write it in {wanted}")
        if interface.min is not None and interface.max is not None and interface.min > interface.max:
            message = f'the {interface.name} of joint "{one.name}" goes from {number(interface.min)} to '
            message += f"{number(interface.max)} in {_name(block)}"
            yield case.problem("control-limit", message, (*path, "min"), "give the smaller one as min")


def _shared(case: Case) -> Iterator[Diagnostic]:
    """Yield the interfaces that two blocks have: the resource manager takes each once."""
    owners: dict[tuple[str, str, str], tuple[Block, Path]] = {}
    for block in case.robot.control:
        for section, one in block.components():
            if section == "joints" and one.name not in case.robot.joint:
                continue  # which has a rule of its own
            path = _path(block, section, one.name)
            for key, names in (("command", one.commands), ("state", one.states)):
                entries = [(key, one.name, name) for name in names]
                taken = [entry for entry in entries if owners.setdefault(entry, (block, path))[0] is not block]
                if taken:
                    first, there = owners[taken[0]]
                    words = quoted(name for *_, name in taken)
                    message = f'"{one.name}" has the {key} {words} in hardware blocks "{first.name}" and "{block.name}"'
                    related, help = [case.related("first said here", there, key=True)], "each interface has one owner"
                    yield case.problem("control-interface", message, path, help, related=related, key=True)


def _joints(case: Case, block: Block, output: Output, carried: set[str]) -> Iterator[Diagnostic]:
    """Yield what is wrong with the joints of a block in one URDF."""
    humble = asked(output) == HUMBLE
    for one in block.joints:
        joint = case.robot.joint.get(one.name)
        if joint is None:
            continue  # which has a rule of its own
        path = _path(block, "joints", one.name)
        related = [case.related("the joint", case.joint(joint), key=True)]
        if not joint.moves:
            message = f'joint "{one.name}" of {_name(block)} is {joint.type}: it has no position to control'
            help = "leave it out of the block, or correct the type of the joint"
            yield case.problem("control-joint", message, path, help, related=related, key=True)
            continue
        if joint.name not in carried:
            message = f'joint "{one.name}" of {_name(block)} is not in {output.file}'
            message += ": Humble does not miss it, other readers do" if humble else ": Jazzy refuses the URDF"
            help = "robot_state_publisher publishes what is in it; frames: all has every joint"
            severity = WARNING if humble else ERROR
            yield case.problem("control-joint", message, path, help, related=related, severity=severity, key=True)
        yield from _mimic(case, block, one, joint, humble)


def _mimic(case: Case, block: Block, one: Component, joint: Joint, humble: bool) -> Iterator[Diagnostic]:
    path = _path(block, "joints", one.name)
    if one.mimic and joint.mimic is None:
        message = f'joint "{one.name}" of {_name(block)} is to follow a leader, and the joint has no mimic'
        yield case.problem("control-mimic", message, (*path, "mimic"), "give the joint its mimic, or remove this")
    if not follows(joint, one) or joint.mimic is None:
        return
    leader, related = joint.mimic.joint, [case.related("its mimic", case.joint(joint, "mimic"), key=True)]
    if one.command and not humble:
        message = f'joint "{one.name}" of {_name(block)} follows "{leader}": on Jazzy a follower has no command'
        help = "leave the command out; or mimic: false, if the hardware moves it by itself"
        yield case.problem("control-mimic", message, (*path, "command"), help, related=related, key=True)
    if leader not in [other.name for other in block.joints]:
        message = f'joint "{one.name}" follows "{leader}", which is not in {_name(block)}'
        help = "add it to the block; or mimic: false, if the hardware moves this one by itself"
        yield case.problem("control-mimic", message, path, help, related=related, key=True)
    if humble and joint.mimic.offset:
        message = (
            f'joint "{one.name}" follows "{leader}" with an offset, which the mock hardware of Humble does not know'
        )
        help = "it is at the product alone there"
        yield case.problem("control-mimic", message, path, help, related=related, severity=WARNING, key=True)


def _unread(case: Case, block: Block) -> Iterator[Diagnostic]:
    """Yield the keys that Humble does not read."""
    unread = [
        (f"{key} of {_name(block)}", _path(block, key))
        for field, key in _LATER.items()
        if getattr(block, field) not in (None, "")
    ]
    for section, one in block.components():
        for key, _, interface in _interfaces(one) if section != "gpio" else ():
            path = _path(block, section, one.name, key, interface.name)
            for word, value in (("data_type", interface.data_type), ("size", interface.size)):
                if value not in (None, ""):
                    unread.append((f'{word} of "{one.name}" {interface.name}, only of gpio', (*path, word)))
    for what, path in unread:
        message, help = f"{HUMBLE.capitalize()} does not read {what}", "leave it out, or ask for a later distribution"
        yield case.problem("control-ignored", message, path, help, key=True)
