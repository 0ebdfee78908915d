"""The trees of frames of a robot: one for each combination of modes in which they differ."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple

from rosorin_compile.model import Robot
from rosorin_compile.model.frame_tree import Row, rows
from rosorin_compile.rules.publishers import MAX_MODES, holds

_MAX_TREES = 32  # that a picture can show
_NAME = re.compile(r"[^\W\d]\w*")

# Colours that people with any kind of colour vision distinguish, dark enough for lines on white; after the palettes of
# Okabe and Ito (https://jfly.uni-koeln.de/color) and of Paul Tol (https://personal.sron.nl/~pault).
PALETTE = (
    *("#0072b2", "#d55e00", "#009e73", "#aa4499", "#b8860b", "#56b4e9", "#882255", "#332288", "#44aa99"),
    *("#999933", "#cc6677", "#117733"),
)
GREY = "#8c959f"  # nobody

_Cube = tuple[bool | None, ...]  # on, off or either, for each mode


class TooMany(Exception):
    """There are more trees than can be shown."""


class Tree(NamedTuple):
    """The edges of one tree, and the modes in which it is published.

    ``label`` has the modes in words ("slam is on", empty if they do not matter), ``short`` for a file name.
    """

    label: str
    short: str
    modes: tuple[Mapping[str, bool], ...]
    edges: tuple[Row, ...]


def colours(publishers: Sequence[str]) -> Mapping[str, str]:
    """Return a colour for each publisher; beyond the palette they repeat."""
    return {name: PALETTE[at % len(PALETTE)] for at, name in enumerate(publishers)}


def frame_trees(robot: Robot, fixed: Mapping[str, bool]) -> tuple[Tree, ...]:
    """Return the trees of a robot that agree with ``fixed`` modes, that of the modes which are on first.

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
        active = _active(edges, {**held, **dict(zip(varied, states, strict=True))})
        groups.setdefault(active, []).append(states)
    trees: list[Tree] = []
    for active, group in groups.items():
        if not any(all(fixed.get(*pair) == pair[1] for pair in zip(varied, states, strict=True)) for states in group):
            continue
        cubes = [zip(varied, cube, strict=True) for cube in _cubes(group)]
        modes = [{**held, **{mode: state for mode, state in cube if state is not None}} for cube in cubes]
        words = [" and ".join(f"{mode} is {'on' if on else 'off'}" for mode, on in states.items()) for states in modes]
        short = "_".join(f"{mode}_{'on' if on else 'off'}" for mode, on in modes[0].items())
        taken = {tree.short.casefold() for tree in trees}
        names = (short, *(f"{short}_{number}" for number in range(2, len(trees) + 3)))
        unique = next(name for name in names if name.casefold() not in taken)
        trees.append(Tree(", or ".join(words), unique, tuple(modes), active))
    if len(trees) > _MAX_TREES:
        raise TooMany(f"the tree of frames differs in {len(trees)} combinations of modes: too many to show")
    return tuple(trees)


def _active(edges: Sequence[Row], modes: Mapping[str, bool]) -> tuple[Row, ...]:
    """Return the edges in some modes. An edge that nobody publishes is replaced by another one of the same frames."""
    there = [row for row in edges if holds(row.when, modes)]
    published = {(row.parent, row.child) for row in there if row.published}
    last = {(row.parent, row.child): row for row in there}

    def is_shown(row: Row) -> bool:
        ends = (row.parent, row.child)
        return row.published or (ends not in published and last[ends] is row)

    return tuple(filter(is_shown, there))


def _cubes(group: Sequence[tuple[bool, ...]]) -> list[_Cube]:
    """Return combinations, each as wide as possible, that together cover a group and nothing else."""

    def inside(cube: _Cube) -> list[tuple[bool, ...]]:
        return list(product(*((True, False) if state is None else (state,) for state in cube)))

    members, left, cubes = set(group), dict.fromkeys(group), []
    while left:
        cube: _Cube = next(iter(left))
        for at in range(len(cube)):
            wider = (*cube[:at], None, *cube[at + 1 :])
            if members.issuperset(inside(wider)):
                cube = wider
        for states in inside(cube):
            left.pop(states, None)
        cubes.append(cube)
    return cubes
