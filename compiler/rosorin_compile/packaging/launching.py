"""Launching: the values of the launch files of a package, spelt as each of the three forms reads them.

In XML and YAML a text is first searched for substitutions, in which "$" begins one and a backslash takes the meaning of
the next character; ``args`` is then split as a shell does (``ros2/launch@{humble,jazzy}: launch/frontend``,
``launch/actions/execute_process.py``).
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from ..emit import FORMATS
from ..emit.static_tf import StaticTransform, describe, numbers_of, static_in_modes, static_transforms
from ..model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Robot
from ..rules.case import feeding
from ..rules.conditions import combinations, holds, modes_in

_ON = '("true", "1", "on")'


class Static(NamedTuple):
    """A static_transform_publisher: its name, its arguments one by one and as one text, where its numbers come from.

    ``condition`` is an expression of Python over launch arguments, empty for always: its pieces are text and the name
    of an argument in turns, text first and last.
    """

    name: str
    spelt_name: str
    arguments: tuple[str, ...]
    args: str
    source: str
    condition: tuple[str, ...] = ()


def plain(text: str) -> str:
    """Return a text as XML and YAML launch files say it where no substitution is meant."""
    return text.replace("\\", "\\\\").replace("$", "\\$")


def statics(robot: Robot, taken: Iterable[str]) -> tuple[list[Static], dict[str, str]]:
    """Return the static transforms of a robot, and the launch arguments of the modes that they depend on.

    ``taken`` are names of launch arguments that are no modes. Numbers are printed as the outputs of the robot ask for.
    """
    numbers = numbers_of(*feeding(robot, STATIC_TRANSFORM_PUBLISHER, FORMATS))
    in_modes = static_in_modes(robot, numbers)
    names = set(taken)
    arguments = {
        mode: f"mode_{mode}" if mode in names else mode for mode in modes_in(robot, [one.when for one in in_modes])
    }
    statics = [_static(transform, ()) for transform in static_transforms(robot, numbers)[0]]
    statics += [_static(one, _condition(one.when, modes_in(robot, [one.when]), arguments)) for one in in_modes]
    return statics, arguments


def evaluated(condition: Sequence[str]) -> str:
    """Return a condition as the argument of ``$(eval '...')``."""
    return "".join(f"$(var {piece})" if index % 2 else piece for index, piece in enumerate(condition))


def _static(transform: StaticTransform, condition: tuple[str, ...]) -> Static:
    args = " ".join(plain(shlex.quote(argument)) for argument in transform.arguments)
    name = transform.name
    return Static(name, plain(name), transform.arguments, args, describe(transform.source), condition)


def _condition(when: str, modes: list[str], arguments: Mapping[str, str]) -> tuple[str, ...]:
    """Return a condition over modes as every combination of them in which it holds."""
    pieces = [""]
    for index, states in enumerate(states for states in combinations(modes) if holds(when, states)):
        for number, (mode, is_on) in enumerate(states.items()):
            pieces[-1] += " and " if number else " or " if index else ""
            pieces[-1] += '"'
            pieces += [arguments[mode], f'".lower() {"in" if is_on else "not in"} {_ON}']
    return tuple(pieces) if len(pieces) > 1 else ("False",)


def moved_by(robot: Robot) -> str:
    """Return the name of the node that publishes the joints of the URDF."""
    joints = robot.published_by(ROBOT_STATE_PUBLISHER)
    return joints[0].publisher.name if joints else ROBOT_STATE_PUBLISHER
