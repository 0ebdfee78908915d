"""Which pairs of links need no check, decided as MoveIt's assistant does, and a little more carefully.

Order and numbers: ``moveit/moveit2@{humble,jazzy}:moveit_setup_assistant/moveit_setup_srdf_plugins/src/
compute_default_collisions.cpp``. A pair keeps its first reason:

1. Adjacent: joined by one joint, or over links without shapes;
2. Default: in collision where every joint is at zero, or in the middle of limits that do not hold zero;
3. Always: in more than a share of the 200 states of a round; rounds go on until one finds none;
4. Never: in none of the states of the rounds, and of the trials after them.

Here the states follow from the seed alone: one after another, from Python's Mersenne twister, whatever the machine or
the number of its cores. And Never takes more than luck: a pair that came nearer than the clearance is none; from the
nearest states that were seen of a pair, joints are turned to bring it nearer still; and a pair with a joint between
that has no bounds is none. What no joint moves against each other is measured once. Hulls of meshes that touch are no
reason to leave a pair out where the meshes themselves do not.
"""

from __future__ import annotations

import math
import os
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from random import Random
from typing import Any

from rosorin_compile.model import DisabledCollision, Joint
from rosorin_compile.source import system
from rosorin_compile.source.progress import Progress

from ..physics.files import Meshes
from .contacts import FAR, TOUCH, Contacts
from .planning import Pair, Planning, ordered

ROUND = 200
_MOST_ROUNDS = 50
_HALVINGS, _FIRST_STEP = 8, 0.1  # of the descent: how often a step is halved that brings no pair nearer, and its begin
_NEAREST, _STARTS = 24, 3  # states of a pair that are looked at closely, and from which it is brought nearer
_AT_ONCE = 1000  # states whose distances are held
_FARTHEST = 10.0  # m: nothing of a robot is farther from its other parts
_WORTH_IT = 8  # pairs: fewer are done before a second process is there
_ASKED = 5  # states in which the meshes of a pair are asked, beside the hulls

Positions = dict[str, float]


class Search:
    """One search: what is known of each pair so far. ``found`` has the pairs that need no check."""

    def __init__(
        self,
        planning: Planning,
        meshes: Meshes,
        same: Mapping[Pair, DisabledCollision | None] | None = None,
    ) -> None:
        self.planning = planning
        self.meshes = meshes
        self.same = dict(same or {})
        self.how = planning.said.search
        self.random = Random(self.how.seed)  # noqa: S311 - a search that anybody can repeat
        self.found: dict[Pair, DisabledCollision] = {}
        self.bounds = bounds_of(planning)
        self.tried = 0
        self.hit: set[Pair] = set()
        self.by_hulls: set[Pair] = set()
        self.contacts = Contacts(planning, meshes)
        self.bounding = Bounding(self.contacts, ())

    def run(self) -> list[DisabledCollision]:
        """Return the pairs that need no check, sorted by name."""
        links = sorted(self.planning.solids)
        pairs = list(combinations(links, 2))
        for pair in adjacent(self.planning):
            self.found[pair] = DisabledCollision(pair, DisabledCollision.ADJACENT)
        for pair, one in self.same.items():
            if pair not in self.found and (one is None or one.reason != DisabledCollision.ADJACENT):
                self.found |= {} if one is None else {pair: one}
                self.hit |= {pair} if one is None else set()
        start = default_state(self.planning)
        for pair, far in self.contacts.touching(start).items():
            if pair not in self.found and pair not in self.hit and self._is_real(pair, [start]):
                self.found[pair] = DisabledCollision(pair, DisabledCollision.DEFAULT, _rounded(far))
        kept = {*self.found, *self.hit}
        rigid = [pair for pair in pairs if pair not in kept and not self.between(pair)]
        self._measure(rigid, start)
        if any(pair not in kept and pair not in self.found for pair in pairs):
            self._rounds()
            self._try(self.how.trials)
        left = [pair for pair in pairs if pair not in self.found and pair not in self.hit]
        self.bounding.settle()
        for pair, nearest in in_two([one for one in left if not self._is_unbounded(one)], self._nearest, self._told):
            if nearest > max(self.how.clearance, TOUCH):
                self.found[pair] = self._far(pair, nearest)
        return [self.found[pair] for pair in sorted(self.found)]

    def between(self, pair: Pair) -> list[Joint]:
        """Return the joints that move one link of a pair against the other."""
        return [joint for joint in self.planning.between(*pair) if not joint.is_fixed]

    def _is_unbounded(self, pair: Pair) -> bool:
        """Say whether a joint between two links can be anywhere, so that no number of states says never."""
        return any(joint.name not in self.bounds for joint in map(self._leader, self.between(pair)))

    def _leader(self, joint: Joint) -> Joint:
        while joint.mimic is not None:
            joint = self.planning.robot.joint[joint.mimic.joint]
        return joint

    def _is_real(self, pair: Pair, states: Sequence[Positions]) -> bool:
        """Say whether a pair touches in each of some states by its meshes, and not by their hulls alone."""
        real = all(self.contacts.touches_at(pair, state) for state in states)
        self.by_hulls |= set() if real else {pair}
        return real

    def _measure(self, rigid: Sequence[Pair], state: Positions) -> None:
        """Call pairs that no joint moves against each other Never, with the distance that they have."""
        for pair in rigid:
            nearest = self.contacts.exact(pair, state, FAR)
            if nearest > TOUCH:
                self.found[pair] = self._far(pair, nearest)

    def _far(self, pair: Pair, nearest: float) -> DisabledCollision:
        if nearest >= FAR:
            return DisabledCollision(pair, DisabledCollision.NEVER, beyond=FAR)
        return DisabledCollision(pair, DisabledCollision.NEVER, _rounded(nearest))

    def _rounds(self) -> None:
        """Find the pairs that are in collision in nearly every state."""
        most = int(ROUND * self.how.always)
        for _ in range(_MOST_ROUNDS):
            self.contacts = Contacts(
                self.planning, self.meshes, {*self.found, *(one for one in self.same if one in self.hit)}
            )
            hits: dict[Pair, list[Positions]] = {}
            deepest: dict[Pair, float] = {}
            for state, touching in self._states(ROUND):
                for pair, far in touching.items():
                    hits.setdefault(pair, []).append(state)
                    deepest[pair] = min(far, deepest.get(pair, far))
            always = [pair for pair, states in hits.items() if len(states) > most and pair not in self.by_hulls]
            always = [pair for pair in always if self._is_real(pair, hits[pair][:_ASKED])]
            for pair in always:
                self.found[pair] = DisabledCollision(pair, DisabledCollision.ALWAYS, _rounded(deepest[pair]))
            if not always:
                return

    def _try(self, trials: int) -> None:
        known = {*self.found, *self.hit}
        others = [pair for pair in combinations(sorted(self.planning.solids), 2) if pair not in known]
        self.bounding = Bounding(self.contacts, others)
        for _ in self._states(trials):
            pass

    def _states(self, count: int) -> Iterator[tuple[Positions, Mapping[Pair, float]]]:
        """Yield random states and the pairs that touch there, and keep what is worth knowing of them."""
        for first in range(0, count, _AT_ONCE):
            states = [self._state() for _ in range(min(_AT_ONCE, count - first))]
            for state, row in zip(states, self.contacts.placed(states), strict=True):
                touching = self.contacts.touching_at(row)
                self.tried += 1
                self.bounding.take(state, self.contacts)
                self.hit.update(touching)
                if self.tried % 20 == 1:
                    Progress.step("trying states", self.tried, max(self.how.trials + ROUND, self.tried))
                yield state, touching

    def _state(self) -> Positions:
        return {name: low + self.random.random() * (high - low) for name, (low, high) in self.bounds.items()}

    def _told(self, done: int, total: int) -> None:
        Progress.step("bringing links near each other", done, total)

    def _nearest(self, pair: Pair) -> float:
        """Return how near (m) a pair comes when its joints are turned to that end; it draws numbers of its own."""
        self.random = Random(f"{self.how.seed} {' '.join(pair)}")  # noqa: S311 - whatever else is searched
        seen = [(self.contacts.exact(pair, state, _FARTHEST), state) for state in self.bounding.nearest(pair)]
        starts = sorted(seen, key=lambda one: one[0])[:_STARTS]
        return min((self._descend(pair, *start) for start in starts), default=math.inf)

    def _descend(self, pair: Pair, best: float, state: Positions) -> float:
        """Return how near (m) a pair comes where joints between are turned, one by one and together."""
        names = list(dict.fromkeys(joint.name for joint in map(self._leader, self.between(pair))))
        share = _FIRST_STEP
        for _ in range(_HALVINGS):
            moved = True
            while moved and best > TOUCH:
                moved = False
                for step in self._steps(names):
                    turned = self._turned(state, step, share)
                    far = self.contacts.exact(pair, turned, _FARTHEST)
                    if far < best - TOUCH:
                        best, state, moved = far, turned, True
            share /= 2
        return best

    def _steps(self, names: Sequence[str]) -> Iterator[Mapping[str, float]]:
        """Yield in which direction joints are turned: each one back and on, then several at a time."""
        for name in names:
            yield {name: -1.0}
            yield {name: 1.0}
        if len(names) > 1:
            for _ in names:
                step = {name: self.random.uniform(-1, 1) for name in names}
                yield step
                yield {name: -turn for name, turn in step.items()}

    def _turned(self, state: Positions, step: Mapping[str, float], share: float) -> Positions:
        """Return a state with joints turned by a share of their range, as far as they go."""
        made = dict(state)
        for name, turn in step.items():
            low, high = self.bounds[name]
            made[name] = min(high, max(low, state[name] + turn * share * (high - low)))
        return made


class Bounding:
    """The states in which the spheres around the shapes of two links were nearest to each other, for some pairs."""

    def __init__(self, contacts: Contacts, pairs: Sequence[Pair]) -> None:
        import numpy as np

        between = [contacts.between(pair) for pair in pairs]
        self.number = {pair: number for number, pair in enumerate(pairs)}
        self.sides = np.array([shapes for several in between for shapes in several], dtype=int).reshape(-1, 2).T
        self.begins = np.cumsum([0, *map(len, between)])[:-1]
        self.least = np.zeros((0, len(pairs)))
        self.when = np.zeros((0, len(pairs)), dtype=int)
        self.rows: list[Any] = []
        self.states: list[Positions] = []

    def take(self, state: Positions, contacts: Contacts) -> None:
        """Take down a state in which the links have just been placed."""
        import numpy as np

        if self.number:
            self.rows.append(np.minimum.reduceat(contacts.apart_at_least(*self.sides), self.begins))
            self.states.append(state)
            if len(self.rows) == _AT_ONCE:
                self.settle()

    def settle(self) -> None:
        """Keep of the states so far those that are nearest."""
        import numpy as np

        if not self.rows:
            return
        numbers = np.arange(len(self.states) - len(self.rows), len(self.states))
        least = np.vstack([self.least, self.rows])
        when = np.vstack([self.when, np.repeat(numbers[:, None], len(self.number), axis=1)])
        order = np.argsort(least, axis=0, kind="stable")[:_NEAREST]
        self.least, self.when = (np.take_along_axis(table, order, 0) for table in (least, when))
        self.rows = []

    def nearest(self, pair: Pair) -> list[Positions]:
        """Return the states in which a pair was nearest, as far as spheres can tell."""
        self.settle()
        return [self.states[when] for when in self.when[:, self.number[pair]].tolist()]


def in_two(
    pairs: Sequence[Pair], work: Callable[[Pair], float], told: Callable[[int, int], None]
) -> Iterator[tuple[Pair, float]]:
    """Yield what a work says of each pair, every second one done by a copy of this process where there are two cores.

    What the copy does not answer for is done here.
    """
    second = _Second(pairs[1::2], work) if len(pairs) >= _WORTH_IT and system.HAS_FORK and system.cores() > 1 else None
    own = pairs if second is None else pairs[::2]
    for number, pair in enumerate(own):
        told(number * len(pairs) // len(own), len(pairs))
        yield pair, work(pair)
    if second is not None:
        answers = second.answers()
        for pair in pairs[1::2]:
            yield pair, answers[pair] if pair in answers else work(pair)


class _Second:
    """A copy of this process that does a part of a work, and tells it through a pipe when it is done."""

    def __init__(self, pairs: Sequence[Pair], work: Callable[[Pair], float]) -> None:
        self.pipe, into = os.pipe()
        self.process = os.fork()
        if self.process == 0:
            Progress.hide()  # its steps are those of a part
            try:
                with open(into, "wb") as stream:  # noqa: PTH123 - a pipe
                    pickle.dump({pair: work(pair) for pair in pairs}, stream)
            finally:
                os._exit(0)
        os.close(into)

    def answers(self) -> dict[Pair, float]:
        """Return what it says of its pairs; nothing if it ended before that."""
        with open(self.pipe, "rb") as stream:  # noqa: PTH123
            content = stream.read()
        os.waitpid(self.process, 0)
        try:
            return dict(pickle.loads(content))  # noqa: S301 - of a copy of this process
        except (EOFError, pickle.UnpicklingError):
            return {}


def bounds_of(planning: Planning) -> dict[str, tuple[float, float]]:
    """Return where the joints that move by themselves can be (rad or m), by name; those without bounds are left out."""
    found = {}
    for name in sorted(planning.joints):
        joint = planning.joints[name]
        if not joint.moves or joint.mimic is not None:
            continue
        limit = joint.limit
        if joint.type != "continuous" and limit is not None and limit.lower is not None and limit.upper is not None:
            found[name] = (limit.lower, limit.upper)
        elif joint.type != "prismatic":
            found[name] = (-math.pi, math.pi)
    return found


def default_state(planning: Planning) -> Positions:
    """Return MoveIt's default state: joints at zero, or in the middle of limits that do not hold zero."""
    bounds = bounds_of(planning).items()
    return {name: 0.0 if low <= 0 <= high else (low + high) / 2 for name, (low, high) in bounds}


def adjacent(planning: Planning) -> list[Pair]:
    """Return the links with shapes that one joint joins, or joints and links without shapes between them."""
    next_to: dict[str, set[str]] = {name: set() for name in planning.links}
    for joint in planning.joints.values():
        next_to[joint.parent].add(joint.child)
        next_to[joint.child].add(joint.parent)
    bare = [name for name in sorted(planning.links) if name not in planning.solids]
    grown = True
    while grown:
        grown = False
        for name in bare:
            for one, other in combinations(sorted(next_to[name]), 2):
                if other not in next_to[one]:
                    next_to[one].add(other)
                    next_to[other].add(one)
                    grown = True
    solid = planning.solids
    return sorted({ordered((one, two)) for one in solid for two in next_to[one] if two in solid and one != two})


def _rounded(length: float) -> float:
    """Return a length (m) to the tenth of a millimetre, which engines agree on from machine to machine."""
    return round(length, 4) + 0.0
