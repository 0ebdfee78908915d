"""Compute the collision matrix of a robot for MoveIt, and write it to a file that the description can include."""

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import combinations, product
from pathlib import Path
from random import Random
from typing import Annotated, Any

from rosorin_compile.formats.mesh_files import Places
from rosorin_compile.model import DisabledCollision, Robot
from rosorin_compile.output.atomic_files import OutputError, may_replace, write_file
from rosorin_compile.request import Request
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, count_of, error
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.yaml_text import Scalar

from .mjcf.bodies import leader_of, range_of
from .physics import require
from .solids import Bodies, Meshes, Pair, read_meshes

FILE = "collisions.yaml"
FAR = 0.02  # m: for links farther apart, the matrix contains this lower bound ("beyond") instead of the distance
TOUCH = 1e-6  # m: tolerance, because rounding can separate faces that coincide
_ROUND, _MOST_ROUNDS = 200, 50  # random states per round, and the maximum number of rounds
_BLOCK = 1000  # number of states held in memory at once
_NEAREST, _STARTS = 24, 3  # per pair of links: number of states to measure, and to start a search from
_FIRST_STEP, _HALVINGS = 0.1, 8  # of the search: first step as a share of the joint range, number of halvings
_BATCH = 8  # number of candidate steps measured at once
_FARTHEST = 10.0  # m: maximum distance to measure, larger than a robot
_MESH_STATES = 5  # maximum number of states in which to test two meshes whose convex hulls touch

State = dict[str, float]  # position (rad or m) of each joint that is not a mimic joint
Planning = Any  # ros.srdf.planning.Planning, which this layer must not import


@dataclass(frozen=True)
class CollisionMatrix:
    """The result of ``compute_matrix``. If ``diagnostics`` has an error, no file was written."""

    robot: str
    file: str
    written: Annotated[bool, "false: the file is up to date, or there is an error"] = False
    urdf: Annotated[str, "the URDF that the matrix belongs to"] = ""
    seed: Annotated[int, "the seed of the search"] = 0
    states: Annotated[int, "the number of random states that were tried"] = 0
    links: Annotated[int, "the number of links with collision shapes"] = 0
    pairs: Annotated[tuple[DisabledCollision, ...], "pairs that MoveIt does not need to check; distances in m"] = ()
    kept: Annotated[int, "the number of pairs whose result is still valid from the matrix before"] = 0
    touching_hulls: Annotated[tuple[Pair, ...], "pairs to be checked whose hulls touch, but not their meshes"] = ()
    contradicted: Annotated[tuple[Pair, ...], "pairs that the description declares as Never, and that collide"] = ()
    included: Annotated[bool, "whether the description includes a matrix"] = False
    diagnostics: tuple[Diagnostic, ...] = ()


def compute_matrix(
    request: Request, plan_of: Callable[[Robot], Planning | None], *, output: Path | None = None, force: bool = False
) -> CollisionMatrix:
    """Find the pairs of links that MoveIt need not check, and write them to a file that the description can include.

    A matrix in the description that still matches the robot is not computed again.

    Args:
        request: The description and the arguments to compile it with.
        plan_of: Returns the URDF and SRDF of a robot as MoveIt loads them, or None if the robot has no URDF output.
        output: The file to write, by default ``collisions.yaml`` next to the description.
        force: Compute all pairs again, even if an existing matrix is still valid.

    Raises MissingPackages if MuJoCo is not installed, and RequestError if ``output`` is not a regular file.
    """
    understood, path = request.understand(), output or request.description.path.parent / FILE
    case, errors = understood.case, tuple(one for one in understood.diagnostics if one.severity == "error")
    refused = CollisionMatrix(request.description.name, str(path), diagnostics=errors)
    if case is None:
        return refused

    def refuse(message: str, help: str, *more: Diagnostic) -> CollisionMatrix:
        return replace(refused, diagnostics=(*more, error("collisions-refused", message, None, help)))

    if (planning := plan_of(case.robot)) is None:
        return refuse(f"{case.robot.name} has no URDF among its outputs", "add urdf: {file: NAME.urdf}")
    if os.path.lexists(path) and not path.is_file():
        raise RequestError(f"{path} cannot be written: it is not a regular file")
    with suppress(OSError, ValueError):  # a missing file can be written, and other errors are reported later
        if not may_replace(path):
            return refuse(f"{path} was not written by rosorin-compile", "name another file with -o, or remove it")
    places = Places(request.description.path, request.description.outputs, request.packages, os.environ)
    files = places.meshes(case.tree, case.robot.outputs) if planning.meshes else {}
    digests, included, seed = planning.digests(files), planning.said.matrix, planning.said.search.seed
    result = replace(refused, urdf=planning.urdf.file, seed=seed, included=included is not None)
    if included is not None and included.of == planning.digest and dict(included.meshes) == digests and not force:
        return result
    require("collisions")
    _, meshes, problems = read_meshes(case, files, planning.meshes)
    if problems:
        help = "--package NAME=PATH names a package"
        return refuse("pairs that never touch can only be found with all meshes", help, *problems)
    parts = planning.parts(digests)
    search = Search(planning, meshes, {} if force else planning.same_pairs(parts))
    pairs = search.run()
    text = f"""\
# Generated by rosorin-compile collisions; edits here are lost. Which pairs of links MoveIt need not check:
# {count_of(search.tried, "random state")} of {planning.urdf.file}, seed {seed}.
moveit:
  collision_matrix:
    of: "{planning.digest}"
    states: {search.tried}
    how: "{parts.how}"
"""
    for key, values in {"meshes": digests, "shapes": parts.shapes, "joints": parts.joints}.items():
        text += f"    {key}:\n" if values else ""
        text += "".join(f'      {Scalar(name).as_text(False)}: "{one}"\n' for name, one in sorted(values.items()))
    text += "    pairs:\n" if pairs else "    pairs: []\n"
    for pair in pairs:
        names = ", ".join(Scalar(name).as_text(True) for name in pair.links)
        distances = {"nearest": pair.nearest, "beyond": pair.beyond}
        more = "".join(f", {key}: {1000 * d + 0.0:.6g} mm" for key, d in distances.items() if d is not None)
        text += f"      - {{links: [{names}], reason: {pair.reason}{more}}}\n"
    try:
        write_file(path, text.encode())
    except OutputError as problem:
        return replace(refused, diagnostics=(problem.diagnostic,))
    never = [one.links for one in planning.said.disabled if one.reason == DisabledCollision.NEVER]
    return replace(
        result,
        written=True,
        states=search.tried,
        links=len(planning.solids),
        pairs=tuple(pairs),
        kept=len(search.same),
        touching_hulls=tuple(sorted(search.only_hulls)),
        contradicted=tuple(pair for pair in never if not search.hit.isdisjoint((pair, pair[::-1]))),
    )


class Search(Bodies):
    """Search for the pairs of links that need no collision check, like MoveIt's Setup Assistant but stricter.

    A pair gets the first reason that applies (moveit2: moveit_setup_srdf_plugins/src/compute_default_collisions.cpp):

    1. Adjacent: connected by a joint, or by a chain of joints through links without collision shapes.
    2. Default: in collision with every joint at zero, or at mid-range if its limits do not include zero.
    3. Always: in collision in more than a given share of 200 random states. Rounds of 200 states are repeated until a
       round finds no such pair.
    4. Never: in collision in no random state, all joints between the links have limits, and a local search that starts
       from the nearest states cannot bring the links closer than the clearance.

    The random states depend only on the seed. The two names in a pair are sorted. Attributes:

    - ``found``: the result for each pair that needs no check
    - ``hit``: pairs that were in collision in a state
    - ``only_hulls``: pairs whose convex hulls touch, but not their meshes
    - ``same``: results of an earlier matrix that are still valid; None means that the pair must be checked
    """

    def __init__(self, planning: Planning, meshes: Meshes, same: Mapping[Pair, DisabledCollision | None]) -> None:
        super().__init__(planning.robot, planning.solids, meshes)
        self.model.geom_margin[:] = TOUCH
        self.geoms = {name: [n for n, solid in enumerate(self.solids) if solid.link == name] for name in self.names}
        self.planning, self.same, self.how = planning, same, planning.said.search
        self.random = Random(self.how.seed)  # noqa: S311 - the search must be reproducible
        self.bounds = {name: ends for name, joint in sorted(planning.joints.items()) if (ends := range_of(joint))}
        self.found: dict[Pair, DisabledCollision] = {}
        self.hit, self.only_hulls = set[Pair](), set[Pair]()
        self.tried = 0

    def run(self) -> list[DisabledCollision]:
        """Return all pairs that need no check, sorted by link names."""
        self.found = {pair: DisabledCollision(pair, DisabledCollision.ADJACENT) for pair in self.planning.adjacent}
        for pair, result in self.same.items():
            if result is None and pair not in self.found:
                self.hit.add(pair)
            elif result is not None and result.reason != DisabledCollision.ADJACENT:
                self.found.setdefault(pair, result)
        start = {name: 0.0 if low <= 0 <= high else (low + high) / 2 for name, (low, high) in self.bounds.items()}
        for pair, overlap in next(self.overlaps([start], TOUCH)).items():
            if pair not in self.found and pair not in self.hit and self._is_real(pair, [start]):
                self.found[pair] = DisabledCollision(pair, DisabledCollision.DEFAULT, _rounded(-overlap.depth))
        known = self.found.keys() | self.hit
        pairs = [pair for pair in combinations(self.names, 2) if pair not in known]
        for pair in pairs:
            if not self._joints_between(pair) and (distance := next(self.distances(pair, [start], FAR))) > TOUCH:
                self.found[pair] = _never(pair, distance)
        if self.found.keys() >= set(pairs):
            return [self.found[pair] for pair in sorted(self.found)]
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
                break
        pairs = [pair for pair in pairs if pair not in self.found and pair not in self.hit]
        nearest = self._nearest_states(pairs)
        pairs = [pair for pair in pairs if pair not in self.hit]
        for number, pair in enumerate(pairs):
            Progress.step("bringing links near each other", number, len(pairs))
            joints = self._joints_between(pair)
            distance = self.approach(pair, joints, nearest[pair]) if self.bounds.keys() >= set(joints) else 0.0
            if distance > max(self.how.clearance, TOUCH):
                self.found[pair] = _never(pair, distance)
        return [self.found[pair] for pair in sorted(self.found)]

    def _joints_between(self, pair: Pair) -> list[str]:
        moving = [joint for joint in self.planning.joints_between(*pair) if not joint.is_fixed]
        return list(dict.fromkeys(leader_of(self.planning.robot, joint).name for joint in moving))

    def _is_real(self, pair: Pair, states: Sequence[State]) -> bool:
        """Return True if the meshes touch in every state; otherwise add the pair to ``only_hulls``."""
        for state in states:
            contacts = [solids for *solids, _ in self.contacts(self.rows([state])[0], TOUCH)]
            if not any(self.touches((a, b), state) for a, b in contacts if {a.link, b.link} == set(pair)):
                self.only_hulls.add(pair)
                return False
        return True

    def distances(self, pair: Pair, states: Sequence[State], most: float) -> Iterator[float]:
        """Yield the distance (m) between two links in each state, clamped to the maximum ``most``."""
        geoms, measure = list(product(self.geoms[pair[0]], self.geoms[pair[1]])), self.mujoco.mj_geomDistance
        places = [slice(7 * number, 7 * number + 7) for number in map(self.names.index, pair)]
        for row in self.rows(states, pair):
            self.data.qpos[places[0]], self.data.qpos[places[1]] = row[:7], row[7:]
            self.mujoco.mj_kinematics(self.model, self.data)
            gaps = (float(measure(self.model, self.data, first, second, most, None)) for first, second in geoms)
            yield min(gaps, default=most)

    def _states(self, count: int) -> Iterator[tuple[State, dict[Pair, float]]]:
        """Yield ``count`` random states, each with the depth (m) of all touching pairs that are not in ``found``."""
        for first in range(0, count, _BLOCK):
            block, bounds = range(min(_BLOCK, count - first)), self.bounds.items()
            states = [{name: low + self.random.random() * (high - low) for name, (low, high) in bounds} for _ in block]
            for state, overlaps in zip(states, self.overlaps(states, TOUCH), strict=True):
                touching = {pair: overlap.depth for pair, overlap in overlaps.items() if pair not in self.found}
                self.hit.update(touching)
                self.tried += 1
                if self.tried % 20 == 1:
                    Progress.step("trying states", self.tried, max(self.how.trials + _ROUND, self.tried))
                yield state, touching

    def _nearest_states(self, pairs: Sequence[Pair]) -> dict[Pair, list[State]]:
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
        """Return the smallest distance (m) of two links that a pattern search over ``joints`` finds from ``states``."""
        chance = Random(f"{self.how.seed} {' '.join(pair)}")  # noqa: S311 - one seed per pair, for reproducible results
        measured = zip(self.distances(pair, states, _FARTHEST), states, strict=True)
        low, high = ({name: ends[which] for name, ends in self.bounds.items()} for which in (0, 1))
        nearest = math.inf
        for best, state in sorted(measured, key=lambda start: start[0])[:_STARTS]:
            share = _FIRST_STEP
            while share > _FIRST_STEP / 2**_HALVINGS and best > TOUCH:
                is_nearer, steps = False, [{name: turn} for name in joints for turn in (-1.0, 1.0)]
                for _ in joints if len(joints) > 1 else ():
                    step = {name: chance.uniform(-1, 1) for name in joints}
                    steps += [step, {name: -turn for name, turn in step.items()}]
                while steps:
                    turned = []
                    for step in steps[:_BATCH]:  # move each joint by a share of its range, clamped to its limits
                        moves = {n: state[n] + turn * share * (high[n] - low[n]) for n, turn in step.items()}
                        turned.append({**state, **{n: min(high[n], max(low[n], at)) for n, at in moves.items()}})
                    distances = enumerate(self.distances(pair, turned, _FARTHEST), 1)
                    done, nearer = next(((n, d) for n, d in distances if d < best - TOUCH), (len(turned), best))
                    if nearer < best:  # the remaining steps start from this state
                        best, state, is_nearer = nearer, turned[done - 1], True
                    steps = steps[done:]
                share = share if is_nearer else share / 2
            nearest = min(nearest, best)
        return nearest


def _never(pair: Pair, distance: float) -> DisabledCollision:
    return DisabledCollision(pair, DisabledCollision.NEVER, *(None, FAR) if distance >= FAR else (_rounded(distance),))


def _rounded(length: float) -> float:
    """Round a length (m) to 0.1 mm, so that the file is the same on every machine."""
    return round(length, 4) + 0.0
