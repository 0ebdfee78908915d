"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="frames",
        group="inspect",
        words="[ROBOT]",
        help="show the tree of frames with their publishers",
        exits="0 shown or written, 1 the robot has errors",
        options="frames:options",
        run="frames:run",
        order=30,
    ),
    Command(
        name="view",
        group="inspect",
        words="[ROBOT]",
        help="show the robot in the browser and update it when files change",
        exits="0 stopped with Ctrl-C or SIGTERM, or page written, 1 errors (with --html)",
        options="view.command:options",
        run="view.command:run",
        order=40,
    ),
    Command(
        name="picture",
        group="inspect",
        words="[ROBOT] -o FILE",
        help="draw the robot to a PNG file, without a browser",
        exits="0 drawn, 1 errors or a missing extra",
        options="picture.command:options",
        run="picture.command:run",
        order=50,
    ),
)
SERVICES = {"pictures of changes": "view.changed:Pictures"}
