"""rosorin-compile schema: print a JSON Schema: of descriptions, for editors, or of a format for programs."""

from __future__ import annotations

import argparse
import sys

from ..diagnostics import did_you_mean
from ..project import data_folder
from .shared import FINE, WrongUsage

# The schemas, and whose form they describe.
NAMES = {
    "authoring": "a description as people write it, with expressions, parts and loops: for editors (default)",
    "description": "a description after includes, arguments and expressions",
    "robot_model": "the artifact robot_model",
    "static_tf": "the artifact static_tf_json",
    "robot_diff": "what diff --json prints",
    "recording": "what verify --json prints",
}


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes."""
    width = max(map(len, NAMES))
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.epilog = "NAME is one of:\n" + "\n".join(f"  {name:<{width}}  {what}" for name, what in NAMES.items())
    command.add_argument("name", nargs="?", default="authoring", metavar="NAME", help="see below; default: authoring")


def run(options: argparse.Namespace) -> int:
    """Print a schema to the letter."""
    if options.name not in NAMES:
        raise WrongUsage(f'there is no schema "{options.name}"; {did_you_mean(options.name, NAMES)}')
    sys.stdout.write((data_folder("schemas") / f"{options.name}.schema.json").read_text("utf-8"))
    return FINE
