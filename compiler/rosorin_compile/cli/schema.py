"""rosorin-compile schema: print a JSON Schema: of descriptions, for editors, or of a format for programs."""

from __future__ import annotations

from rosorin_compile.formats.schemas import schema_names, schema_text
from rosorin_compile.source.console import give
from rosorin_compile.source.diagnostics import did_you_mean

from . import complete
from .answer import give_result
from .command import Options, argument, command, option
from .usage import FINE, WrongUsage


@command("schema", exits="0 printed", sections=lambda: {"Schemas": [*schema_names().items()]})
@argument(
    "name",
    default="authoring",
    metavar="[NAME]",
    help="name of a schema, see below; default: authoring",
    shell_complete=complete.of("schema"),
)
@option("--list", is_flag=True, help="list the schemas")
def run(options: Options) -> int:
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
