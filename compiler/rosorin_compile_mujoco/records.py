"""What this package brings to the command line, and does for others."""

from __future__ import annotations

from rosorin_compile import Check, Command

COMMANDS = (
    Command(
        name="collisions",
        group="describe and compile",
        words="[ROBOT]",
        help="compute which links MoveIt need not check against each other",
        exits="0 written or unchanged, 1 errors",
        options="collisions.command:options",
        run="collisions.command:run",
        order=70,
    ),
    Command(
        name="simulate",
        group="ask",
        words="[ROBOT]",
        help="say how the robot behaves in MuJoCo: resting, in its poses, driving",
        exits="0 within the limits, 1 errors, or something beyond a limit",
        options="simulate.command:options",
        run="simulate.command:run",
        order=60,
    ),
)
CHECKS = (
    Check(
        name="physics",
        words="[ROBOT ...]",
        help="look for what cannot be, with MuJoCo: parts inside each other, joints that lead there",
        exits="0 at most warnings, 1 errors",
        options="physics.command:options",
        run="physics.command:run",
    ),
)
SERVICES = {"links inside each other": "physics.touching:Touching"}
