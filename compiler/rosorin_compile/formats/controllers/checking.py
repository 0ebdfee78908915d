"""Parameters of a controller held against the table of its type, and against what the robot knows.

The same is asked of what a description says and of a file that people have: ``Finding`` names the key, who asks knows
where that was written.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from ...diagnostics import ERROR, NOTE, WARNING, Diagnostic, Related, Span, did_you_mean
from ...diagnostics.registry import CONTROL, Rule
from ...diagnostics.wording import listed, quoted
from ...model import Robot
from ...model.control import JOINT_WORDS, POSITION, VELOCITY
from ..distributions import title
from .known import COMMANDS, Known
from .tables import SHORT, Key, Table, full, is_of_all_nodes, other, plugins, table
from .values import converted, fits, refused, told, type_in_words

RULES = (
    Rule(
        "controller-type",
        "A distribution has no controller of this type. A note where it is of another package: its parameters are not "
        "checked.",
        "The message names the nearest one, or the distribution that has it.",
        CONTROL,
    ),
    Rule(
        "controller-key",
        "A controller, or the controller_manager, has no such parameter: it would be ignored in silence. The message "
        "says if another distribution has it.",
        "Correct the name, or remove it.",
        CONTROL,
    ),
    Rule(
        "controller-value",
        "The value of a parameter is of another type, which stops the controller when it starts, or one that its "
        "validators refuse.",
        "Write what the message asks for: `1.0` where a double is wanted.",
        CONTROL,
    ),
    Rule(
        "controller-missing",
        "A controller needs a parameter that nobody gives it.",
        "Give it; or say in the description what it follows from: `drive`, `sensors`, `control`.",
        CONTROL,
    ),
    Rule(
        "controller-name",
        "A controller names a joint, a frame or a sensor that the robot does not have.",
        "Correct the name.",
        CONTROL,
    ),
    Rule(
        "controller-differs",
        "A controller is told something else than the robot says: the radius of a wheel, the distance between two, "
        "which is on the left. A warning in a description.",
        "Correct one of the two; what is left out of a description is filled in.",
        CONTROL,
    ),
    Rule(
        "controller-interface",
        "A warning: a controller commands what no hardware block has.",
        "Give the joint this command in `control`, or name another joint.",
        CONTROL,
    ),
)

_TOLERANCE = 0.005  # of a size: people round, and measure wheels that are pressed flat
_LEAST = 0.0005  # m
_JOINTS = re.compile(r"(?:\w+_)?(?:joints?|joint_name|wheels?_names|joints_names|dof_names|state_names)")
_NOT_OF_URDF = ("extra_joints",)
_FRAMES = ("base_frame_id", "frame_id", "odom_frame_id")
_WORLD = ("map", "odom", "world", "earth")
_MANY = 12
_SIZES = ("radius", "separation", "wheelbase", "track", "width", "axis")


class Finding(NamedTuple):
    """Something wrong with a parameter; ``key`` is empty for the controller as a whole, ``at_key``: the name of it."""

    rule: str
    message: str
    key: str = ""
    help: str = ""
    severity: str = ERROR
    at_key: bool = False


def of_type(name: str, kind: str, distribution: str) -> Finding | None:
    """Return what is wrong with the type of a controller; ``distribution`` is humble or jazzy."""
    known, wanted = plugins(distribution), full(kind)
    if wanted in known:
        return None
    said, where = f'the controller "{name}" is of type "{kind}"', title(distribution)
    if wanted in plugins(other(distribution)):
        message = f"{said}, which {where} does not have; {title(other(distribution))} has it"
        return Finding("controller-type", message, "type", "take another type, or ask for that distribution")
    help = did_you_mean(kind, [*known, *(word for word, of in SHORT.items() if of in known)])
    package = kind.partition("/")[0]
    if help.startswith("did") or package in known.values() or "/" not in kind:
        help = help if help.startswith("did") else _listed(known, package)
        return Finding("controller-type", f"{said}, which there is not on {where}", "type", help)
    message = f"{said}, of a package that is not known: its parameters are not checked"
    return Finding("controller-type", message, "type", "", NOTE)


def _listed(known: Mapping[str, str], package: str) -> str:
    of = [one for one, its in known.items() if its == package]
    return f"{package} has {listed(of)}" if of else f"short words: {', '.join(SHORT)}; any other is PACKAGE/CLASS"


def against_table(
    name: str, table: Table | None, its: Table | None, values: Mapping[str, Any], distribution: str
) -> Iterator[Finding]:
    """Yield what is wrong with parameters by their table; ``its`` is that of the other distribution.

    ``values`` are those that were said, by full key; ``name`` says whose they are.
    """
    if table is None:
        return
    for key, value in values.items():
        if is_of_all_nodes(key):
            continue
        found = table.find(key)
        if found is None:
            yield _unknown(name, key, table, its, values, distribution)
            continue
        yield from _value(name, key, value, found)
        many, one = table.mapped(key)
        given = values.get(many)
        if many and isinstance(given, (list, tuple)) and one not in given:
            message = f'"{key}" of {name} is about "{one}", which is not in its {many}: nobody reads it'
            yield Finding("controller-key", message, key, did_you_mean(one, set(map(str, given))), at_key=True)


def _unknown(
    name: str, key: str, table: Table, its: Table | None, values: Mapping[str, Any], distribution: str
) -> Finding:
    """Return what to say of a key that a table does not have."""
    message = f'{name} has no parameter "{key}" on {title(distribution)}: nobody reads it'
    if its is not None and key in its:
        message = (
            f'"{key}" of {name} is a parameter of {title(other(distribution))}: {title(distribution)} does not read it'
        )
    help = did_you_mean(key, _with_values(table, values))
    if help.startswith("known"):
        last = key.rpartition(".")[2]
        same = [one for one in table.names() if one.rpartition(".")[2] == last]
        help = (
            f'did you mean "{same[0]}"?' if len(same) == 1 else "" if its is not None and key in its else _known(table)
        )
    return Finding("controller-key", message, key, help or "remove it", at_key=True)


def _known(table: Table) -> str:
    names = table.shown()
    more = f" and {len(names) - _MANY} more" if len(names) > _MANY else ""
    return f"known: {', '.join(sorted(names)[:_MANY])}{more}"


def _with_values(table: Table, values: Mapping[str, Any]) -> Iterator[str]:
    """Yield the keys of a table, those of lists for each value that is given."""
    for name in table.shown():
        many = re.search(r"<(\w+)>", name)
        given = values.get(many[1]) if many else None
        if many and isinstance(given, (list, tuple)):
            yield from (name.replace(many[0], str(one)) for one in given)
        elif not many:
            yield name


def _value(name: str, key: str, value: Any, found: Key) -> Iterator[Finding]:
    if not fits(value, found.type):
        message = f'"{key}" of {name} is {type_in_words(found.type)}, not {told(value)}: it does not start'
        meant = converted(value, found.type)
        yield Finding("controller-value", message, key, f"write {written(meant)}" if fits(meant, found.type) else "")
    elif found.forced and value not in ("", found.forced):
        message = f'"{key}" of {name} is "{found.forced}" whatever stands here'
        yield Finding("controller-value", message, key, "remove it", WARNING)
    elif why := refused(found, value):
        message = f'"{key}" of {name} is {written(value)}: {why}'
        yield Finding("controller-value", message, key, "correct it: it does not start like this")


def written(value: Any) -> str:
    """Return a value as YAML has it, in one line."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(written, value))}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value)
    return f'"{value}"' if isinstance(value, str) else str(value)


def missing(name: str, table: Table | None, values: Mapping[str, Any], why: str) -> Iterator[Finding]:
    """Yield the parameters that a controller needs and ``values`` do not have; ``why`` the robot does not know them."""
    needed = [key for key, _ in table.needed() if key not in values] if table is not None else []
    if needed:
        message = f"{name} needs {quoted(needed, most=4)}"
        help = f"{why}; give it in params" if why else f"params: {{{needed[0]}: ...}}"
        yield Finding("controller-missing", message, "", help)


def against_robot(
    name: str, kind: str, values: Mapping[str, Any], known: Known, robot: Robot, severity: str
) -> Iterator[Finding]:
    """Yield where parameters of a controller disagree with a robot; ``severity`` is that of other numbers."""
    for key, value in values.items():
        last = key.rpartition(".")[2]
        texts = [value] if isinstance(value, str) else value if isinstance(value, (list, tuple)) else []
        unknown = list(_not_there(robot, key, last, [one for one in texts if isinstance(one, str) and one]))
        for what, one, of in unknown:
            message = f'"{key}" of {name} names "{one}", which is no {what} of the robot'
            yield Finding("controller-name", message, key, did_you_mean(one, of))
        if not unknown and key in known.values:
            yield from _same(name, key, value, known.values[key], severity)
    yield from _commanded(name, kind, values, robot)


def _not_there(robot: Robot, key: str, last: str, texts: Iterable[str]) -> Iterator[tuple[str, str, Collection[str]]]:
    """Yield the names in a parameter that the robot does not have: what each should be, it, and those there are."""
    if last in _FRAMES:
        frames = {*robot.link, *(name for edge in robot.edges for name in (edge.parent, edge.child))}
        frames |= set(_WORLD) if last == "odom_frame_id" else set()
        yield from (("frame", one, frames) for one in texts if one.lstrip("/") not in frames)
    elif "." not in key and _JOINTS.fullmatch(last) and last not in _NOT_OF_URDF:
        yield from (("joint", one, robot.joint) for one in texts if one not in robot.joint)


def _same(name: str, key: str, value: Any, wanted: Any, severity: str) -> Iterator[Finding]:
    """Yield what a parameter says otherwise than the robot: a size, or which joint it is."""
    if _JOINTS.fullmatch(key):
        if (sorted(value) if isinstance(value, (list, tuple)) else value) == (
            sorted(wanted) if isinstance(wanted, list) else wanted
        ) or key in ("joints", "joint"):
            return
        message = f'"{key}" of {name} is {_names(value)}, and the drive says {_names(wanted)}'
        yield Finding("controller-differs", message, key, "correct one of the two", severity)
    elif _is_size(key) and isinstance(value, (int, float)) and isinstance(wanted, float):
        if abs(value - wanted) <= max(_LEAST, _TOLERANCE * abs(wanted)):
            return
        message = f'"{key}" of {name} is {value:.6g}, and the robot says {wanted:.6g}'
        twice = abs(value - 2 * wanted) <= max(_LEAST, _TOLERANCE * abs(wanted))
        half = abs(2 * value - wanted) <= max(_LEAST, _TOLERANCE * abs(wanted))
        help = f"it is {'twice' if twice else 'half'} that: " if twice or half else ""
        help += f"write {wanted:.6g}, or correct the robot"
        yield Finding("controller-differs", message, key, help, severity)


def _is_size(key: str) -> bool:
    last = key.rpartition(".")[2]
    if key.startswith("kinematics.base_frame_offset"):
        return True
    return "multiplier" not in key and last.rpartition("_")[2].lower() in _SIZES


def _names(value: Any) -> str:
    return quoted(map(str, value)) if isinstance(value, (list, tuple)) else f'"{value}"'


def _commanded(name: str, kind: str, values: Mapping[str, Any], robot: Robot) -> Iterator[Finding]:
    """Yield the commands that a controller wants and that no hardware block has, where there are any blocks."""
    if not robot.control:
        return
    there = {(one.name, word) for block in robot.control for one in block.joints for word in one.commands}
    for key, joints, words in _wanted(kind, values):
        words = [word for word in words if word in JOINT_WORDS]
        lacking = [one for one in joints if one in robot.joint and any((one, word) not in there for word in words)]
        if lacking:
            message = f"{name} commands the {listed(words)} of {quoted(lacking, most=4)}, which no hardware block has"
            help = f"in control: joints: {{{lacking[0]}: {{command: {words[0]}}}}}"
            yield Finding("controller-interface", message, key, help, WARNING)
    sensor = values.get("sensor_name")
    named = {one.name for block in robot.control for one in block.sensors}
    if isinstance(sensor, str) and sensor and sensor not in named:
        message = f'"sensor_name" of {name} is "{sensor}", and no hardware block has a sensor of this name'
        help = did_you_mean(sensor, named) if named else f"in control: sensors: {{{sensor}: {{}}}}"
        yield Finding("controller-interface", message, "sensor_name", help, WARNING)


def _wanted(kind: str, values: Mapping[str, Any]) -> Iterator[tuple[str, list[str], list[str]]]:
    """Yield keys that name joints, with the joints, and the commands that a controller wants of each."""
    driving = kind in [SHORT[one] for one in SHORT if "drive" in one or "steering" in one or one == "tricycle"]
    for key, value in values.items():
        if not _JOINTS.fullmatch(key) or key in _NOT_OF_URDF:
            continue
        joints = [value] if isinstance(value, str) else [str(one) for one in dict.fromkeys(value or ())]
        words: Any = []
        if driving and "state" not in key:
            steers = "steering" in key or (
                key in ("front_wheels_names", "rear_wheels_names")
                and (key == "front_wheels_names") == values.get("front_steering", True)
            )
            words = [POSITION if steers else VELOCITY]
        elif kind in COMMANDS:
            words = [COMMANDS[kind]]
        elif kind == SHORT["forward_command"]:
            words = [values["interface_name"]] if values.get("interface_name") else []
        elif kind == SHORT["joint_trajectory"] and key == "joints" and not values.get("command_joints"):
            words = values.get("command_interfaces") or []
        if words and joints:
            yield key, joints, [str(word) for word in words]


def tables_of(kind: str, distribution: str) -> tuple[Table | None, Table | None]:
    """Return the table of a type in a distribution, and in the other one."""
    return table(distribution, full(kind)), table(other(distribution), full(kind))


def diagnostic(finding: Finding, span: Span | None, related: Iterable[Related] = ()) -> Diagnostic:
    """Return a finding with its place."""
    return Diagnostic(finding.rule, finding.severity, finding.message, span, tuple(related), finding.help)
