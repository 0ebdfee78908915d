"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="frames",
        group="ask",
        words="[ROBOT]",
        help="show the tree of frames with who publishes them",
        exits="0 shown or written, 1 the robot has errors",
        options="frames:options",
        run="frames:run",
        order=30,
    ),
    Command(
        name="view",
        group="ask",
        words="[ROBOT]",
        help="show the robot in the browser, and follow its files",
        exits="0 it was ended by Ctrl-C or SIGTERM, or the page is written; with --html also 1 errors",
        options="view.command:options",
        run="view.command:run",
        order=40,
    ),
    Command(
        name="picture",
        group="ask",
        words="[ROBOT] -o FILE",
        help="draw the robot into a PNG, without a browser",
        exits="0 drawn, 1 errors, or what draws is not installed",
        options="picture.command:options",
        run="picture.command:run",
        order=50,
    ),
)
SERVICES = {"pictures of changes": "view.changed:Pictures"}
