"""rosorin-compile init: start a new robot."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .shared import FINE, PROBLEMS, WrongUsage


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes."""
    command.add_argument("name", metavar="NAME", help="name of the robot: letters, digits, underscores")
    command.add_argument(
        "--folder", default=".", metavar="FOLDER", help="the project, which has or gets descriptions/; default: ."
    )


def run(options: argparse.Namespace) -> int:
    """Write a new description, and say what to do next."""
    from ..starter import CannotStart, start

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
