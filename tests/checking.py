"""What the rules say of a description that is made in Python."""

from __future__ import annotations

from typing import Any

import yaml

from rosorin_compile.build import build
from rosorin_compile.diagnostic import NOTE, Diagnostic, Source, arrange, has_errors
from rosorin_compile.emit import FORMATS
from rosorin_compile.load import parse_yaml
from rosorin_compile.rules import check
from rosorin_compile.validate import validate


def found(description: dict[str, Any]) -> list[Diagnostic]:
    """Return what the rules say of a description of the right shape."""
    tree = parse_yaml(Source("robot.yaml", yaml.safe_dump(description, sort_keys=False)))
    assert not has_errors(validate(tree, FORMATS)), arrange(validate(tree, FORMATS))
    built = build(tree)
    assert built.robot is not None, built.diagnostics
    return check(built.robot, tree, built.places, FORMATS)


def rules(description: dict[str, Any]) -> list[str]:
    return sorted(d.rule for d in found(description) if d.severity != NOTE)


def robot(joints: dict[str, Any], **more: Any) -> dict[str, Any]:
    names = {joint[end] for joint in joints.values() for end in ("parent", "child")}
    return {"robot": "made", "links": {name: {} for name in sorted(names)}, "joints": joints, **more}
