"""rosorin-compile schema: print a JSON Schema: of descriptions, for editors, or of a format for programs."""

from __future__ import annotations

import argparse

from .. import world
from ..diagnostics import did_you_mean
from ..diagnostics.console import give
from ..formats import FORMATS
from ..project import data_folder
from .usage import FINE, WrongUsage

# The schemas that are no format's, and whose form they describe.
_NAMES = {
    "authoring": "a description as people write it, with expressions, parts and loops: for editors (default)",
    "description": "a description after includes, arguments and expressions",
    "robot_diff": "what diff --json prints",
    "recording": "what verify --json prints",
}


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes."""
    known = names()
    width = max(map(len, known))
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.epilog = "NAME is one of:\n" + "\n".join(f"  {name:<{width}}  {what}" for name, what in known.items())
    command.add_argument(
        "name", nargs="?", default="authoring", metavar="NAME", completes="SCHEMA", help="see below; default: authoring"
    )


def names() -> dict[str, str]:
    """Return the schemas, and whose form they describe: those of formats are named by their records."""
    return {**_NAMES, **{one.schema: f"the artifact {one.name}" for one in FORMATS.values() if one.schema}}


def run(options: argparse.Namespace) -> int:
    """Print a schema to the letter."""
    known = names()
    if options.name not in known:
        raise WrongUsage(f'there is no schema "{options.name}"; {did_you_mean(options.name, known)}')
    give(world.text(data_folder("schemas") / f"{options.name}.schema.json"))
    return FINE
