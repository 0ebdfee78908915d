"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Check

CHECKS = (
    Check(
        name="parameters",
        words="[ROBOT] FILE ...",
        help="hold parameter files of nodes against a robot: who publishes which edge, frames",
        exits="0 at most warnings, 1 errors",
        options="command:options",
        run="command:run",
        old=("--parameters", "--controllers", "--launch", "--remap", "--namespace", "--distribution"),
    ),
)
