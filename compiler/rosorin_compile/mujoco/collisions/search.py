"""Which pairs of links need no check, decided as MoveIt's assistant does, and a little more carefully.

Order and numbers: ``moveit/moveit2@{humble,jazzy}:moveit_setup_assistant/moveit_setup_srdf_plugins/src/
compute_default_collisions.cpp``. A pair keeps its first reason:

1. Adjacent: joined by one joint, or over links without shapes;
2. Default: in collision where every joint is at zero, or in the middle of limits that do not include zero;
3. Always: in more than a share of the 200 states of a round; rounds go on until one finds none;
4. Never: in none of the states of the rounds, and of the trials after them.

Here the states follow from the seed alone: one after another, from Python's Mersenne twister, whatever the machine.
And Never takes more than luck: a pair that came nearer than the clearance is none; from the nearest states of a pair,
joints are turned to bring it nearer still; and a pair with a joint between that has no bounds is none. What no joint
moves against each other is measured once. Hulls of meshes that touch are no reason to leave a pair out where the meshes
themselves do not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from random import Random
from typing import TYPE_CHECKING

from rosorin_compile.model import DisabledCollision, Joint
from rosorin_compile.source.progress import Progress

from ..physics.scene import Pair
from ..physics.solids import Meshes
from .contacts import FAR, TOUCH, Contacts, Planning, State, ordered

if TYPE_CHECKING:
    from ..physics.solids import Floats

ROUND, _MOST_ROUNDS = 200, 50  # states of a round
_BLOCK = 1000  # states whose distances are in memory
_NEAREST, _STARTS = 24, 3  # states of a pair that are measured, and from which it is brought nearer
_FIRST_STEP, _HALVINGS = 0.1, 8  # of a joint's range, and how often it is halved when no step brings a pair nearer
_BATCH = 8  # steps that are measured at once
_FARTHEST = 10.0  # m: nothing of a robot is farther from its other parts
_MESH_STATES = 5  # states in which the meshes of a pair are tested, besides their hulls


class Search:
    """One search. ``found`` are the pairs that need no check, ``hit`` those that touched in a state.

    ``same`` are pairs with a result that is still valid, None for one to be checked.
    """

    def __init__(
        self, planning: Planning, meshes: Meshes, same: Mapping[Pair, DisabledCollision | None] | None = None
    ) -> None:
        self.planning, self.meshes, self.same = planning, meshes, dict(same or {})
        self.how = planning.said.search
        self.random = Random(self.how.seed)  # noqa: S311 - a search that anybody can repeat
        self.bounds = bounds_of(planning)
        self.found: dict[Pair, DisabledCollision] = {}
        self.hit: set[Pair] = set()
        self.only_hulls: set[Pair] = set()  # pairs whose hulls touch, and not their meshes
        self.tried = 0
        self.contacts = Contacts(planning, meshes)

    def run(self) -> list[DisabledCollision]:
        """Return the pairs that need no check, sorted by name."""
        pairs = list(combinations(sorted(self.planning.solids), 2))
        for pair in adjacent(self.planning):
            self.found[pair] = DisabledCollision(pair, DisabledCollision.ADJACENT)
        for pair, result in self.same.items():
            if result is None and pair not in self.found:
                self.hit.add(pair)
            elif result is not None and result.reason != DisabledCollision.ADJACENT:
                self.found.setdefault(pair, result)
        limits = self.bounds.items()
        start = {name: 0.0 if low <= 0 <= high else (low + high) / 2 for name, (low, high) in limits}
        for pair, distance in self.contacts.touching(self.contacts.rows([start])[0]).items():
            if pair not in self.found and pair not in self.hit and self._is_real(pair, [start]):
                self.found[pair] = DisabledCollision(pair, DisabledCollision.DEFAULT, _rounded(distance))
        open_pairs = [pair for pair in pairs if pair not in self.found and pair not in self.hit]
        for pair in open_pairs:
            if not self._joints_between(pair):
                distance = next(self.contacts.distances(pair, [start], FAR))
                if distance > TOUCH:
                    self.found[pair] = _never(pair, distance)
        if any(pair not in self.found for pair in open_pairs):
            self._find_always()
            self._find_never(pairs)
        return [self.found[pair] for pair in sorted(self.found)]

    def _joints_between(self, pair: Pair) -> list[Joint]:
        """Return the joints that move one link of a pair against the other; for a mimic joint, its leader."""
        joints = [joint for joint in self.planning.between(*pair) if not joint.is_fixed]
        for number, joint in enumerate(joints):
            while joint.mimic is not None:
                joint = joints[number] = self.planning.robot.joint[joint.mimic.joint]
        return joints

    def _is_real(self, pair: Pair, states: Sequence[State]) -> bool:
        """Return True if a pair touches in each of some states by its meshes, and not by their hulls alone."""
        is_real = all(self.contacts.touch_as_meshes(pair, state) for state in states)
        self.only_hulls |= set() if is_real else {pair}
        return is_real

    def _states(self, count: int) -> Iterator[tuple[State, Mapping[Pair, float]]]:
        """Yield random states and the pairs that touch there."""
        for first in range(0, count, _BLOCK):
            states = [
                {name: low + self.random.random() * (high - low) for name, (low, high) in self.bounds.items()}
                for _ in range(min(_BLOCK, count - first))
            ]
            for state, row in zip(states, self.contacts.rows(states), strict=True):
                touching = self.contacts.touching(row)
                self.hit.update(touching)
                self.tried += 1
                if self.tried % 20 == 1:
                    Progress.step("trying states", self.tried, max(self.how.trials + ROUND, self.tried))
                yield state, touching

    def _find_always(self) -> None:
        """Find the pairs that are in collision in nearly every state."""
        for _ in range(_MOST_ROUNDS):
            excluded = {*self.found, *(pair for pair in self.same if pair in self.hit)}
            self.contacts = Contacts(self.planning, self.meshes, excluded)
            hits: dict[Pair, list[State]] = {}
            deepest: dict[Pair, float] = {}
            for state, touching in self._states(ROUND):
                for pair, distance in touching.items():
                    hits.setdefault(pair, []).append(state)
                    deepest[pair] = min(distance, deepest.get(pair, distance))
            most = int(ROUND * self.how.always)
            often = [pair for pair, states in hits.items() if len(states) > most and pair not in self.only_hulls]
            always = [pair for pair in often if self._is_real(pair, hits[pair][:_MESH_STATES])]
            for pair in always:
                self.found[pair] = DisabledCollision(pair, DisabledCollision.ALWAYS, _rounded(deepest[pair]))
            if not always:
                return

    def _find_never(self, pairs: Sequence[Pair]) -> None:
        """Find the pairs that touch in no state and come no nearer than the clearance."""
        nearest = _Nearest(self.contacts, [pair for pair in pairs if pair not in self.found and pair not in self.hit])
        for state, _ in self._states(self.how.trials):
            nearest.add(state)
        left = [pair for pair in nearest.pairs if pair not in self.hit]
        for number, pair in enumerate(left):
            Progress.step("bringing links near each other", number, len(left))
            joints = list(dict.fromkeys(joint.name for joint in self._joints_between(pair)))
            if self.bounds.keys() >= set(joints):
                distance = self.approach(pair, joints, nearest.states_of(pair))
                if distance > max(self.how.clearance, TOUCH):
                    self.found[pair] = _never(pair, distance)

    def approach(self, pair: Pair, joints: Sequence[str], states: Sequence[State]) -> float:
        """Return how near (m) a pair comes from some states when the joints between are turned to that end."""
        chance = Random(f"{self.how.seed} {' '.join(pair)}")  # noqa: S311 - whatever else is searched
        measured = zip(self.contacts.distances(pair, states, _FARTHEST), states, strict=True)
        starts = sorted(measured, key=lambda one: one[0])[:_STARTS]
        return min((self._descend(pair, joints, chance, *start) for start in starts), default=math.inf)

    def _descend(self, pair: Pair, joints: Sequence[str], chance: Random, best: float, state: State) -> float:
        """Return how near (m) a pair comes from one state, joints turned one by one and together."""
        share = _FIRST_STEP
        for _ in range(_HALVINGS):
            is_nearer = True
            while is_nearer and best > TOUCH:
                is_nearer, steps = False, _steps(joints, chance)
                while steps:
                    turned = [self._turned(state, step, share) for step in steps[:_BATCH]]
                    distances = enumerate(self.contacts.distances(pair, turned, _FARTHEST), 1)
                    done, nearer = next(((n, d) for n, d in distances if d < best - TOUCH), (len(turned), best))
                    if nearer < best:  # the steps after it start there
                        best, state, is_nearer = nearer, turned[done - 1], True
                    steps = steps[done:]
            share /= 2
        return best

    def _turned(self, state: State, step: Mapping[str, float], share: float) -> State:
        """Return a state with joints turned by a share of their range, as far as they go."""
        turned = dict(state)
        for name, turn in step.items():
            low, high = self.bounds[name]
            turned[name] = min(high, max(low, state[name] + turn * share * (high - low)))
        return turned


def _steps(joints: Sequence[str], chance: Random) -> list[dict[str, float]]:
    """Return directions in which joints are turned: each one back and on, then several at a time."""
    steps = [{name: turn} for name in joints for turn in (-1.0, 1.0)]
    for _ in joints if len(joints) > 1 else ():
        step = {name: chance.uniform(-1, 1) for name in joints}
        steps += [step, {name: -turn for name, turn in step.items()}]
    return steps


class _Nearest:
    """Records the states in which the spheres around the shapes of two links were nearest, for some pairs."""

    def __init__(self, contacts: Contacts, pairs: Sequence[Pair]) -> None:
        import numpy as np

        self.contacts, self.pairs = contacts, list(pairs)
        geoms = [contacts.geom_pairs(pair) for pair in pairs]
        self.geoms = np.array([both for several in geoms for both in several], dtype=int).reshape(-1, 2).T
        self.first = np.cumsum([0, *map(len, geoms)])[:-1]
        self.least = np.zeros((0, len(self.pairs)))
        self.when = np.zeros((0, len(self.pairs)), dtype=int)
        self.rows: list[Floats] = []
        self.states: list[State] = []

    def add(self, state: State) -> None:
        """Add a state, in which the links have just been placed."""
        import numpy as np

        if self.pairs:
            self.rows.append(np.minimum.reduceat(self.contacts.sphere_gaps(self.geoms), self.first))
            self.states.append(state)
            if len(self.rows) == _BLOCK:
                self._merge()

    def _merge(self) -> None:
        """Keep the nearest of the states so far."""
        import numpy as np

        numbers = np.arange(len(self.states) - len(self.rows), len(self.states))
        least = np.vstack([self.least, *self.rows])
        when = np.vstack([self.when, np.repeat(numbers[:, None], len(self.pairs), axis=1)])
        order = np.argsort(least, axis=0, kind="stable")[:_NEAREST]
        self.least, self.when = (np.take_along_axis(table, order, 0) for table in (least, when))
        self.rows = []

    def states_of(self, pair: Pair) -> list[State]:
        """Return the states in which a pair was nearest, as far as spheres can tell."""
        if self.rows:
            self._merge()
        return [self.states[when] for when in self.when[:, self.pairs.index(pair)].tolist()]


def bounds_of(planning: Planning) -> dict[str, tuple[float, float]]:
    """Return the ranges (rad or m) of joints that move by themselves, by name; those without bounds are left out."""
    bounds = {}
    for name in sorted(planning.joints):
        joint = planning.joints[name]
        limit = joint.limit
        if not joint.moves or joint.mimic is not None:
            continue
        if joint.type != "continuous" and limit is not None and limit.lower is not None and limit.upper is not None:
            bounds[name] = (limit.lower, limit.upper)
        elif joint.type != "prismatic":
            bounds[name] = (-math.pi, math.pi)
    return bounds


def adjacent(planning: Planning) -> list[Pair]:
    """Return the links with shapes that one joint joins, or joints and links without shapes between them."""
    neighbours: dict[str, set[str]] = {name: set() for name in planning.links}
    for joint in planning.joints.values():
        neighbours[joint.parent].add(joint.child)
        neighbours[joint.child].add(joint.parent)
    for bare in sorted(planning.links):
        if bare not in planning.solids:  # its neighbours become neighbours of each other
            around = neighbours.pop(bare)
            for name in around:
                neighbours[name] = (neighbours[name] | around) - {name, bare}
    return sorted({ordered(one, other) for one in neighbours for other in neighbours[one]})


def _never(pair: Pair, distance: float) -> DisabledCollision:
    if distance >= FAR:
        return DisabledCollision(pair, DisabledCollision.NEVER, beyond=FAR)
    return DisabledCollision(pair, DisabledCollision.NEVER, _rounded(distance))


def _rounded(length: float) -> float:
    """Return a length (m) to the tenth of a millimetre, on which engines agree from machine to machine."""
    return round(length, 4) + 0.0
