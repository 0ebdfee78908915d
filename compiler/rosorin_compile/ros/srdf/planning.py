"""A robot as MoveIt loads it from URDF and SRDF: joints of groups, the virtual joint, and collision pairs.

As in ``moveit/moveit2:moveit_core/robot_model``, a chain is the path between its base and its tip in the tree of links;
a link in a group adds its parent joint. Digests show whether the collision matrix is up to date; their inputs are
rounded to nine decimals, so that they are equal on all machines.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cached_property
from hashlib import sha256
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.urdf.write import joints_of, links_of, solids
from rosorin_compile.model import DisabledCollision, Joint, Mesh, Output, Robot, Shape, Transform
from rosorin_compile.model.drive import SLIDING
from rosorin_compile.model.robot import JointPose
from rosorin_compile.ros.sections.moveit import FIXED, FLOATING, PLANAR, Group, Moveit, Pair, VirtualJoint
from rosorin_compile.source.cache import of_robot
from rosorin_compile.source.diagnostics import count_of, first_of
from rosorin_compile.source.files import read_bytes

URDF = "urdf"
_FORM = 1  # version of the search algorithm; increase it to make every collision matrix stale


class MatrixDigests(NamedTuple):
    """Digests of the inputs of a collision matrix: search settings (``how``), shapes of each link, and each joint."""

    how: str
    shapes: Mapping[str, str]
    joints: Mapping[str, str]


@of_robot
def planning_model(robot: Robot) -> PlanningModel | None:
    """Return the robot as MoveIt loads it, or None if there is no URDF output that MoveIt can load."""
    urdfs = [output for output in robot.outputs if output.backend == URDF]
    name = robot.moveit.urdf if robot.moveit is not None else ""
    published = [output for output in urdfs if output.options.get("frames", "published") == "published"]
    candidates = [output for output in urdfs if output.name == name] if name else published or urdfs
    return PlanningModel(robot, candidates[0]) if candidates else None


class PlanningModel:
    """A robot as MoveIt loads it from a URDF output. ``said`` is the section ``moveit``; its names may be invalid."""

    def __init__(self, robot: Robot, urdf: Output) -> None:
        self.robot = robot
        self.urdf = urdf
        self.said = robot.moveit or Moveit()
        self.links = links_of(robot, urdf)
        self.joints: Mapping[str, Joint] = {joint.name: joint for joint in joints_of(robot, urdf)}
        self.joint_to: Mapping[str, Joint] = {joint.child: joint for joint in self.joints.values()}
        self.groups: Mapping[str, Group] = {group.name: group for group in self.said.groups}

    @cached_property
    def digest(self) -> str:
        """A digest of the collision shapes, joints and limits in the URDF, and of the search settings."""
        links = {name: [_solid(one) for one in solids] for name, solids in self.solids.items()}
        joints = [self._joint(name) for name in self._carrying()]
        return _hash({"form": _FORM, "links": links, "joints": joints, "search": vars(self.said.search)}, 32)

    @property
    def meshes(self) -> list[str]:
        """The sorted unique names of collision mesh files."""
        shapes = (shape.geometry for solids in self.solids.values() for shape in solids)
        return sorted({geometry.file for geometry in shapes if isinstance(geometry, Mesh)})

    def digests(self, files: Mapping[str, Path]) -> dict[str, str]:
        """Return the digests of readable collision mesh files by name; ``files`` maps names to paths."""
        found = {}
        for name in self.meshes:
            with suppress(KeyError, OSError):
                found[name] = sha256(read_bytes(files[name])).hexdigest()[:32]
        return found

    def parts(self, meshes: Mapping[str, str]) -> MatrixDigests:
        """Return the digests of the inputs of the collision matrix; ``meshes`` maps mesh file names to digests."""
        shapes = {}
        for name, those in sorted(self.solids.items()):
            files = [meshes.get(one.geometry.file, "") for one in those if isinstance(one.geometry, Mesh)]
            shapes[name] = _hash([list(map(_solid, those)), files])
        joints = {name: _hash(self._joint(name)) for name in self._carrying()}
        return MatrixDigests(_hash([_FORM, vars(self.said.search)]), shapes, joints)

    def same_pairs(self, now: MatrixDigests) -> dict[Pair, DisabledCollision | None]:
        """Map link pairs with the same digests in ``now`` to their matrix entries, or to None if MoveIt checks them."""
        if (matrix := self.said.matrix) is None or matrix.how != now.how:
            return {}
        then = {sort_pair(pair.links): pair for pair in matrix.pairs}
        shapes = [name for name, digest in now.shapes.items() if matrix.shapes.get(name) == digest]
        joints = {name for name, digest in now.joints.items() if matrix.joints.get(name) == digest}
        ways = {name: {joint.name for joint in self.chain(name)} for name in shapes}
        found: dict[Pair, DisabledCollision | None] = {}
        for first, second in combinations(sorted(shapes), 2):
            if self._with_leaders(ways[first] ^ ways[second]) <= joints:
                found[sort_pair((first, second))] = then.get(sort_pair((first, second)))
        return found

    def stale_pairs(self) -> tuple[list[Pair], list[str]]:
        """Return the pairs of the matrix whose shapes, joints or meshes changed, and the names of changed mesh files.

        Pairs that are still adjacent are not stale. Mesh files that do not exist count as unchanged.
        """
        if (computed := self.said.matrix) is None:
            return [], []
        then, now = dict(computed.meshes), self.digests(self.robot.mesh_files)
        changed = [name for name, digest in now.items() if then.get(name) != digest]
        if computed.of == self.digest and not changed:
            return [], []
        same = self.same_pairs(self.parts({**then, **now}))
        reasons = {sort_pair(pair.links): pair.reason for pair in computed.pairs}
        adjacent = {pair for pair in self.adjacent if reasons.get(pair) == DisabledCollision.ADJACENT}
        existing = [pair for pair in reasons if self.links.issuperset(pair)]
        return [pair for pair in existing if pair not in same and pair not in adjacent], changed

    def _with_leaders(self, names: Iterable[str]) -> set[str]:
        found: set[str] = set()
        waiting = list(names)
        while waiting:
            if (joint := self.joints.get(waiting.pop())) is not None and joint.name not in found:
                found.add(joint.name)
                waiting += [joint.mimic.joint] if joint.mimic is not None else []
        return found

    def _carrying(self) -> list[str]:
        """Return the sorted names of joints that move links with shapes, and of the joints that they mimic."""
        return sorted(self._with_leaders(joint.name for link in self.solids for joint in self.chain(link)))

    def _joint(self, name: str) -> list[Any]:
        joint = self.joints[name]
        limit = joint.limit
        limits = None if limit is None or joint.type == "continuous" else _rounded((limit.lower, limit.upper))
        mimic = joint.mimic and [joint.mimic.joint, _rounded((joint.mimic.multiplier, joint.mimic.offset))]
        axis = None if joint.is_fixed else _rounded(joint.axis)
        return [name, joint.type, joint.parent, joint.child, _place(joint.origin.transform()), axis, limits, mimic]

    @cached_property
    def root(self) -> str:
        return next(link.name for link in self.robot.walk() if link.name in self.links)

    def chain(self, link: str) -> list[Joint]:
        """Return the joints on the path from a link up to the root."""
        found: list[Joint] = []
        while (joint := self.joint_to.get(link)) is not None and joint not in found:
            found, link = [*found, joint], joint.parent
        return found

    def joints_between(self, base: str, tip: str) -> list[Joint]:
        """Return the joints on the path from ``base`` to ``tip``."""
        up, other = self.chain(tip), self.chain(base)
        shared = [joint for joint in up if joint in other]
        return [*(j for j in other if j not in shared), *(j for j in reversed(up) if j not in shared)]

    def joints_in(self, group: Group) -> list[str]:
        """Return the names of all joints of a group and its subgroups, including fixed joints, in URDF order."""
        joints: set[str] = set()
        groups = [group]
        for one in groups:
            if one.chain is not None and self.links.issuperset(one.chain):
                joints |= {joint.name for joint in self.joints_between(*one.chain)}
            joints |= {*one.joints, *(self.joint_to[link].name for link in one.links if link in self.joint_to)}
            inner = (self.groups[name] for name in one.groups if name in self.groups)
            groups += [each for each in inner if each not in groups]
        order = [joint.name for joint in self.robot.joints_down() if joint.name in self.joints]
        order = [self.virtual.name, *order] if self.virtual is not None else order
        return [name for name in order if name in joints]

    def links_in(self, group: Group) -> set[str]:
        """Return the child links of the joints of a group, as in MoveIt."""
        return {self.joints[name].child for name in self.joints_in(group) if name in self.joints}

    def active(self, group: Group) -> list[str]:
        """Return the joints of a group that a planner moves: not fixed, mimic, passive or virtual."""
        names = [name for name in self.joints_in(group) if name not in self.said.passive_joints]
        joints = [self.joints[name] for name in names if name in self.joints]
        return [joint.name for joint in joints if joint.moves and joint.mimic is None]

    def states(self, group: Group) -> dict[str, JointPose]:
        """Return the poses that are states of a group, by state name."""
        poses = {pose.name: pose for pose in self.robot.poses}
        if group.states is not None:
            return {state: poses[name] for state, name in group.states.items() if name in poses}
        active = self.active(group)
        return {name: pose for name, pose in poses.items() if active and all(one in pose.positions for one in active)}

    @cached_property
    def virtual(self) -> VirtualJoint | None:
        """The joint between the world and the root link, with defaults that suit the robot, or None if disabled."""
        if (said := self.said.virtual_joint) is None:
            return None
        edge = next((edge for edge in self.robot.edges if edge.child == self.root and edge.moving), None)
        is_free = any(output.options.get("base") == "free" for output in self.robot.outputs)
        floats = is_free or edge is not None or any(pose.base is not None for pose in self.robot.poses)
        base = PLANAR if self.robot.drive is not None else FLOATING if floats else FIXED
        parent = edge.parent if edge is not None else "odom" if base == PLANAR else "world"
        return VirtualJoint(said.type or base, said.parent or parent, said.name)

    def joint_properties(self) -> dict[str, dict[str, str]]:
        """Return joint settings for planners, including the motion model diff_drive for a base that cannot slide."""
        found = {joint: dict(said) for joint, said in self.said.joint_properties.items()}
        virtual, drive = self.virtual, self.robot.drive
        if virtual is not None and virtual.type == PLANAR and drive is not None and drive.kind not in SLIDING:
            found.setdefault(virtual.name, {}).setdefault("motion_model", "diff_drive")
        return found

    @cached_property
    def solids(self) -> Mapping[str, list[Shape]]:
        """The collision shapes in the URDF, by link; links without shapes are left out."""
        if "collision" not in self.urdf.options.get("elements", ("collision",)):
            return {}
        shapes = {name: solids(self.robot, name, self.urdf, self.links) for name in sorted(self.links)}
        return {name: list(found) for name, found in shapes.items() if found}

    @cached_property
    def adjacent(self) -> list[Pair]:
        """The sorted pairs of links with shapes that a joint connects, directly or through links without shapes."""
        neighbours: dict[str, set[str]] = {name: set() for name in self.links}
        for joint in self.joints.values():
            neighbours[joint.parent].add(joint.child)
            neighbours[joint.child].add(joint.parent)
        for bare in sorted(self.links - self.solids.keys()):  # connect the neighbours of each link without shapes
            around = neighbours.pop(bare)
            for name in around:
                neighbours[name] = (neighbours[name] | around) - {name, bare}
        return sorted({sort_pair((link, near)) for link, several in neighbours.items() for near in several})

    def disabled_pairs(self) -> list[DisabledCollision]:
        """Return the sorted pairs that MoveIt does not check; the matrix has priority over the description."""
        checked = {sort_pair(pair) for pair in self.said.checked}
        found: dict[Pair, DisabledCollision] = {}
        matrix = self.said.matrix.pairs if self.said.matrix is not None else ()
        for one in (*matrix, *self.said.disabled, *(DisabledCollision(pair) for pair in self.robot.disabled_contacts)):
            if (pair := sort_pair(one.links)) not in checked and self.links.issuperset(pair):
                found.setdefault(pair, DisabledCollision(pair, one.reason, one.nearest, one.beyond))
        return [found[pair] for pair in sorted(found)]


def sort_pair(pair: Pair) -> Pair:
    """Sort the two link names of a pair, so that (a, b) and (b, a) are the same pair."""
    one, other = sorted(pair)
    return (one, other)


def stale_text(pairs: list[Pair]) -> str:
    """Format stale pairs of the collision matrix for a message."""
    names = first_of([f"{one} and {other}" for one, other in pairs], 20)
    return f"{count_of(len(pairs), 'pair')} may collide now, though the SRDF still disables the check of {names}"


def _hash(contents: Any, length: int = 16) -> str:
    return sha256(json.dumps(contents, sort_keys=True, separators=(",", ":")).encode()).hexdigest()[:length]


def _solid(shape: Shape) -> list[Any]:
    sizes = [[key, _rounded(value)] for key, value in sorted(vars(shape.geometry).items())]
    return [type(shape.geometry).__name__, sizes, _place(shape.origin().transform())]


def _place(transform: Transform) -> Any:
    return _rounded((transform.xyz, *transform.rows))


def _rounded(value: Any) -> Any:
    if isinstance(value, (tuple, list)):
        return [_rounded(one) for one in value]
    return round(float(value), 9) + 0.0 if isinstance(value, (int, float)) else value
