"""Read the driver's JSON (``schemas/robot_model.schema.json``) of another robot as a description.

It has joints, one box a link, a height map and the calibration of servos, but no masses and no limits of effort or
velocity.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rosorin_compile.language.schema import subject
from rosorin_compile.language.validator import misfits_of, validator, words_of
from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import Source, Span, error
from rosorin_compile.source.load import json_of
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.wording import masked
from rosorin_compile.source.xml.markup import MarkupError, read_source

from ..imported import Imported, as_tree
from ..reading import accept, lower_artifact

RULES = (Rule("json-syntax", "The file is not JSON.", "Correct the place that is named; numbers are finite.", READING),)

_RANGE_NOTE = "the driver's model does not say which pulses exist; these are those between the limits"
_ANY_PULSE = 10**9
_HELP = "the file is to fit schemas/robot_model.schema.json"


def read(text: str) -> Robot:
    """Return the robot that a driver's model of ours contains. Raises ValueError if it is damaged."""
    model = _json(text)
    for misfit in misfits_of(validator("robot_model"), model):
        if misfit.keyword not in ("additionalProperties", "enum"):  # which are reported in other ways
            raise ValueError(f"not a driver's model: {words_of(misfit)}")
    return robot_of(model)


def _json(text: str) -> Any:
    """Parse JSON, in which all numbers are finite. Raises ValueError."""
    model = json_of(text)
    try:
        json.dumps(model, allow_nan=False)
    except ValueError:
        raise ValueError("a number is not finite") from None
    return model


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
        source = read_source(path)
        model = _json(source.text)
    except MarkupError as problem:
        return Imported(None, [problem.diagnostic], files=(path,))
    except json.JSONDecodeError as problem:
        span = Span(source, problem.lineno, problem.colno)
        return Imported(None, [error("json-syntax", f"not JSON: {problem.msg}", span, "correct it")], files=(path,))
    except ValueError as problem:
        wrong = [error("json-syntax", f"not JSON: {problem}", Span(source, 1, 1), "correct it")]
        return Imported(None, wrong, files=(path,))
    wrong = []
    for misfit in misfits_of(validator("robot_model"), model):
        where = subject(misfit.path) if misfit.path else "the file"
        message = f"not a driver's model: {where}: {words_of(misfit)}"
        wrong.append(error("wrong-format", message, Span(source, 1, 1), _HELP))
    if wrong:
        return Imported(None, wrong, files=(path,))
    # The format has no word for the limits of effort and velocity that the rules require.
    note = f"from {masked(path.name)}: {model['source']}".removesuffix(": ")
    tree, diagnostics = accept(as_tree(_description(model, note, path.stem), Span(source, 1, 1)), lenient=True)
    return Imported(tree, diagnostics, files=(path,))


def _description(model: Mapping[str, Any], note: str, robot: str = "robot") -> dict[str, Any]:
    """Return the sections of a description."""
    links: dict[str, dict[str, Any]] = {}
    joints: dict[str, dict[str, Any]] = {}
    for name, entry in model["joints"].items():
        joints[name] = {key: entry[key] for key in ("type", "parent", "child", "xyz", "rpy")}
        if entry["type"] != "fixed":
            limit = entry["limit"] and {"limit": dict(zip(("lower", "upper"), entry["limit"], strict=True))}
            joints[name] |= {"axis": entry["axis"], **(limit or {})}
        for end in ("parent", "child"):
            links.setdefault(entry[end], {})
    shapes = [(name, {"box": {"min": box["min"], "max": box["max"]}}) for name, box in model["boxes"].items()]
    if "chassis_heightmap" in model:
        found = model["chassis_heightmap"]
        names = {"origin": "origin_xy", "cell": "cell", "heights": "z", "method": "method"}
        grid = {key: found[name] for key, name in names.items() if key != "method" or found[name]}
        source = {"source": {"status": "stand_in", "note": found["stand_in"]}} if "stand_in" in found else {}
        shapes.append((found["frame"], {"height_map": grid, **source}))
    for name, shape in shapes:
        links.setdefault(name, {}).setdefault("collision", []).append(shape)
    sections = {"robot": robot, "source": {"status": "imported", "note": note}, "links": links, "joints": joints}
    if "pulse_to_rad" in model:
        sections["servos"] = {"pulse_to_rad": _servos(model["pulse_to_rad"], model["joints"])}
    return sections


def _servos(entry: Mapping[str, Any], joints: Mapping[str, Any]) -> dict[str, Any]:
    """Return the calibration as a group of servos; its pulses are those between the limits of the joints."""
    bounds = [value for name in entry["joints"] for value in (joints.get(name, {}).get("limit") or ())]
    rad, zero = float(entry["rad_per_pulse"]), int(entry["zero"])
    reach = [bound / rad for bound in bounds or (-math.pi, math.pi)] if rad else [1.0]
    pulses = sorted(zero + (-pulse if entry["flipped"] else pulse) for pulse in [0.0, *reach])
    return {
        **{key: entry[key] for key in ("joints", "rad_per_pulse", "flipped")},
        "zero_pulse": entry["zero"],
        "pulse_range": [math.floor(pulses[0]), math.ceil(pulses[-1])],
        "source": {"status": "stand_in", "note": _RANGE_NOTE},
    }
