"""rosorin-compile init: start a new robot, which compiles as it is and has the editors' schema beside it."""

from __future__ import annotations

import argparse
import os
import sys
from contextlib import suppress
from pathlib import Path

from ..output import cleared
from ..output.staging import staged
from ..project import DESCRIPTIONS, ROOT_FILE, data_folder
from ..startup.records import NamedTuple
from .usage import FINE, PROBLEMS, WrongUsage


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes."""
    command.add_argument("name", metavar="NAME", help="name of the robot: letters, digits, underscores")
    command.add_argument(
        "--folder", default=".", metavar="FOLDER", help="the project, which has or gets descriptions/; default: ."
    )


def run(options: argparse.Namespace) -> int:
    """Write a new description, and say what to do next."""
    try:
        started = start(options.name, Path(options.folder))
    except CannotStart as problem:
        raise WrongUsage(str(problem)) from None
    except OSError as problem:
        sys.stderr.write(f"cannot write in {options.folder}: {problem.strerror or problem}\n")
        return PROBLEMS
    print(f"{started.description} written: a small mobile base with a lidar")
    if started.schema_written:
        print(f"{started.schema} written: completion and help in editors")
    elif started.outdated:
        print(f"{started.schema} is of another version; to renew it: rosorin-compile schema > {started.schema}")
    where = "" if Path(options.folder).samefile(".") else f"cd {options.folder} && "
    print(f"next: {where}rosorin-compile all {options.name}")
    return FINE


STARTER = "starter.yaml"  # in the data package of templates
PLACEHOLDER = "NAME"
SCHEMA = Path(".schema", "rosorin-compile.schema.json")  # in the folder of descriptions, as the modeline says
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
    from ..frontend.load import plain_scalar

    help = "use letters, digits and underscores, and begin with a letter: my_robot"
    if not name.isascii() or not name.replace("_", "").replace("-", "").isalnum() or not name[0].isalpha():
        raise CannotStart(f'"{name}" cannot be the name of a robot; {help}')
    if len(name) > _MAX_NAME:
        raise CannotStart(f"the name of a robot has at most {_MAX_NAME} letters")
    if not isinstance(plain_scalar(name), str):
        raise CannotStart(f'"{name}" means something else in YAML; {help}')


def start(name: str, project: Path) -> Started:
    """Write a new description of that name into a project, whole or not at all; nothing is overwritten.

    Raises CannotStart, and OSError if the disk refuses.
    """
    check_name(name)
    folder = project / DESCRIPTIONS
    target = folder / name
    if os.path.lexists(target):
        raise CannotStart(f"{target} is there already; nothing is overwritten, take another name")
    text = (data_folder("templates") / STARTER).read_text("utf-8").replace(PLACEHOLDER, name)
    folder.mkdir(parents=True, exist_ok=True)
    with cleared(folder), staged(folder) as stage:
        (stage / name).mkdir()
        (stage / name / ROOT_FILE).write_text(text, "utf-8")
        written, outdated = _give_schema(folder, stage)
        (stage / name).rename(target)
    return Started(target / ROOT_FILE, folder / SCHEMA, written, outdated)


def _give_schema(folder: Path, stage: Path) -> tuple[bool, bool]:
    """Write the schema for editors unless there is one; say whether it was written, or is of another version."""
    data = (data_folder("schemas") / "authoring.schema.json").read_bytes()
    target = folder / SCHEMA
    with suppress(FileNotFoundError):
        return False, target.read_bytes() != data
    target.parent.mkdir(exist_ok=True)
    new = stage / SCHEMA.name
    new.write_bytes(data)
    new.rename(target)
    return True, False
