"""What an explanation is made of: frames, the edges that lead to them, numbers, and where each was written."""

from __future__ import annotations

from typing import NamedTuple


class Where(NamedTuple):
    """A place in a file, lines and columns from 1, and the text that is written there."""

    file: str
    line: int
    column: int
    text: str


class Meaning(NamedTuple):
    """What a name in an expression stands for: its value in SI units, and what gave it.

    ``where`` is None for the command line; ``names`` are those in the expression that gave the value.
    """

    name: str
    value: str
    given_by: str
    where: Where | None
    names: tuple[Meaning, ...] = ()


class Step(NamedTuple):
    """An include, a part, a type of sensor or a round of a loop that a value came through."""

    message: str
    where: Where


class Origin(NamedTuple):
    """Where a value was written.

    ``names`` are those of its expression, ``expressions`` what took it over from elsewhere (outermost first),
    ``stack`` the includes, parts and loops that it came through (innermost first). A pose that was put together from
    that of a part and that of its mount has both in ``parts``.
    """

    where: Where
    names: tuple[Meaning, ...] = ()
    expressions: tuple[Where, ...] = ()
    stack: tuple[Step, ...] = ()
    parts: tuple[Origin, ...] = ()


class Number(NamedTuple):
    """A number in SI units; ``origin`` is None where it was not written, ``note`` then says why it is what it is."""

    name: str
    value: float
    unit: str
    origin: Origin | None
    note: str = ""


class Transform(NamedTuple):
    """Where a frame sits in another: metres, radians and degrees about fixed axes, quaternion in the order x y z w."""

    xyz: tuple[float, ...]
    rpy: tuple[float, ...]
    rpy_degrees: tuple[float, ...]
    quaternion_xyzw: tuple[float, ...]


class Edge(NamedTuple):
    """One edge of the tree of frames, at position zero.

    ``joint`` and ``type`` are empty for an edge of another node; ``transform`` is None where only that node knows it.
    """

    parent: str
    child: str
    joint: str
    type: str
    publisher: str
    topic: str
    when: str
    transform: Transform | None
    numbers: tuple[Number, ...]
    where: Where
    stack: tuple[Step, ...] = ()


class Placed(NamedTuple):
    """Where a frame sits in the root with the joints in a pose; the pose "" has all of them at zero."""

    pose: str
    root: str
    transform: Transform | None


class Shape(NamedTuple):
    """A shape of a link in a few words, and its numbers."""

    purpose: str
    kind: str
    words: str
    numbers: tuple[Number, ...]
    where: Where


class Explanation(NamedTuple):
    """All that is known of a frame.

    ``roles`` say what it is, ``where`` and ``stack`` where the link is written, ``chain`` leads from the root to it,
    ``others`` are the edges of other nodes that place it as well, ``children`` the frames on it, ``joint`` the numbers
    of the joint that holds it, ``inertial`` those of its mass.
    """

    name: str
    roles: tuple[str, ...]
    where: Where | None
    stack: tuple[Step, ...]
    chain: tuple[Edge, ...]
    others: tuple[Edge, ...]
    placed: tuple[Placed, ...]
    children: tuple[str, ...]
    joint: tuple[Number, ...]
    inertial: tuple[Number, ...]
    shapes: tuple[Shape, ...]

    def numbers(self) -> list[Number]:
        """Return the numbers of the frame itself: of the edges that place it, its joint, mass and shapes."""
        edges = [edge for edge in (*self.chain[-1:], *self.others) if edge.child == self.name]
        of_edges = [number for edge in edges for number in edge.numbers]
        return [*of_edges, *self.joint, *self.inertial, *(n for shape in self.shapes for n in shape.numbers)]


class Answer(NamedTuple):
    """Some numbers of a frame."""

    name: str
    numbers: tuple[Number, ...]


class NamedValue(NamedTuple):
    """An argument or a named value: what it stands for, and the expressions that use it."""

    name: str
    meaning: Meaning
    used_by: tuple[Where, ...]


def as_json(value: object) -> object:
    """Return a value of this module as plain JSON, its fields by name."""
    fields = getattr(value, "_asdict", None)
    if fields is not None:
        return {key: as_json(item) for key, item in fields().items()}
    return [as_json(item) for item in value] if isinstance(value, (list, tuple)) else value
