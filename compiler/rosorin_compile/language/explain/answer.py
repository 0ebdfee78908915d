"""Explain: where a frame sits, and where each number that puts it there was written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import UnknownName, did_you_mean, nearest

from ..expand import Expanded
from ..lower import Lowered
from ..schema import sections
from .chains import Frames, of_entry, of_joint, of_mass, of_shapes
from .explanation import Answer, Explanation, NamedValue, Number
from .origins import Origins

__all__ = ["Answer", "Explanation", "NotThere", "explain"]


_THREE = {"xyz": ("x", "y", "z"), "rpy": ("roll", "pitch", "yaw")}


class NotThere(UnknownName):
    """The robot has nothing of that name; the message has a suggestion."""


def explain(
    expanded: Expanded, lowered: Lowered, given: Mapping[str, Any], names: Sequence[str], pose: str = ""
) -> list[Explanation | Answer | NamedValue]:
    """Return what is known of each frame, link, joint, sensor, use, argument or named value of a sound description.

    Names of numbers ("z", "mass", "upper") among the names ask for these alone. ``given`` are the arguments of the run,
    ``pose`` is a named pose to show the frames in beside all joints at zero. Raises NotThere.
    """
    if expanded.tree is None or expanded.scope is None or lowered.robot is None:
        raise ValueError("a description with errors has no meaning to explain")
    origins = Origins(expanded.tree, expanded.scope, dict(given))
    frames = Frames(lowered.robot, lowered.places, origins)
    if pose and all(known.name != pose for known in lowered.robot.poses):
        raise NotThere(_missing("pose", pose, [known.name for known in lowered.robot.poses]))
    without_frames = [
        (section, name)
        for section, node in sections().items()
        if node.explained is True
        for name in expanded.tree.get(section) or ()
    ]
    targets: dict[str, None] = {}
    others: list[str] = []
    simulated: list[Answer] = []
    for name in names:
        found = _targets(frames, name)
        targets |= dict.fromkeys(found)
        entries = (
            [] if found else [Answer(name, tuple(of_entry(frames, path))) for path in without_frames if path[1] == name]
        )
        simulated += entries
        others += [] if found or entries else [name]
    explanations = [_explanation(frames, target, pose) for target in targets]
    answered: list[Explanation | Answer] = [*explanations, *simulated]
    numbers = {number.name for one in answered for number in _numbers(one)}
    values: list[NamedValue] = []
    for name in list(others):
        if any(_is_called(number, name) for number in numbers):
            continue
        meaning = origins.meanings.named(name)
        if meaning is not None and expanded.values is not None:
            uses = tuple(origins.where(place.span) for place in expanded.values.uses(name))
            values.append(NamedValue(name, meaning, uses))
            others.remove(name)
        else:
            known = {*frames.names(), *(sensor.name for sensor in frames.robot.sensors), *frames.robot.joint}
            known |= {str(path[1]) for path in without_frames}
            known |= {use for frame in frames.names() for use in frames.uses(frame)}
            known |= expanded.scope.places.keys()
            what = "frame, link, joint, sensor, use, value or number"
            raise NotThere(_missing(what, name, [*sorted(known), *sorted(numbers)]))
    shown = [_answer(one, others, frames.robot) for one in answered] if others else answered
    return [*shown, *values]


def _numbers(one: Explanation | Answer) -> Sequence[Number]:
    return one.numbers() if isinstance(one, Explanation) else one.numbers


def _is_called(number: str, word: str) -> bool:
    """Say whether a word asks for a number: by its name, "inertia ixx", a part of that, or as one of three."""
    return word in (number, number.partition("[")[0]) or word in number.split() or number in _THREE.get(word, ())


def _answer(explanation: Explanation | Answer, words: Sequence[str], robot: Robot) -> Answer:
    """Return the numbers that words ask for; those of the joint before those of the mass, if both have one."""
    added = tuple(f"{section} " for section in robot.sections.said)
    found: dict[Number, None] = {}
    for word in words:
        numbers = _numbers(explanation)
        exactly = [number for number in numbers if number.name == word]
        if exactly:  # what sections add to it goes with it
            exactly += [one for one in numbers if one.name.startswith(added) and one.name.endswith(f" {word}")]
            exactly += [one for one in numbers if one.name == f"{word} in all"]
        found |= dict.fromkeys(exactly or [number for number in numbers if _is_called(number.name, word)])
    return Answer(explanation.name, tuple(found))


def _targets(frames: Frames, name: str) -> list[str]:
    """Return the frames that a name means: its own, that of a sensor, the one that a joint holds, those of a use."""
    robot = frames.robot
    found = [name] if name in frames.names() else []
    found += [sensor.frame for sensor in robot.sensors if sensor.name == name]
    found += [joint.child for joint in robot.joints if joint.name == name]
    return list(dict.fromkeys(found or [frame for frame in frames.names() if name in frames.uses(frame)]))


def _missing(what: str, name: str, known: Sequence[str]) -> str:
    if len(known) > 40 and nearest(name, known) is None:
        return f'there is no {what} "{name}"'
    return f'there is no {what} "{name}"; {did_you_mean(name, known) or "there is none at all"}'


def _explanation(frames: Frames, name: str, pose: str) -> Explanation:
    robot, chain = frames.robot, frames.chain(name)
    joint, link = robot.joint_to.get(name), robot.link.get(name)
    where, stack = frames.origins.at(frames.places["link", name]) if link is not None else (None, ())
    placed = [frames.placed(name, chain, "")]
    if pose:
        placed.append(frames.placed(name, chain, pose))
    return Explanation(
        name=name,
        roles=tuple(_roles(robot, name)),
        where=where,
        stack=stack,
        chain=chain,
        others=frames.others(name),
        placed=tuple(placed),
        children=frames.children(name),
        joint=tuple(of_joint(frames, joint)) if joint is not None else (),
        inertial=tuple(of_mass(frames, link)) if link is not None else (),
        shapes=tuple(of_shapes(frames, link)) if link is not None else (),
    )


def _roles(robot: Robot, name: str) -> list[str]:
    """Return what a frame is, in words."""
    roles = []
    if name in robot.link:
        link = robot.link[name]
        body = link.inertial is not None or link.visual or link.collision
        roles.append("link" if body else "frame")
    else:
        roles.append("frame of other nodes")
    for sensor in robot.sensors:
        if sensor.frame == name:
            roles.append(f'frame of the sensor "{sensor.name}" ({sensor.type})')
        if sensor.optical_frame == name:
            roles.append(f'optical frame of the sensor "{sensor.name}" ({sensor.type})')
    if name in robot.joint_to:
        roles.append(f'child of the joint "{robot.joint_to[name].name}"')
    elif name in robot.link:
        roles.append("root")
    return roles
