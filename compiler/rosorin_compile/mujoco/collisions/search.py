"""Which pairs of links need no check, decided as MoveIt's assistant does, and a little more carefully.

Order and numbers: ``moveit/moveit2@{humble,jazzy}:moveit_setup_assistant/moveit_setup_srdf_plugins/src/
compute_default_collisions.cpp``. A pair keeps its first reason:

1. Adjacent: joined by one joint, or over links without shapes;
2. Default: in collision where every joint is at zero, or in the middle of limits that do not include zero;
3. Always: in more than a share of the 200 states of a round; rounds go on until one finds none;
4. Never: in none of the states of the rounds, and of the trials after them.

Here the states follow from the seed alone. Never takes more than luck: a pair that came nearer than the clearance is
none; from its nearest states joints are turned to bring it nearer still; and a pair with a joint between that has no
bounds is none. What no joint moves against each other is measured once. Hulls of meshes that touch are no reason to
leave a pair out where the meshes themselves do not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, product
from random import Random
from typing import Any

from rosorin_compile.model import DisabledCollision
from rosorin_compile.source.progress import Progress

from ..physics.scene import Bodies, Meshes, Pair
from ..rest_pose import leader_of, range_of

FAR = 0.02  # m: links that stay farther apart than this are reported so, without the distance
TOUCH = 1e-6  # m: faces that lie on each other touch, whatever the rounding of the poses made of it
_ROUND, _MOST_ROUNDS = 200, 50  # states of a round
_BLOCK = 1000  # states whose positions are in memory
_NEAREST, _STARTS = 24, 3  # states of a pair that are measured, and from which it is brought nearer
_FIRST_STEP, _HALVINGS = 0.1, 8  # of a joint's range, and how often it is halved when no step brings a pair nearer
_BATCH = 8  # steps that are measured at once
_FARTHEST = 10.0  # m: nothing of a robot is farther from its other parts
_MESH_STATES = 5  # states in which the meshes of a pair are tested, besides their hulls

State = dict[str, float]  # of joints that move by themselves, rad or m
Planning = Any  # ros.srdf.planning.Planning, the robot as MoveIt plans with it: this layer does not import it


class Search(Bodies):
    """One search. ``found`` are the pairs that need no check, ``hit`` those that touched in a state.

    ``same`` are pairs with a result that is still valid, None for one to be checked; ``only_hulls`` those whose hulls
    touch, and not their meshes. Pairs are sorted by name.
    """

    def __init__(
        self, planning: Planning, meshes: Meshes, same: Mapping[Pair, DisabledCollision | None] | None = None
    ) -> None:
        super().__init__(planning.robot, planning.solids, meshes)
        self.model.geom_margin[:] = TOUCH
        self.geoms = {name: [n for n, solid in enumerate(self.solids) if solid.link == name] for name in self.names}
        self.planning, self.same, self.how = planning, dict(same or {}), planning.said.search
        self.random = Random(self.how.seed)  # noqa: S311 - a search that anybody can repeat
        joints = sorted(planning.joints.items())
        self.bounds = {name: ends for name, joint in joints if (ends := range_of(joint))}
        self.found: dict[Pair, DisabledCollision] = {}
        self.hit, self.only_hulls = set[Pair](), set[Pair]()
        self.tried = 0

    def run(self) -> list[DisabledCollision]:
        """Return the pairs that need no check, sorted by name."""
        self.found = {pair: DisabledCollision(pair, DisabledCollision.ADJACENT) for pair in self.planning.adjacent}
        for pair, result in self.same.items():
            if result is None and pair not in self.found:
                self.hit.add(pair)
            elif result is not None and result.reason != DisabledCollision.ADJACENT:
                self.found.setdefault(pair, result)
        start = {name: 0.0 if low <= 0 <= high else (low + high) / 2 for name, (low, high) in self.bounds.items()}
        for pair, overlap in self.overlaps_at(self.rows([start])[0], TOUCH).items():
            if pair not in self.found and pair not in self.hit and self._is_real(pair, [start]):
                self.found[pair] = DisabledCollision(pair, DisabledCollision.DEFAULT, _rounded(-overlap.depth))
        links, known = list(self.planning.solids), self.found.keys() | self.hit
        pairs = [pair for pair in combinations(links, 2) if pair not in known]
        for pair in pairs:
            if not self._joints_between(pair):
                distance = next(self.distances(pair, [start], FAR))
                if distance > TOUCH:
                    self.found[pair] = _never(pair, distance)
        if not self.found.keys() >= set(pairs):
            self._find_always()
            self._find_never([pair for pair in pairs if pair not in self.found and pair not in self.hit])
        return [self.found[pair] for pair in sorted(self.found)]

    def _joints_between(self, pair: Pair) -> list[str]:
        """Return the joints that move one link of a pair against the other; for a mimic joint, its leader."""
        moving = [joint for joint in self.planning.between(*pair) if not joint.is_fixed]
        return list(dict.fromkeys(leader_of(self.planning.robot, joint).name for joint in moving))

    def _is_real(self, pair: Pair, states: Sequence[State]) -> bool:
        """Return True if a pair touches in each of some states by its meshes, and not by their hulls alone."""
        for state in states:
            contacts = [solids for *solids, _ in self.contacts(self.rows([state])[0], TOUCH)]
            if not any(self.touches((a, b), state) for a, b in contacts if {a.link, b.link} == set(pair)):
                self.only_hulls.add(pair)
                return False
        return True

    def distances(self, pair: Pair, states: Sequence[State], most: float) -> Iterator[float]:
        """Yield the distance (m) of a pair in each state, ``most`` at most; below zero is the depth.

        Contacts do not have it: with a margin of centimetres MuJoCo 4.0 misses some of them.
        """
        geoms, measure = list(product(self.geoms[pair[0]], self.geoms[pair[1]])), self.mujoco.mj_geomDistance
        places = [slice(7 * number, 7 * number + 7) for number in map(self.names.index, pair)]
        for row in self.rows(states, pair):
            self.data.qpos[places[0]], self.data.qpos[places[1]] = row[:7], row[7:]
            self.mujoco.mj_kinematics(self.model, self.data)
            gaps = (float(measure(self.model, self.data, first, second, most, None)) for first, second in geoms)
            yield min(gaps, default=most)

    def _states(self, count: int) -> Iterator[tuple[State, dict[Pair, float]]]:
        """Yield random states, in which the links are placed, and the open pairs that touch there with their depth."""
        for first in range(0, count, _BLOCK):
            states = [
                {name: low + self.random.random() * (high - low) for name, (low, high) in self.bounds.items()}
                for _ in range(min(_BLOCK, count - first))
            ]
            for state, row in zip(states, self.rows(states), strict=True):
                overlaps = self.overlaps_at(row, TOUCH).items()
                touching = {pair: overlap.depth for pair, overlap in overlaps if pair not in self.found}
                self.hit.update(touching)
                self.tried += 1
                if self.tried % 20 == 1:
                    Progress.step("trying states", self.tried, max(self.how.trials + _ROUND, self.tried))
                yield state, touching

    def _find_always(self) -> None:
        """Find the pairs that are in collision in nearly every state."""
        valid = {pair for pair in self.same if pair in self.hit}
        for _ in range(_MOST_ROUNDS):
            hits: dict[Pair, list[tuple[State, float]]] = {}
            for state, touching in self._states(_ROUND):
                for pair in touching.keys() - valid - self.only_hulls:
                    hits.setdefault(pair, []).append((state, touching[pair]))
            often = {pair: states for pair, states in hits.items() if len(states) > int(_ROUND * self.how.always)}
            always = [p for p, states in often.items() if self._is_real(p, [one for one, _ in states[:_MESH_STATES]])]
            for pair in always:
                depth = max(depth for _, depth in hits[pair])
                self.found[pair] = DisabledCollision(pair, DisabledCollision.ALWAYS, _rounded(-depth))
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

        geoms = [list(product(self.geoms[first], self.geoms[second])) for first, second in pairs]
        first, second = np.array([both for several in geoms for both in several], dtype=int).reshape(-1, 2).T
        starts, radii = np.cumsum([0, *map(len, geoms)])[:-1], self.model.geom_rbound[first]
        radii += self.model.geom_rbound[second]
        gaps, numbers = np.empty((0, len(pairs))), np.empty((0, len(pairs)), dtype=int)
        states, block = list[State](), list[Any]()
        for state, _ in self._states(self.how.trials):
            apart = np.linalg.norm(self.data.geom_xpos[first] - self.data.geom_xpos[second], axis=1)
            block.append(np.minimum.reduceat(apart - radii, starts) if pairs else apart)
            states.append(state)
            if len(block) == _BLOCK or len(states) == self.how.trials:
                added = np.arange(len(states) - len(block), len(states))[:, None].repeat(len(pairs), axis=1)
                gaps, numbers = np.concatenate([gaps, block]), np.concatenate([numbers, added])
                order = np.argsort(gaps, axis=0, kind="stable")[:_NEAREST]
                gaps, numbers, block = (*(np.take_along_axis(one, order, 0) for one in (gaps, numbers)), [])
        return {pair: [states[number] for number in numbers[:, index]] for index, pair in enumerate(pairs)}

    def approach(self, pair: Pair, joints: Sequence[str], states: Sequence[State]) -> float:
        """Return how near (m) a pair comes from some states when the joints between are turned to that end."""
        chance = Random(f"{self.how.seed} {' '.join(pair)}")  # noqa: S311 - whatever else is searched
        measured = zip(self.distances(pair, states, _FARTHEST), states, strict=True)
        starts = sorted(measured, key=lambda start: start[0])[:_STARTS]
        return min((self._descend(pair, joints, chance, *start) for start in starts), default=math.inf)

    def _descend(self, pair: Pair, joints: Sequence[str], chance: Random, best: float, state: State) -> float:
        """Return how near (m) a pair comes from one state, joints turned one by one and together."""
        share, is_nearer = _FIRST_STEP, True
        for _ in range(_HALVINGS):
            while is_nearer and best > TOUCH:
                is_nearer = False
                steps = [{name: turn} for name in joints for turn in (-1.0, 1.0)]
                for _ in joints if len(joints) > 1 else ():
                    step = {name: chance.uniform(-1, 1) for name in joints}
                    steps += [step, {name: -turn for name, turn in step.items()}]
                while steps:
                    turned = []
                    for step in steps[:_BATCH]:  # each joint by a share of its range, as far as it goes
                        moved = {
                            name: min(high, max(low, state[name] + step[name] * share * (high - low)))
                            for name, (low, high) in self.bounds.items()
                            if name in step
                        }
                        turned.append({**state, **moved})
                    distances = enumerate(self.distances(pair, turned, _FARTHEST), 1)
                    done, nearer = next(((n, d) for n, d in distances if d < best - TOUCH), (len(turned), best))
                    if nearer < best:  # the steps after it start there
                        best, state, is_nearer = nearer, turned[done - 1], True
                    steps = steps[done:]
            share, is_nearer = share / 2, True
        return best


def _never(pair: Pair, distance: float) -> DisabledCollision:
    is_far = distance >= FAR
    return DisabledCollision(pair, DisabledCollision.NEVER, *((None, FAR) if is_far else (_rounded(distance),)))


def _rounded(length: float) -> float:
    """Return a length (m) to the tenth of a millimetre, on which engines agree from machine to machine."""
    return round(length, 4) + 0.0
