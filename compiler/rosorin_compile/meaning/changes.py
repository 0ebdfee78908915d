"""Differences of meaning: what the committed and the compiled artifacts say differently, each thing once."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from ..formats import Fact, Value
from ..model import Robot, Vector
from .causes import causes
from .entities import Entities, Entry, Pair
from .solids import Delta, Solid, delta
from .tolerance import NOISE, Turn, joined, same_angles, same_turn, same_value, wrapped
from .view import ANGLES, AXES
from .wording import Change, cells_change, contacts_change, shapes_change, value_change

# The order of the lines about one thing.
_QUANTITIES = (
    *("", "parent", "publisher", "topic", "type", "child", "origin", "roll", "pitch", "yaw", "axis", "lower", "upper"),
    *("effort", "velocity", "damping", "friction", "armature", "mimic", "kp", "kv", "ctrl", "cells", "cell", "base"),
    *("mass", "centre", "inertia", "box", "collision", "visual", "site", "contact"),
)
_CONTACT = "contact with "
# What an artifact repeats in other words needs no second line.
_REPEATED = {"ctrl lower": "lower", "ctrl upper": "upper"}


def changes(robot: Robot, pairs: Sequence[Pair], whole: Pair | None) -> list[Change]:
    """Return what differs, sorted: by link from the root on, then servos, poses and the rest.

    ``pairs`` are the artifacts whose texts differ, in the order in which they are to be listed; ``whole`` is the one
    that carries every frame with its own shapes, None if there is none.
    """
    entities = Entities(robot, pairs)
    entries: dict[Fact, list[Entry]] = dict(entities.types)
    solids: list[tuple[Pair, str, str]] = []
    for pair in pairs:
        for fact, entry in _plain(pair):
            if not entities.hides(pair, fact):
                entries.setdefault(fact, []).append(entry)
        for link, purpose in sorted(pair.old.shapes.keys() | pair.new.shapes.keys()):
            if entities.hides(pair, Fact("link", link, purpose)):
                continue
            boxes = dict(_single_box(pair, link, purpose))
            for fact, entry in boxes.items():
                entries.setdefault(fact, []).append(entry)
            if not boxes and delta(*_solids(pair, link, purpose)) != Delta((), ()):
                solids.append((pair, link, purpose))
    found = entities.changes()
    for fact, group in entries.items():
        found += _value_changes(robot, fact, group)
    found += [*_turn_changes(robot, pairs, entities), *_cell_changes(pairs), *_contact_changes(pairs, entities)]
    found = _shape_changes(robot, pairs, whole, solids, found)
    place = {link.name: index for index, link in enumerate(robot.walk())}
    return sorted((_arranged(change, pairs) for change in found), key=lambda change: _order(robot, place, change))


def _plain(pair: Pair) -> Iterator[tuple[Fact, Entry]]:
    old, new = pair.old.plain, pair.new.plain
    for fact in dict.fromkeys([*old, *new]):
        before, after = old.get(fact), new.get(fact)
        if same_value(before, after) or fact.quantity.startswith(_CONTACT):
            continue
        twin = fact._replace(quantity=_REPEATED.get(fact.quantity, ""))
        if twin.quantity and before in (None, old.get(twin)) and after in (None, new.get(twin)):
            continue
        yield fact, Entry(pair.output, before, after)
    for frame in sorted(pair.old.turns.keys() ^ pair.new.turns.keys()):
        for index, angle in enumerate(ANGLES):
            values = [turns.get(frame) for turns in (pair.old.turns, pair.new.turns)]
            said = [turn and Value(turn.rpy[index], "rad", turn.tolerance[index]) for turn in values]
            yield Fact("frame", frame, angle), Entry(pair.output, said[0], said[1])


def _solids(pair: Pair, link: str, purpose: str) -> tuple[tuple[Solid, ...], tuple[Solid, ...]]:
    return pair.old.shapes.get((link, purpose), ()), pair.new.shapes.get((link, purpose), ())


def _single_box(pair: Pair, link: str, purpose: str) -> Iterator[tuple[Fact, Entry]]:
    """Yield what became of the corners of a box that is the only shape of a link, before and after."""
    old, new = _solids(pair, link, purpose)
    if len(old) != 1 or len(new) != 1 or old[0].words != new[0].words:
        return
    before, after = old[0].box, new[0].box
    if before is None or after is None:
        return
    tolerance, name = (
        2 * max(old[0].tolerance, new[0].tolerance) + NOISE,
        "box" if purpose == "collision" else f"{purpose} box",
    )
    for end, first, second in (("min", before.lower, after.lower), ("max", before.upper, after.upper)):
        for axis, a, b in zip(AXES, first, second, strict=True):
            entry = Entry(pair.output, Value(a, "m", tolerance), Value(b, "m", tolerance))
            if not same_value(entry.old, entry.new):
                yield Fact("link", link, f"{name} {end} {axis}"), entry


def _value_changes(robot: Robot, fact: Fact, group: Sequence[Entry]) -> Iterator[Change]:
    """Yield a change for each set of artifacts that mean the same by it, in the numbers of the most precise one."""
    clusters: list[list[Entry]] = []
    for entry in sorted(group, key=_tolerance):
        for cluster in clusters:
            if same_value(cluster[0].old, entry.old, NOISE) and same_value(cluster[0].new, entry.new, NOISE):
                cluster.append(entry)
                break
        else:
            clusters.append([entry])
    for cluster in clusters:
        text, remark = value_change(robot, fact, cluster[0].old, cluster[0].new)
        yield Change(*fact, text, remark, tuple(entry.output for entry in cluster))


def _tolerance(entry: Entry) -> float:
    return max(value.tolerance for value in (entry.old, entry.new) if value is not None)


def _turn_changes(robot: Robot, pairs: Sequence[Pair], entities: Entities) -> Iterator[Change]:
    """Yield a change for each angle of each rotation that differs."""
    found: dict[str, list[tuple[Turn, Turn, list[str]]]] = {}
    for pair in pairs:
        for frame in sorted(pair.old.turns.keys() & pair.new.turns.keys()):
            old, new = pair.old.turns[frame], pair.new.turns[frame]
            if same_angles(old, new) or entities.hides(pair, Fact("frame", frame, "roll")):
                continue
            clusters = found.setdefault(frame, [])
            same = [cluster for cluster in clusters if same_turn(cluster[0], old) and same_turn(cluster[1], new)]
            if not same:
                clusters.append((old, new, [pair.output]))
                continue
            best, at = min((same[0], (old, new, [])), key=lambda c: sum(c[0].tolerance) + sum(c[1].tolerance)), same[0]
            clusters[clusters.index(at)] = (best[0], best[1], [*at[2], pair.output])
    for frame, clusters in found.items():
        for old, new, outputs in clusters:
            yield from _angle_changes(robot, frame, old, new, tuple(outputs))


def _angle_changes(robot: Robot, frame: str, old: Turn, new: Turn, outputs: tuple[str, ...]) -> Iterator[Change]:
    before, after = _written(robot, frame, old, new)
    allowed = [joined(s, t) + NOISE for s, t in zip(old.tolerance, new.tolerance, strict=True)]
    angles = [index for index in range(3) if abs(after[index] - before[index]) > allowed[index]]
    for index in angles or range(3):
        fact = Fact("frame", frame, ANGLES[index])
        text, remark = value_change(robot, fact, Value(before[index], "rad"), Value(after[index], "rad"))
        yield Change(*fact, text, remark, outputs)


def _written(robot: Robot, frame: str, old: Turn, new: Turn) -> tuple[Vector, Vector]:
    """Return two rotations as angles (rad): the new one as the description writes it, the old one as near to it.

    Many triples mean one rotation; the user knows the one that he wrote.
    """
    after = new.rpy
    if frame in robot.joint_to and same_turn(Turn(robot.joint_to[frame].origin.rpy, new.tolerance), new):
        after = robot.joint_to[frame].origin.rpy
    roll, pitch, yaw = old.rpy
    forms = [(roll, pitch, yaw), (roll + math.pi, math.pi - pitch, yaw + math.pi)]
    near = [[b + wrapped(a - b) for a, b in zip(form, after, strict=True)] for form in forms]
    best = min(near, key=lambda form: sum(abs(a - b) for a, b in zip(form, after, strict=True)))
    return (best[0], best[1], best[2]), after


def _cell_changes(pairs: Sequence[Pair]) -> Iterator[Change]:
    found: dict[tuple[str, str], list[str]] = {}
    for pair in pairs:
        for frame in sorted(pair.old.heights.keys() & pair.new.heights.keys()):
            text = cells_change(pair.old.heights[frame], pair.new.heights[frame])
            if text:
                found.setdefault((frame, text), []).append(pair.output)
    for (frame, text), outputs in found.items():
        yield Change("height map", frame, "cells", text, "", tuple(outputs))


def _contact_changes(pairs: Sequence[Pair], entities: Entities) -> Iterator[Change]:
    """Yield one change for all pairs of links that are excluded from contact now, or no more."""
    for pair in pairs:
        facts = [(old, new) for old, new in ((pair.old.plain, pair.new.plain), (pair.new.plain, pair.old.plain))]
        removed, new = (
            [
                f"{fact.name} {fact.quantity.removeprefix(_CONTACT)}"
                for fact in here
                if fact.quantity.startswith(_CONTACT) and fact not in there and not entities.hides(pair, fact)
            ]
            for here, there in facts
        )
        if removed or new:
            yield Change("contact", "contact", "", contacts_change(new, removed), "", (pair.output,))


def _shape_changes(
    robot: Robot, pairs: Sequence[Pair], whole: Pair | None, solids: list[tuple[Pair, str, str]], found: list[Change]
) -> list[Change]:
    """Return the changes found so far and those of shapes, the ones that follow from another under that other."""
    found, own = list(found), []
    # A link that others carry the shapes of comes first: what it says may explain the shapes of the others.
    for pair, link, purpose in solids:
        reasons = causes(robot, pair, (link, purpose), pairs, None, found)
        if not reasons and (whole is None or pair.output == whole.output):
            _add(found, _shape_change(pair, link, purpose))
        elif not reasons:
            own.append((pair, link, purpose))
        _attach(found, reasons, pair, link)
    for pair, link, purpose in own:
        reasons = causes(robot, pair, (link, purpose), pairs, whole, found)
        if reasons:
            _attach(found, reasons, pair, link)
        else:
            _add(found, _shape_change(pair, link, purpose))
    return found


def _shape_change(pair: Pair, link: str, purpose: str) -> Change:
    old, new = _solids(pair, link, purpose)
    text = shapes_change(link, purpose, (len(old), len(new)), delta(old, new))
    return Change("link", link, f"{purpose} shapes", text, "", (pair.output,))


def _add(found: list[Change], change: Change) -> None:
    """Add a change; one that another artifact said in the same words is listed with it."""
    for at, other in enumerate(found):
        if other[:5] == change[:5]:
            found[at] = other._replace(artifacts=(*other.artifacts, *change.artifacts))
            return
    found.append(change)


def _attach(found: list[Change], reasons: Sequence[int], pair: Pair, link: str) -> None:
    for at in reasons:
        change = found[at]
        own = (change.kind, change.name) == ("link", link)  # the very shapes, as another artifact has them
        outputs, links = (*change.artifacts, pair.output), (*change.therefore, *(() if own else (link,)))
        found[at] = change._replace(artifacts=tuple(dict.fromkeys(outputs)), therefore=tuple(dict.fromkeys(links)))


def _arranged(change: Change, pairs: Sequence[Pair]) -> Change:
    """Return a change with its artifacts in the order of the pairs."""
    return change._replace(artifacts=tuple(pair.output for pair in pairs if pair.output in change.artifacts))


def _order(robot: Robot, place: Mapping[str, int], change: Change) -> tuple[object, ...]:
    """Return the key to sort changes by: the link from the root on, then what it is about."""
    link = robot.joint[change.name].child if change.kind == "joint" and change.name in robot.joint else change.name
    kinds = {"frame": 0, "joint": 0, "link": 0, "inertial": 0, "height map": 0, "servo": 1, "pose": 2}
    words = change.quantity.split(" ")
    quantity = _QUANTITIES.index(words[0]) if words[0] in _QUANTITIES else len(_QUANTITIES)
    where = place.get(link.split(" ")[0], len(place))
    return (kinds.get(change.kind, 3), where, link, quantity, change.quantity, change.text, change.artifacts)
