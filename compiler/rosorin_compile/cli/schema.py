"""rosorin-compile schema: print a JSON Schema: of descriptions, for editors, or of a format for programs."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosorin_compile.formats.schemas import schema_names, schema_text
from rosorin_compile.source.console import give
from rosorin_compile.source.diagnostics import did_you_mean

from .answer import give_result
from .usage import FINE, WrongUsage

if TYPE_CHECKING:
    from .parser import Parser


def options(command: Parser) -> None:
    """Add what this command takes."""
    known = schema_names()
    width = max(map(len, known))
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.epilog = "schemas:\n" + "\n".join(f"  {name:<{width}}  {what}" for name, what in known.items())
    command.add_argument(
        "name",
        nargs="?",
        default="authoring",
        metavar="NAME",
        completes="SCHEMA",
        help="name of a schema, see below; default: authoring",
    )
    command.add_argument("--list", action="store_true", help="list the schemas")
    command.add_result_form()


def run(options: argparse.Namespace) -> int:
    """Print a schema to the letter, or list them."""
    known = schema_names()
    if options.list:
        width = max(map(len, known))
        rows = [{"name": name, "what": what} for name, what in known.items()]
        give_result(options, rows, lambda: "\n".join(f"{name:<{width}}  {what}" for name, what in known.items()))
        return FINE
    if options.format != "text":
        raise WrongUsage("--format goes with --list: a schema is printed as it is")
    if options.name not in known:
        raise WrongUsage(f'there is no schema "{options.name}"; {did_you_mean(options.name, known)}')
    give(schema_text(options.name))
    return FINE
