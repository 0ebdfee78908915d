"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Command

COMMANDS = (
    Command(
        name="import",
        group="import and compare",
        words="SOURCE",
        help="convert a URDF, xacro, SDF or MJCF to a description",
        exits="0 written, 1 the source has errors",
        options="command:options",
        run="command:run",
        order=10,
    ),
)
