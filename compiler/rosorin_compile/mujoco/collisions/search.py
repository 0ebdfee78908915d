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
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations, product
from random import Random
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import DisabledCollision
from rosorin_compile.source.progress import Progress

from ..physics.scene import Bodies, Meshes, Pair
from ..rest_pose import leader_of, range_of

if TYPE_CHECKING:
    from ..physics.scene import Floats

FAR = 0.02  # m: links that stay farther apart than this are reported so, without the distance
TOUCH = 1e-6  # m: faces that lie on each other touch, whatever the rounding of the poses made of it
ROUND, _MOST_ROUNDS = 200, 50  # states of a round
_BLOCK = 1000  # states whose positions are in memory
_NEAREST, _STARTS = 24, 3  # states of a pair that are measured, and from which it is brought nearer
_FIRST_STEP, _HALVINGS = 0.1, 8  # of a joint's range, and how often it is halved when no step brings a pair nearer
_BATCH = 8  # steps that are measured at once
_FARTHEST = 10.0  # m: nothing of a robot is farther from its other parts
_MESH_STATES = 5  # states in which the meshes of a pair are tested, besides their hulls

State = dict[str, float]  # of joints that move by themselves, rad or m
Planning = Any  # ros.srdf.planning.Planning, the robot as MoveIt plans with it: this layer does not import it


def ordered(first: str, second: str) -> Pair:
    """Return a pair of links sorted by name."""
    return (first, second) if first < second else (second, first)


class Contacts(Bodies):
    """The collision shapes of the links of a URDF; ``excluded`` pairs are not tested."""

    def __init__(self, planning: Planning, meshes: Meshes, excluded: Iterable[Pair] = ()) -> None:
        links = sorted(planning.solids)
        super().__init__(planning.robot, {name: planning.solids[name] for name in links}, meshes, excluded)
        self.model.geom_margin[:] = TOUCH
        self.geoms: dict[str, list[int]] = {name: [] for name in links}
        for geom, solid in enumerate(self.solids):
            self.geoms[solid.link].append(geom)

    def touching(self, row: Floats) -> dict[Pair, float]:
        """Return the pairs of links that touch where a row of ``rows`` has them, and the distance (m), below zero."""
        distances: dict[Pair, float] = {}
        for first, second, distance in self.contacts(row, TOUCH):
            pair = ordered(first.link, second.link)
            distances[pair] = min(distance, distances.get(pair, distance))
        return distances

    def touch_as_meshes(self, pair: Pair, state: State) -> bool:
        """Return True if a pair whose hulls touch does so by the meshes themselves."""
        if not any(self.solids[geom].mesh for link in pair for geom in self.geoms[link]):
            return True
        contacts = [(first, second) for first, second, _ in self.contacts(self.rows([state])[0], TOUCH)]
        return any(self.touches(solids, state) for solids in contacts if {one.link for one in solids} == set(pair))

    def geom_pairs(self, pair: Pair) -> list[tuple[int, int]]:
        """Return each shape of one link with each of the other, by their numbers."""
        return list(product(self.geoms[pair[0]], self.geoms[pair[1]]))

    def distances(self, pair: Pair, states: Sequence[State], most: float) -> Iterator[float]:
        """Yield the distance (m) of a pair in each state, ``most`` at most; below zero is the depth.

        Contacts do not have it: with a margin of centimetres MuJoCo 4.0 misses some of them.
        """
        geoms, measure = self.geom_pairs(pair), self.mujoco.mj_geomDistance
        places = [slice(7 * number, 7 * number + 7) for number in map(self.names.index, pair)]
        for row in self.rows(states, pair):
            self.data.qpos[places[0]], self.data.qpos[places[1]] = row[:7], row[7:]
            self.mujoco.mj_kinematics(self.model, self.data)
            gaps = (float(measure(self.model, self.data, first, second, most, None)) for first, second in geoms)
            yield min(gaps, default=most)


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
        joints = sorted(planning.joints.items())
        self.bounds = {name: ends for name, joint in joints if (ends := range_of(joint))}
        self.found: dict[Pair, DisabledCollision] = {}
        self.hit: set[Pair] = set()
        self.only_hulls: set[Pair] = set()  # pairs whose hulls touch, and not their meshes
        self.tried = 0
        self.contacts = Contacts(planning, meshes)

    def run(self) -> list[DisabledCollision]:
        """Return the pairs that need no check, sorted by name."""
        self.found = {pair: DisabledCollision(pair, DisabledCollision.ADJACENT) for pair in self.planning.adjacent}
        for pair, result in self.same.items():
            if result is None and pair not in self.found:
                self.hit.add(pair)
            elif result is not None and result.reason != DisabledCollision.ADJACENT:
                self.found.setdefault(pair, result)
        limits = self.bounds.items()
        start = {name: 0.0 if low <= 0 <= high else (low + high) / 2 for name, (low, high) in limits}
        for pair, distance in self.contacts.touching(self.contacts.rows([start])[0]).items():
            if self._is_open(pair) and self._is_real(pair, [start]):
                self.found[pair] = DisabledCollision(pair, DisabledCollision.DEFAULT, _rounded(distance))
        open_pairs = [pair for pair in combinations(sorted(self.planning.solids), 2) if self._is_open(pair)]
        for pair in open_pairs:
            if not self._joints_between(pair):
                distance = next(self.contacts.distances(pair, [start], FAR))
                if distance > TOUCH:
                    self.found[pair] = _never(pair, distance)
        if any(pair not in self.found for pair in open_pairs):
            self._find_always()
            self._find_never([pair for pair in open_pairs if self._is_open(pair)])
        return [self.found[pair] for pair in sorted(self.found)]

    def _is_open(self, pair: Pair) -> bool:
        return pair not in self.found and pair not in self.hit

    def _joints_between(self, pair: Pair) -> list[str]:
        """Return the joints that move one link of a pair against the other; for a mimic joint, its leader."""
        moving = [joint for joint in self.planning.between(*pair) if not joint.is_fixed]
        return list(dict.fromkeys(leader_of(self.planning.robot, joint).name for joint in moving))

    def _is_real(self, pair: Pair, states: Sequence[State]) -> bool:
        """Return True if a pair touches in each of some states by its meshes, and not by their hulls alone."""
        is_real = all(self.contacts.touch_as_meshes(pair, state) for state in states)
        self.only_hulls |= set() if is_real else {pair}
        return is_real

    def _states(self, count: int) -> Iterator[tuple[State, Mapping[Pair, float]]]:
        """Yield random states, in which the links are placed, and the pairs that touch there."""
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
        nearest = self._nearest_states(pairs)
        left = [pair for pair in pairs if pair not in self.hit]
        for number, pair in enumerate(left):
            Progress.step("bringing links near each other", number, len(left))
            joints = self._joints_between(pair)
            if self.bounds.keys() >= set(joints):
                distance = self.approach(pair, joints, nearest[pair])
                if distance > max(self.how.clearance, TOUCH):
                    self.found[pair] = _never(pair, distance)

    def _nearest_states(self, pairs: Sequence[Pair]) -> dict[Pair, list[State]]:
        """Return the random states in which the spheres around the shapes of two links were nearest, nearest first."""
        import numpy as np

        geoms = [self.contacts.geom_pairs(pair) for pair in pairs]
        first, second = np.array([both for several in geoms for both in several], dtype=int).reshape(-1, 2).T
        starts, columns = np.cumsum([0, *map(len, geoms)])[:-1], np.arange(len(pairs))
        radii = self.contacts.model.geom_rbound[first] + self.contacts.model.geom_rbound[second]
        least, when = np.full((_NEAREST, len(pairs)), math.inf), np.zeros((_NEAREST, len(pairs)), dtype=int)
        states: list[State] = []
        for state, _ in self._states(self.how.trials):
            if pairs:
                places = self.contacts.data.geom_xpos
                gaps = np.minimum.reduceat(np.linalg.norm(places[first] - places[second], axis=1) - radii, starts)
                worst = least.argmax(axis=0)
                nearer = gaps < least[worst, columns]
                least[worst[nearer], columns[nearer]] = gaps[nearer]
                when[worst[nearer], columns[nearer]] = len(states)
            states.append(state)
        count = min(_NEAREST, len(states))
        order = np.lexsort((when, least), axis=0)[:count]
        numbers = np.take_along_axis(when, order, 0).T.tolist()
        return {pair: [states[number] for number in row] for pair, row in zip(pairs, numbers, strict=True)}

    def approach(self, pair: Pair, joints: Sequence[str], states: Sequence[State]) -> float:
        """Return how near (m) a pair comes from some states when the joints between are turned to that end."""
        chance = Random(f"{self.how.seed} {' '.join(pair)}")  # noqa: S311 - whatever else is searched
        measured = zip(self.contacts.distances(pair, states, _FARTHEST), states, strict=True)
        starts = sorted(measured, key=lambda start: start[0])[:_STARTS]
        return min((self._descend(pair, joints, chance, *start) for start in starts), default=math.inf)

    def _descend(self, pair: Pair, joints: Sequence[str], chance: Random, best: float, state: State) -> float:
        """Return how near (m) a pair comes from one state, joints turned one by one and together."""
        share = _FIRST_STEP
        for _ in range(_HALVINGS):
            is_nearer = True
            while is_nearer and best > TOUCH:
                is_nearer = False
                steps = [{name: turn} for name in joints for turn in (-1.0, 1.0)]
                for _ in joints if len(joints) > 1 else ():
                    step = {name: chance.uniform(-1, 1) for name in joints}
                    steps += [step, {name: -turn for name, turn in step.items()}]
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


def _never(pair: Pair, distance: float) -> DisabledCollision:
    is_far = distance >= FAR
    return DisabledCollision(pair, DisabledCollision.NEVER, *((None, FAR) if is_far else (_rounded(distance),)))


def _rounded(length: float) -> float:
    """Return a length (m) to the tenth of a millimetre, on which engines agree from machine to machine."""
    return round(length, 4) + 0.0
