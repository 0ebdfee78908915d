"""Compare what links collide with and look like, as sets of solids; of links that are fixed together as one set."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.model import Box, Capsule, Ellipsoid, HeightMap, Link, Mesh, Shape, Transform
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.model.looks import is_own
from rosorin_compile.model.shape import GROUNDED, ROWS, Rgba, plain
from rosorin_compile.source.progress import Progress

from .describe import shapes_change
from .difference import SHAPE, VISUAL, YAML, Item, Side
from .pairing import Pairing
from .precision import Placed, Precision, exact, joined
from .sentences import colour_change, row, several
from .solids import Solid, largest_step, match, same_space, solid_of

# What a format may lack beside topics: capsules (cylinders stand for them), and more than one box a link.
CAPSULE, ONE_BOX = "capsule", "several shapes"
_BACKSLASH = "\\"


class Piece(NamedTuple):
    """A solid of a link, the shape that it belongs to, and the solid seen from some frame."""

    link: str
    shape: Shape
    solid: Solid

    def seen_from(self, place: Placed) -> Piece:
        """Return the piece in the frame in which its link is placed."""
        return self._replace(solid=self.solid.seen_from(place))


class ShapeDifferences(NamedTuple):
    """What differs in shapes, notes on what is written otherwise, and what cannot be compared."""

    items: list[Item]
    notes: list[str]
    not_compared: list[str]


Pieces = list[Piece]


def pieces_of(
    link: str,
    shapes: Sequence[Shape],
    precision: Precision,
    capsules: bool = True,
    form: str = ROWS,
    words: bool = False,
) -> Pieces:
    """Return the solids of a link in its own frame, without colours; files by their names alone.

    Without ``capsules`` these are as a URDF 1.0 has them; ``form`` is how height maps are cut into boxes. With
    ``words`` they have their names and what a simulation needs.
    """
    found: Pieces = []
    for whole in shapes:
        for shape in whole.solids(form):
            made = shape if capsules else replace(shape, geometry=plain(shape.geometry))
            solid = solid_of(made, precision)._replace(rgba=None)
            kept = [word for word in solid.words if words and not word.startswith("file ")]
            if isinstance(shape.geometry, Mesh):
                kept.append(f"file {shape.geometry.file.replace(_BACKSLASH, '/').rsplit('/', 1)[-1]}")
            solid = solid._replace(words=tuple(kept))
            found.append(Piece(link, whole, solid))
    return found


def compare_shapes(
    pairing: Pairing, sides: tuple[Side, Side], origins: Mapping[str, str], purpose: str
) -> ShapeDifferences:
    """Return what differs in the shapes of a purpose ("collision" or "visual").

    ``origins`` are the frames in which bodies of A are compared as a whole.
    """
    work = _Comparison(pairing, sides, purpose)
    done = set()
    for number, (top, goal) in enumerate(pairing.bodies.items()):
        Progress.step("comparing shapes", number, len(pairing.bodies))
        work.body(pairing.a.members[top], pairing.b.members[goal], origins[top])
        done |= {name for name in pairing.a.members[top] if pairing.b.top.get(name) == goal}
    for name in pairing.shared:
        if name not in done:
            work.body([name], [name], "")
    return ShapeDifferences(work.items, work.all_notes(), work.not_compared())


class _Comparison:
    """Goes through bodies; collects what differs."""

    def __init__(self, pairing: Pairing, sides: tuple[Side, Side], purpose: str) -> None:
        self.pairing = pairing
        self.sides = sides
        self.purpose = purpose
        self.bodies = pairing.a, pairing.b
        has = [any(_is_round(shape) for link in side.robot.links for shape in self._of(link)) for side in self.bodies]
        lack = [CAPSULE in side.format.lacks for side in sides]
        self.capsules = not any(lack[at] and not has[at] and has[1 - at] for at in (0, 1))
        self.one_box = any(ONE_BOX in side.format.lacks for side in sides)
        formats = [side.format for side in sides]
        # A description has the words of a URDF; the formats of simulators have a colour by default.
        plain = all(format is FORMATS.published() or not format.load for format in formats)
        self.words = formats[0] is formats[1]
        self.says_no_colour = formats[0] is formats[1] or plain
        self.items: list[Item] = []
        self.notes: list[str] = []
        self.not_comparable: dict[str, list[str]] = {}
        self.meshes: set[str] = set()

    def _of(self, link: Link) -> tuple[Shape, ...]:
        return link.collision if self.purpose == "collision" else link.visual

    def all_notes(self) -> list[str]:
        """Return the notes on what is written otherwise, and means the same."""
        files = several(sorted(self.meshes))
        return [*self.notes, *([f"mesh files are named otherwise: {files}"] if files else [])]

    def not_compared(self) -> list[str]:
        """Return what was not compared, and why."""
        found = [f"the collision of {several(names)}: {why}" for why, names in self.not_comparable.items()]
        if not self.capsules:
            lacking = next(side.format for side in self.sides if CAPSULE in side.format.lacks)
            found.append(f"the round ends of capsules: {lacking.named} has cylinders of the same full length")
        return found

    def body(self, mine: Sequence[str], theirs: Sequence[str], origin: str) -> None:
        """Compare the solids of links that are fixed together: link by link, then what is left of all of them."""
        old, new = self._pieces(mine, theirs)
        counts = {name: sum(piece.link == name for piece in old) for name in mine}
        shared = [name for name in mine if name in theirs]
        pairs = []
        for name in shared:
            found, first, second = self._matched(_on(old, [name]), _on(new, [name]))
            pairs += found
            old, new = _without(old, [name]) + first, _without(new, [name]) + second
        if origin and not self.one_box and old and new:
            found, old, new = self._matched(old, new, origin)
            moved = sorted({f"{one.link} -> {other.link}" for one, other in found if one.link != other.link})
            if moved:
                text = f"{self.purpose} shapes are on another link of the same body: {several(moved)}"
                self.notes.append(text)
            pairs += found
        for names, frame in [*(([name], "") for name in shared), ([*mine, *theirs], origin)]:
            if not frame and len(names) > 1:
                continue
            if removed := self._same_space(_on(old, names), _on(new, names), frame):
                old, new = ([piece for piece in some if id(piece.solid) not in removed] for some in (old, new))
        self._named_otherwise(pairs)
        for name in shared:
            first, second = _on(old, [name]), _on(new, [name])
            if first or second:
                self._differ(name, (counts[name], counts[name] - len(first) + len(second)), first, second)

    def _pieces(self, mine: Sequence[str], theirs: Sequence[str]) -> tuple[Pieces, Pieces]:
        """Return the solids of the links of a body in both robots; height maps that both have are compared apart."""
        found: tuple[Pieces, Pieces] = ([], [])
        links = self.pairing.a.robot.link, self.pairing.b.robot.link
        for name in dict.fromkeys([*mine, *theirs]):
            has = name in mine, name in theirs
            shapes = [self._of(side[name]) if there else () for side, there in zip(links, has, strict=True)]
            maps = [any(isinstance(one.geometry, HeightMap) for one in some) for some in shapes]
            if all(maps):
                shapes = [tuple(s for s in some if not isinstance(s.geometry, HeightMap)) for some in shapes]
            elif any(maps) and self.one_box and all(has):
                self.not_comparable.setdefault("a height map on one side, boxes on the other", []).append(name)
                continue
            if self.one_box and all(has) and not all(map(_is_simple, shapes)):
                lacking = next(side.format for side in self.sides if ONE_BOX in side.format.lacks)
                self.not_comparable.setdefault(f"{lacking.named} has one box along the axes of a link", []).append(name)
                continue
            for at in (0, 1):
                form = self._form(at, shapes[at], shapes[1 - at])
                if form == GROUNDED:
                    self.notes.append(f"the boxes of the height map of {name} reach down to z = 0 on one side")
                found[at].extend(
                    pieces_of(name, shapes[at], self.bodies[at].precision, self.capsules, form, self.words)
                )
        return found

    def _form(self, at: int, shapes: Sequence[Shape], others: Sequence[Shape]) -> str:
        """Return how height maps are cut: down to the ground if an output asks for it and more of the other fits."""
        asked = any(o.options.get("height_maps") == GROUNDED for o in self.sides[at].robot.outputs)
        if not asked or not any(isinstance(one.geometry, HeightMap) for one in shapes):
            return ROWS
        boxes = [piece.solid for piece in pieces_of("", others, self.bodies[1 - at].precision)]
        fits = {
            form: len(match([p.solid for p in pieces_of("", shapes, exact, form=form)], boxes).pairs)
            for form in (ROWS, GROUNDED)
        }
        return max(fits, key=fits.__getitem__)

    def _matched(self, old: Pieces, new: Pieces, origin: str = "") -> tuple[list[tuple[Piece, Piece]], Pieces, Pieces]:
        """Return the pairs of pieces that are the same, and what is left; seen from a frame, if there is one."""
        solids = [
            [piece.solid.seen_from(side.relative(origin, piece.link)) if origin else piece.solid for piece in some]
            for side, some in zip(self.bodies, (old, new), strict=True)
        ]
        rest = match(*solids, self.pairing.tolerance)
        pairs = [(old[one], new[other]) for one, other in rest.pairs]
        return pairs, [old[at] for at in rest.old], [new[at] for at in rest.new]

    def _same_space(self, old: Pieces, new: Pieces, origin: str) -> set[int]:
        """Return the solids (by id) of boxes that fill the same space: height maps are cut in one way or another."""
        boxes: list[list[tuple[Piece, Solid]]] = []
        for side, some in zip(self.bodies, (old, new), strict=True):
            seen = [
                (piece, piece.solid.seen_from(side.relative(origin, piece.link)) if origin else piece.solid)
                for piece in some
            ]
            boxes.append([(piece, solid) for piece, solid in seen if solid.box])
        if not all(boxes) or not same_space(*([solid for _, solid in some] for some in boxes), self.pairing.tolerance):
            return set()
        pieces = [piece for some in boxes for piece, _ in some]
        words = [{word for _, solid in some for word in solid.words if not word.startswith("name ")} for some in boxes]
        if words[0] != words[1]:
            return set()
        links = several(sorted({piece.link for piece in pieces}))
        self.notes.append(f"{self.purpose} boxes are cut otherwise, and fill the same space: {links}")
        return {id(piece.solid) for piece in pieces}

    def _differ(self, name: str, counts: tuple[int, int], old: Pieces, new: Pieces) -> None:
        """Add what became of the solids of a link that are in one robot alone."""
        kind = SHAPE if self.purpose == "collision" else VISUAL
        solids = [piece.solid for piece in old], [piece.solid for piece in new]
        for change in shapes_change(name, self.purpose, counts, *solids):
            largest = largest_step(change.old, change.new) if change.old and change.new else None
            values = ("; ".join(map(_words, some)) for some in (change.old, change.new))
            self.items.append(Item(kind, name, self.purpose, change.text, *values, "m", largest))
            if len(change.old) == len(change.new) == 1:
                found = [
                    next(piece for piece in some if piece.solid is solid)
                    for some, (solid,) in zip((old, new), (change.old, change.new), strict=True)
                ]
                self._named_otherwise([(found[0], found[1])])

    def _named_otherwise(self, pairs: Iterable[tuple[Piece, Piece]]) -> None:
        """Compare the names of mesh files and the colours of solids; the same colours of one link once."""
        colours: dict[tuple[str, Rgba | None, Rgba | None], None] = {}
        for one, other in pairs:
            files = [getattr(piece.shape.geometry, "file", "") for piece in (one, other)]
            if files[0] != files[1] and one.solid.words == other.solid.words:
                self.meshes.add(f"{files[0]} -> {files[1]}")
            found = self._colours(one.shape, other.shape) if self.purpose == "visual" else None
            if found:
                colours.setdefault((one.link, *found))
        for link, old, new in colours:
            text = colour_change(f"{link} visual", old, new)
            before, after = (row(one) if one else "none" for one in (old, new))
            self.items.append(Item(VISUAL, link, "colour", text, before, after))

    def _colours(self, one: Shape, other: Shape) -> tuple[Rgba | None, Rgba | None] | None:
        """Return the colours of two visuals if they differ; a colour that nobody gave is none."""
        pairs = zip(self.bodies, (one, other), strict=True)
        old, new = (side.robot.colour(shape) for side, shape in pairs)
        if any(side.format is not YAML for side in self.sides):
            old, new = (None if colour is None or is_own(colour) else colour for colour in (old, new))
        if old is None or new is None:
            same = old is new or not self.says_no_colour
            return None if same else (old, new)
        known = joined(self.bodies[0].precision("rgba", *old), self.bodies[1].precision("rgba", *new))
        if all(abs(x - y) <= known + self.pairing.tolerance for x, y in zip(old, new, strict=True)):
            return None
        return old, new


def _on(pieces: Pieces, links: Sequence[str]) -> Pieces:
    return [piece for piece in pieces if piece.link in links]


def _without(pieces: Pieces, links: Sequence[str]) -> Pieces:
    return [piece for piece in pieces if piece.link not in links]


def _is_round(shape: Shape) -> bool:
    return isinstance(shape.geometry, (Capsule, Ellipsoid))


def _is_simple(shapes: Sequence[Shape]) -> bool:
    """Return True if a driver's model can say what a link collides with: a box along its axes, and a height map."""
    solids = [shape for shape in shapes if not isinstance(shape.geometry, HeightMap)]
    if not solids:
        return True
    placed = solids[0].moved(IDENTITY.transform())
    return len(solids) == 1 and isinstance(placed.geometry, Box) and placed.pose == IDENTITY


def _words(solid: Solid) -> str:
    rpy, files = pose_of(Transform(solid.rows)).rpy, [word for word in solid.words if word.startswith("file ")]
    turned = ["rpy", row(rpy)] if any(rpy) else []
    return " ".join([solid.kind, *files, row(solid.sizes), "at", row(solid.centre), *turned])
