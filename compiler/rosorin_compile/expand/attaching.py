"""Attaching: the joint between a frame of the description and the root link of a robot that it includes."""

from __future__ import annotations

from ..tree import Instance, Map


def root_of(tree: Map) -> str:
    """Return the root link of a robot: what is read as one has a single root."""
    children = {joint["child"] for joint in (tree.get("joints") or {}).values()}
    return next(str(name) for name in tree["links"] if name not in children)


def free_name(root: str, tree: Map) -> str:
    """Return a name for the joint above a root that no joint of the robot has."""
    taken = tree.get("joints") or ()
    name = f"{root}_joint"
    while name in taken:
        name = name.removesuffix("_joint") + "_mount_joint"
    return name


def joint_above(root: str, entry: Map, via: Instance | None) -> Map:
    """Return the joint that attaches a root: what the include says of it, at its places."""
    span = entry.value_spans["parent"]
    made = Map(span, via)
    made.put("type", "fixed", span, span)
    made.put("child", root, span, span)
    for key in ("parent", "xyz", "rpy", "publisher"):
        if entry.get(key) is not None:
            made.put(key, entry[key], entry.key_spans[key], entry.value_spans[key])
    return made
