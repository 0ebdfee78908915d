"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="import",
        group="bring in",
        words="SOURCE",
        help="make a description of a URDF, a xacro, an SDF or an MJCF",
        exits="0 written, 1 the source has errors",
        options="command:options",
        run="command:run",
        order=10,
    ),
)
