"""rosorin-compile schema: print a JSON Schema: of descriptions, for editors, or of a format for programs."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING

from rosorin_compile.formats import FORMATS
from rosorin_compile.source import files
from rosorin_compile.source.console import give
from rosorin_compile.source.diagnostics import did_you_mean
from rosorin_compile.source.project import data_folder

from .answer import GENERAL, give_result
from .usage import FINE, WrongUsage

if TYPE_CHECKING:
    from .parser import Parser

# The schemas that are no format's, and whose form they describe.
_NAMES = {
    "authoring": "a description as written, with expressions, parts and loops (default)",
    "description": "a description after includes, arguments and expressions are evaluated",
    "robot_diff": "the result of diff --format json",
    "recording": "the result of verify --format json",
}
_ENDING = ".schema.json"


def options(command: Parser) -> None:
    """Add what this command takes."""
    known = names()
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


def names() -> dict[str, str]:
    """Return the schemas, and whose form they describe: those of formats are named by their records."""
    formats = {one.proving.schema: f"the artifact {one.name}" for one in FORMATS.values() if one.proving.schema}
    return {**_NAMES, **formats, **_of_answers()}


def _of_answers() -> dict[str, str]:
    """Return the schemas of what commands answer, by their names."""
    files = [file.name for file in sorted(data_folder("schemas").glob(f"{GENERAL}*"))]
    commands = {file.removesuffix(_ENDING): file.removesuffix(_ENDING).split("_")[1:] for file in files}
    return {name: f"the result of {' '.join(words) or 'any command'} --format json" for name, words in commands.items()}


def text_of(name: str) -> str:
    """Return a schema; those of descriptions with the sections that plug-ins bring."""
    from rosorin_compile.language.schema import schema
    from rosorin_compile.language.section_registry import plugged_sections

    if name == "description":
        return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"
    if name != "authoring" or not plugged_sections():
        return files.read_text(data_folder("schemas") / f"{name}{_ENDING}")
    from rosorin_compile.language.language import Language

    return json.dumps(Language.of(FORMATS.values()).authoring(), indent=1, ensure_ascii=False) + "\n"


def run(options: argparse.Namespace) -> int:
    """Print a schema to the letter, or list them."""
    known = names()
    if options.list:
        width = max(map(len, known))
        rows = [{"name": name, "what": what} for name, what in known.items()]
        give_result(options, rows, lambda: "\n".join(f"{name:<{width}}  {what}" for name, what in known.items()))
        return FINE
    if options.format != "text":
        raise WrongUsage("--format goes with --list: a schema is printed as it is")
    if options.name not in known:
        raise WrongUsage(f'there is no schema "{options.name}"; {did_you_mean(options.name, known)}')
    give(text_of(options.name))
    return FINE
