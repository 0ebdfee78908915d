"""Shapes: what links collide with and look like, as sets of solids; of fixed links together where they share them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.formats import FORMATS, Format
from rosorin_compile.model import Box, Capsule, Cylinder, Ellipsoid, HeightMap, Link, Mesh, Shape, Sphere, Transform
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.model.looks import is_own
from rosorin_compile.model.shape import GROUNDED, ROWS, plain
from rosorin_compile.source.progress import Progress

from .bodies import Bodies
from .difference import SHAPE, VISUAL, YAML, Item, Side
from .joints import changed
from .not_compared import CAPSULE, ONE_BOX
from .pairing import Pairing
from .precision import POSE_NOISE, ROOT_THREE, TURNS, Placed, Printing, joined
from .sentences import About, cells_change, colour_change, row, several
from .shape_sentences import FEW, likened, numbers_change, shapes_change, words_change
from .solids import Delta, Solid, largest_step, match, same_space, solid_of


class Purpose(NamedTuple):
    """What is compared: collision or visual shapes of two robots that were read from these formats."""

    name: str
    formats: tuple[Format, Format]
    capsules: bool

    @property
    def simple(self) -> bool:
        """Whether one side has one box a link along its axes, and one height map."""
        return any(ONE_BOX in format.writing.lacks for format in self.formats)

    @property
    def of_artifacts(self) -> bool:
        """Whether neither side is a description, in which every colour was said by somebody."""
        return YAML not in self.formats

    @property
    def says_no_colour(self) -> bool:
        """Whether a visual without a colour means the same on both sides: a description has the words of a URDF."""
        return self.formats[0] is self.formats[1] or all(
            format is FORMATS.published() or not format.load for format in self.formats
        )


class Shapes(NamedTuple):
    """What differs in shapes, notes on what is written otherwise, and what cannot be compared."""

    items: list[Item]
    notes: list[str]
    not_compared: list[str]


def compare_shapes(
    pairing: Pairing, sides: tuple[Side, Side], clusters: Mapping[str, list[list[str]]], purpose: str
) -> Shapes:
    """Return what differs in the shapes of a purpose ("collision" or "visual")."""
    capsules = _capsules_told(pairing, sides, purpose)
    asked = Purpose(purpose, (sides[0].format, sides[1].format), capsules)
    work = _Shapes(pairing, asked)
    for number, (top, goal) in enumerate(pairing.bodies.items()):
        Progress.step("comparing shapes", number, len(pairing.bodies))
        frame = clusters[top][0][0] if clusters.get(top) else ""
        work.body(pairing.a.members[top], pairing.b.members[goal], frame)
    done = {name for top in pairing.bodies for name in pairing.a.members[top] if _same_body(pairing, top, name)}
    for name in pairing.shared:
        if name not in done:
            work.body([name], [name], "")
    if not capsules:
        lacking = next(side.format for side in sides if CAPSULE in side.format.writing.lacks)
        what = f"the round ends of capsules: {lacking.named} has cylinders of the same full length"
        work.not_compared.append(what)
    if work.unsaid:
        links = several(work.unsaid)
        simple = next(side.format for side in sides if ONE_BOX in side.format.writing.lacks)
        what = f"the collision of {links}: {simple.named} has one box along the axes of a link"
        work.not_compared.append(what)
    if work.meshes:
        work.notes.append(f"mesh files are named otherwise: {several(sorted(work.meshes))}")
    return Shapes(work.items, work.notes, work.not_compared)


def _same_body(pairing: Pairing, top: str, name: str) -> bool:
    return pairing.b.top.get(name) == pairing.bodies[top]


def _capsules_told(pairing: Pairing, sides: tuple[Side, Side], purpose: str) -> bool:
    """Say whether capsules and ellipsoids are compared as such: not where a URDF has none, the other side some."""
    has = [
        any(isinstance(s.geometry, (Capsule, Ellipsoid)) for link in bodies.robot.links for s in _of(link, purpose))
        for bodies in (pairing.a, pairing.b)
    ]
    rows = zip(has, has[::-1], sides, strict=True)
    return not any(not mine and other and CAPSULE in side.format.writing.lacks for mine, other, side in rows)


def _of(link: Link, purpose: str) -> tuple[Shape, ...]:
    return link.collision if purpose == "collision" else link.visual


class _Shapes:
    """Goes through bodies; collects what differs."""

    def __init__(self, pairing: Pairing, purpose: Purpose) -> None:
        self.pairing = pairing
        self.purpose = purpose
        self.items: list[Item] = []
        self.notes: list[str] = []
        self.not_compared: list[str] = []
        self.meshes: set[str] = set()
        self.unsaid: list[str] = []

    def body(self, mine: Sequence[str], theirs: Sequence[str], frame: str) -> None:
        """Compare the solids of links that are fixed to each other: link by link, then what is left of all of them."""
        a, b = self.pairing.a.robot.link, self.pairing.b.robot.link
        old = {name: self._pieces(self.pairing.a, name) for name in mine}
        new = {name: self._pieces(self.pairing.b, name) for name in theirs}
        shared = [name for name in mine if name in new]
        for name in shared:
            old[name], new[name] = self._maps(name, old[name], new[name])
        self._grounded(old, new, frame)
        counts = {name: len(old[name]) for name in mine}
        pairs: list[tuple[Piece, Piece]] = []
        for name in shared:
            if self._told(a[name], b[name]):
                both, old[name], new[name] = self._matched(old[name], new[name])
                pairs += both
            else:
                self.unsaid.append(name)
                old[name], new[name] = [], []
        if frame and not self.purpose.simple:
            rest = self._across(old, new, frame)
            pairs += rest
        self._pairs(pairs)
        self._cut_otherwise(old, new, "" if self.purpose.simple else frame)
        for name in shared:
            if old[name] or new[name]:
                self._differ(name, counts[name], old[name], new[name])

    def _grounded(self, old: dict[str, list[Piece]], new: dict[str, list[Piece]], frame: str) -> None:
        """Let height maps reach down to z = 0 where an output asks for it, and the other side has just these boxes."""
        mine, theirs = (old, self.pairing.a), (new, self.pairing.b)
        for (some, bodies), (others, their) in ((mine, theirs), (theirs, mine)):
            if not any(output.options.get("height_maps") == GROUNDED for output in bodies.robot.outputs):
                continue
            for name, pieces in some.items():
                maps = {id(piece.shape): piece.shape for piece in pieces if _reaches_not_down(piece)}
                if not maps or self.purpose.simple:
                    continue
                shapes = tuple(maps.values())
                down = pieces_of(name, shapes, bodies.printing, self.purpose.capsules, GROUNDED)
                if frame:
                    here = [seen(piece, bodies.relative(frame, name, {})) for piece in down]
                    there = [seen(p, their.relative(frame, link, {})) for link, found in others.items() for p in found]
                else:
                    here, there = down, others.get(name, [])
                if len(self._matched(here, there)[0]) < len(down):
                    continue
                kept = [piece for piece in pieces if id(piece.shape) not in maps]
                some[name] = [piece._replace(number=index) for index, piece in enumerate([*kept, *down])]
                self.notes.append(f"the boxes of the height map of {name} reach down to z = 0 on one side")

    def _cut_otherwise(self, old: dict[str, list[Piece]], new: dict[str, list[Piece]], frame: str) -> None:
        """Take out the boxes of a body that fill the same space: those of a height map are cut in one way or another.

        They are held against each other link by link, then all together, seen from ``frame``, if there is one.
        """
        a, b = self.pairing.a, self.pairing.b
        both = (old, a), (new, b)
        steps = [[name] for name in old if name in new] + ([list({**old, **new})] if frame else [])
        for names in steps:
            boxes: list[list[Piece]] = []
            for some, bodies in both:
                pieces = [piece for name in names for piece in some.get(name, ())]
                if len(names) > 1:
                    pieces = [seen(piece, bodies.relative(frame, piece.link, {})) for piece in pieces]
                boxes.append([piece for piece in pieces if piece.solid.box])
            first, second = ([piece.solid for piece in pieces] for pieces in boxes)
            if not first or not second or not same_space(first, second, self.pairing.tolerance):
                continue
            for (some, _), pieces in zip(both, boxes, strict=True):
                taken = {(piece.link, piece.number) for piece in pieces}
                for name in names:
                    some[name] = [piece for piece in some.get(name, ()) if (name, piece.number) not in taken]
            links = several(sorted({piece.link for pieces in boxes for piece in pieces}))
            self.notes.append(f"{self.purpose.name} boxes are cut otherwise, and fill the same space: {links}")

    def _pieces(self, bodies: Bodies, name: str) -> list[Piece]:
        shapes = _of(bodies.robot.link[name], self.purpose.name)
        return pieces_of(name, shapes, bodies.printing, self.purpose.capsules)

    def _told(self, one: Link, other: Link) -> bool:
        """Say whether both formats have a word for what a link collides with."""
        sides = zip((one, other), self.purpose.formats[::-1], strict=True)
        return not any(ONE_BOX in their.writing.lacks and not _is_simple(link) for link, their in sides)

    def _maps(self, name: str, old: list[Piece], new: list[Piece]) -> tuple[list[Piece], list[Piece]]:
        """Return the solids of a link without those of height maps that both robots have, after comparing these."""
        maps = [
            next((p.shape for p in pieces if isinstance(p.shape.geometry, HeightMap)), None) for pieces in (old, new)
        ]
        if maps[0] is None and maps[1] is None:
            return old, new
        left = tuple([p for p in pieces if not isinstance(p.shape.geometry, HeightMap)] for pieces in (old, new))
        if maps[0] is not None and maps[1] is not None:
            self.items += _height_maps(self.pairing, name, maps[0], maps[1], self.purpose.simple)
            return left[0], left[1]
        if self.purpose.simple:
            self.not_compared.append(f"the collision of {name}: a height map on one side, boxes on the other")
            return [], []
        return old, new

    def _across(
        self, old: dict[str, list[Piece]], new: dict[str, list[Piece]], frame: str
    ) -> list[tuple[Piece, Piece]]:
        """Match what is left among all links of a body, seen from one frame; what matches is taken out of both."""
        if not any(old.values()) or not any(new.values()):
            return []
        a, b = self.pairing.a, self.pairing.b
        first = [seen(piece, a.relative(frame, name, {})) for name, pieces in old.items() for piece in pieces]
        second = [seen(piece, b.relative(frame, name, {})) for name, pieces in new.items() for piece in pieces]
        pairs, *rest = self._matched(first, second)
        for pieces, left in zip((old, new), rest, strict=True):
            kept = {(piece.link, piece.number) for piece in left}
            for name in pieces:
                pieces[name] = [piece for piece in pieces[name] if (name, piece.number) in kept]
        moved = sorted({f"{one.link} -> {other.link}" for one, other in pairs if one.link != other.link})
        if moved:
            self.notes.append(f"{self.purpose.name} shapes hang on another link of the same body: {several(moved)}")
        return pairs

    def _matched(
        self, old: Sequence[Piece], new: Sequence[Piece]
    ) -> tuple[list[tuple[Piece, Piece]], list[Piece], list[Piece]]:
        """Return the pairs of pieces that are the same, and what is left of both."""
        rest = match([piece.solid for piece in old], [piece.solid for piece in new], self.pairing.tolerance)
        pairs = [(old[one], new[other]) for one, other in rest.pairs]
        return pairs, [old[index] for index in rest.old], [new[index] for index in rest.new]

    def _differ(self, name: str, count: int, old: list[Piece], new: list[Piece]) -> None:
        """Say what became of the solids of a link that are in one robot alone: of each, if they are few."""
        counts = count, count - len(old) + len(new)
        if max(len(old), len(new)) > FEW:
            self._item(name, old, new, counts)
            return
        solids = [piece.solid for piece in old], [piece.solid for piece in new]
        pairs = [(old[one], new[other]) for one, other in likened(*solids)]
        for one, other in pairs:
            about = About(name, self.purpose.name)
            told = (*numbers_change(about, one.solid, other.solid), *words_change(about, one.solid, other.solid))
            for sentence in told:
                self._add(name, str(sentence), [one], [other])
        self._pairs(pairs)
        if counts[0] != counts[1]:
            left = [[piece for piece in some if all(piece not in pair for pair in pairs)] for some in (old, new)]
            self._item(name, left[0], left[1], counts)

    def _item(self, name: str, old: list[Piece], new: list[Piece], counts: tuple[int, int]) -> None:
        change = Delta(tuple(p.solid for p in old), tuple(p.solid for p in new))
        told = shapes_change(name, self.purpose.name, counts, change)
        for sentence in (*told.numbers, *told.words):
            self._add(name, str(sentence), old, new)

    def _add(self, name: str, text: str, old: list[Piece], new: list[Piece]) -> None:
        largest = largest_step(Delta(*(tuple(p.solid for p in some) for some in (old, new)))) if old and new else None
        kind = SHAPE if self.purpose.name == "collision" else VISUAL
        before, after = "; ".join(map(_words, old)), "; ".join(map(_words, new))
        self.items.append(Item(kind, name, self.purpose.name, text, before, after, "m", largest))

    def _pairs(self, pairs: Sequence[tuple[Piece, Piece]]) -> None:
        """Compare what else is said of solids: the names of mesh files, and colours; the same of one link once."""
        colours: dict[tuple[Any, ...], None] = {}
        for one, other in pairs:
            files = [getattr(piece.shape.geometry, "file", "") for piece in (one, other)]
            if files[0] != files[1] and one.solid.words == other.solid.words:
                self.meshes.add(f"{files[0]} -> {files[1]}")
            found = self._colours(one.shape, other.shape) if self.purpose.name != "collision" else None
            if found:
                colours.setdefault((one.link, *found))
        for link, old, new in colours:
            text = colour_change(About(link, "visual"), old, new).text
            before, after = (row(one) if one else "none" for one in (old, new))
            self.items.append(Item(VISUAL, link, "colour", text, before, after))

    def _colours(self, one: Shape, other: Shape) -> tuple[Any, Any] | None:
        """Return the colours of two visuals if they differ; a simulator's format has a default of its own."""
        old, new = self.pairing.a.robot.colour(one), self.pairing.b.robot.colour(other)
        if old is None or new is None:
            if old is new or not self.purpose.says_no_colour:
                return None
            return old, new
        if self.purpose.of_artifacts and is_own(old) and is_own(new):  # which nobody has said
            return None
        known = joined(self.pairing.a.printing.tolerance("rgba", *old), self.pairing.b.printing.tolerance("rgba", *new))
        if all(abs(x - y) <= known + self.pairing.tolerance for x, y in zip(old, new, strict=True)):
            return None
        return old, new


class Piece(NamedTuple):
    """A solid of a link: the link and its number there, the shape that says it, and the solid seen from some frame."""

    link: str
    number: int
    shape: Shape
    solid: Solid


def pieces_of(
    link: str, shapes: Sequence[Shape], printing: Printing, capsules: bool = True, form: str = ROWS
) -> list[Piece]:
    """Return the solids of a link in its own frame; without ``capsules`` as a URDF 1.0 has them.

    ``form`` is how height maps are cut into boxes.
    """
    found: list[Piece] = []
    for whole in shapes:
        for shape in whole.solids(form):
            made = shape if capsules else replace(shape, geometry=plain(shape.geometry))
            found.append(Piece(link, len(found), whole, _solid(made, whole, printing)))
    return found


def _solid(shape: Shape, whole: Shape, printing: Printing) -> Solid:
    solid = solid_of(shape).bare
    if isinstance(shape.geometry, Mesh):
        name = shape.geometry.file.replace("\\", "/").rsplit("/", 1)[-1]
        solid = solid._replace(words=(f"file {name}",))
    length = ROOT_THREE * printing.tolerance("xyz", *whole.pose.xyz) + _size_tolerance(whole.geometry, printing)
    turn = POSE_NOISE + TURNS * printing.tolerance("rpy", *whole.pose.rpy)
    return solid._replace(tolerance=length, turn_tolerance=turn)


def _size_tolerance(geometry: object, printing: Printing) -> float:
    if isinstance(geometry, Box):
        corners = max(printing.tolerance("min", *geometry.lower), printing.tolerance("max", *geometry.upper))
        return max(printing.tolerance("size", *geometry.size), corners)
    if isinstance(geometry, (Cylinder, Capsule)):
        return max(printing.tolerance("radius", geometry.radius), printing.tolerance("length", geometry.length))
    if isinstance(geometry, Sphere):
        return printing.tolerance("radius", geometry.radius)
    if isinstance(geometry, HeightMap):
        return printing.tolerance("heights", *(z for line in geometry.heights for z in line[:1]))
    return 0.0


def seen(piece: Piece, place: Placed) -> Piece:
    """Return a solid seen from the frame that its link is placed in."""
    return piece._replace(solid=piece.solid.seen_from(place))


def _reaches_not_down(piece: Piece) -> bool:
    return isinstance(piece.shape.geometry, HeightMap) and bool(piece.shape.geometry.bottom)


def _words(piece: Piece) -> str:
    solid = piece.solid
    rpy = pose_of(Transform(solid.rows)).rpy
    turned = ["rpy", row(rpy)] if any(rpy) else []
    return " ".join([solid.kind, *solid.words, row(solid.sizes), "at", row(solid.centre), *turned])


def _is_simple(link: Link) -> bool:
    """Say whether a driver's model can say what a link collides with: no more than a box along its axes and a map."""
    solids = [shape for shape in link.collision if not isinstance(shape.geometry, HeightMap)]
    if not solids:
        return True
    placed = solids[0].moved(IDENTITY.transform())
    return len(solids) == 1 and isinstance(placed.geometry, Box) and placed.pose == IDENTITY


def _height_maps(pairing: Pairing, name: str, one: Shape, other: Shape, simple: bool) -> list[Item]:
    """Return what differs in two height maps; a driver's model does not say how boxes are made from it."""
    old, new = one.geometry, other.geometry
    if not isinstance(old, HeightMap) or not isinstance(new, HeightMap):
        return []
    items = []
    numbers = [("cell", old.cell, new.cell)]
    numbers += [(f"origin {axis}", x, y) for axis, x, y in zip("xy", old.origin, new.origin, strict=True)]
    numbers += [] if simple else [("step", old.step, new.step)]
    for quantity, before, after in numbers:
        if abs(after - before) > pairing.tolerance:
            items.append(changed(SHAPE, name, f"height map {quantity}", (before, after), "m"))
    sizes = [f"{len(heights)} x {len(heights[0]) if heights else 0}" for heights in (old.heights, new.heights)]
    if sizes[0] != sizes[1]:
        text = cells_change(name, old.heights, new.heights).text
        return [*items, Item(SHAPE, name, "height map", text, sizes[0], sizes[1])]
    pairs = [pair for lines in zip(old.heights, new.heights, strict=True) for pair in zip(*lines, strict=False)]
    steps = [abs(b - a) for a, b in pairs if abs(b - a) > pairing.tolerance]
    if steps:
        text = cells_change(name, old.heights, new.heights).text
        items.append(Item(SHAPE, name, "height map", text, None, None, "m", max(steps)))
    return items if simple else [*items, *_bottoms(pairing, name, old, new)]


def _bottoms(pairing: Pairing, name: str, old: HeightMap, new: HeightMap) -> list[Item]:
    """Return what differs in where two height maps of one size begin."""
    lows = [
        [grid.bottom_of(i, j) for i, row in enumerate(grid.heights) for j, height in enumerate(row) if height > 0]
        for grid in (old, new)
    ]
    ends = [(min(low, default=0.0), max(low, default=0.0)) for low in lows]
    if all(low == high for low, high in ends):
        before, after = ends[0][0], ends[1][0]
        same = abs(after - before) <= pairing.tolerance
        return [] if same else [changed(SHAPE, name, "height map bottom", (before, after), "m")]
    steps = [abs(b - a) for a, b in zip(*lows, strict=False)]
    largest = max(steps, default=0.0)
    if len(lows[0]) != len(lows[1]) or largest <= pairing.tolerance:
        return []
    text = f"{name} height map: the bottom changed, by up to {1000 * largest:.1f} mm"
    return [Item(SHAPE, name, "height map bottom", text, None, None, "m", largest)]
