"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="simulate",
        group="ask",
        words="[ROBOT]",
        help="say how the robot behaves in MuJoCo: resting, in its poses, driving",
        exits="0 within the limits, 1 errors, or something beyond a limit",
        options="command:options",
        run="command:run",
        order=60,
    ),
)
