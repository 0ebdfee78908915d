"""Convert values of MuJoCo to entries of a description, with source positions and without rounding errors.

An entry is a YAML mapping. ``put_words`` converts attributes to the types in the JSON schema of the description. A
node is an XML element as ``engine`` returns it: a dict with a tag, attributes as strings, and child nodes.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rosorin_compile.language.schema import resolve, schema
from rosorin_compile.model import Transform, Vector
from rosorin_compile.model.geometry import IDENTITY, Rows
from rosorin_compile.model.link import along_link
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.elements import attribute_value
from rosorin_compile.source.xml.markup import Attribute, Element

Attributes = Mapping[str, str]
Words = Mapping[str, str] | None  # maps MJCF attributes to keys of the description where the names differ
Node = Mapping[str, Any]

DEGREE = math.pi / 180
ROUNDING = 1e-15  # typical rounding error of numbers near 1
ANGLE_ROUNDING = 1e-12  # rad
NO_POSE = Transform()
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def legal(name: str) -> str:
    """Replace characters that are not allowed in names of a description (markup, quotes, white space) by "_"."""
    return " ".join(re.sub(r"[<>&\"'\s\x00-\x1f\x7f]+", "_", word) for word in name.split(" ") if word)


def put_value(entry: Map, key: str, value: Any, span: Span | None = None) -> None:
    """Set a key of an entry. ``span`` is the source position, by default that of the value, or else of the entry."""
    place = span or getattr(value, "span", None) or entry.span
    entry.put(key, value, place, place)


def put_some(entry: Map, key: str, value: Any) -> None:
    """Set a key of an entry unless the value is empty."""
    if value:
        put_value(entry, key, value)


def map_entry(values: Mapping[str, Any], element: Element) -> Map:
    """Create an entry at the source position of an element, without empty values; zero is not empty."""
    entry = Map(element.span)
    for key, value in values.items():
        if value or value == 0:
            put_value(entry, key, value)
    return entry


def put_number(entry: Map, key: str, value: float, element: Element, attribute: str = "", at: int = 0) -> None:
    """Set a key of an entry to a number.

    Its source position is that of item ``at`` in ``attribute`` if the item has this value, else that of ``element``.
    """
    words = element.attributes.get(attribute)
    word = words.words()[at : at + 1] if words else []
    entry.put(key, plain(value), element.span, word[0].span if word and _equals(word[0].text, value) else element.span)


def put_pose(entry: Map, place: Transform, element: Element) -> None:
    """Set ``xyz`` and ``rpy`` of an entry, each unless it is zero."""
    xyz, rpy = tidy_vector(place.xyz), rpy_of(place.rows)
    if xyz != IDENTITY.xyz:
        put_value(entry, "xyz", numbers(xyz, element, "pos"))
    if rpy != IDENTITY.rpy:
        put_value(entry, "rpy", numbers(rpy, element))


def put_source(entry: Map, status: str, note: str) -> None:
    """Set the key ``source`` of an entry, which documents the origin of its values."""
    source = Map(entry.span)
    put_value(source, "status", status)
    put_value(source, "note", note)
    put_value(entry, "source", source)


def put_inner(entry: Map, key: str, value: Any) -> None:
    """Set a key in the ``mjcf`` section of an entry, which is created if necessary."""
    inner = entry.get("mjcf") or Map(entry.span)
    put_value(inner, key, value)
    put_value(entry, "mjcf", inner)


def numbers(values: Sequence[float], element: Element, attribute: str = "") -> Seq:
    """Create a list of numbers, with their source positions in ``attribute`` if the values are equal there."""
    own = element.attributes.get(attribute)
    words = own.words() if own else []
    exact = len(words) == len(values) and all(map(_equals, (word.text for word in words), values))
    listed = Seq(element.span)
    for at, value in enumerate(values):
        listed.put(plain(value), words[at].span if exact else element.span)
    return listed


def list_entry(values: Iterable[Any], element: Element) -> Seq:
    """Create a list of values at the source position of an element."""
    listed = Seq(element.span)
    for value in values:
        listed.put(value, element.span)
    return listed


def plain(value: float) -> float | int:
    """Convert a float without fraction to int."""
    return int(value) if value == int(value) and abs(value) < 1e15 else value


def put_words(entry: Map, attributes: Attributes, kind: str, element: Element, words: Words = None) -> dict[str, str]:
    """Set keys of an entry from XML attributes, in order, and return the attributes that no key can express.

    ``kind`` is the name of the entry's definition in the schema. ``words`` maps attributes to keys where the names
    differ. Attributes that only MuJoCo has are set in the ``mjcf`` section of the entry.
    """
    forms, called = schema()["$defs"][kind]["properties"], words or {}
    more = resolve(forms.get("mjcf", {})).get("properties", {})
    inner, rest = Map(element.span), {}
    for name, text in attributes.items():
        if name == "name":
            continue
        key, target, value = called.get(name, name), entry, None
        if key in forms and key not in ("mjcf", "name", "source", "xyz", "rpy"):
            value = value_of(text, forms[key], element, name)
        if value is None and name in more:
            key, target, value = name, inner, value_of(text, more[name], element, name)
        if value is None:
            rest[name] = text
        else:
            put_value(target, key, value, _place(element, name, text))
    put_some(entry, "mjcf", inner)
    return rest


def value_of(text: str, form: Mapping[str, Any], element: Element, attribute: str) -> Any:
    """Convert an attribute value to the type in the JSON schema ``form``, or return None if it does not fit."""
    if form.get("$ref") == "#/$defs/name":
        return text
    if form.get("$ref") == "#/$defs/rgba":
        form = {"minItems": 3, "maxItems": 4, "type": "array"}
    kinds, allowed = form.get("type", "string"), form.get("items", {}).get("enum", ())
    if "enum" in form or kinds == "string":
        return text if text in form.get("enum", (text,)) else None
    if kinds == "boolean":
        return {"true": True, "false": False}.get(text)
    if allowed and all(word in allowed for word in text.split()):
        return list_entry(text.split(), element)
    found = _numbers(text)
    if len(found) == 1 and ("number" in kinds or kinds == "integer"):
        return int(found[0]) if kinds == "integer" else plain(found[0])
    fits = form.get("minItems", 0) <= len(found) <= form.get("maxItems", len(found))
    return numbers(found, element, attribute) if found and "array" in kinds and fits else None


def _numbers(text: str) -> list[float]:
    try:
        return [tidy(float(word)) if float(word) else 0.0 for word in text.split()]
    except ValueError:
        return []


def number_or_text(text: str) -> float | int | str:
    """Convert a string to a number, or return the string if it is not numeric."""
    try:
        return plain(float(text))
    except (ValueError, OverflowError):
        return text


def _equals(text: str, value: float) -> bool:
    return number_or_text(text) == value


def _place(element: Element, attribute: str, text: str) -> Span:
    own: Attribute | None = element.attributes.get(attribute)
    if own is None:
        return element.span
    words, found = own.words(), _numbers(text)
    is_number = len(words) == 1 and len(found) == len(text.split()) == 1 and _equals(words[0].text, float(text))
    return own.span if own.value == text or is_number else element.span


def floats(attributes: Attributes, name: str, usual: Sequence[float] = ()) -> list[float]:
    """Return the numbers in an attribute; if it has fewer numbers than ``usual``, the rest comes from ``usual``."""
    found = [float(word) for word in attributes.get(name, "").split()]
    return [*found, *usual[len(found) :]]


def text_of(node: Node, indent: str = "") -> str:
    """Format a node as XML."""
    pairs = node["attributes"].items()
    attributes = "".join(f" {name}={attribute_value(legal(text) if name == 'name' else text)}" for name, text in pairs)
    if not node["inner"]:
        return f"{indent}<{node['tag']}{attributes}/>"
    inner = "\n".join(text_of(one, f"{indent}  ") for one in node["inner"])
    return f"{indent}<{node['tag']}{attributes}>\n{inner}\n{indent}</{node['tag']}>"


def tidy(value: float, zero: float = ROUNDING) -> float:
    """Round a number to the nearest short decimal, or to 0 if its magnitude is below ``zero``.

    >>> tidy(0.30000000000000004), tidy(0.1234567890123456), tidy(1e-17), tidy(-0.0)
    (0.3, 0.1234567890123456, 0.0, 0.0)
    """
    if abs(value) < zero:
        return 0.0
    shorter = (float(f"{value:.{digits}g}") for digits in range(1, 14))
    return next((short for short in shorter if abs(short - value) <= ROUNDING * abs(value)), value)


def tidy_angle(value: float) -> float:
    """Remove the rounding error of an angle (rad) close to whole degrees; -180 degrees become 180 degrees.

    >>> tidy_angle(1.5707963267948963) == 90 * DEGREE, tidy_angle(-math.pi) == math.pi
    (True, True)
    """
    made = tidy_position(value)
    return -made if made == -180 * DEGREE else 0.0 if abs(made) < ANGLE_ROUNDING else made


def tidy_position(value: float, slides: bool = False) -> float:
    """Remove the rounding error of a joint position (rad, or m if ``slides``); -180 degrees are unchanged."""
    degrees = round(value / DEGREE) if math.isfinite(value) and not slides else 0
    if degrees and abs(value - degrees * DEGREE) <= ANGLE_ROUNDING * max(1.0, abs(degrees) / 180):
        return degrees * DEGREE
    return tidy(value)


def tidy_vector(values: Iterable[float]) -> Vector:
    """Apply ``tidy`` to three numbers."""
    x, y, z = map(tidy, values)
    return (x, y, z)


def transform(pos: Sequence[float], quat: Sequence[float] | None = None) -> Transform:
    """Create a transform from a position (m) and a quaternion (w, x, y, z) of any length (None: no rotation)."""
    x, y, z = pos
    return Transform(xyz=(x, y, z)) if quat is None else Transform.of_quaternion((x, y, z), quat)


def rotation(quaternion: Sequence[float]) -> Rows:
    """Return the rotation matrix (as rows) of a quaternion (w, x, y, z) of any length above zero."""
    return transform(NO_POSE.xyz, quaternion).rows


def rpy_of(rows: Rows) -> Vector:
    """Convert a rotation matrix to fixed-axis roll, pitch and yaw (rad), without rounding errors."""
    roll, pitch, yaw = Transform(rows).rpy()
    return tidy_angle(roll), tidy_angle(pitch), tidy_angle(yaw)


def full_inertia(diagonal: Sequence[float], rows: Rows) -> dict[str, float]:
    """Convert principal moments and the rotation of their axes to ixx ... iyz (kg*m^2) along the link axes."""
    xx, yy, zz = diagonal
    moments = along_link((xx, yy, zz, 0.0, 0.0, 0.0), Transform(rows))
    most = ROUNDING * max(map(abs, diagonal))
    return {name: tidy(one, most) for name, one in zip(MOMENTS, moments, strict=True)}


def is_unturned(place: Transform) -> bool:
    """Return True if a transform has no rotation."""
    return all(abs(a - (n == k)) < ANGLE_ROUNDING for n, row in enumerate(place.rows) for k, a in enumerate(row))


def pose_attributes(place: Transform) -> dict[str, str]:
    """Return the MJCF attributes ``pos`` and ``quat`` for a transform, without ``quat`` if there is no rotation."""
    pos = {"pos": " ".join(repr(plain(tidy(value))) for value in place.xyz)}
    return pos if is_unturned(place) else pos | {"quat": " ".join(map(repr, place.quaternion()))}
