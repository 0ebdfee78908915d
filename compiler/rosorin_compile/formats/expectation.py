"""Expectation: what the model says, thing by thing as it is asked for, while an artifact is held against it."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import NamedTuple

from rosorin_compile.model import Inertial, Joint, Pose, Robot, Shape, Vector
from rosorin_compile.model.geometry import Rows, rotation_of_rpy

from .facts import AXES, Block, Six, Solid, frame_block, mass_block, mass_of
from .format import Fact, Value, row_name

_NOTHING: Block = {}


class Placed(NamedTuple):
    """Where a frame sits: its parent, the place there (m), the angles (rad) as they were written, the rotation."""

    parent: str
    xyz: Vector
    rpy: Vector
    rows: Rows


class Expectation:
    """What the model says about frames, joints and masses, in the terms of the artifacts.

    ``names`` are the names of links by those that an artifact has for them, ``joints`` those of joints, ``solids`` the
    shapes of the robot as solids, by their identity, as far as somebody asked for them.
    """

    def __init__(self, robot: Robot) -> None:
        self.names: Mapping[str, str] = {}
        self.joints: Mapping[str, str] = {}
        self.solids: dict[int, tuple[Shape, Solid]] = {}
        self._joints = robot.joint
        self._inertials = {link.name: link.inertial for link in robot.links if link.inertial is not None}
        self._poses: dict[str, tuple[str, Pose]] = {joint.child: (joint.parent, joint.origin) for joint in robot.joints}
        for edge in robot.edges:
            # Of several rows for one frame the first one bears its name alone.
            if edge.joint:
                self._poses[row_name(edge)] = (edge.parent, robot.joint[edge.joint].origin)
            elif edge.pose is not None:
                self._poses.setdefault(edge.child, (edge.parent, edge.pose))
        self._places: dict[str, Placed] = {}
        self._masses: dict[int, tuple[float, Vector, Six]] = {}
        self._blocks: dict[tuple[str, str], Block] = {}
        self._motions: dict[Hashable, Block] = {}
        self._motion_of: dict[str, Block] = {}

    def of(
        self, names: Mapping[str, str], inertials: Mapping[str, Inertial], joints: Mapping[str, str] | None = None
    ) -> Expectation:
        """Return what is known for an artifact that has other names, or in which some links weigh something else."""
        if not names and not inertials and not joints:
            return self
        other = Expectation.__new__(Expectation)
        other.__dict__.update(self.__dict__)
        other.names = names
        other.joints = joints or {}
        if inertials:
            other._inertials = {**self._inertials, **inertials}
            other._masses, other._blocks = {}, {}
        return other

    def place(self, frame: str) -> Placed | None:
        """Return where a frame sits; None of one that nothing is known of."""
        found = self._places.get(frame)
        if found is None and frame in self._poses:
            parent, pose = self._poses[frame]
            found = self._places[frame] = Placed(parent, pose.xyz, pose.rpy, rotation_of_rpy(pose.rpy))
        return found

    def mass(self, link: str) -> tuple[float, Vector, Six] | None:
        """Return mass, centre and moments of a link as ``facts.mass_of``; None of one without."""
        inertial = self._inertials.get(link)
        if inertial is None:
            return None
        found = self._masses.get(id(inertial))  # which links may share
        if found is None:
            found = self._masses[id(inertial)] = mass_of(inertial)
        return found

    def motion(self, joint: str) -> Block:
        """Return what is said of a joint but its child: one object for joints of which the same is said."""
        found = self._motion_of.get(joint)
        if found is None:
            found = self._motion_of[joint] = self._motion(self._joints[joint]) if joint in self._joints else _NOTHING
        return found

    def _motion(self, joint: Joint) -> Block:
        key = (joint.type, joint.axis, id(joint.limit), id(joint.mimic))  # which joints may share
        found = self._motions.get(key)
        if found is None:
            found = self._motions[key] = _motion_of(joint)
        return found

    def child(self, joint: str) -> str:
        """Return the child of a joint; empty of one that nothing is known of."""
        return self._joints[joint].child if joint in self._joints else ""

    def block(self, kind: str, name: str) -> Block:
        """Return all that is known of a thing."""
        found = self._blocks.get((kind, name))
        if found is None:
            found = self._blocks[kind, name] = self._block(kind, name)
        return found

    def _block(self, kind: str, name: str) -> Block:
        if kind == "frame" and name in self._poses:
            return frame_block(*self._poses[name])
        if kind == "joint" and name in self._joints:
            return {"child": Value(self._joints[name].child), **self.motion(name)}
        if kind == "link" and name in self._inertials:
            return mass_block(self._inertials[name])
        return _NOTHING

    def value(self, fact: Fact) -> Value | None:
        """Return what is known of a fact."""
        return self.block(fact[0], fact[1]).get(fact[2])


def _motion_of(joint: Joint) -> Block:
    values: dict[str, Value] = {"type": Value(joint.type)}
    unit = "m" if joint.type == "prismatic" else "rad"
    if joint.moves or joint.type == "planar":
        values |= {f"axis {axis}": Value(float(value)) for axis, value in zip(AXES, joint.axis, strict=True)}
    if joint.moves and joint.limit:
        limits = {"lower": joint.limit.lower, "upper": joint.limit.upper, "velocity": joint.limit.velocity}
        limits["effort"] = joint.limit.effort
        values |= {quantity: Value(float(value), unit) for quantity, value in limits.items() if value is not None}
    if joint.mimic:
        values["mimic joint"] = Value(joint.mimic.joint)
        values["mimic multiplier"] = Value(float(joint.mimic.multiplier))
        values["mimic offset"] = Value(float(joint.mimic.offset), unit)
    return values
