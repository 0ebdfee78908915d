"""News: what an artifact says beside what the model says. Of most robots that is nothing, and it is quickly seen.

Of thousands of parts that are alike an artifact says the same; what is said of them is one object (``formats.facts``),
and is held against what the model says of them once.
"""

from __future__ import annotations

from typing import NamedTuple

from ..formats import Block, Blocks, Fact, Facts, Value
from ..formats.facts import ANGLES, AXES, SIZES, Known
from .solids import COLLISION, Solid, solid_of
from .view import View, check, solid_part, view_of, view_of_model

# What says the space that a shape takes.
_GEOMETRY = frozenset(
    (
        "geometry",
        *(f"origin {axis}" for axis in AXES),
        *ANGLES,
        *(size for sizes in SIZES.values() for size in sizes),
        *(f"box {end} {axis}" for end in ("min", "max") for axis in AXES),
    )
)
_NOTHING: tuple[Block, Block] = ({}, {})


class _Shape(NamedTuple):
    """What a block says of a shape: its number and the solid; None where it says a piece of it."""

    number: int
    solid: Solid | None


_IDLE = _Shape(0, None)


def news(blocks: Blocks, known: Known) -> tuple[View, View]:
    """Return the view of what an artifact says otherwise than is known, and that of what is known of it.

    What it says of things and quantities that are not known is left out, but for parents and what collides. Raises
    ValueError if the artifact is damaged.
    """
    said, meant, names, turned = Facts(), Facts(), set[str](), set[str]()
    shapes, others = dict[str, list[tuple[_Shape, Block]]](), dict[tuple[int, int], Block]()
    shape_of: dict[int, _Shape | None] = {}
    for kind, name, block in blocks:
        if kind == "link":
            names.add(name)
            if id(block) not in shape_of:
                shape_of[id(block)] = _shape(name, block)
            shape = shape_of[id(block)]
            if shape is not None:
                if shape is not _IDLE:
                    shapes.setdefault(name, []).append((shape, block))
                continue
        elif kind == "frame":
            names.add(name)
        shared, own = known.get((kind, name), _NOTHING)
        if len(block) == 1:  # whose parent or child something is stands by itself
            new = _new(block, own if block.keys() <= own.keys() else shared)
        else:
            key = (id(block), id(shared))
            if key not in others:
                for quantity, value in block.items():
                    check(Fact(kind, name, quantity), value)
                others[key] = _new(block, {**shared, **own})
            new = others[key]
        for quantity, value in new.items():
            fact = Fact(kind, name, quantity)
            said[fact] = value
            if quantity == "parent":
                names.add(str(value[0]))
            elif kind == "frame" and quantity in ANGLES:
                turned.add(name)
            for one in (shared, own):
                if quantity in one:
                    meant[fact] = one[quantity]
    # Of a rotation that is not known all three angles.
    for kind, name, block in blocks if turned else ():
        if kind == "frame" and name in turned:
            said |= {Fact(kind, name, angle): block[angle] for angle in ANGLES if angle in block}
            shared, _ = known.get((kind, name), _NOTHING)
            meant |= {Fact(kind, name, angle): shared[angle] for angle in ANGLES if angle in shared}
    view = view_of(said, {})
    solids = {(name, COLLISION): _solids(name, found) for name, found in shapes.items()}
    found = {at: several for at, several in solids.items() if several}
    return view._replace(shapes=found, names=frozenset(names)), view_of_model(meant, view.turns)


def _new(block: Block, known: Block) -> Block:
    """Return what a block says otherwise than is known, and whose parent something is."""
    new: dict[str, Value] = {}
    for quantity, value in block.items():
        meant = known.get(quantity)
        if quantity == "parent" or (
            meant is not None and (value[0] != meant[0] or type(value[0]) is not type(meant[0]))
        ):
            new[quantity] = value
    return new


def _shape(link: str, block: Block) -> _Shape | None:
    """Return what a block says of a shape; None if it speaks of something else. It speaks of one shape or of none.

    What is said of shapes that do not collide, or beside the space that one takes, is idle.
    """
    first = solid_part(next(iter(block), ""))
    if first is None:
        return None
    if first[0] != COLLISION:
        return _IDLE
    for quantity, value in block.items():
        check(Fact("link", link, quantity), value)
    parts = [solid_part(quantity) for quantity in block]
    found = {
        part[2]: value
        for part, value in zip(parts, block.values(), strict=True)
        if part is not None and part[0] == COLLISION and part[2] in _GEOMETRY
    }
    numbers = {part[1] for part in parts if part is not None}
    whole = len(numbers) == 1 and ("geometry" in found or "box min x" in found) and len(found) > 1
    if whole:
        return _Shape(numbers.pop(), solid_of(found))
    return _Shape(0, None) if found else _IDLE


def _solids(link: str, found: list[tuple[_Shape, Block]]) -> tuple[Solid, ...]:
    """Return the solids that collide of a link, by their numbers."""
    solids = {shape.number: shape.solid for shape, _ in found if shape.solid is not None}
    if len(solids) < len(found):
        facts = {Fact("link", link, quantity): value for _, block in found for quantity, value in block.items()}
        return view_of(facts, {}).shapes.get((link, COLLISION), ())
    return tuple(solids[number] for number in sorted(solids))
