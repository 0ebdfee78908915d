"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="verify",
        group="deploy and verify",
        words="[ROBOT] SOURCE",
        help="compare a recording of the robot with its description",
        exits="0 it matches, 1 it does not match or cannot be read",
        options="command:options",
        run="command:run",
        order=30,
    ),
)
