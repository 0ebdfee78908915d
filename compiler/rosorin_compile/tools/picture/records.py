"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="picture",
        group="ask",
        words="[ROBOT] -o FILE",
        help="draw the robot into a PNG or SVG, without a browser",
        exits="0 drawn, 1 errors, or what draws is not installed",
        options="command:options",
        run="command:run",
        order=50,
    ),
)
