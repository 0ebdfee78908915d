"""Find renamed links and joints, between two versions of a robot or between two robots.

Two links that only one side has are the same link if the joint above them has the same name, if the same frame is
attached to them, or if their pose is equal. Two joints are the same joint if the link below them is the same.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from rosorin_compile.model import Pose, Robot

from .walk import Leaves

Names = Mapping[str, str]
_LINKS = ("frame", "link", "height map")
_DIGITS = 9  # decimal places of metres and radians
# The share of names that must begin with a prefix.
_MOST = 0.6


def links_of(found: Leaves) -> set[str]:
    """Return the names of all links and frames in leaves, without the rows of publishers that alternate by mode."""
    names = {name for kind, name in found if kind in ("frame", "link")}
    return names | {str(of["parent"]) for (kind, _), of in found.items() if kind == "frame" and "parent" in of}


def new_link_names(old: Leaves, new: Leaves) -> dict[str, str]:
    """Return the new names of renamed links by their old names, from the root down."""
    before, after = links_of(old), links_of(new)
    gone, fresh = before - after, after - before
    found: dict[str, str] = {}
    signs = ["joint", "child", "place"] if gone and fresh else []
    waiting = list(signs)
    while waiting:  # each match may allow further matches
        sign = waiting.pop(0)
        was, now = _signs(old, gone, sign, found), _signs(new, fresh, sign, found)
        made = {link: now[key] for key, link in was.items() if key in now and link not in found}
        made = {link: name for link, name in made.items() if name not in found.values()}
        found |= made
        waiting = list(signs) if made else waiting
    return found


def _signs(side: Leaves, links: Collection[str], sign: str, renamed: Names) -> dict[tuple[Any, ...], str]:
    """Return links by identifying feature, without features that two links share."""
    found: dict[tuple[Any, ...], str] = {}
    shared = set()
    roots = [link for link in links if ("frame", link) not in side] if sign == "place" else []
    signs: list[tuple[str, tuple[Any, ...]]] = [(link, ("",)) for link in roots]
    for (kind, name), of in side.items():
        origin = of.get("origin")
        if sign == "joint" and kind == "joint" and of.get("child") in links:
            signs.append((of["child"], (name,)))
        elif sign == "child" and kind == "frame" and of.get("parent") in links:
            signs.append((of["parent"], (name,)))
        elif sign == "place" and kind == "frame" and name in links and isinstance(origin, Pose):
            numbers = (round(x, _DIGITS) + 0.0 for x in (*origin.xyz, *origin.rpy))
            signs.append((name, (of.get("parent", ""), *numbers)))
    for link, value in signs:
        key = (renamed.get(value[0], value[0]), *value[1:])
        if found.setdefault(key, link) != link:
            shared.add(key)
    return {key: link for key, link in found.items() if key not in shared}


def new_joint_names(old: Leaves, new: Leaves) -> dict[str, str]:
    """Return the new names of renamed joints by their old names: the link below is the same."""
    joints = [[(name, of) for (kind, name), of in side.items() if kind == "joint"] for side in (old, new)]
    before, after = ({of["child"]: name for name, of in some if "child" in of} for some in joints)
    found = {name: after[child] for child, name in before.items() if after.get(child, name) != name}
    # A joint may have another link below it, because its link was removed.
    kept = {before[child] for child in before.keys() - after} | {after[child] for child in after.keys() - before}
    fixed = [{name for name, of in some if of.get("type") == "fixed"} for some in joints]
    unlike = {name for name, other in found.items() if (name in fixed[0]) != (other in fixed[1])}
    return {name: other for name, other in found.items() if name not in unlike or kept.isdisjoint((name, other))}


def with_names(found: Leaves, names: Names, what: str, new: Leaves) -> Leaves:
    """Rename each "link" or "joint" in leaves; references get the new name only if ``new`` has it there, too."""
    if not names:
        return found
    kinds = _LINKS if what == "link" else ("joint",)
    made: Leaves = {}
    for (kind, name), entry in found.items():
        plain, space, rest = name.partition(" ")  # rows of publishers that alternate by mode have more words
        if kind in kinds or (kind, name) not in new:
            name = f"{names[plain]}{space}{rest}" if plain in names else names.get(name, name)
        now = new.get((kind, name), {})
        own = made[kind, name] = {}
        for quantity, value in entry.items():
            words = " ".join(names.get(word, word) for word in quantity.split(" "))
            is_fixed = kind in ("frame", "joint") or quantity in now or words not in now
            place = quantity if is_fixed else words
            own[place] = _value(kind, place, value, names, kinds, now.get(place))
    return made


def _value(kind: str, quantity: str, value: Any, names: Names, kinds: Sequence[str], now: Any) -> Any:
    if isinstance(value, frozenset):
        return frozenset(" - ".join(sorted(names.get(word, word) for word in one.split(" - "))) for one in value)
    if isinstance(value, tuple) and value and all(isinstance(one, str) for one in value):
        other = tuple(names.get(one, one) for one in value)
        return other if other == now else value
    if not isinstance(value, str):
        return value
    if "link" in kinds and quantity in ("parent", "child") and kind in ("frame", "joint"):
        return names.get(value, value)
    return now if isinstance(now, str) and names.get(value) == now else value


def renamed_robot(robot: Robot, links: Names, joints: Names) -> Robot:
    """Rename the links and joints of a robot, but not the references in its sections."""
    return replace(
        robot,
        links=tuple(replace(link, name=links.get(link.name, link.name)) for link in robot.links),
        joints=tuple(
            replace(
                joint,
                name=joints.get(joint.name, joint.name),
                parent=links.get(joint.parent, joint.parent),
                child=links.get(joint.child, joint.child),
                mimic=joint.mimic and replace(joint.mimic, joint=joints.get(joint.mimic.joint, joint.mimic.joint)),
            )
            for joint in robot.joints
        ),
    )


def prefix_of(a: Robot, b: Robot) -> str:
    """Return the prefix that most link names in ``b`` have, compared with ``a``, or an empty text."""
    mine, theirs = [link.name for link in a.links], [link.name for link in b.links]
    ends = [other[: -len(name)] for name in mine for other in theirs if other.endswith(name) and other != name]
    best = max(sorted(set(ends)), key=ends.count, default="")
    count = ends.count(best)
    is_most = count > max(1, len(set(mine) & set(theirs))) and count >= _MOST * min(len(mine), len(theirs))
    return best if is_most else ""


def without_prefix(names: Iterable[str], prefix: str) -> dict[str, str]:
    """Map the names with a prefix to the names without it, except if that name is already used."""
    every = set(names)
    cut = {name: name.removeprefix(prefix) for name in every if name.startswith(prefix) and name != prefix}
    return {name: short for name, short in cut.items() if short not in every}
