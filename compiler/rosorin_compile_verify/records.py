"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="verify",
        group="run on the robot",
        words="[ROBOT] SOURCE",
        help="hold a recording of the robot against its description",
        exits="0 the robot that is described, 1 another one, or nothing that can be read",
        options="command:options",
        run="command:run",
        order=30,
    ),
)
