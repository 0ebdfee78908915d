"""Read the driver's JSON (``schemas/robot_model.schema.json``) of another robot as a description.

It has joints, one box a link, a height map and the calibration of servos, but no masses and no limits of effort or
velocity.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rosorin_compile.language.schema import subject
from rosorin_compile.language.validator import misfits_of, validator, words_of
from rosorin_compile.model import Robot
from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.diagnostics import Source, Span, error
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.tree import Map, locate
from rosorin_compile.source.wording import masked
from rosorin_compile.source.xml.files import read_source
from rosorin_compile.source.xml.markup import MarkupError

from ..format import Placed
from ..imported import Imported, as_tree
from ..reading import accept, lower_artifact

RULES = (Rule("json-syntax", "The file is not JSON.", "Correct the place that is named; numbers are finite.", READING),)

_RANGE_NOTE = "the driver's model does not say which pulses exist; these are those between the limits"
_ANY_PULSE = 10**9
_HELP = "the file is to fit schemas/robot_model.schema.json"
_PAIR = re.compile(r"(?<!\\)((?:\\\\)*)\\u([dD][89abAB][0-9a-fA-F]{2})\\u([dD][c-fC-F][0-9a-fA-F]{2})")


def read(text: str) -> Robot:
    """Return the robot that a driver's model of ours contains. Raises ValueError if it is damaged."""
    model = json_of(text)
    for misfit in misfits_of(validator("robot_model"), model):
        if misfit.keyword not in ("additionalProperties", "enum"):  # which are reported in other ways
            raise ValueError(f"not a driver's model: {words_of(misfit)}")
    try:
        json.dumps(model, allow_nan=False)
    except ValueError:
        raise ValueError("a number is not finite") from None
    return robot_of(model)


def robot_of(model: Mapping[str, Any]) -> Robot:
    """Return the robot of a valid driver's model."""
    tree = as_tree(_description(model, model["source"]), Source("the driver's model", "").span())
    for name, entry in model["joints"].items():
        tree["joints"][name]["axis"] = entry["axis"]  # of fixed joints, too
    for group in (tree.get("servos") or {}).values():
        group["pulse_range"] = [-_ANY_PULSE, _ANY_PULSE]  # which no model contains
    return lower_artifact(tree, ())


def read_robot_model(path: Path) -> Imported:
    """Return the robot of a driver's JSON as a plain tree. Problems are diagnostics, never exceptions."""
    try:
        model = _parsed(read_source(path))
    except (MarkupError, LoadError) as problem:
        return Imported(None, [problem.diagnostic], files=(path,))
    wrong = []
    for misfit in misfits_of(validator("robot_model"), model):
        where = subject(misfit.path) if misfit.path else "the file"
        message = f"not a driver's model: {where}: {words_of(misfit)}"
        wrong.append(error("wrong-format", message, locate(model, misfit.path).span, _HELP))
    if wrong:
        return Imported(None, wrong, files=(path,))
    # The format has no word for the limits of effort and velocity that the rules require.
    note = f"from {masked(path.name)}: {model['source']}".removesuffix(": ")
    tree, diagnostics = accept(as_tree(_description(model, note, path.stem), model.span), lenient=True)
    return Imported(tree, diagnostics, files=(path,))


def _parsed(source: Source) -> Map:
    """Return the JSON as a tree with positions: JSON is YAML. Raises LoadError."""
    start = Span(source, 1, 1)
    try:
        json_of(source.text, _no_number)
        # YAML writes letters beyond U+FFFF as one escape, JSON as a pair (RFC 8259, 7).
        tree = parse_yaml(source._replace(text=_PAIR.sub(_letter, source.text)))
    except json.JSONDecodeError as problem:
        place = Span(source, problem.lineno, problem.colno)
        raise LoadError(error("json-syntax", f"not JSON: {problem.msg}", place, "correct it")) from None
    except ValueError as problem:
        raise LoadError(error("json-syntax", f"not JSON: {problem}", start, "correct it")) from None
    if not isinstance(tree, Map):
        message = f"{source.path} holds no object, so it is no driver's model"
        raise LoadError(error("wrong-format", message, start, _HELP))
    return tree


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is not a number of JSON")


def _letter(pair: re.Match[str]) -> str:
    first, second = int(pair[2], 16), int(pair[3], 16)
    return f"{pair[1]}\\U{0x10000 + ((first - 0xD800) << 10) + (second - 0xDC00):08x}"


def _at(entry: Mapping[str, Any], key: str) -> Any:
    return Placed(entry[key], entry.value_spans[key]) if isinstance(entry, Map) else entry[key]


def _placed(value: Any, entry: Any) -> Any:
    return Placed(value, entry.span) if isinstance(entry, Map) else value


def _description(model: Mapping[str, Any], note: str, robot: str = "robot") -> dict[str, Any]:
    """Return the sections of a description, with the places of their values where the JSON has them."""
    links: dict[str, dict[str, Any]] = {}
    for entry in model["joints"].values():
        for end in ("parent", "child"):
            links.setdefault(entry[end], {})
    shapes = [(name, {"box": {key: _at(box, key) for key in ("min", "max")}}) for name, box in model["boxes"].items()]
    if "chassis_heightmap" in model:
        found = model["chassis_heightmap"]
        names = {"origin": "origin_xy", "cell": "cell", "heights": "z", "method": "method"}
        grid = {key: _at(found, name) for key, name in names.items() if key != "method" or found[name]}
        source = {"source": {"status": "stand_in", "note": found["stand_in"]}} if "stand_in" in found else {}
        shapes.append((found["frame"], {"height_map": grid, **source}))
    for name, shape in shapes:
        links.setdefault(name, {}).setdefault("collision", []).append(shape)
    source = {"status": "imported", "note": note}
    joints = {name: _placed(_joint(entry), entry) for name, entry in model["joints"].items()}
    sections = {"robot": robot, "source": source, "links": links, "joints": joints}
    if "pulse_to_rad" in model:
        servos = model["pulse_to_rad"]
        sections["servos"] = {"pulse_to_rad": _placed(_servos(servos, model["joints"]), servos)}
    return sections


def _joint(entry: Mapping[str, Any]) -> dict[str, Any]:
    joint: dict[str, Any] = {key: _at(entry, key) for key in ("type", "parent", "child", "xyz", "rpy")}
    if entry["type"] != "fixed":
        joint["axis"] = _at(entry, "axis")
    if entry["limit"] is not None and entry["type"] != "fixed":
        joint["limit"] = _placed(dict(zip(("lower", "upper"), entry["limit"], strict=True)), entry)
    return joint


def _servos(entry: Mapping[str, Any], joints: Mapping[str, Any]) -> dict[str, Any]:
    """Return the calibration as a group of servos; its pulses are those between the limits of the joints."""
    bounds = [value for name in entry["joints"] for value in (joints.get(name, {}).get("limit") or ())]
    rad, zero = float(entry["rad_per_pulse"]), int(entry["zero"])
    reach = [bound / rad for bound in bounds or (-math.pi, math.pi)] if rad else [1.0]
    pulses = sorted(zero + (-pulse if entry["flipped"] else pulse) for pulse in [0.0, *reach])
    names = {"rad_per_pulse": "rad_per_pulse", "zero_pulse": "zero", "flipped": "flipped"}
    return {
        "joints": _at(entry, "joints"),
        **{key: _at(entry, name) for key, name in names.items()},
        "pulse_range": [math.floor(pulses[0]), math.ceil(pulses[-1])],
        "source": {"status": "stand_in", "note": _RANGE_NOTE},
    }
