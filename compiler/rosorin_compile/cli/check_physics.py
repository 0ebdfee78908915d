"""rosorin-compile check physics: find collisions and impossible masses with MuJoCo and the meshes."""

from rosorin_compile.mujoco.physics.checking import check_physics, require
from rosorin_compile.source.project import Description

from .command import Options, check, check_options, hook_option
from .console import FINE, PROBLEMS
from .run import Run, for_each, severities


@check("physics", exits="0 no errors, 1 errors")
@check_options()
@hook_option()
def run(options: Options) -> int:
    """Check the physics of each robot."""
    require("check physics")
    return for_each(options, _check)


def _check(run: Run, description: Description) -> int:
    result = check_physics(run.request(description))
    run.console.show(result.diagnostics)
    run.console.robots[-1]["looked_at"] = result.looked_at
    if result.looked_at is None:
        return run.no_robot(description)
    run.console.say(f"{description.name}: physics of {result.looked_at}: {severities(result.diagnostics)}")
    return FINE if result.fine else PROBLEMS
