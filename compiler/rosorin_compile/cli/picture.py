"""rosorin-compile picture: draw a robot to a PNG file, without a browser."""

from __future__ import annotations

import re

from rosorin_compile.source.diagnostics import RequestError

from . import command as cli
from .answer import PROBLEMS
from .run import Run, joint_options

_APPEARANCE = "Appearance"


@cli.command("picture", exits="0 drawn, 1 errors or a missing extra")
@cli.robot_argument
@cli.path_option("-o", "--output", required=True, metavar="FILE", help="picture to write: FILE.png")
@cli.force_option
@cli.position_options()
@cli.option(
    "--from",
    "view",
    default="iso",
    metavar="VIEW",
    help="camera: iso, front, side, top or AZIMUTH,ELEVATION (30deg,20deg); default: iso",
    section=_APPEARANCE,
)
@cli.option("--size", default="1280x800", metavar="WxH", help="size in pixels; default: 1280x800", section=_APPEARANCE)
@cli.flag(
    "--collision", help="show collision shapes of all links; default: of links without visuals", section=_APPEARANCE
)
@cli.flag("--frames", help="show published frames with their names", section=_APPEARANCE)
@cli.texts("--frame", "chosen", metavar="FRAME", help="show a frame; repeatable", section=_APPEARANCE, offers="frame")
@cli.mode_option("on", section=_APPEARANCE)
@cli.choice(
    "--theme",
    ("light", "dark"),
    default="light",
    help="colours of background and floor; default: light",
    section=_APPEARANCE,
)
@cli.flag("--transparent", help="draw only the robot and its shadow, on a transparent background", section=_APPEARANCE)
@cli.robot_options
def run(options: cli.Options) -> int:
    """Write a picture of a robot."""
    from rosorin_compile import api
    from rosorin_compile.model.servos import NoPulse

    state = joint_options(options)
    size = re.fullmatch(r"([0-9]{1,5})[xX]([0-9]{1,5})", options.size)
    if size is None:
        raise RequestError(f'"{options.size}" is not WIDTHxHEIGHT in pixels, such as 1280x800')
    run, description = Run.alone(options, "a picture shows one robot", "rosorin-compile picture ROBOT -o FILE")
    console = run.console
    try:
        result = api.picture(
            run.request(description),
            options.output,
            **state,
            **options.pick("view collision theme transparent force"),
            size=(int(size[1]), int(size[2])),
            published_frames=options.frames,
            frames=options.chosen,
        )
    except NoPulse as problem:
        console.warn(f"rosorin-compile: {problem}")
        return PROBLEMS
    console.show(result.diagnostics)
    if not result.drawn:
        console.warn(f"{description.name}: no picture was drawn")
        return PROBLEMS
    console.say(f"{result.robot}: {result.file}, {result.width} x {result.height}")
    return run.give(result)
