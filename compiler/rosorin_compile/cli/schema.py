"""rosorin-compile schema: print a JSON Schema: of descriptions, for editors, or of a format for programs."""

from __future__ import annotations

from rosorin_compile.cli.console import give
from rosorin_compile.formats import schema_names, schema_text
from rosorin_compile.source.diagnostics import RequestError, did_you_mean

from . import complete
from .answer import FINE, give_result, table
from .command import Options, argument, command, flag


@command("schema", exits="0 printed", sections=lambda: {"Schemas": [*schema_names().items()]})
@argument(
    "name",
    default="authoring",
    metavar="[NAME]",
    help="name of a schema, see below; default: authoring",
    shell_complete=complete.of("schema"),
)
@flag("--list", help="list the schemas")
def run(options: Options) -> int:
    """Print a schema as it is, or list them."""
    names = schema_names()
    if options.list:
        rows = [{"name": name, "what": what} for name, what in names.items()]
        return give_result(options, rows, lambda: "\n".join(table(list(names.items()))))
    if options.format != "text":
        raise RequestError("--format goes with --list: a schema is printed as it is")
    if options.name not in names:
        raise RequestError(f'there is no schema "{options.name}"; {did_you_mean(options.name, names)}')
    give(schema_text(options.name))
    return FINE
