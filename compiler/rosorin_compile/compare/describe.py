"""Describe the differences between two robots or artifacts, in one sentence per value and with units."""

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from rosorin_compile.model import Pose, Robot, Transform
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.model.joint import MOVING_TYPES, SEVERAL_COORDINATES
from rosorin_compile.source.numbers import amount
from rosorin_compile.source.wording import count_of

from . import sentences
from .precision import NOISE, ROOT_THREE, TURNS, Precisions, exact, join_errors
from .solids import SIZES, Solid, largest_step, match, same_colour, turned_by
from .walk import Address, Difference, Leaves, Shapes, known_inertia, same_turn

MOVING = (*MOVING_TYPES, *SEVERAL_COORDINATES)
# Units for revolute and for prismatic joints, by the last words of a quantity; the first match is used.
_POSITION = ("rad", "m")
_UNITS = {
    **dict.fromkeys(("damping", "kv", "k velocity"), ("N*m*s/rad", "N*s/m")),
    **dict.fromkeys(("friction", "effort"), ("N*m", "N")),
    **dict.fromkeys(("stiffness", "kp"), ("N*m/rad", "N/m")),
    "armature": ("kg*m^2", "kg"),
    "k position": ("1/s", "1/s"),
    "velocity": ("rad/s", "m/s"),
    **dict.fromkeys(("lower", "upper", "offset", "rising", "falling", "spring reference"), _POSITION),
    **dict.fromkeys(("reference position", "soft lower limit", "soft upper limit"), _POSITION),
}
_OTHER_UNITS = {"rad per pulse": "rad", "radius": "m", "mass": "kg"}


class Describer(NamedTuple):
    """Describes the differences between the old and the new values of a robot."""

    robot: Robot
    sides: tuple[Leaves, Leaves]  # all old values, and all new values
    precisions: Precisions = (exact, exact)  # precision of the old and of the new numbers
    tolerance: float = NOISE

    def describe(self, differences: Sequence[Difference]) -> Iterator[tuple[Difference, str]]:
        """Yield each difference with a sentence about it; some sentences describe several related differences."""
        quantities = {one.address for one in differences}
        for one in differences:
            kind, name, quantity = one.address
            if quantity in ("mimic multiplier", "mimic offset") and Address(kind, name, "mimic joint") in quantities:
                continue
            if quantity in ("centre of mass", "inertia") and None in (one.old, one.new):
                continue  # the sentence about a new or removed mass is sufficient
            if isinstance(one.old, Shapes) or isinstance(one.new, Shapes):
                for change in shapes_change(name, quantity, *solids_left(one, self.precisions)):
                    yield one, change.text
            else:
                yield one, self.sentence(one)

    def sentence(self, one: Difference) -> str:
        """Describe a difference in one sentence. Differences in shapes are described by ``shapes_change``."""
        (kind, name, quantity), old, new = one
        if isinstance(old, frozenset) or isinstance(new, frozenset):
            return sentences.set_change(f"{kind} {quantity}".strip(), old or (), new or ())
        if not quantity:
            word = sentences.NEW if old is None else sentences.REMOVED
            if kind in ("frame", "link"):
                return describe_attachment(self.robot, name, word, [self.sides[word == sentences.NEW]])
            what, called = (f"{kind} of", name) if kind == "height map" else (kind, "" if kind == name else name)
            return sentences.existence(word, what, called)
        if quantity == "mimic joint":
            return f"{name} mimics {self._mimic(name, 0)} -> {self._mimic(name, 1)}"
        if old is not None and new is not None:
            if isinstance(old, Pose) and isinstance(new, Pose) and kind == "frame":
                return self._placed(name, old, new)
            if quantity == "axis":
                return sentences.axis_change(name, old, new)
            if quantity == "centre of mass":
                distance, least = math.dist(old, new), self._known("xyz", old, new) + self.tolerance
                steps = sentences.coordinates(Pose(old), Pose(new), (distance, 0.0), (least, 0.0))
                return f"{name} centre of mass moved {amount(distance, 'm')}: {steps.removeprefix('origin ')}"
            if quantity == "inertia":
                least = known_inertia(old, new, self.precisions, self.tolerance)
                return sentences.inertia_change(name, old, new, least)
            if quantity == "heights":
                return sentences.cells_change(name, old, new, self.tolerance)
        word = "colour" if quantity == "rgba" else quantity
        subject = f"pose {name}: {word}" if kind == "pose" else f"{kind} {name} {word}"
        if kind == "frame" and quantity in ("publisher", "topic"):
            subject = f"{name}: {'published by' if quantity == 'publisher' else quantity}"
        elif kind in ("frame", "joint", "link") or kind == name:
            subject = f"{name} {quantity}"
        elif kind == "height map":
            subject = f"{name} height map {quantity}"
        return sentences.value_change(subject, old, new, self._unit(one.address, old if new is None else new))

    def _known(self, key: str, old: Sequence[float], new: Sequence[float]) -> float:
        return join_errors(self.precisions[0](key, *old), self.precisions[1](key, *new))

    def _unit(self, address: Address, value: Any) -> str:
        kind, name, quantity = address
        joint = self.robot.joint.get(name if kind == "joint" else quantity)
        if not sentences.is_number(value):
            return ""
        if kind == "joint":
            units = next((_UNITS[end] for end in _UNITS if f" {quantity}".endswith(f" {end}")), ("", ""))
            return units[joint is not None and joint.type == "prismatic"]
        if kind == "pose":
            return joint.unit if joint is not None else ""
        return _OTHER_UNITS.get(quantity, "m" if kind == "height map" else "")

    def _mimic(self, joint: str, side: int) -> str:
        of = self.sides[side].get(("joint", joint), {})
        leader, factor, offset = of.get("mimic joint"), of.get("mimic multiplier", 1.0), of.get("mimic offset", 0.0)
        return f"{leader} * {sentences.number(factor)} + {sentences.number(offset)}" if leader else "nothing"

    def _placed(self, frame: str, old: Pose, new: Pose) -> str:
        turned = not same_turn(old.rpy, new.rpy, self.precisions, self.tolerance)
        least = self.tolerance + ROOT_THREE * self._known("xyz", old.xyz, new.xyz)
        moved = any(abs(a - b) > least for a, b in zip(old.xyz, new.xyz, strict=True))
        distance = math.dist(old.xyz, new.xyz) if moved or not turned else 0.0
        angle = old.transform().angle_to(new.transform()) if turned else 0.0
        before, after = (str(side.get(("frame", frame), {}).get("parent", "")) for side in self.sides)
        small = max(NOISE, least / ROOT_THREE), self.tolerance / TURNS + self._known("rpy", old.rpy, new.rpy)
        return sentences.describe_move(frame, (before, after), (old, new), (distance, angle), small)


def describe_attachment(robot: Robot, name: str, word: str, sides: Sequence[Leaves]) -> str:
    """Describe a link or frame that is NEW or REMOVED (``word``), with its joint, parent and publisher."""
    frames = [side.get(("frame", name), {}) for side in sides]
    joints = [(side["joint", joint].get("type", ""), joint) for side in sides if (joint := joint_of(side, name))]
    kind, joint = next((one for one in joints if one[0] in MOVING), ("", ""))
    parent = next(filter(None, (frame.get("parent") for frame in frames)), "")
    nodes = (of.get("publisher", "") for of in frames if "topic" in of or of.get("publisher", "").startswith("nobody"))
    publisher = next(filter(None, nodes), "")
    if word == sentences.NEW and name in robot.joint_to:
        published = robot.joint_to[name].publisher
        publisher = published.name if published.publishes else "nobody"
    how = [f"{kind} on {parent}".strip() if parent else "the root", joint]
    how += [f"published by {publisher.split(':')[0]}"] if publisher else []
    is_solid = any(key in side.get(("link", name), {}) for side in sides for key in ("mass", "collision", "visual"))
    return sentences.existence(word, "link" if is_solid else "frame", name, how)


def joint_of(leaves: Leaves, child: str) -> str:
    """Return the name of the joint whose child is the link ``child``, or "" if there is none."""
    return next((name for (kind, name), of in leaves.items() if kind == "joint" and of.get("child") == child), "")


# The changed solids of a link are described separately if there are at most this many.
FEW = 5
NO_WORD = "nothing"


class ShapeChange(NamedTuple):
    """A sentence about a change in the shapes of a link, with the old and new solids."""

    text: str
    old: Sequence[Solid]
    new: Sequence[Solid]
    looks: bool = False  # only names or colours changed


def solids_left(one: Difference, precisions: Precisions) -> tuple[tuple[int, int], list[Solid], list[Solid]]:
    """Return the numbers of solids (old, new) of a link, and the old and new solids without an equal counterpart."""
    sides = zip(one[1:], precisions, strict=True)
    old, new = (side.solids(known) if isinstance(side, Shapes) else [] for side, known in sides)
    rest = match(old, new)
    return (len(old), len(new)), [old[at] for at in rest.old], [new[at] for at in rest.new]


def shapes_change(
    link: str, purpose: str, counts: tuple[int, int], removed: Sequence[Solid], added: Sequence[Solid]
) -> list[ShapeChange]:
    """Describe how the solids of a link changed; ``counts`` are the numbers of all its solids (old, new)."""
    start, (before, after) = f"{link} {purpose}", counts
    is_few = max(len(removed), len(added)) <= FEW
    became = pair_by_place(removed, added) if is_few else [(at, at) for at in range(min(len(removed), len(added)))]
    pairs = [(removed[i], added[j]) for i, j in became]
    numbers = [ShapeChange(text, [a], [b]) for a, b in pairs if (text := _numbers(start, a, b))]
    words = [ShapeChange(text, [a], [b], True) for a, b in pairs for text in _words(start, a, b)]
    if is_few and before != after:
        left = [one for at, one in enumerate(removed) if at not in dict(became)]
        rest = [one for at, one in enumerate(added) if at not in dict(became).values()]
        numbers.append(ShapeChange(f"{start}: {before} -> {after} shapes", left, rest))
    elif not is_few:
        texts = dict.fromkeys(change.text for change in words) if len(removed) == len(added) else {}
        words = [ShapeChange(text, removed, added, True) for text in texts] if len(texts) <= FEW else []
        largest = largest_step(pairs)
        by = f"{len(pairs)} of {{}} changed" + (f", up to {amount(largest, 'm')}" if largest else "")
        text = by.format(count_of(before, "shape"))
        if before != after:
            text = f"{before} -> {after} shapes" + (f", {by.format('them')}" if pairs else "")
        numbers = [ShapeChange(f"{start}: {text}", removed, added)] if numbers or not words else []
    return [*numbers, *words]


def pair_by_place(old: Sequence[Solid], new: Sequence[Solid]) -> list[tuple[int, int]]:
    """Match each old solid to the most similar new solid, and return pairs (index in ``old``, index in ``new``)."""

    def unlike(one: Solid, other: Solid) -> tuple[int, float]:
        different = sum(a != b for a, b in zip(one[1:6], other[1:6], strict=True))
        return len(SIZES) * (one.kind != other.kind) + different, math.dist(one.centre, other.centre)

    costs = {(i, j): unlike(one, other) for i, one in enumerate(old) for j, other in enumerate(new)}
    found: dict[int, int] = {}
    for i, j in sorted(costs, key=lambda pair: (costs[pair], pair)):
        if i not in found and j not in found.values():
            found[i] = j
    ordered = {index: index for index in range(len(old))} if len(old) == len(new) else found
    return sorted(min(ordered, found, key=lambda pairs: sum(costs[pair][0] for pair in pairs.items())).items())


def _words(start: str, one: Solid, other: Solid) -> Iterator[str]:
    if not same_colour(one.rgba, other.rgba, NOISE + join_errors(one.colour_tolerance, other.colour_tolerance)):
        yield sentences.colour_change(start, one.rgba, other.rgba)
    before, after = one.words, other.words
    if one.kind != other.kind:  # ``_numbers`` reports the new kind with the mesh file
        before, after = (tuple(word for word in some if not word.startswith("file ")) for some in (before, after))
    old, new = ([word for word in some if word not in rest] for some, rest in ((before, after), (after, before)))
    if len(old) == len(new) == 1 and old[0].split(" ")[0] == new[0].split(" ")[0]:
        yield f"{start}: {other.kind} {old[0]} -> {new[0].partition(' ')[2]}"
    elif old or new:
        yield f"{start}: {other.kind} {', '.join(old) or NO_WORD} -> {', '.join(new) or NO_WORD}"


def _numbers(start: str, one: Solid, other: Solid) -> str:
    """Describe in one sentence how the kind, size and pose of a solid changed; return "" if they did not."""
    length, turn = join_errors(one.tolerance, other.tolerance), join_errors(one.turn_tolerance, other.turn_tolerance)
    parts = _parts(one, other, (NOISE + length, NOISE + turn))
    if not parts and (one.words, one.rgba) == (other.words, other.rgba):
        parts = _parts(one, other, (0.0, 0.0))
    kind = f" {one.kind}" if one.kind == other.kind else ""
    return f"{start}:{kind} {', '.join(parts)}" if parts else ""


def _parts(one: Solid, other: Solid, least: sentences.Apart) -> list[str]:
    if one.kind != other.kind:
        return [f"{_sized(one)} -> {_sized(other)}", *_place(one, other, least)]
    if one.kind == "mesh":
        scale = f"scale {sentences.row(one.sizes)} -> {sentences.row(other.sizes)}"
        return [*([scale] if one.sizes != other.sizes else []), *_place(one, other, least)]
    names, values, boxes = list(SIZES[one.kind]), [one.sizes, other.sizes], [one.box, other.box]
    if all(boxes):  # axis-aligned boxes are described by their corners
        names = [f"{end} {axis}" for end in ("min", "max") for axis in sentences.AXES]
        values = [(*box.lower, *box.upper) for box in boxes if box]
    steps = [(name, a, b) for name, a, b in zip(names, *values, strict=True) if abs(b - a) > least[0]]
    texts = [f"{name} {' -> '.join(sentences.number_pair(a, b))} m" for name, a, b in steps]
    by = sentences.step(steps[0][2] - steps[0][1], steps[0][1], "m") if len(steps) == 1 else ""
    parts = [sentences.with_remark(", ".join(texts), by)] if texts else []
    return parts if all(boxes) else parts + _place(one, other, least)


def _sized(solid: Solid) -> str:
    if solid.kind == "mesh":
        return " ".join(["mesh", *(word for word in solid.words if word.startswith("file "))])
    sizes = [f"{name} {sentences.number(size)} m" for name, size in zip(SIZES[solid.kind], solid.sizes, strict=True)]
    return f"{solid.kind} ({', '.join(sizes)})"


def _place(one: Solid, other: Solid, least: sentences.Apart) -> list[str]:
    distance, angle = math.dist(one.centre, other.centre), turned_by(one, other)
    distance, angle = (distance if distance > least[0] else 0.0), (angle if angle > least[1] else 0.0)
    if not distance and not angle:
        return []
    old, new = (pose_of(Transform(solid.rows, solid.centre)) for solid in (one, other))
    steps = sentences.coordinates(old, new, (distance, angle), least)
    return [sentences.with_remark(sentences.far(distance, angle, verbs=True), steps)]
