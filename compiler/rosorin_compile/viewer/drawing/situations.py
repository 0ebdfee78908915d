"""Situations: the combinations of modes in which the tree of frames differs, each said in the fewest words found."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import NamedTuple

from rosorin_compile.model import Robot
from rosorin_compile.model.frame_tree import Row, rows
from rosorin_compile.rules.conditions import MAX_MODES, holds

MAX_SITUATIONS = 32  # more trees than that are no picture

_NAME = re.compile(r"[^\W\d]\w*")

Cube = tuple[bool | None, ...]  # on, off or either, for each mode


class TooMany(Exception):
    """There are more trees than can be shown; the message says why."""


class Situation(NamedTuple):
    """Modes in which the tree is one and the same, and its edges.

    ``label`` says which ("slam is on"; empty if there is one tree for all), ``short`` is that for a file name.
    """

    label: str
    short: str
    modes: tuple[Mapping[str, bool], ...]
    edges: tuple[Row, ...]


def situations(robot: Robot, fixed: Mapping[str, bool]) -> tuple[Situation, ...]:
    """Return the trees of a robot, that of the modes which are on first; only those that agree with ``fixed``.

    Raises TooMany.
    """
    edges = rows(robot)
    named = {name for row in edges for name in _NAME.findall(row.when)}
    used = [mode for mode in robot.modes if mode in named]
    held = {mode: fixed[mode] for mode in used if mode in fixed} if len(used) > MAX_MODES else {}
    varied = [mode for mode in used if mode not in held]
    if len(varied) > MAX_MODES:
        raise TooMany(f"the frames depend on {len(varied)} modes together: too many to show")
    groups: dict[tuple[Row, ...], list[tuple[bool, ...]]] = {}
    for states in product((True, False), repeat=len(varied)):
        combination = {**held, **dict(zip(varied, states, strict=True))}
        groups.setdefault(_active(edges, combination), []).append(states)
    made = []
    for active, group in groups.items():
        if any(_agrees(dict(zip(varied, states, strict=True)), fixed) for states in group):
            made.append(_situation(held, varied, group, active))
    if len(made) > MAX_SITUATIONS:
        raise TooMany(f"the tree of frames differs in {len(made)} combinations of modes: too many to show")
    return _told_apart(made)


def _active(edges: Sequence[Row], combination: Mapping[str, bool]) -> tuple[Row, ...]:
    """Return the edges that are there in a combination.

    A joint that nobody publishes gives way to another edge between the same frames: a node that publishes it, or a turn
    in which nobody does.
    """
    there = [row for row in edges if holds(row.when, combination)]
    published = {(row.parent, row.child) for row in there if row.published}
    last = {(row.parent, row.child): row for row in there}
    return tuple(
        row
        for row in there
        if row.published or ((row.parent, row.child) not in published and last[row.parent, row.child] is row)
    )


def _agrees(combination: Mapping[str, bool], fixed: Mapping[str, bool]) -> bool:
    return all(fixed.get(mode, state) == state for mode, state in combination.items())


def _situation(
    held: Mapping[str, bool], varied: Sequence[str], group: Sequence[tuple[bool, ...]], active: tuple[Row, ...]
) -> Situation:
    modes = [
        {**held, **{mode: state for mode, state in zip(varied, cube, strict=True) if state is not None}}
        for cube in _cubes(group)
    ]
    label = ", or ".join(_words(states) for states in modes)
    short = "_".join(f"{mode}_{'on' if state else 'off'}" for mode, state in modes[0].items())
    return Situation(label, short, tuple(modes), active)


def _words(states: Mapping[str, bool]) -> str:
    return " and ".join(f"{mode} is {'on' if state else 'off'}" for mode, state in states.items())


def _cubes(group: Sequence[tuple[bool, ...]]) -> list[Cube]:
    """Return combinations that together cover a group and nothing else, each as wide as it can be."""
    members, left, cubes = set(group), dict.fromkeys(group), []
    while left:
        cube: Cube = next(iter(left))
        for at in range(len(cube)):
            wider = (*cube[:at], None, *cube[at + 1 :])
            if members.issuperset(_inside(wider)):
                cube = wider
        for states in _inside(cube):
            left.pop(states, None)
        cubes.append(cube)
    return cubes


def _inside(cube: Cube) -> Iterator[tuple[bool, ...]]:
    return product(*((True, False) if state is None else (state,) for state in cube))


def _told_apart(situations: Iterable[Situation]) -> tuple[Situation, ...]:
    """Return situations whose names for files differ, whatever the modes are called and on every disk."""
    taken: set[str] = set()
    kept = []
    for situation in situations:
        short, number = situation.short, 1
        while short.casefold() in taken:
            number += 1
            short = f"{situation.short}_{number}"
        taken.add(short.casefold())
        kept.append(situation._replace(short=short))
    return tuple(kept)
