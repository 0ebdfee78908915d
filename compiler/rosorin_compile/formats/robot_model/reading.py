"""The driver's JSON (``schemas/robot_model.schema.json``) read back into the plain tree.

It knows joints, one box a link, a height map and the calibration of servos; it knows no masses, and no limits of effort
or velocity.
"""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

from rosorin_compile.language.schema import subject
from rosorin_compile.language.validator import misfits_of, validator, words
from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.diagnostics import Diagnostic, Source, Span, error
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.tree import Map, Seq, locate
from rosorin_compile.source.xml.files import printable_name, read_source
from rosorin_compile.source.xml.markup import MarkupError

from ..checked import accept
from ..imported import Imported

RULES = (Rule("json-syntax", "The file is not JSON.", "Correct the place that is named; numbers are finite.", READING),)

_RANGE_NOTE = "the driver's model does not say which pulses exist; these are those between the limits"
_HELP = "the file is to fit schemas/robot_model.schema.json"
_PAIR = re.compile(r"(?<!\\)((?:\\\\)*)\\u([dD][89abAB][0-9a-fA-F]{2})\\u([dD][c-fC-F][0-9a-fA-F]{2})")
# Where no joint of the servos has limits (rad).
_HALF_TURN = math.pi


def read_robot_model(path: Path) -> Imported:
    """Return the robot of a driver's JSON as a plain tree. Problems are diagnostics, never exceptions."""
    try:
        source = read_source(path)
        model = _parsed(source)
    except (MarkupError, LoadError) as problem:
        return Imported(None, [problem.diagnostic], files=(path,))
    wrong = _misfits(model)
    if wrong:
        return Imported(None, wrong, files=(path,))
    tree = _tree(model, path)
    # The format has no word for what the rules want of limits.
    accepted, diagnostics = accept(tree, lenient=True)
    return Imported(accepted, diagnostics, files=(path,))


def _parsed(source: Source) -> Map:
    """Return the JSON as a tree that knows its lines: JSON is YAML. Raises LoadError."""
    try:
        json_of(source.text, _not_a_number)
        # YAML writes letters beyond U+FFFF as one escape, JSON as a pair (RFC 8259, 7).
        tree = parse_yaml(source._replace(text=_PAIR.sub(_letter, source.text)))
    except json.JSONDecodeError as problem:
        place = Span(source, problem.lineno, problem.colno)
        raise LoadError(error("json-syntax", f"not JSON: {problem.msg}", place, "correct it")) from None
    except ValueError as problem:
        place = Span(source, 1, 1)
        raise LoadError(error("json-syntax", f"not JSON: {problem}", place, "correct it")) from None
    if not isinstance(tree, Map):
        message = f"{source.path} holds no object, so it is no driver's model"
        raise LoadError(error("wrong-format", message, Span(source, 1, 1), _HELP))
    return tree


def _letter(pair: re.Match[str]) -> str:
    first, second = int(pair[2], 16), int(pair[3], 16)
    return f"{pair[1]}\\U{0x10000 + ((first - 0xD800) << 10) + (second - 0xDC00):08x}"


def _not_a_number(word: str) -> float:
    raise ValueError(f"{word} is not a number of JSON")


def _misfits(model: Map) -> list[Diagnostic]:
    """Return an error for each place that does not fit the schema of the format."""
    diagnostics = []
    for misfit in misfits_of(validator("robot_model"), model):
        span = locate(model, misfit.path).span
        where = subject(misfit.path) if misfit.path else "the file"
        diagnostics.append(error("wrong-format", f"not a driver's model: {where}: {words(misfit)}", span, _HELP))
    return diagnostics


def _tree(model: Map, path: Path) -> Map:
    tree = Map(model.span)
    note = f"from {printable_name(path)}: {model['source']}" if model["source"] else f"from {printable_name(path)}"
    _put(tree, "robot", path.stem)
    _put(tree, "source", _said(model, "imported", note))
    _put(tree, "links", _link_entries(model))
    joints = Map(model["joints"].span)
    for name, entry in model["joints"].items():
        joints.put(_word(name), _joint_entry(entry), model["joints"].key_spans[name], entry.span)
    _put(tree, "joints", joints)
    if "pulse_to_rad" in model:
        servos = Map(model["pulse_to_rad"].span)
        _put(servos, "pulse_to_rad", _servo_entries(model["pulse_to_rad"], model["joints"]))
        _put(tree, "servos", servos)
    return tree


def _put(entry: Map, key: str, value: Any, span: Span | None = None) -> None:
    place = span or getattr(value, "span", None) or entry.span
    entry.put(key, value, place, place)


def _take(entry: Map, key: str, other: Map, theirs: str) -> None:
    """Set a key to a value of the JSON, with its place."""
    value = other[theirs]
    entry.put(key, _word(value), other.key_spans[theirs], other.value_spans[theirs])


def _word(value: Any) -> Any:
    """Return a text that stood in quotes as a plain one, anything else as it is."""
    return str(value) if isinstance(value, str) else value


def _said(at: Map, status: str, note: str) -> Map:
    source = Map(at.span)
    _put(source, "status", status)
    _put(source, "note", note)
    return source


def _link_entries(model: Map) -> Map:
    """Return the links that joints, boxes and the height map name, with what they collide with."""
    links = Map(model.span)
    for entry in model["joints"].values():
        for end in ("parent", "child"):
            if entry[end] not in links:
                links.put(_word(entry[end]), Map(entry.span), entry.value_spans[end], entry.span)
    for name, box in model["boxes"].items():
        shape, corners = Map(box.span), Map(box.span)
        for corner in ("min", "max"):
            _take(corners, corner, box, corner)
        _put(shape, "box", corners)
        _shape(links, name, shape, model["boxes"].key_spans[name])
    if "chassis_heightmap" in model:
        described = model["chassis_heightmap"]
        shape, grid = Map(described.span), Map(described.span)
        for key, theirs in (("origin", "origin_xy"), ("cell", "cell"), ("heights", "z")):
            _take(grid, key, described, theirs)
        if described["method"]:
            _take(grid, "method", described, "method")
        _put(shape, "height_map", grid)
        if "stand_in" in described:
            _put(shape, "source", _said(described, "stand_in", described["stand_in"]))
        _shape(links, described["frame"], shape, described.value_spans["frame"])
    return links


def _shape(links: Map, name: str, shape: Map, span: Span) -> None:
    if name not in links:
        links.put(_word(name), Map(span), span, span)
    if "collision" not in links[name]:
        _put(links[name], "collision", Seq(shape.span))
    links[name]["collision"].put(shape, shape.span)


def _joint_entry(entry: Map) -> Map:
    joint = Map(entry.span)
    for key in ("type", "parent", "child", "xyz", "rpy"):
        _take(joint, key, entry, key)
    if entry["type"] != "fixed":
        _take(joint, "axis", entry, "axis")
        if entry["limit"] is not None:
            limit = Map(entry["limit"].span)
            for index, key in enumerate(("lower", "upper")):
                _put(limit, key, entry["limit"][index], entry["limit"].value_spans[index])
            _put(joint, "limit", limit)
    return joint


def _servo_entries(entry: Map, joints: Map) -> Map:
    """Return the calibration as a group of servos; its pulses are those between the limits of the joints."""
    servos = Map(entry.span)
    names = Seq(entry["joints"].span)
    for name, place in zip(entry["joints"], entry["joints"].value_spans, strict=True):
        names.put(_word(name), place)
    _put(servos, "joints", names)
    for key, theirs in (("rad_per_pulse", "rad_per_pulse"), ("zero_pulse", "zero")):
        _take(servos, key, entry, theirs)
    _take(servos, "flipped", entry, "flipped")
    bounds = [value for name in entry["joints"] for value in (joints.get(name, {}).get("limit") or ())]
    rad, zero = float(entry["rad_per_pulse"]), int(entry["zero"])
    reach = [bound / rad for bound in bounds or (-_HALF_TURN, _HALF_TURN)] if rad else [1.0]
    pulses = sorted(zero + (-pulse if entry["flipped"] else pulse) for pulse in [0.0, *reach])
    ends = Seq(entry.span)
    for pulse in (math.floor(pulses[0]), math.ceil(pulses[-1])):
        ends.put(pulse, entry.span)
    _put(servos, "pulse_range", ends)
    _put(servos, "source", _said(entry, "stand_in", _RANGE_NOTE))
    return servos
