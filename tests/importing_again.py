"""Round: an imported tree compiled to a URDF, that read again, and what of two trees has to be alike."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from rosorin_compile.build import build
from rosorin_compile.emit import FORMATS
from rosorin_compile.templating import Templates
from rosorin_compile.tree import Map, Seq

DEFAULTS: dict[str, Any] = {
    "xyz": [0, 0, 0],
    "rpy": [0, 0, 0],
    "scale": [1, 1, 1],
    "multiplier": 1,
    "offset": 0,
    "urdf_elements": [],
    "soft_lower_limit": 0,
    "soft_upper_limit": 0,
    "k_position": 0,
    "damping": 0,
    "friction": 0,
    "dynamics": {},
}


def urdf_of(tree: Map) -> str:
    """Return the URDF of an imported tree."""
    whole, outputs, output = Map(tree.span), Map(tree.span), Map(tree.span)
    for key, value in tree.items():
        whole.put(key, value, tree.span, tree.span)
    output.put("file", "robot.urdf", tree.span, tree.span)
    output.put("version", "1.2", tree.span, tree.span)
    outputs.put("urdf", output, tree.span, tree.span)
    whole.put("outputs", outputs, tree.span, tree.span)
    robot = build(whole).robot
    assert robot is not None
    text, said = FORMATS["urdf"].write(robot, robot.outputs[0], Templates(Path()))
    assert not [d for d in said if d.severity == "error"], said
    return text


def meaning(tree: Any) -> Any:
    """Return a tree as what it means: without places, defaults and where it came from."""
    if isinstance(tree, Map):
        kept = {key: meaning(value) for key, value in tree.items() if key not in ("source", "accept")}
        if kept.get("axis") == [1, 0, 0]:
            del kept["axis"]
        if re.fullmatch(r".*_\d+", kept.get("material", "")) and "rgba" in kept:  # a look needs a name in a URDF
            del kept["material"]
        return {key: value for key, value in kept.items() if DEFAULTS.get(key) != value}
    if isinstance(tree, Seq):
        return [meaning(value) for value in tree]
    return float(tree) + 0.0 if isinstance(tree, (int, float)) else str(tree)


def accepted(tree: Map) -> set[tuple[str, str]]:
    """Return what a tree accepts: pairs of rule and name."""
    return {(entry["rule"], name) for entry in tree.get("accept", ()) for name in entry["of"]}
