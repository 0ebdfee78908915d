"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="collisions",
        group="describe and compile",
        words="[ROBOT]",
        help="compute which links MoveIt need not check against each other",
        exits="0 written or unchanged, 1 errors",
        options="command:options",
        run="command:run",
        order=70,
    ),
)
