"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="extract",
        group="bring in",
        words="",
        help="take boxes and height maps out of meshes",
        exits="0 taken out, 1 it cannot be",
        options="command:options",
        run="command:run",
        order=20,
    ),
)
