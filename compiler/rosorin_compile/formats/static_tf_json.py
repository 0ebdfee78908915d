"""static_tf_json: the arguments of the static_transform_publisher nodes as data, for launch files that exist already.

``schemas/static_tf.schema.json`` says what each value is.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Output, Robot
from rosorin_compile.source import files
from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.diagnostics import Diagnostic

from .format import Facts, Format, InRos, Proving
from .static_tf import NUMBER_FORMAT, check_numbers, frames, node_facts, static_transforms
from .unsupported import NODES, PLACES

if TYPE_CHECKING:
    from collections.abc import Mapping

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


def read(text: str) -> Facts:
    """Return what the arguments say. Raises ValueError if the text is not such a file."""
    facts: Facts = {}
    try:
        for node in json_of(text)["static_transform_publisher"]:
            said = node_facts(node["name"], node["arguments"])
            _same_ends(node, said)
            facts |= said
    except (KeyError, TypeError) as problem:
        raise ValueError(f"not a list of static transforms: {problem!r}") from None
    return facts


def _same_ends(node: Mapping[str, Any], said: Facts) -> None:
    """Raise ValueError where the frames of an entry are not those of its arguments."""
    ((child, parent),) = ((fact.name, value.value) for fact, value in said.items() if fact.quantity == "parent")
    if (node["parent"], node["child"]) != (parent, child):
        ends = f"from {node['parent']} to {node['child']}"
        raise ValueError(f"{node['name']} goes {ends}, its arguments from {parent} to {child}")


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
    facts=read,
    proving=Proving(
        syntax=json_of,
        schema="static_tf",
        frames=frames,
    ),
    ros=InRos(
        feeds=(STATIC_TRANSFORM_PUBLISHER,),
        folder="config",
        deploys=True,
        robot_of=robot_of,
    ),
)
