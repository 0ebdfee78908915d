"""The command and the function that this package adds to the tool."""

from __future__ import annotations

from rosorin_compile import Command

SERVICES = {"many variants": "library:sweep"}

COMMANDS = (
    Command(
        name="sweep",
        group="describe and compile",
        words="[ROBOT] --over LIST -o FOLDER",
        help="compile many variants of one robot, each to a separate folder",
        exits="0 all variants written or unchanged, 1 a variant has errors or cannot be written",
        options="command:options",
        run="command:run",
        order=60,
    ),
)
