"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="extract",
        group="import and compare",
        words="",
        help="compute boxes and height maps from meshes",
        exits="0 written, 1 errors",
        options="command:options",
        run="command:run",
        order=20,
    ),
)
