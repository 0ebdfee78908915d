"""Print an explanation of frames and named values."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rosorin_compile.source.numbers import exact, to_fixed

from .explain import Answer, Edge, Explanation, NamedValue, Number
from .origins import Meaning, Step, Where

_DIGITS = 9  # printed for quaternions and degrees


def lines(found: Explanation | Answer | NamedValue) -> Iterator[str]:
    """Yield the lines that ``rosorin-compile explain`` prints."""
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
    if found.chain:
        yield f"From {found.chain[0].parent} to {found.name}, moving joints at zero:"
        yield from (line for edge in found.chain for line in _edge(edge))
    if found.others:
        yield "Other nodes place it as well:"
        yield from (line for edge in found.others for line in _edge(edge))
    for placed in found.placed if found.chain else ():
        pose = f'in the pose "{placed.pose}"' if placed.pose else "with all joints at zero"
        yield f"{found.name} in {placed.root}, {pose}:"
        transform = placed.transform
        if transform is None:
            yield "  not known: another node alone knows an edge of the chain"
        else:
            yield f"  xyz                 {_row(transform.xyz)} m"
            yield f"  rpy                 {_row(transform.rpy)} rad"
            yield f"                      {_row(transform.rpy_degrees)} deg"
            yield f"  quaternion x y z w  {_row(transform.quaternion_xyzw)}"
        yield ""
    if found.joint:
        yield f"Joint {found.chain[-1].joint}:"
        yield from (*_numbers(found.joint, found.chain[-1].stack), "")
    if found.inertial:
        yield from ("Mass:", *_numbers(found.inertial, found.stack), "")
    if found.shapes:
        yield "Shapes:"
        for shape in found.shapes:
            yield f"  {shape.purpose}  {_place(shape.where)}  {shape.where.text}"
            yield from _numbers(shape.numbers, found.stack)
        yield ""


def _edge(edge: Edge) -> Iterator[str]:
    joint = f"{edge.joint}, {edge.type}, " if edge.joint else ""
    topic = f" on {edge.topic}" if edge.topic else ""
    when = f", when {edge.when}" if edge.when else ""
    yield f"  {edge.parent} -> {edge.child}: {joint}{edge.publisher}{topic}{when}"
    yield f"    {_place(edge.where)}"
    yield from _stack(edge.stack, 4)
    if edge.transform is None:
        yield "    the numbers are known to that node alone"
    else:
        yield from _numbers(edge.numbers, edge.stack)
        yield f"    quaternion x y z w  {_row(edge.transform.quaternion_xyzw)}"
    yield ""


def _numbers(numbers: Sequence[Number], known: Sequence[Step]) -> Iterator[str]:
    """Yield a line per number, then its origin; what several numbers share follows the last of them."""
    rows = []
    for number in _merge_zeros(numbers):
        degrees = f" ({to_fixed(math.degrees(number.value), 6)} deg)" if number.unit == "rad" and number.value else ""
        rows.append((number, f"{exact(number.value)} {number.unit}".rstrip() + degrees))
    width = max((len(number.name) for number, _ in rows), default=0)
    value_width = max((len(value) for _, value in rows), default=0)
    for (number, value), (follower, _) in zip(rows, [*rows[1:], (None, "")], strict=False):
        origin, following = number.origin, follower.origin if follower is not None else None
        source = number.note
        if origin is not None:
            combined = "of the pose in the part and that of its mount"
            source = combined if origin.parts else f"{_place(origin.where)}  {origin.where.text}"
        yield f"    {number.name:{width}}  {value:{value_width}}  {source}".rstrip()
        if origin is None:
            continue
        if following is None or following.parts != origin.parts:
            for part in origin.parts:
                yield f"        {_place(part.where)}  {part.where.text}"
                yield from _meanings(part.names, 10)
        if following is None or (following.where, following.names) != (origin.where, origin.names):
            yield from _meanings(origin.names, 8)
        if following is None or following.expressions != origin.expressions:
            yield from (f"        {_place(where)}: taken over by {where.text}" for where in origin.expressions)
        if origin.stack != tuple(known) and (following is None or following.stack != origin.stack):
            yield from _stack(origin.stack, 8)


def _merge_zeros(numbers: Sequence[Number]) -> Iterator[Number]:
    while numbers:
        three = numbers[:3]
        names = " ".join(number.name for number in three)
        merge = names in ("x y z", "roll pitch yaw") and all(n.origin is None and n.value == 0 for n in three)
        yield three[0]._replace(name=names) if merge else three[0]
        numbers = numbers[3 if merge else 1 :]


def _row(values: Sequence[float]) -> str:
    return "  ".join(to_fixed(value, _DIGITS) for value in values)


def _meanings(names: Sequence[Meaning], indent: int) -> Iterator[str]:
    for meaning in names:
        place = f"  {_place(meaning.where)}  {meaning.where.text}" if meaning.where else ""
        value = f" = {meaning.value}" if meaning.value else ""
        yield f"{'':{indent}}{meaning.name}{value}: {meaning.given_by}{place}".rstrip()
        yield from _meanings(meaning.names, indent + 2)


def _stack(stack: Sequence[Step], indent: int) -> Iterator[str]:
    return (f"{'':{indent}}{_place(step.where)}: {step.message}" for step in stack)


def _place(where: Where) -> str:
    return f"{where.file}:{where.line}:{where.column}"
