"""Changes that are planted in a robot: each is one number, name or attribute, and what has to be said of it."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any, NamedTuple

from rosorin_compile.model import Robot, Transform
from rosorin_compile.model.geometry import norm, rotation_about

LEAST = 1e-6  # what a number changes by; what is no difference is less
SECTIONS = ("sections", "values")  # the way to the values of sections, which are by name
Path = tuple[Any, ...]  # names of fields, places in tuples, and keys of mappings as ("key", KEY)


def leaves(value: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield every number, name and attribute of a value of the model, with the way to it."""
    if is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            yield from leaves(getattr(value, field.name), (*path, field.name))
    elif isinstance(value, Mapping):
        for key in value:
            yield from leaves(value[key], (*path, ("key", key)))
    elif isinstance(value, (tuple, list)):
        for index, one in enumerate(value):
            yield from leaves(one, (*path, index))
    elif isinstance(value, (int, float, str)):
        yield path, value


def put(value: Any, path: Path, new: Any) -> Any:
    """Return a value of the model with another one at the end of a way."""
    if not path:
        return new
    step, *rest = path
    if is_dataclass(value):
        return replace(value, **{step: put(getattr(value, step), tuple(rest), new)})  # type: ignore[type-var]
    if isinstance(value, Mapping):
        return {**value, step[1]: put(value[step[1]], tuple(rest), new)}
    return type(value)(put(one, tuple(rest), new) if at == step else one for at, one in enumerate(value))


def at(value: Any, path: Path) -> Any:
    """Return what stands at the end of a way."""
    for step in path:
        if is_dataclass(value):
            value = getattr(value, step)
        else:
            value = value[step[1]] if isinstance(step, tuple) else value[step]
    return value


def kind_of(path: Path) -> str:
    """Return a way without the places and keys on it: joints.*.limit.lower; of a section from its name on."""
    steps = (path[2][1], *path[3:]) if path[:2] == SECTIONS else path
    return ".".join("*" if isinstance(step, int) else "{}" if isinstance(step, tuple) else step for step in steps)


def other(value: Any) -> Any:
    """Return another value of the same type."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + 1
    if isinstance(value, float):
        return value * 1.01 + 0.003
    if isinstance(value, str) and value.lstrip().startswith("<"):  # XML stays XML
        return value.replace("/>", ' planted="x"/>', 1)
    return f"{value}_x" if value else "x"


class Planted(NamedTuple):
    """A change: the robot with it, the thing that a sentence names, and the values that it gives.

    What has one ``group`` is one sentence.
    """

    robot: Robot
    group: tuple[str, str]
    name: str
    values: tuple[tuple[Any, Any], ...]


def told(planted: Sequence[Planted], lines: Sequence[str]) -> bool:
    """Return True if sentences report what was planted, each group in one sentence, and nothing else."""
    groups: dict[tuple[str, str], list[Planted]] = {}
    for one in planted:
        groups.setdefault(one.group, []).append(one)
    reported = [{number for number, line in enumerate(lines) if _reports(line, some)} for some in groups.values()]
    return len(lines) == len(groups) and all(reported) and set().union(*reported) == set(range(len(lines)))


def _reports(line: str, planted: Sequence[Planted]) -> bool:
    name, pairs = planted[0].name, list(_pairs(line))
    values = [pair for one in planted for pair in one.values]
    texts = [pair for pair in values if isinstance(pair[0], (bool, str))]
    numbers = [pair for pair in values if pair not in texts]
    return (
        re.search(rf"(?<![\w/]){re.escape(name)}(?![\w/])", line) is not None
        and all(any(_are(said, pair) for said in pairs) for pair in numbers)
        and all(_has_words(line, *map(_word, pair)) for pair in texts)
    )


def _has_words(line: str, old: str, new: str) -> bool:
    # Some formats give a name to what has none.
    changed = re.search(rf"{re.escape(old)}\"? -> .*{re.escape(new)}", line)
    return bool(changed) or (not old and f"new, {new}" in line) or (not new and f"removed, was {old}" in line)


def _word(value: bool | str) -> str:
    return str(value).lower() if isinstance(value, bool) else value or ""


def _are(said: tuple[float, float], values: tuple[float, float]) -> bool:
    step = values[1] - values[0]
    close = (abs(a - b) <= 0.06 * abs(step) + 5e-6 * abs(b) for a, b in zip(said, values, strict=True))
    return all(close) and abs(said[1] - said[0] - step) <= 0.06 * abs(step)


_NUMBER = r"[-+]?\d[\d.]*(?:e[-+]?\d+)?"


def _pairs(line: str) -> Iterator[tuple[float, float]]:
    """Yield the numbers before and after; those of two rows of numbers in their order."""
    for found in re.finditer(rf"(?<![\w.])({_NUMBER}(?: {_NUMBER})*) -> ({_NUMBER}(?: {_NUMBER})*)", line):
        old, new = ([float(number) for number in side.split()] for side in found.groups())
        yield from zip(old, new, strict=False) if len(old) == len(new) else [(old[-1], new[0])]


def changed(value: Any, chance: random.Random) -> Any:
    """Return another value of the same type; a number keeps its sign."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + chance.randint(1, 9)
    if isinstance(value, float):
        step = max(abs(value) * chance.choice([1e-5, 1e-3, 0.02, 0.5]), LEAST) * chance.uniform(1, 1.5)
        return value - step if value < 0 else value + step
    return f"{value}_{chance.randint(1, 999)}" if value else f"x_{chance.randint(1, 999)}"


class Rule(NamedTuple):
    """What is said of a leaf of some kind: the field that names its owner, and the word of its group.

    Without a word each leaf is a sentence of its own. ``fits`` says for which owners the leaf means something.
    """

    owner: str = "name"
    word: str = ""
    fits: Callable[[Any], bool] = lambda _: True


def _moves(joint: Any) -> bool:
    return bool(joint.type != "fixed")


def _has_bounds(joint: Any) -> bool:
    return joint.type in ("revolute", "prismatic")


def _upright(link: Any) -> bool:
    return bool(link.inertial is not None and not any(link.inertial.pose.rpy))


# What a URDF has a word for, and what only a description has.
URDF: Mapping[str, Rule] = {
    "joints.*.origin.xyz.*": Rule("child", "origin"),
    "joints.*.limit.lower": Rule(fits=_has_bounds),
    "joints.*.limit.upper": Rule(fits=_has_bounds),
    "joints.*.limit.effort": Rule(fits=_moves),
    "joints.*.limit.velocity": Rule(fits=_moves),
    "joints.*.dynamics.damping": Rule(fits=_moves),
    "joints.*.dynamics.friction": Rule(fits=_moves),
    "joints.*.mimic.multiplier": Rule(),
    "joints.*.mimic.offset": Rule(),
    "joints.*.safety.k_velocity": Rule(fits=_moves),
    "links.*.inertial.mass": Rule(),
    "links.*.inertial.pose.xyz.*": Rule(word="centre"),
    "links.*.inertial.ixx": Rule(word="inertia", fits=_upright),
    "links.*.inertial.iyz": Rule(word="inertia", fits=_upright),
    "links.*.visual.*.rgba.*": Rule(word="colour"),
    "links.*.visual.*.geometry.radius": Rule(word="shape"),
    "links.*.collision.*.geometry.radius": Rule(word="collision"),
    "links.*.collision.*.pose.xyz.*": Rule(word="collision"),
    "links.*.visual.*.name": Rule(),
}
DESCRIPTION: Mapping[str, Rule] = {
    **URDF,
    "joints.*.dynamics.armature": Rule(fits=_moves),
    "joints.*.actuator.kp": Rule(fits=_moves),
    "joints.*.actuator.kv": Rule(fits=_moves),
    "sensors.*.type": Rule(),
    "sensors.*.simulated.*.attributes.{}": Rule(),
    "control.*.plugin": Rule(),
    "control.*.params.{}": Rule(),
    "controllers.*.type": Rule(),
    "controllers.*.params.{}": Rule(),
    "publishers.*.package": Rule(),
    "drive.radius": Rule(""),
    "edges.*.pose.xyz.*": Rule("child", "origin"),
    "moveit.search.trials": Rule(""),
}


def _owner(path: Path) -> Path:
    """Return the way to the entry that a leaf is of: a joint, a link, a hardware block."""
    return path[:4] if path[:2] == SECTIONS else path[:2]


def _leaf(robot: Robot, chance: random.Random, taken: set[Path], rules: Mapping[str, Rule] = URDF) -> Planted | None:
    ways = [
        path
        for path, _ in leaves(robot)
        if path not in taken and kind_of(path) in rules and rules[kind_of(path)].fits(at(robot, _owner(path)))
    ]
    if not ways:
        return None
    kind = chance.choice(sorted({kind_of(path) for path in ways}))
    path = chance.choice([path for path in ways if kind_of(path) == kind])
    taken.add(path)
    rule, old = rules[kind], at(robot, path)
    new = changed(old, chance)
    name = getattr(at(robot, _owner(path)), rule.owner) if rule.owner else kind.partition(".")[0]
    word = f"{rule.word} {path[3]}" if rule.word in ("colour", "shape", "collision") else rule.word
    return Planted(put(robot, path, new), (name, word or str(path)), name, ((old, new),))


def _axis(robot: Robot, chance: random.Random, taken: set[Path]) -> Planted | None:
    ways = [i for i, joint in enumerate(robot.joints) if joint.moves and ("joints", i, "axis") not in taken]
    if not ways:
        return None
    path = ("joints", chance.choice(ways), "axis")
    taken.add(path)
    x, y, z = old = at(robot, path)
    across = (0.0, -z, y) if abs(x) < 0.9 * norm(old) else (-y, x, 0.0)
    new = Transform(rotation_about(across, chance.uniform(0.01, 0.5))).rotate(old)
    values = tuple((a, b) for a, b in zip(old, new, strict=True) if abs(a - b) > 1e-9)
    name = robot.joints[path[1]].name
    return Planted(put(robot, path, new), (name, "axis"), name, values)


def plant(robot: Robot, chance: random.Random, count: int, rules: Mapping[str, Rule]) -> tuple[Robot, list[Planted]]:
    """Return a robot with so many changes, fewer if it has not enough that can be changed."""
    taken: set[Path] = set()
    planted: list[Planted] = []
    for _ in range(4 * count):
        one = _axis(robot, chance, taken) if chance.random() < 0.2 else _leaf(robot, chance, taken, rules)
        if one is not None:
            planted.append(one)
            robot = one.robot
        if len(planted) == count:
            break
    return robot, planted
