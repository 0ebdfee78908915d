"""rosorin-compile init: start a new robot, which compiles as it is and has the editors' schema beside it."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.output import locked, staging_folder
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import error
from rosorin_compile.source.project import DESCRIPTIONS, ROOT_FILE, SCHEMA, data_folder

from .answer import answer_of, give_result
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from .parser import Parser


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_argument("name", metavar="NAME", help="name of the robot: letters, digits and underscores")
    command.add_argument(
        "template",
        nargs="?",
        choices=tuple(TEMPLATES),
        metavar="TEMPLATE",
        help=f"one of {', '.join(TEMPLATES)}; default: prompt in a terminal, else {DEFAULT}",
    )
    command.add_result_form()
    command.add_argument(
        "-o",
        "--output",
        default=".",
        type="path",
        metavar="FOLDER",
        help="folder of the project; default: .",
    )


def run(options: argparse.Namespace) -> int:
    """Write a new description, and say what to do next."""
    for_people = options.format == "text"
    try:
        check_free(options.name, Path(options.output))
        template = options.template or (asked() if for_people else DEFAULT)
        started = start(options.name, Path(options.output), template)
    except CannotStart as problem:
        raise WrongUsage(str(problem)) from None
    except OSError as problem:
        message = f"cannot write in {options.output}: {problem.strerror or problem}"
        if for_people:
            sys.stderr.write(f"{message}\n")
        else:
            console = answer_of(options).console()
            console.show([error("output-folder", message, None, "name another folder")])
        return PROBLEMS
    made = {"description": str(started.description), "template": template, "schema": str(started.schema)}
    made |= {"schema_written": started.schema_written, "schema_outdated": started.outdated}
    give_result(options, made, lambda: "\n".join(_told(options, started, template)))
    return FINE


def _told(options: argparse.Namespace, started: Started, template: str) -> Iterator[str]:
    """Yield what was written, and what to do next, as lines."""
    yield f"{started.description} written: {TEMPLATES[template].what}"
    if started.schema_written:
        yield f"{started.schema} written: completion and help in editors"
    elif started.outdated:
        yield f"{started.schema} is of another version; to renew it: rosorin-compile schema > {started.schema}"
    where = "" if files.same_file(options.output, ".") else f"cd {options.output} && "
    yield f"next: {where}rosorin-compile all {options.name}, and rosorin-compile view {options.name} to see it"


def asked() -> str:
    """Return the template that whoever sits at a terminal wants; without one the default. Raises WrongUsage."""
    if sys.stdin is None or not (sys.stdin.isatty() and sys.stdout.isatty()):
        return DEFAULT
    width = max(map(len, TEMPLATES))
    for name, template in TEMPLATES.items():
        print(f"  {name:{width}}  {template.what}")
    print(f"which one? [{DEFAULT}] ", end="", flush=True)
    answer = sys.stdin.readline().strip() or DEFAULT
    begun = [name for name in TEMPLATES if name.startswith(answer)]
    if len(begun) != 1:
        raise WrongUsage(f'there is no template "{answer}"; take one of {", ".join(TEMPLATES)}')
    return begun[0]


class Template(NamedTuple):
    """A description to start from: what it is, and its files; two templates may share one."""

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
START = "start"  # their folder, in the data package of templates
PLACEHOLDER = "NAME"
_MAX_NAME = 60


class CannotStart(Exception):
    """There will be no new description; the message says why and what would help."""


class Started(NamedTuple):
    """What was written: the description, and the schema if there was none; ``outdated``: there is another version."""

    description: Path
    schema: Path
    schema_written: bool
    outdated: bool


def check_name(name: str) -> None:
    """Raise CannotStart unless a name can be that of a folder, a robot, and its artifacts."""
    from rosorin_compile.source.load import plain_scalar

    help = "use letters, digits and underscores, and begin with a letter: my_robot"
    if not name.isascii() or not name.replace("_", "").replace("-", "").isalnum() or not name[0].isalpha():
        raise CannotStart(f'"{name}" cannot be the name of a robot; {help}')
    if len(name) > _MAX_NAME:
        raise CannotStart(f"the name of a robot has at most {_MAX_NAME} letters")
    if not isinstance(plain_scalar(name), str):
        raise CannotStart(f'"{name}" means something else in YAML; {help}')


def check_free(name: str, project: Path) -> None:
    """Raise CannotStart unless a description of that name can be written into a project."""
    check_name(name)
    target = project / DESCRIPTIONS / name
    if os.path.lexists(target):
        raise CannotStart(f"{target} is there already; nothing is overwritten, take another name")


def texts_of(template: str, name: str) -> dict[str, str]:
    """Return the files of a template, by their names, for a robot of that name."""
    folder = data_folder("templates") / START
    paths = [folder / file for file in TEMPLATES[template].files]
    return {path.name: files.read_text(path).replace(PLACEHOLDER, name) for path in paths}


def start(name: str, project: Path, template: str = DEFAULT) -> Started:
    """Write a new description of that name into a project, whole or not at all; nothing is overwritten.

    Raises CannotStart, and OSError if the disk refuses.
    """
    check_free(name, project)
    folder = project / DESCRIPTIONS
    target = folder / name
    texts = texts_of(template, name)
    folder.mkdir(parents=True, exist_ok=True)
    with locked(folder, tidy=True), staging_folder(folder) as stage:
        (stage / name).mkdir()
        for file, text in texts.items():
            (stage / name / file).write_text(text, "utf-8", newline="\n")
        written, outdated = _give_schema(folder, stage)
        (stage / name).rename(target)
    return Started(target / ROOT_FILE, folder / SCHEMA, written, outdated)


def _give_schema(folder: Path, stage: Path) -> tuple[bool, bool]:
    """Write the schema for editors unless there is one; say whether it was written, or is of another version."""
    from .schema import text_of

    data = text_of("authoring").encode()
    target = folder / SCHEMA
    with suppress(FileNotFoundError):
        return False, files.read_bytes(target) != data
    target.parent.mkdir(exist_ok=True)
    new = stage / SCHEMA.name
    new.write_bytes(data)
    new.rename(target)
    return True, False
