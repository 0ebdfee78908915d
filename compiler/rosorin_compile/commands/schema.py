"""rosorin-compile schema: print the JSON Schema of descriptions, for editors."""

from __future__ import annotations

import argparse
import sys

from ..data import data_folder
from .shared import FINE


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes: nothing."""


def run(_options: argparse.Namespace) -> int:
    """Print the schema that descriptions have while they are written: with expressions, parts and loops."""
    sys.stdout.write((data_folder("schemas") / "authoring.schema.json").read_text("utf-8"))
    return FINE
