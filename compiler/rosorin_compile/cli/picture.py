"""rosorin-compile picture: draw a robot to a PNG file, without a browser."""

import re

from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.viewer.picture.draw import picture

from . import command as cli
from .console import PROBLEMS
from .run import Run, refuse_positions


@cli.command("picture", exits="0 drawn, 1 errors or a missing extra")
@cli.robot_argument
@cli.option("-o", "--output FILE", required=True, help="picture to write: FILE.png")
@cli.force_option
@cli.position_options()
@cli.combined(
    cli.option("--from VIEW", "view", default="iso", help="camera: iso, front, side, top or angles (30deg,20deg)"),
    cli.option("--size WxH", default="1280x800", help="size in pixels"),
    cli.flag("--collision", help="show collision shapes of all links; default: of links without visuals"),
    cli.flag("--frames", "published_frames", help="show published frames with their names"),
    cli.repeatable("--frame FRAME", "frames", help="show a frame; repeatable", offers="frame"),
    cli.mode_option("on"),
    cli.option("--theme light|dark", default="light", help="colours of background and floor"),
    cli.flag("--transparent", help="draw only the robot and its shadow, on a transparent background"),
    section="Appearance",
)
@cli.robot_options
def run(options: cli.Options) -> int:
    """Write a picture of a robot."""
    from rosorin_compile.model.servos import NoPulse

    refuse_positions(options.words)
    size = re.fullmatch(r"([0-9]{1,5})[xX]([0-9]{1,5})", options.size)
    if size is None:
        raise RequestError(f'"{options.size}" is not WIDTHxHEIGHT in pixels, such as 1280x800')
    run, description = Run.alone(options)
    picked = options.pick("pose joints pulses modes view collision published_frames frames theme transparent force")
    pixels = (int(size[1]), int(size[2]))
    try:
        result = picture(run.request(description), options.output, **picked, size=pixels)
    except NoPulse as problem:
        run.console.warn(f"rosorin-compile: {problem}")
        return PROBLEMS
    run.console.show(result.diagnostics)
    if not result.drawn:
        run.console.warn(f"{description.name}: no picture was drawn")
        return PROBLEMS
    run.console.say(f"{result.robot}: {result.file}, {result.width} x {result.height}")
    return run.give(result)
