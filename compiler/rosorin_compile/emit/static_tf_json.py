"""static_tf_json: the arguments of the static_transform_publisher nodes as data, for launch files that exist already.

``schemas/static_tf.schema.json`` says what each value is.
"""

from __future__ import annotations

import json
from typing import Any

from ..bounded import json_of
from ..diagnostic import Diagnostic
from ..model import Output, Robot
from ..templating import Templates
from . import Facts
from .static_tf import describe, facts_of, numbers_of, static_in_modes, static_transforms


def emit(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the static edges of a robot as JSON, in the order of the description. Option: ``number_format``."""
    numbers = numbers_of(output)
    transforms, diagnostics = static_transforms(robot, numbers)
    nodes: list[dict[str, Any]] = []
    for transform in [*transforms, *static_in_modes(robot, numbers)]:
        node: dict[str, Any] = {"name": transform.name, "parent": transform.parent, "child": transform.child}
        if transform.source.status == "stand_in":
            node["stand_in"] = describe(transform.source)
        if transform.when:
            node["when"] = transform.when
        node["arguments"] = list(transform.arguments)
        nodes.append(node)
    return json.dumps({"robot": robot.name, "static_transform_publisher": nodes}, indent=2) + "\n", diagnostics


def read(text: str) -> Facts:
    """Return what the arguments say. Raises ValueError if the text is not such a file."""
    facts: Facts = {}
    try:
        for node in json_of(text)["static_transform_publisher"]:
            facts |= facts_of(node["name"], node["arguments"])
    except (KeyError, TypeError) as problem:
        raise ValueError(f"not a list of static transforms: {problem!r}") from None
    return facts
