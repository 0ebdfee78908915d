"""What this package brings to the command line, and does for others."""

from __future__ import annotations

from rosorin_compile import Check, Command

COMMANDS = (
    Command(
        name="collisions",
        group="describe and compile",
        words="[ROBOT]",
        help="compute the pairs of links that MoveIt does not need to check",
        exits="0 written or unchanged, 1 errors",
        options="collisions.command:options",
        run="collisions.command:run",
        order=70,
    ),
    Command(
        name="simulate",
        group="inspect",
        words="[ROBOT]",
        help="test the robot in MuJoCo: at rest, in its poses and driving",
        exits="0 within the limits, 1 errors or a result beyond a limit",
        options="simulate.command:options",
        run="simulate.command:run",
        order=60,
    ),
)
CHECKS = (
    Check(
        name="physics",
        words="[ROBOT ...]",
        help="find links that collide with each other at rest or while joints move, with MuJoCo",
        exits="0 no errors, 1 errors",
        options="physics.command:options",
        run="physics.command:run",
    ),
)
SERVICES = {"links inside each other": "physics.touching:Touching"}
