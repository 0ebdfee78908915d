"""Compute from a URDF, with pinocchio, the numbers that a conversion must keep.

``benchmarks/converters.py`` compares each MJCF with them.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

STATES = 20
SEED = 25


def reference(path: Path) -> dict[str, Any]:
    """Return the numbers of a URDF that an MJCF is compared with.

    ``links`` are names, the root first. ``joints`` has the properties of each moving joint by its name. ``mass`` is in
    kg. ``states`` are 20 random states of the joints: the positions ``q``, the pose of each link relative to the root
    link, and the joint-space inertia matrix. ``rest`` is the zero pose, moved into the limits. ``pairs`` has two lists
    of links per entry, which can touch. ``visuals`` are the links with visual shapes.
    """
    import pinocchio

    root = ET.parse(path).getroot()  # noqa: S314
    joints = {joint.attrib["name"]: _properties(joint) for joint in root.iter("joint") if _moves(joint)}
    links = [link.attrib["name"] for link in root.findall("link")]
    children = {child.attrib["link"] for child in root.iter("child")}
    links.sort(key=lambda link: link in children)  # the root is first
    model = pinocchio.buildModelFromUrdf(str(path))
    data = model.createData()
    rows = [model.joints[model.getJointId(name)].idx_v for name in joints]
    draw = np.random.default_rng(SEED)
    states = []
    for _ in range(STATES):
        positions = {name: float(draw.uniform(*(joint["limits"] or (-3, 3)))) for name, joint in joints.items()}
        q = pinocchio.neutral(model)
        for name, value in positions.items():
            joint = model.joints[model.getJointId(name)]
            q[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else (np.cos(value), np.sin(value))
        pinocchio.framesForwardKinematics(model, data, q)
        inertia = pinocchio.crba(model, data, q)
        inertia = np.triu(inertia) + np.triu(inertia, 1).T
        poses = {link: data.oMf[model.getFrameId(link, pinocchio.BODY)].homogeneous for link in links}
        states.append(
            {
                "q": positions,
                "poses": {link: pose.tolist() for link, pose in poses.items()},
                "inertia": inertia[np.ix_(rows, rows)].tolist(),
            }
        )
    rest = {name: float(np.clip(0, *(joint["limits"] or (0, 0)))) for name, joint in joints.items()}
    mass = sum(float(mass.attrib["value"]) for mass in root.findall("link/inertial/mass"))
    visuals = [link.attrib["name"] for link in root.findall("link") if link.find("visual") is not None]
    return {
        "links": links,
        "joints": joints,
        "mass": mass,
        "states": states,
        "rest": rest,
        "pairs": _pairs(root),
        "visuals": visuals,
    }


def _pairs(root: ET.Element) -> list[tuple[list[str], list[str]]]:
    """Return the pairs of rigid groups of links with collision shapes that no joint connects."""
    group = {link.attrib["name"]: link.attrib["name"] for link in root.findall("link")}
    joints = [joint for joint in root.iter("joint") if joint.find("parent") is not None]
    ends = [(joint.find("parent").get("link"), joint.find("child").get("link"), _moves(joint)) for joint in joints]
    for parent, child, _ in (one for one in ends if not one[2]):
        old, new = group[child], group[parent]
        group = {link: new if name == old else name for link, name in group.items()}
    adjacent = {frozenset((group[parent], group[child])) for parent, child, moves in ends if moves}
    members: dict[str, list[str]] = {}
    for link in root.findall("link"):
        if link.find("collision") is not None:
            members.setdefault(group[link.attrib["name"]], []).append(link.attrib["name"])
    return [(members[a], members[b]) for a, b in combinations(members, 2) if {a, b} not in adjacent]


def _moves(joint: ET.Element) -> bool:
    return joint.find("parent") is not None and joint.get("type") != "fixed"


def _properties(joint: ET.Element) -> dict[str, Any]:
    dynamics, limit, mimic = joint.find("dynamics"), joint.find("limit"), joint.find("mimic")
    limited = limit is not None and joint.get("type") != "continuous"
    return {
        "damping": float(dynamics.get("damping", 0)) if dynamics is not None else 0.0,
        "friction": float(dynamics.get("friction", 0)) if dynamics is not None else 0.0,
        "limits": [float(limit.get(end, 0)) for end in ("lower", "upper")] if limit is not None and limited else None,
        "effort": float(limit.get("effort", 0)) if limit is not None else 0.0,
        "mimic": {
            "joint": mimic.get("joint"),
            "multiplier": float(mimic.get("multiplier", 1)),
            "offset": float(mimic.get("offset", 0)),
        }
        if mimic is not None
        else None,
    }
