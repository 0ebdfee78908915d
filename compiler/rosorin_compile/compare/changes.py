"""Differences of meaning: what the committed and the compiled artifacts say differently, each thing once."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.formats import Fact, Value
from rosorin_compile.formats.facts import AXES, COLLISION, INERTIA, Solid
from rosorin_compile.formats.format import ANGLES, About
from rosorin_compile.model import Pose, Robot, Vector

from .causes import LOOK, causes
from .entities import Change, Entities, Entry, Numbers, Pair
from .shape_wording import NO_WORD, shapes_change
from .solids_old import CAPSULE, Delta, as_cylinder, delta, same_set
from .tolerance import NOISE, Turn, joined, same_angles, same_turn, same_value, wrapped
from .view import View
from .wording import (
    Least,
    Sentence,
    axis_change,
    cells_change,
    centre_change,
    contacts_change,
    inertia_change,
    mimic_change,
    mimic_text,
    placed,
    value_change,
)

# The order of the lines about one thing.
_QUANTITIES = (
    *("", "parent", "publisher", "topic", "type", "child", "origin", "roll", "pitch", "yaw", "axis", "lower", "upper"),
    *("effort", "velocity", "damping", "friction", "armature", "mimic", "kp", "kv", "ctrl", "cells", "cell", "base"),
    *("mass", "centre", "inertia", "collision", "visual", "site", "contact"),
)
# What is said of two links, and what a change of it is called.
_BETWEEN = {
    "contact with ": "excluded contacts",
    "pairs with ": "contact pairs",
    "rubs with ": "contact pairs with friction",
    "disabled collision with ": "disabled collisions",
    "checked collision with ": "checked collisions",
}
# Numbers that say one thing together.
_GROUPS: Mapping[str, Sequence[str]] = {
    "origin": AXES,
    "axis": AXES,
    "centre of mass": AXES,
    "inertia": INERTIA,
    "mimic": ("joint", "multiplier", "offset"),
}
_NOTHING, _UPRIGHT = Numbers({}), Turn((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
# What an artifact repeats in other words needs no second line.
_REPEATED = {"ctrl lower": "lower", "ctrl upper": "upper"}


class _Shapes(NamedTuple):
    """What became of the numbers of shapes in one artifact, and where among the changes that is told.

    ``told`` are the link, the purpose, and how many shapes there were and are.
    """

    told: tuple[str, str, tuple[int, int]]
    step: Delta
    places: range


def changes(robot: Robot, pairs: Sequence[Pair], whole: Pair | None) -> list[Change]:
    """Return what differs, sorted: by link from the root on, then servos, poses and the rest.

    ``pairs`` are the artifacts whose texts differ, in the order in which they are to be listed; ``whole`` is the one
    that carries every frame with its own shapes, None if there is none.
    """
    entities = Entities(robot, pairs)
    entries: dict[Fact, list[Entry]] = dict(entities.types)
    solids: list[tuple[Pair, str, str]] = []
    for pair in pairs:
        for fact, entry in _entries(pair):
            if not entities.hides(pair, fact):
                entries.setdefault(fact, []).append(entry)
        for link, purpose in sorted(pair.old.shapes.keys() | pair.new.shapes.keys()):
            if entities.hides(pair, Fact("link", link, purpose)):
                continue
            if delta(*_solids(pair, link, purpose)) != Delta((), ()):
                solids.append((pair, link, purpose))
    found = entities.changes()
    for fact, group in entries.items():
        found += _value_changes(robot, fact, group)
    found += [*_cell_changes(pairs), *_contact_changes(pairs, entities)]
    found = _shape_changes(robot, pairs, whole, solids, found)
    place = {link.name: index for index, link in enumerate(robot.walk())}
    return sorted((_arranged(change, pairs) for change in found), key=lambda change: _order(robot, place, change))


def _numbers(view: View, thing: Fact) -> Numbers:
    """Return what an artifact says of one thing, such as the three coordinates of an axis."""
    parts = _GROUPS.get(thing.quantity, ("",))
    values = {part: view.plain.get(thing._replace(quantity=f"{thing.quantity} {part}".rstrip())) for part in parts}
    turn = view.turns.get(thing.name) if thing[::2] == ("frame", "origin") else None
    return Numbers({part: value for part, value in values.items() if value is not None}, turn)


def _thing(fact: Fact) -> Fact:
    """Return what a fact is a part of: the axis of a joint, for one of its coordinates."""
    group, _, part = fact.quantity.rpartition(" ")
    return fact._replace(quantity=group) if part in _GROUPS.get(group, ()) else fact


def _things(pair: Pair) -> Iterator[Fact]:
    """Yield the things that one artifact says differently, in its order."""
    old, new = pair.old, pair.new
    facts = (fact for fact in {**old.plain, **new.plain} if not same_value(old.plain.get(fact), new.plain.get(fact)))
    turned = (
        frame for frame in {**old.turns, **new.turns} if not _same_turn(old.turns.get(frame), new.turns.get(frame))
    )
    yield from dict.fromkeys([*map(_thing, facts), *(Fact("frame", frame, "origin") for frame in turned)])


def _entries(pair: Pair) -> Iterator[tuple[Fact, Entry]]:
    for thing in _things(pair):
        before, after = _numbers(pair.old, thing), _numbers(pair.new, thing)
        if thing.quantity.startswith(tuple(_BETWEEN)):
            continue
        if thing.quantity in _REPEATED:
            twin = thing._replace(quantity=_REPEATED[thing.quantity])
            pairs = ((before, _numbers(pair.old, twin)), (after, _numbers(pair.new, twin)))
            if all(own in (_NOTHING, other) for own, other in pairs):
                continue
        yield thing, Entry(pair, before, after)


def _same(one: Numbers, other: Numbers, noise: float = 0.0) -> bool:
    """Say whether two artifacts mean the same; of one writer without ``noise``."""
    parts = one.parts.keys() | other.parts.keys()
    if not all(same_value(one.parts.get(part), other.parts.get(part), noise) for part in parts):
        return False
    return same_turn(one.turn, other.turn) if noise else _same_turn(one.turn, other.turn)


def _same_turn(one: Turn | None, other: Turn | None) -> bool:
    """Say whether two rotations of one writer are one."""
    return one is other if one is None or other is None else same_angles(one, other)


def _solids(pair: Pair, link: str, purpose: str) -> tuple[tuple[Solid, ...], tuple[Solid, ...]]:
    return pair.old.shapes.get((link, purpose), ()), pair.new.shapes.get((link, purpose), ())


def _value_changes(robot: Robot, fact: Fact, group: Sequence[Entry]) -> Iterator[Change]:
    """Yield the changes of each set of artifacts that mean the same by it, in the numbers of the most precise one."""
    clusters: list[list[Entry]] = []
    for entry in sorted(group, key=_tolerance):
        for cluster in clusters:
            if _same(cluster[0].old, entry.old, NOISE) and _same(cluster[0].new, entry.new, NOISE):
                cluster.append(entry)
                break
        else:
            clusters.append([entry])
    for cluster in clusters:
        outputs = tuple(entry.pair.output for entry in cluster)
        for quantity, sentence in _sentences(robot, fact, cluster[0]):
            yield Change(fact.kind, fact.name, quantity, *sentence, outputs)


def _tolerance(entry: Entry) -> float:
    sides = (entry.old, entry.new)
    turns = [sum(side.turn.tolerance) for side in sides if side.turn is not None]
    return max([*turns, *(value.tolerance for side in sides for value in side.parts.values())], default=0.0)


def _sentences(robot: Robot, fact: Fact, entry: Entry) -> Iterator[tuple[str, Sentence]]:
    """Yield the sentences on what became of one thing, each with its quantity; one for numbers that belong together."""
    old, new = ({part: value.value for part, value in side.parts.items()} for side in (entry.old, entry.new))
    whole = len(old) == len(new) == len(_GROUPS.get(fact.quantity, ())) > 0
    if whole and fact.quantity == "origin" and entry.old.turn is not None and entry.new.turn is not None:
        yield fact.quantity, _placed(robot, fact.name, entry)
    elif fact.quantity == "mimic" and not same_value(entry.old.parts.get("joint"), entry.new.parts.get("joint")):
        yield fact.quantity, mimic_change(fact.name, _leader(old), _leader(new))
    elif whole and fact.quantity in ("axis", "centre of mass"):
        vectors = _vector(old), _vector(new)
        if fact.quantity == "axis":
            yield fact.quantity, axis_change(fact.name, *vectors)
        else:
            yield fact.quantity, centre_change(fact.name, *vectors, _least(entry)[0])
    elif whole and fact.quantity == "inertia":
        changed = [not same_value(entry.old.parts[name], entry.new.parts[name]) for name in INERTIA]
        before, after = ([float(numbers[name]) for name in INERTIA] for numbers in (old, new))
        yield fact.quantity, inertia_change(fact.name, before, after, changed)
    else:
        for part in dict.fromkeys([*old, *new]):
            values = entry.old.parts.get(part), entry.new.parts.get(part)
            if not same_value(*values):
                one = fact._replace(quantity=f"{fact.quantity} {part}".rstrip())
                yield one.quantity, value_change(one.about, *values)
        if entry.old.turn is not entry.new.turn and None in (entry.old.turn, entry.new.turn):
            for index, angle in enumerate(ANGLES):
                angles = [turn and Value(turn.rpy[index], "rad") for turn in (entry.old.turn, entry.new.turn)]
                yield angle, value_change(About(fact.name, angle), *angles)


def _vector(numbers: Mapping[str, float | str]) -> Vector:
    x, y, z = (float(numbers[axis]) for axis in AXES)
    return (x, y, z)


def _leader(values: Mapping[str, float | str]) -> str:
    """Return what a joint follows in words."""
    multiplier, offset = (float(values.get(part, default)) for part, default in (("multiplier", 1.0), ("offset", 0.0)))
    return mimic_text(str(values.get("joint", "")), multiplier, offset)


def _placed(robot: Robot, frame: str, entry: Entry) -> Sentence:
    """Return what became of where a frame sits."""
    old, new = entry.old.turn or _UPRIGHT, entry.new.turn or _UPRIGHT
    values = [_vector({part: value.value for part, value in side.parts.items()}) for side in (entry.old, entry.new)]
    stays = all(same_value(entry.old.parts[axis], entry.new.parts[axis]) for axis in AXES)
    distance = 0.0 if stays else math.dist(*values)
    before, after = _written(robot, frame, old, new)
    poses = Pose(values[0], before), Pose(values[1], after)
    angle = 0.0 if same_angles(old, new) else poses[0].transform().angle_to(poses[1].transform())
    parents = entry.pair.old.parent(frame), entry.pair.new.parent(frame)
    return placed(frame, parents, poses, (distance, angle), least=_least(entry))


def _least(entry: Entry) -> Least:
    """Return the step of a length (m) and of an angle (rad) that is none, as well as an artifact prints them."""
    old, new = entry.old, entry.new
    lengths = (joined(old.parts[axis].tolerance, new.parts[axis].tolerance) for axis in AXES)
    turns = zip((old.turn or _UPRIGHT).tolerance, (new.turn or _UPRIGHT).tolerance, strict=True)
    return NOISE + max(lengths), NOISE + max(joined(*turn) for turn in turns)


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
    found: dict[tuple[str, Sentence], list[str]] = {}
    for pair in pairs:
        for frame in sorted(pair.old.heights.keys() & pair.new.heights.keys()):
            old, new = pair.old.heights[frame], pair.new.heights[frame]
            steps = [abs(new[cell] - old[cell]) for cell in sorted(old.keys() & new.keys()) if new[cell] != old[cell]]
            if steps or _grid(old) != _grid(new):
                found.setdefault((frame, cells_change(frame, steps, (_grid(old), _grid(new)))), []).append(pair.output)
    for (frame, sentence), outputs in found.items():
        yield Change("height map", frame, "cells", *sentence, tuple(outputs))


def _grid(cells: Mapping[tuple[int, int], float]) -> str:
    rows, columns = (1 + max((cell[axis] for cell in cells), default=-1) for axis in (0, 1))
    return f"{rows} x {columns}"


def _contact_changes(pairs: Sequence[Pair], entities: Entities) -> Iterator[Change]:
    """Yield one change for all pairs of links that are excluded from contact now, or no more, and one for pairs."""
    for pair in pairs:
        facts = [(old, new) for old, new in ((pair.old.plain, pair.new.plain), (pair.new.plain, pair.old.plain))]
        for begin, title in _BETWEEN.items():
            removed, new = (
                [
                    f"{fact.name} {fact.quantity.removeprefix(begin)}"
                    for fact in here
                    if fact.quantity.startswith(begin) and fact not in there and not entities.hides(pair, fact)
                ]
                for here, there in facts
            )
            if removed or new:
                yield Change("contact", "contact", "", *contacts_change(new, removed, title), (pair.output,))


def _shape_changes(
    robot: Robot, pairs: Sequence[Pair], whole: Pair | None, solids: list[tuple[Pair, str, str]], found: list[Change]
) -> list[Change]:
    """Return the changes found so far and those of shapes, the ones that follow from another under that other."""
    found, own = list(found), []
    shapes: list[_Shapes] = []
    solids = [one for one in solids if not _is_as_collision(*one)]
    # A link that others carry the shapes of comes first: what it says may explain the shapes of the others.
    for pair, link, purpose in solids:
        reasons = causes(robot, pair, (link, purpose), pairs, None, found)
        if not reasons and (whole is None or pair.output == whole.output):
            _add(found, shapes, pair, link, purpose)
        elif not reasons:
            own.append((pair, link, purpose))
        _explained(found, reasons, pair, (link, purpose))
    for pair, link, purpose in own:
        reasons = causes(robot, pair, (link, purpose), pairs, whole, found)
        if reasons:
            _explained(found, reasons, pair, (link, purpose))
        else:
            _add(found, shapes, pair, link, purpose)
    return found


def _is_as_collision(pair: Pair, link: str, purpose: str) -> bool:
    """Say whether the visuals of a link were and are its collision shapes, which differ: those are told.

    Not where they look otherwise, too.
    """
    seen, solid = _solids(pair, link, purpose), _solids(pair, link, COLLISION)
    if purpose == COLLISION or not all(solid) or delta(*solid) == Delta((), ()) or _repainted(delta(*seen)):
        return False
    return all(same_set(_bare(one), _bare(other)) for one, other in zip(seen, solid, strict=True))


def _repainted(step: Delta) -> bool:
    """Say whether shapes look otherwise, besides their numbers."""
    old, new = ({_painted(solid) for solid in solids} for solids in step)
    return bool(old and new) and old != new


def _painted(solid: Solid) -> tuple[str, ...]:
    return tuple(word for word in solid.words if word.split(" ")[0] in LOOK)


def _add(found: list[Change], shapes: list[_Shapes], pair: Pair, link: str, purpose: str) -> None:
    """Add the changes of the shapes of a link; those that mean the same in another artifact are listed with them."""
    old, new = _solids(pair, link, purpose)
    counts = len(old), len(new)
    numbers, _ = shapes_change(link, purpose, counts, delta(old, new))
    _add_words(found, pair, link, purpose)
    made = [Change("link", link, f"{purpose} shapes", *sentence, (pair.output,)) for sentence in numbers]
    step = delta(_plain(old), _plain(new))
    for told, other, places in shapes:
        same = told == (link, purpose, counts) and len(places) == len(numbers)
        if same and all(same_set(*both) for both in zip(step, other, strict=True)):
            for at, change in zip(places, made, strict=True):
                outputs = (*found[at].artifacts, pair.output)
                # A capsule is a cylinder in a URDF.
                clearer = change if CAPSULE in change.row.quantity else found[at]
                found[at] = clearer._replace(artifacts=outputs)
            return
    shapes.append(_Shapes((link, purpose, counts), step, range(len(found), len(found) + len(numbers))))
    found += made


def _add_words(found: list[Change], pair: Pair, link: str, purpose: str) -> None:
    """Add what is said otherwise of the shapes of a link beside their numbers."""
    old, new = _solids(pair, link, purpose)
    for sentence in shapes_change(link, purpose, (len(old), len(new)), delta(old, new)).words:
        change = Change("link", link, f"{purpose} shapes", *sentence, (pair.output,))
        twin = next((at for at, other in enumerate(found) if _same_words(other, change)), None)
        if twin is None:
            found.append(change)
        else:
            found[twin] = found[twin]._replace(artifacts=(*found[twin].artifacts, pair.output))


def _same_words(one: Change, other: Change) -> bool:
    """Say whether two artifacts tell the same of a shape, one of which may have had no word before."""
    same = one[:3] == other[:3] and one.row.after == other.row.after
    return same and (one.row.before == other.row.before or NO_WORD in (one.row.before, other.row.before))


def _plain(solids: Sequence[Solid]) -> list[Solid]:
    """Return solids without words, and capsules as a URDF 1.0 has them."""
    return [as_cylinder(solid) for solid in _bare(solids)]


def _bare(solids: Sequence[Solid]) -> list[Solid]:
    """Return solids without words, which are others in each artifact."""
    return [solid._replace(words=()) for solid in solids]


def _explained(found: list[Change], reasons: Sequence[int], pair: Pair, thing: tuple[str, str]) -> None:
    """List an artifact with what explains its shapes of a link; no number explains what else is said of them."""
    link, purpose = thing
    _attach(found, reasons, pair, link)
    if reasons and all(found[at][:3] == ("link", link, f"{purpose} shapes") for at in reasons):
        _add_words(found, pair, link, purpose)


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
