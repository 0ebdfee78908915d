"""Create a new description from a template."""

import json
import os
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.formats import schema_text
from rosorin_compile.output.atomic_files import lock, staging_folder
from rosorin_compile.request import FilePath
from rosorin_compile.source.diagnostics import RequestError, UnknownName
from rosorin_compile.source.load import plain_scalar
from rosorin_compile.source.project import DESCRIPTIONS, ROOT_FILE, Description, data_folder


class Template(NamedTuple):
    """A template for a new description: ``what`` describes the robot, ``files`` are paths in the template folder."""

    what: str
    files: tuple[str, ...]


_ARM = ("arm/arm.yaml", "arm/gripper.yaml")
_ON_WHEELS = ("base", "sensors", "control", "collisions")
TEMPLATES = {
    "base": Template("a small mobile base with a lidar, which drives", ("base/robot.yaml",)),
    "arm": Template("an arm of five joints with a gripper", ("arm/robot.yaml", *_ARM, "arm/collisions.yaml")),
    "mobile_manipulator": Template(
        "a base that drives, with an arm, a gripper, a lidar, a camera and an IMU",
        ("mobile_manipulator/robot.yaml", *_ARM, *(f"mobile_manipulator/{name}.yaml" for name in _ON_WHEELS)),
    ),
    "sensor_rig": Template("sensors on a plate: a lidar, two cameras, an IMU, GNSS", ("sensor_rig/robot.yaml",)),
}
DEFAULT = "base"
START = "start"  # folder of the template files in the package data
PLACEHOLDER = "NAME"
_MAX_NAME = 60


@dataclass(frozen=True)
class NewRobot:
    """The result of ``init``: the new description, and the JSON schema for editors.

    ``schema_outdated`` is True if the project already has a different version of the schema, which is not replaced.
    """

    description: Path
    template: str
    schema: Path
    schema_written: bool
    schema_outdated: bool


def check_free(name: str, project: Path) -> None:
    """Raise RequestError if ``name`` is not a valid robot name, or is already used in the project."""
    help = "use letters, digits and underscores, and begin with a letter: my_robot"
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", name):
        raise RequestError(f'"{name}" cannot be the name of a robot; {help}')
    if len(name) > _MAX_NAME:
        raise RequestError(f"the name of a robot has at most {_MAX_NAME} letters")
    if not isinstance(plain_scalar(name), str):
        raise RequestError(f'"{name}" means something else in YAML; {help}')
    target = project / DESCRIPTIONS / name
    if os.path.lexists(target):
        raise RequestError(f"{target} is there already; nothing is overwritten, take another name")


def texts_of(template: str, name: str) -> dict[str, str]:
    """Return the text of each template file by file name; ``PLACEHOLDER`` is replaced with the robot name."""
    folder = data_folder("templates") / START
    paths = [folder / file for file in TEMPLATES[template].files]
    return {path.name: path.read_text("utf-8").replace(PLACEHOLDER, name) for path in paths}


def init(name: str, template: str = "base", project: FilePath = ".") -> NewRobot:
    """Write a new description from a template, and the schema for editors.

    Args:
        name: The name of the robot: letters, digits and underscores.
        template: ``"base"``, ``"arm"``, ``"mobile_manipulator"`` or ``"sensor_rig"``.
        project: The folder that contains ``descriptions/``.

    Raises:
        OSError: The folder cannot be written.

    Example:
        >>> import rosorin_compile, tempfile
        >>> new = rosorin_compile.init("my_robot", "arm", project=tempfile.mkdtemp())
        >>> new.description.name, new.schema_written
        ('robot.yaml', True)
    """
    if template not in TEMPLATES:
        raise UnknownName("template", template, TEMPLATES)
    check_free(name, Path(project))
    folder = Path(project) / DESCRIPTIONS
    target = folder / name
    texts = texts_of(template, name)
    folder.mkdir(parents=True, exist_ok=True)
    schema, data = folder / Description.SCHEMA, schema_text("authoring")
    with lock(folder, tidy=True), staging_folder(folder) as stage:
        (stage / name).mkdir()
        for file, text in texts.items():
            (stage / name / file).write_text(text, "utf-8", newline="\n")
        is_new, is_outdated = not os.path.lexists(schema), False
        if is_new:
            schema.parent.mkdir(exist_ok=True)
            (stage / schema.name).write_text(data, "utf-8", newline="\n")
            (stage / schema.name).rename(schema)
        else:
            is_outdated = not _is_same_schema(schema.read_bytes(), data)
        (stage / name).rename(target)
    return NewRobot(target / ROOT_FILE, template, schema, is_new, is_outdated)


def _is_same_schema(committed: bytes, text: str) -> bool:
    """Return True if the committed JSON schema equals ``text``, apart from xacro macros that were added."""
    with suppress(ValueError, KeyError, TypeError, AttributeError):
        schema = json.loads(committed)
        schema["properties"]["include"]["items"].pop("allOf", None)
        return bool(schema == json.loads(text))
    return False
