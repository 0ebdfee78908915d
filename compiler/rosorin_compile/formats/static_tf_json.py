"""static_tf_json: the arguments of the static_transform_publisher nodes as data, for launch files that exist already.

``schemas/static_tf.schema.json`` says what each value is.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import Output, Robot
from rosorin_compile.source import files
from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.diagnostics import Diagnostic

from .static_tf import FORMAT as LAUNCH_FILE
from .static_tf import Transforms, describe, read_arguments, static_transforms

if TYPE_CHECKING:
    from .templating import Templates


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the static edges of a robot as JSON, in the order of the description. Option: ``number_format``."""
    import json

    always, in_modes, diagnostics = static_transforms(robot, [output])
    nodes: list[dict[str, Any]] = []
    for transform in [*always, *in_modes]:
        node: dict[str, Any] = {"name": transform.name, "parent": transform.parent, "child": transform.child}
        if transform.source.status == "stand_in":
            node["stand_in"] = describe(transform.source)
        if transform.when:
            node["when"] = transform.when
        node["arguments"] = list(transform.arguments)
        nodes.append(node)
    return json.dumps({"robot": robot.name, "static_transform_publisher": nodes}, indent=2) + "\n", diagnostics


def view(robot: Robot, output: Output) -> Transforms:
    """Return what a list of static transforms must contain."""
    always, in_modes, _ = static_transforms(robot, [output])
    return Transforms(tuple(one.edge for one in (*always, *in_modes)))


def read(text: str) -> Transforms:
    """Return the transforms of a list. Raises ValueError if the text is not such a file."""
    edges = []
    try:
        for node in json_of(text)["static_transform_publisher"]:
            edge = replace(read_arguments(node["name"], node["arguments"]), when=str(node.get("when", "")))
            if (node["parent"], node["child"]) != (edge.parent, edge.child):
                ends = f"from {node['parent']} to {node['child']}"
                raise ValueError(f"{node['name']} goes {ends}, its arguments from {edge.parent} to {edge.child}")
            edges.append(edge)
    except (KeyError, TypeError, AttributeError) as problem:
        raise ValueError(f"not a list of static transforms: {problem!r}") from None
    return Transforms(tuple(edges))


def robot_of(path: Path) -> str:
    """Return the robot that a file was generated for; empty if it is no such file. Raises OSError."""
    try:
        content = json_of(files.read_bytes(path, 1_000_000))
    except ValueError:
        return ""
    robot = content.get("robot") if isinstance(content, dict) and "static_transform_publisher" in content else None
    return robot if isinstance(robot, str) else ""


FORMAT = replace(
    LAUNCH_FILE,
    name="static_tf_json",
    word="list of static transforms",
    about="the arguments of the static transforms, for launch files of your own",
    rank=50,
    file="static_tf.json",
    endings=(".json",),
    write=write,
    view=view,
    read=read,
    located=False,
    syntax=json_of,
    schema="static_tf",
    folder="config",
    robot_of=robot_of,
)
