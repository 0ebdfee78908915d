"""The trees of frames of a robot: one for each combination of modes in which they differ."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import count, product
from typing import NamedTuple

from rosorin_compile.model import Robot
from rosorin_compile.model.frame_tree import Row, rows
from rosorin_compile.rules.publishers import MAX_MODES, holds
from rosorin_compile.source.diagnostics import RequestError

_MAX_TREES = 32  # that a picture can show
_NAME = re.compile(r"[^\W\d]\w*")

# Colours that people with any kind of colour vision distinguish, dark enough for lines on white; after the palettes of
# Okabe and Ito (https://jfly.uni-koeln.de/color) and of Paul Tol (https://personal.sron.nl/~pault).
PALETTE = (
    *("#0072b2", "#d55e00", "#009e73", "#aa4499", "#b8860b", "#56b4e9", "#882255", "#332288", "#44aa99"),
    *("#999933", "#cc6677", "#117733"),
)
GREY = "#8c959f"  # nobody


class TooMany(RequestError):
    """There are more trees than can be shown."""

    def __str__(self) -> str:
        """Return the message with a way to have fewer."""
        return f"{self.args[0]}; name modes: --mode NAME"


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
        if not any(all(fixed.get(mode, on) == on for mode, on in zip(varied, states, strict=True)) for states in group):
            continue
        modes = tuple(held | {varied[at]: on for at, on in cube.items()} for cube in _cubes(group))
        words = [" and ".join(f"{mode} is {'on' if on else 'off'}" for mode, on in states.items()) for states in modes]
        short = "_".join(f"{mode}_{'on' if on else 'off'}" for mode, on in modes[0].items())
        taken = {tree.short.casefold() for tree in trees}
        if short.casefold() in taken:
            short = next(name for at in count(2) if (name := f"{short}_{at}").casefold() not in taken)
        trees.append(Tree(", or ".join(words), short, modes, active))
    if len(trees) > _MAX_TREES:
        raise TooMany(f"the tree of frames differs in {len(trees)} combinations of modes: too many to show")
    return tuple(trees)


def _active(edges: Sequence[Row], modes: Mapping[str, bool]) -> tuple[Row, ...]:
    """Return the edges in some modes. An edge that nobody publishes is replaced by another one of the same frames."""
    active = [row for row in edges if holds(row.when, modes)]
    best = {(row.parent, row.child): row for row in sorted(active, key=lambda row: row.published)}
    return tuple(row for row in active if row.published or best[row.parent, row.child] is row)


def _cubes(group: Sequence[tuple[bool, ...]]) -> list[dict[int, bool]]:
    """Return the fewest conditions, each a state by mode number, that together describe a group of combinations."""
    left, cubes = list(group), []
    while left:
        cube = dict(enumerate(left[0]))
        for at in range(len(left[0])):
            wider = {mode: on for mode, on in cube.items() if mode != at}
            size = 2 ** (len(left[0]) - len(wider))
            if sum(all(states[mode] == on for mode, on in wider.items()) for states in group) == size:
                cube = wider
        left = [states for states in left if any(states[mode] != on for mode, on in cube.items())]
        cubes.append(cube)
    return cubes
