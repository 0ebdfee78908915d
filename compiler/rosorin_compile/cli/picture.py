"""rosorin-compile picture: draw a robot to a PNG file, without a browser."""

from __future__ import annotations

import re

import click

from . import complete
from .answer import give_result
from .command import Options, command, option
from .options import PATH, mode_option, position_options, robot_argument, robot_options
from .run import Run, assignments, mode_states
from .usage import FINE, PROBLEMS, WrongUsage

_USAGE = "rosorin-compile picture ROBOT -o FILE"
_SIZE = re.compile(r"([0-9]{1,5})[xX]([0-9]{1,5})")


_APPEARANCE = "Appearance"


@command("picture", exits="0 drawn, 1 errors or a missing extra")
@robot_argument
@option("-o", "--output", type=PATH, required=True, metavar="FILE", help="picture to write: FILE.png")
@option("--force", is_flag=True, help="replace a file that this command did not write")
@position_options()
@option(
    "--from",
    "view",
    default="iso",
    metavar="VIEW",
    help="camera: iso, front, side, top or AZIMUTH,ELEVATION (30deg,20deg); default: iso",
    section=_APPEARANCE,
)
@option("--size", default="1280x800", metavar="WxH", help="size in pixels; default: 1280x800", section=_APPEARANCE)
@option(
    "--collision",
    is_flag=True,
    help="show collision shapes of all links; default: of links without visuals",
    section=_APPEARANCE,
)
@option("--frames", is_flag=True, help="show published frames with their names", section=_APPEARANCE)
@option(
    "--frame",
    "chosen",
    multiple=True,
    metavar="FRAME",
    help="show a frame; repeatable",
    section=_APPEARANCE,
    shell_complete=complete.of("frame"),
)
@mode_option("on", section=_APPEARANCE)
@option(
    "--theme",
    type=click.Choice(("light", "dark")),
    default="light",
    help="colours of background and floor; default: light",
    section=_APPEARANCE,
)
@option(
    "--transparent",
    is_flag=True,
    help="draw only the robot and its shadow, on a transparent background",
    section=_APPEARANCE,
)
@robot_options
def run(options: Options) -> int:
    """Write a picture of a robot."""
    from rosorin_compile import api
    from rosorin_compile.model.servos import NoPulse

    value = next((word for word in options.words if "=" in word and ":=" not in word), None)
    if value is not None:
        raise WrongUsage(f"write --joint {value} for a position, --pulse {value} for a pulse")
    size = _SIZE.fullmatch(options.size)
    if size is None:
        raise WrongUsage(f'"{options.size}" is not WIDTHxHEIGHT in pixels, such as 1280x800')
    run, description = Run.alone(options, "a picture shows one robot", _USAGE)
    console = run.console
    try:
        made = api.picture(
            run.request(description),
            options.output,
            pose=options.pose,
            joints=assignments(options.joints, "JOINT=POSITION"),
            pulses=assignments(options.pulses, "JOINT=PULSE"),
            view=options.view,
            size=(int(size[1]), int(size[2])),
            collision=options.collision,
            published_frames=options.frames,
            frames=options.chosen,
            modes=mode_states(options.modes),
            theme=options.theme,
            transparent=options.transparent,
            force=options.force,
        )
    except NoPulse as problem:
        console.warn(f"rosorin-compile: {problem}")
        return PROBLEMS
    console.show(made.diagnostics)
    if not made.drawn:
        console.warn(f"{description.name}: no picture was drawn")
        return PROBLEMS
    console.say(f"{made.robot}: {made.file}, {made.width} x {made.height}")
    give_result(options, made, str)
    return FINE
