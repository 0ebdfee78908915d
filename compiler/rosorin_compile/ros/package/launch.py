"""The launch files of a package that publish the frames: their arguments, and their static transforms in each form."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import describe
from rosorin_compile.formats.static_tf import ARGUMENTS as COMMON
from rosorin_compile.formats.static_tf import (
    STATES,
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

# Packages of the nodes that show a robot on a screen, or replace its driver; a robot does not need them.
SCREEN = ("joint_state_publisher", "joint_state_publisher_gui", "rviz2")
PREFIX = "$(var frame_prefix)"
LAUNCH = "description.launch"
FORMS = ("py", "xml", "yaml")
# What the XML and the YAML form include; all forms include the second if the description is compiled at launch.
PUBLISHER, STATICS = "robot_state_publisher.launch.py", "static_frames.launch.py"
# The launch configuration with the path of the description and its arguments, as words of a command line.
WORDS = "rosorin_compile_words"


class LaunchArgument(NamedTuple):
    """A launch argument; ``default`` is None if it is required, ``choices`` are empty for any value."""

    name: str
    default: str | None
    help: str
    choices: tuple[str, ...] = ()


class PackageFile(NamedTuple):
    """A file that a package has besides artifacts: its place, its template, and what README.md says about it."""

    place: str
    template: str
    about: str


ARGUMENTS = (
    *(LaunchArgument(name, "", help) for name, help in COMMON.items()),
    LaunchArgument("use_sim_time", "false", "take the time from /clock, as simulators and recordings publish it"),
    LaunchArgument("joint_state_publisher", "false", "publish all joints at zero, where no driver does"),
    LaunchArgument("joint_state_publisher_gui", "false", "publish the joints from sliders in a window"),
    LaunchArgument("rviz", "false", "show the robot in RViz"),
)


def mode_arguments(robot: Robot) -> dict[str, str]:
    """Return the launch arguments of the modes that static transforms depend on, by mode."""
    modes = modes_in(robot, [one.when for one in static_transforms(robot)[1]])
    return free_names(modes, [argument.name for argument in ARGUMENTS], "mode_")


def plain(text: str) -> str:
    """Escape a text for XML and YAML launch files, so that no part of it is a substitution."""
    return text.replace("\\", "\\\\").replace("$", "\\$")


def in_args(text: str) -> str:
    """Escape a word of a command line for XML and YAML launch files."""
    return plain(shlex.quote(text))


def launch_values(robot: Robot, carried: Carried | None) -> dict[str, Any]:
    """Return the values of the templates of launch files; ``carried`` is compiled at launch."""
    always, in_modes, _ = static_transforms(robot, FORMATS.feeding(robot, STATIC_TRANSFORM_PUBLISHER))
    modes = mode_arguments(robot)
    conditions = {one.when: condition(robot, one.when) for one in in_modes}
    statics = [_static(one) for one in always]
    for one in in_modes:
        condition_ = conditions[one.when]
        both = {"condition": in_frontends(condition_, modes), "python_condition": if_condition(condition_, modes, 12)}
        statics.append(_static(one) | both)
    more = [
        LaunchArgument(name, "false", f"the robot is run in the mode {mode}", STATES) for mode, name in modes.items()
    ]
    if carried is None:
        passed_on = [one for one in ARGUMENTS if one.name in (*COMMON, "use_sim_time")]
    else:
        more += [one.argument for one in carried.passed]
        passed_on = [*(one for one in ARGUMENTS if one.name in COMMON), *more]
    joints = robot.published_by(ROBOT_STATE_PUBLISHER)
    return {
        "arguments": [*ARGUMENTS, *more],
        "passed_on": passed_on,
        "included": STATICS if carried else PUBLISHER,
        "publisher": joints[0].publisher.name if joints else ROBOT_STATE_PUBLISHER,
        "statics": statics,
        "modes": modes,
        "conditions": {when: in_python(one, modes, 4) for when, one in conditions.items()},
        "imports": import_substitutions(conditions.values(), "LaunchConfiguration", *(("Command",) if carried else ())),
        "plain": plain,
        "in_args": in_args,
        "prefix": PREFIX,
        "screen": SCREEN,
        "carried": carried,
        "words": WORDS,
    }


def _static(transform: StaticTransform) -> dict[str, Any]:
    """Return a static_transform_publisher for the templates: ``pairs`` for Python, ``args`` for XML and YAML."""
    words = (f"{flag} {PREFIX if is_frame else ''}{in_args(value)}" for flag, value, is_frame in transform.words())
    return {
        "name": transform.name,
        "spelt_name": plain(transform.name),
        "pairs": list(transform.in_python()),
        "args": " ".join(words),
        "source": describe(transform.source),
        "condition": "",
    }


def launch_files(carried: Carried | None) -> Iterator[PackageFile]:
    """Yield the launch files that publish the frames."""
    kind = "compiled_launch" if carried else "launch"
    for form in FORMS:
        yield PackageFile(
            f"launch/{LAUNCH}.{form}", f"{kind}.{form}", "publishers of the frames; the three forms do the same"
        )
    if carried:
        yield PackageFile(
            f"launch/{STATICS}",
            "compiled_statics.launch.py",
            "publishers of the static frames; the three forms include it",
        )
    else:
        about = "robot_state_publisher; the XML and the YAML form include it"
        yield PackageFile(f"launch/{PUBLISHER}", "publisher.launch.py", about)
