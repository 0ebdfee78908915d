"""rosorin-compile schema: print a JSON Schema: of descriptions, for editors, or of a format for programs."""

import json

from rosorin_compile import api
from rosorin_compile.formats import schema_names, schema_text
from rosorin_compile.source.diagnostics import RequestError, UnknownName

from .command import Options, argument, command, flag
from .console import FINE, give, table


@command("schema", exits="0 printed", sections=lambda: {"Schemas": [*schema_names().items()]})
@argument(
    "name", default="authoring", metavar="[NAME]", help="a schema, see below; default: authoring", offers=("schema",)
)
@flag("--list", help="list the schemas")
@flag("--macros", help="add the macros of the xacro files that robots of this project include, and their parameters")
def run(options: Options) -> int:
    """Print a schema as it is, or list them."""
    names = schema_names()
    if options.list:
        rows = [{"name": name, "what": what} for name, what in names.items()]
        return options.console.give(rows, lambda: "\n".join(table(list(names.items()))))
    if options.format != "text":
        raise RequestError("--format goes with --list: a schema is printed as it is")
    if options.name not in names:
        raise UnknownName("schema", options.name, names)
    if options.macros:
        give(json.dumps(api.schema(options.name, macros=True), indent=1, ensure_ascii=False) + "\n")
    else:
        give(schema_text(options.name))
    return FINE
