"""The command and the check of the package."""

from rosorin_compile.extend import Check, Command

BALLS = Command(
    name="balls",
    group="inspect",
    words="[ROBOT]",
    help="list the balls of a robot",
    exits="0 listed, 1 the robot has errors",
    options="parcels:options",
    run="parcels:run",
)
PARCEL = Check(
    name="parcel",
    words="[ROBOT ...]",
    help="check that the mass of all balls fits into a parcel",
    options="parcels:check_options",
    run="parcels:check",
)
