"""static_tf_json: the arguments of the static_transform_publisher nodes as data, for launch files that exist already.

``schemas/static_tf.schema.json`` says what each value is.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Output, Robot
from rosorin_compile.source import files
from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.diagnostics import Diagnostic

from .format import Format, InRos, Proving
from .static_tf import (
    NUMBER_FORMAT,
    ROUNDING,
    Transforms,
    check_numbers,
    read_arguments,
    static_transforms,
    transforms_of,
)
from .unsupported import NODES, PLACES

if TYPE_CHECKING:
    from .templating import Templates


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the static edges of a robot as JSON, in the order of the description. Option: ``number_format``."""
    import json

    transforms, in_modes, diagnostics = static_transforms(robot, [output])
    nodes: list[dict[str, Any]] = []
    for transform in [*transforms, *in_modes]:
        node: dict[str, Any] = {"name": transform.name, "parent": transform.parent, "child": transform.child}
        if transform.source.status == "stand_in":
            node["stand_in"] = transform.described()
        if transform.when:
            node["when"] = transform.when
        node["arguments"] = list(transform.arguments)
        nodes.append(node)
    return json.dumps({"robot": robot.name, "static_transform_publisher": nodes}, indent=2) + "\n", diagnostics


def view(robot: Robot, output: Output) -> Transforms:
    """Return what a list of static transforms is meant to contain."""
    return transforms_of(robot, output, with_conditions=True)


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


_LARGEST = 1_000_000  # bytes


def robot_of(path: Path) -> str:
    """Return the robot that a file was generated for; empty if it is no such file. Raises OSError."""
    if path.stat().st_size > _LARGEST:
        return ""
    try:
        content = json_of(files.read_bytes(path))
    except ValueError:
        return ""
    robot = content.get("robot") if isinstance(content, dict) and "static_transform_publisher" in content else None
    return robot if isinstance(robot, str) else ""


FORMAT = Format(
    name="static_tf_json",
    word="list of static transforms",
    article="a",
    about="the arguments of the static transforms, for launch files of your own",
    rank=50,
    covers=("robot", *PLACES, *NODES),
    options={"number_format": NUMBER_FORMAT},
    check=check_numbers,
    file="static_tf.json",
    endings=(".json",),
    write=write,
    view=view,
    read=read,
    rounding=ROUNDING,
    proving=Proving(
        syntax=json_of,
        schema="static_tf",
    ),
    ros=InRos(
        feeds=(STATIC_TRANSFORM_PUBLISHER,),
        folder="config",
        deploys=True,
        robot_of=robot_of,
    ),
)
