"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Check

SERVICES = {"links inside each other": "touching:Touching"}
CHECKS = (
    Check(
        name="physics",
        words="[ROBOT ...]",
        help="look for what cannot be, with MuJoCo: parts inside each other, joints that lead there",
        exits="0 at most warnings, 1 errors",
        options="command:options",
        run="command:run",
        old=("--physics",),
        each="command:after",
    ),
)
