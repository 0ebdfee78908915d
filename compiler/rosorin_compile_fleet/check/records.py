"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Check

CHECKS = (
    Check(
        name="fleet",
        words="FILE",
        help="hold the robots of a sweep against each other: what differs, likely typos, stand-ins",
        options="command:options",
        run="command:run",
    ),
)
