"""Starting: what the launch files of a package say, spelt as each of their three forms reads it."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import describe
from rosorin_compile.formats.static_tf import ARGUMENTS as COMMON
from rosorin_compile.formats.static_tf import (
    STATES,
    Condition,
    StaticTransform,
    condition,
    free_names,
    if_condition,
    import_substitutions,
    in_frontends,
    in_python,
    static_transforms,
)
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Robot
from rosorin_compile.rules.publishers import modes_in

if TYPE_CHECKING:
    from .carrying import Carried

# Packages of the nodes that show a robot on a screen, or stand in for its driver; nothing on a robot needs them.
SCREEN = ("joint_state_publisher", "joint_state_publisher_gui", "rviz2")
PREFIX = "$(var frame_prefix)"
LAUNCH = "description.launch"
# What the XML and the YAML form include, and what all three forms do where the description is compiled at launch.
PUBLISHER, STATICS = "robot_state_publisher.launch.py", "static_frames.launch.py"
# The launch configuration that holds the description and its arguments, where they cannot stand in the launch file.
WORDS = "rosorin_compile_words"


class LaunchArgument(NamedTuple):
    """An argument of the launch files; ``default`` is None where there is none, ``choices`` are empty for any value."""

    name: str
    default: str | None
    help: str
    choices: tuple[str, ...] = ()


ARGUMENTS = (
    *(LaunchArgument(name, "", help) for name, help in COMMON.items()),
    LaunchArgument("use_sim_time", "false", "take the time from /clock, as simulators and recordings publish it"),
    LaunchArgument("joint_state_publisher", "false", "publish all joints at zero, where no driver does"),
    LaunchArgument("joint_state_publisher_gui", "false", "publish the joints from sliders in a window"),
    LaunchArgument("rviz", "false", "show the robot in RViz"),
)


class Static(NamedTuple):
    """A static_transform_publisher: its name, its arguments for each form, and where its numbers come from.

    ``pairs`` are the arguments as Python, flag and value; ``args`` is one text for XML and YAML. ``condition`` is that
    of XML and YAML, ``python_condition`` that of Python; both are empty for always.
    """

    name: str
    spelt_name: str
    pairs: tuple[tuple[str, str], ...]
    args: str
    source: str
    condition: str = ""
    python_condition: str = ""


class Statics(NamedTuple):
    """The static transforms of a robot, the launch arguments of the modes that they depend on, conditions in Python."""

    nodes: list[Static]
    modes: dict[str, str]
    conditions: dict[str, str]
    read: tuple[Condition, ...]

    def imports(self, *more: str) -> str:
        """Return the import of substitutions."""
        return import_substitutions(self.read, "LaunchConfiguration", *more)

    def arguments(self) -> list[LaunchArgument]:
        """Return the launch arguments of the modes."""
        return [
            LaunchArgument(name, "false", f"the robot is run in the mode {mode}", STATES)
            for mode, name in self.modes.items()
        ]


def in_args(text: str) -> str:
    """Return a word of a command line as XML and YAML launch files say it."""
    return plain(shlex.quote(text))


def plain(text: str) -> str:
    """Return a text as XML and YAML launch files say it where no substitution is meant."""
    return text.replace("\\", "\\\\").replace("$", "\\$")


def spelt_statics(robot: Robot, taken: Iterable[str]) -> Statics:
    """Return the static transforms of a robot, spelt for launch files.

    ``taken`` are names of launch arguments that are no modes. Numbers are printed as the outputs of the robot ask for.
    """
    always, in_modes, _ = static_transforms(robot, FORMATS.feeding(robot, STATIC_TRANSFORM_PUBLISHER))
    modes = free_names(modes_in(robot, [one.when for one in in_modes]), taken, "mode_")
    nodes = [_static(transform) for transform in always]
    read = {one.when: condition(robot, one.when) for one in in_modes}
    for one in in_modes:
        words = in_frontends(read[one.when], modes)
        python = if_condition(read[one.when], modes, 12)
        nodes.append(_static(one)._replace(condition=words, python_condition=python))
    conditions = {when: in_python(one, modes, 4) for when, one in read.items()}
    return Statics(nodes, modes, conditions, tuple(read.values()))


def _static(transform: StaticTransform) -> Static:
    words = (f"{flag} {PREFIX if is_frame else ''}{in_args(value)}" for flag, value, is_frame in transform.words())
    name = transform.name
    return Static(name, plain(name), tuple(transform.in_python()), " ".join(words), describe(transform.source))


def words_of(carried: Carried, package: str) -> str:
    """Return the description and its arguments, as XML and YAML launch files say them behind ``print``."""
    if not carried.simple:
        return f"$(var {WORDS})"
    passed = (f'"{one.name}:=$(var {one.argument.name})"' for one in carried.passed)
    return " ".join([f'"$(find-pkg-share {package})/{carried.description}"', *passed])


def values(robot: Robot, carried: Carried | None, package: str) -> dict[str, Any]:
    """Return what the templates of launch files need to know of a robot; ``carried`` is compiled at launch."""
    statics = spelt_statics(robot, [argument.name for argument in ARGUMENTS])
    if carried is None:
        arguments = [*ARGUMENTS, *statics.arguments()]
        included, passed_on = PUBLISHER, [one for one in ARGUMENTS if one.name in (*COMMON, "use_sim_time")]
    else:
        more = [*statics.arguments(), *(one.argument for one in carried.passed)]
        arguments = [*ARGUMENTS, *more]
        included, passed_on = STATICS, [*(one for one in ARGUMENTS if one.name in COMMON), *more]
    return {
        "arguments": arguments,
        "passed_on": passed_on,
        "included": included,
        "publisher": moved_by(robot),
        "statics": statics.nodes,
        "modes": statics.modes,
        "conditions": statics.conditions,
        "imports": statics.imports(*(("Command",) if carried else ())),
        "plain": plain,
        "in_args": in_args,
        "prefix": PREFIX,
        "screen": SCREEN,
        "carried": carried,
        "words": WORDS,
        "said": words_of(carried, package) if carried else "",
    }


def templates(carried: Carried | None) -> dict[str, str]:
    """Return the templates of the launch files by their names."""
    kind = "compiled_launch" if carried else "launch"
    found = {f"launch/{LAUNCH}.{form}": f"{kind}.{form}" for form in ("py", "xml", "yaml")}
    if carried:
        return {**found, f"launch/{STATICS}": "compiled_statics.launch.py"}
    return {**found, f"launch/{PUBLISHER}": "publisher.launch.py"}


def contents(carried: Carried | None) -> list[tuple[str, str]]:
    """Return the launch files with what each is."""
    rows = [(f"launch/{LAUNCH}.*", "one launch file in three forms")]
    if carried:
        rows.append((carried.description, "the description that is compiled at launch, and what it reads"))
        return [*rows, (f"launch/{STATICS}", "the static frames alone; what the three forms include")]
    return [*rows, (f"launch/{PUBLISHER}", "robot_state_publisher alone; what the XML and the YAML form include")]


def moved_by(robot: Robot) -> str:
    """Return the name of the node that publishes the joints of the URDF."""
    joints = robot.published_by(ROBOT_STATE_PUBLISHER)
    return joints[0].publisher.name if joints else ROBOT_STATE_PUBLISHER
