"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="view",
        group="ask",
        words="[ROBOT]",
        help="show the robot in the browser, and follow its files",
        exits="0 it was ended by Ctrl-C or SIGTERM, or the page is written; with --html also 1 errors",
        options="command:options",
        run="command:run",
        order=40,
    ),
)
SERVICES = {"pictures of changes": "changed:Pictures", "the page of a robot": "pages:page_of"}
