"""An explanation as text, for people."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rosorin_compile.language.explain.explanation import (
    Answer,
    Edge,
    Explanation,
    Meaning,
    NamedValue,
    Number,
    Step,
    Transform,
    Where,
)
from rosorin_compile.source.numbers import exact, fixed

_DIGITS = 9  # of a quaternion and of an angle in degrees: enough to recognise it


def lines(found: Explanation | Answer | NamedValue) -> Iterator[str]:
    """Yield the lines of an explanation, or of the numbers that were asked for."""
    if isinstance(found, NamedValue):
        yield from _meanings([found.meaning], 0)
        yield "  used by:" if found.used_by else "  nothing uses it"
        yield from (f"    {_place(where)}  {where.text}" for where in found.used_by)
        return
    if isinstance(found, Answer):
        yield found.name
        yield from _numbers(found.numbers, ()) if found.numbers else ("    has none of these numbers",)
        return
    yield f"{found.name}: {', '.join(found.roles)}"
    if found.where is not None:
        yield f"  {_place(found.where)}"
        yield from _stack(found.stack, 2)
    if found.children:
        yield f"  carries {', '.join(found.children)}"
    yield ""
    yield from _way(found)
    yield from _values(found)


def _way(found: Explanation) -> Iterator[str]:
    """Yield by which edges it hangs, and where that is."""
    if found.chain:
        yield f"From {found.chain[0].parent} to {found.name}, moving joints at zero:"
        for edge in found.chain:
            yield from _edge(edge)
    if found.others:
        yield "Other nodes place it as well:"
        for edge in found.others:
            yield from _edge(edge)
    if found.chain:
        yield from _placed(found)


def _values(found: Explanation) -> Iterator[str]:
    """Yield the numbers of its joint, its mass and its shapes."""
    if found.joint:
        yield f"Joint {found.chain[-1].joint}:"
        yield from _numbers(found.joint, found.chain[-1].stack)
        yield ""
    if found.inertial:
        yield "Mass:"
        yield from _numbers(found.inertial, found.stack)
        yield ""
    if found.shapes:
        yield "Shapes:"
        for shape in found.shapes:
            yield f"  {shape.purpose} {shape.kind}, {shape.words}  {_place(shape.where)}"
            yield from _numbers(shape.numbers, found.stack)
        yield ""


def _edge(edge: Edge) -> Iterator[str]:
    what = f"{edge.joint}, {edge.type}, " if edge.joint else ""
    topic = f" on {edge.topic}" if edge.topic else ""
    when = f", when {edge.when}" if edge.when else ""
    yield f"  {edge.parent} -> {edge.child}: {what}{edge.publisher}{topic}{when}"
    yield f"    {_place(edge.where)}"
    yield from _stack(edge.stack, 4)
    if edge.transform is None:
        yield "    the numbers are known to that node alone"
    else:
        yield from _numbers(edge.numbers, edge.stack)
        yield f"    quaternion x y z w  {_list(edge.transform.quaternion_xyzw)}"
    yield ""


def _placed(found: Explanation) -> Iterator[str]:
    for placed in found.placed:
        pose = f'in the pose "{placed.pose}"' if placed.pose else "with all joints at zero"
        yield f"{found.name} in {placed.root}, {pose}:"
        if placed.transform is None:
            yield "  not known: another node alone knows an edge of the chain"
        else:
            yield from _transform(placed.transform)
        yield ""


def _transform(transform: Transform) -> Iterator[str]:
    yield f"  xyz                 {_list(transform.xyz)} m"
    yield f"  rpy                 {_list(transform.rpy)} rad"
    yield f"                      {_list(transform.rpy_degrees)} deg"
    yield f"  quaternion x y z w  {_list(transform.quaternion_xyzw)}"


def _list(values: Sequence[float]) -> str:
    return "  ".join(fixed(value, _DIGITS) for value in values)


def _numbers(numbers: Sequence[Number], known: Sequence[Step]) -> Iterator[str]:
    """Yield a line for each number, and below it what is behind it; a stack that is ``known`` is not repeated."""
    numbers = list(_without_defaults(numbers))
    names = max((len(number.name) for number in numbers), default=0)
    values = max((len(_value(number)) for number in numbers), default=0)
    for index, number in enumerate(numbers):
        origin = number.origin
        yield f"    {number.name:{names}}  {_value(number):{values}}  {_source(number)}".rstrip()
        if origin is None:
            continue
        following = numbers[index + 1].origin if index + 1 < len(numbers) else None
        if following is None or following.parts != origin.parts:
            for part in origin.parts:
                yield f"        {_place(part.where)}  {part.where.text}"
                yield from _meanings(part.names, 10)
        if following is None or (following.where, following.names) != (origin.where, origin.names):
            yield from _meanings(origin.names, 8)
        # What several numbers have in common stands below the last of them.
        if following is None or following.expressions != origin.expressions:
            for where in origin.expressions:
                yield f"        {_place(where)}: taken over by {where.text}"
        if origin.stack != tuple(known) and (following is None or following.stack != origin.stack):
            yield from _stack(origin.stack, 8)


def _without_defaults(numbers: Sequence[Number]) -> Iterator[Number]:
    """Yield numbers, three zeros that were not written as one."""
    index = 0
    while index < len(numbers):
        three = numbers[index : index + 3]
        names = " ".join(number.name for number in three)
        if names in ("x y z", "roll pitch yaw") and all(n.origin is None and n.value == 0 for n in three):
            yield three[0]._replace(name=names)
            index += 3
        else:
            yield numbers[index]
            index += 1


def _source(number: Number) -> str:
    """Return where a number was written, and what is written there; where it was not, why it is what it is."""
    if number.origin is None:
        return number.note
    if number.origin.parts:
        return "of the pose in the part and that of its mount"
    return f"{_place(number.origin.where)}  {number.origin.where.text}"


def _value(number: Number) -> str:
    unit = f" {number.unit}" if number.unit else ""
    degrees = f" ({fixed(math.degrees(number.value), 6)} deg)" if number.unit == "rad" and number.value else ""
    return f"{exact(number.value)}{unit}{degrees}"


def _meanings(names: Sequence[Meaning], indent: int) -> Iterator[str]:
    for meaning in names:
        place = f"  {_place(meaning.where)}  {meaning.where.text}" if meaning.where else ""
        value = f" = {meaning.value}" if meaning.value else ""
        yield f"{'':{indent}}{meaning.name}{value}: {meaning.given_by}{place}".rstrip()
        yield from _meanings(meaning.names, indent + 2)


def _stack(stack: Sequence[Step], indent: int) -> Iterator[str]:
    for step in stack:
        yield f"{'':{indent}}{_place(step.where)}: {step.message}"


def _place(where: Where) -> str:
    return f"{where.file}:{where.line}:{where.column}"
