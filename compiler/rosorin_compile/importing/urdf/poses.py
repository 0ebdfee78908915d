"""Origins of URDF: a position and an orientation, as ``xyz`` and ``rpy`` of an entry."""

from __future__ import annotations

from ...diagnostic import NOTE, Diagnostic
from ...model.geometry import transform_of_quaternion
from ...registry import READING, Rule
from ...tree import Map, Path, Seq
from ..markup import Element
from .reading import Reading, named
from .values import ANGLES, LENGTHS, PLAIN, numbers, put_numbers

RULES = (
    Rule("zero-quaternion", "A quaternion is zero, which is no rotation.", "Correct it.", READING),
    Rule("import-converted", "A note: the same is said in another form.", topic=READING),
)


def put_origin(entry: Map, element: Element, path: Path, reading: Reading) -> None:
    """Set ``xyz`` and ``rpy`` of an entry from the <origin> in an element."""
    origin = reading.single(element, "origin")
    if origin is None:
        return
    reading.known(origin, (), ("xyz", "rpy", "quat_xyzw"), None)
    reading.paths[id(origin)] = (*path, "xyz" if "xyz" in origin.attributes else "rpy")
    put_numbers(entry, "xyz", origin, "xyz", 3, LENGTHS, reading)
    if "quat_xyzw" not in origin.attributes:
        put_numbers(entry, "rpy", origin, "rpy", 3, ANGLES, reading)
        return
    attribute = origin.attributes["quat_xyzw"]
    if "rpy" in origin.attributes:
        message = f"{named(origin)} has rpy and quat_xyzw; readers differ in which of them they take"
        reading.error("duplicate-element", message, attribute.name_span, "remove one")
        return
    found = numbers(origin, "quat_xyzw", 4, PLAIN, reading)
    if found is None:
        return
    if not any(found):
        reading.error(
            "zero-quaternion", f"quat_xyzw of {named(origin)} is zero: no rotation", attribute.span, "correct it"
        )
        return
    x, y, z, w = found
    rpy = transform_of_quaternion((0.0, 0.0, 0.0), (w, x, y, z)).rpy()
    made = Seq(attribute.span)
    for angle in rpy:
        made.put(angle + 0.0, attribute.span)
    entry.put("rpy", made, attribute.name_span, attribute.span)
    message = f"quat_xyzw of {named(origin)} became rpy: the same rotation"
    reading.diagnostics.append(Diagnostic("import-converted", NOTE, message, attribute.span))
