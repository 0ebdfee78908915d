"""rosorin-compile picture: draw a robot to a PNG file, without a browser."""

from __future__ import annotations

import argparse
import re
from typing import TYPE_CHECKING

from .answer import give_result
from .run import Run, assignments, mode_states
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from .parser import Parser

_USAGE = "rosorin-compile picture ROBOT -o FILE"
_SIZE = re.compile(r"([0-9]{1,5})[xX]([0-9]{1,5})")


def options(command: Parser) -> None:
    """Add the options of this command."""
    command.add_robot()
    command.add_argument(
        "-o", "--output", type="path", required=True, metavar="FILE", help="picture to write: FILE.png"
    )
    command.add_argument("--force", action="store_true", help="replace a file that this command did not write")
    state = command.add_argument_group("joint positions (default: zero)")
    state.add_argument("--pose", default="", metavar="POSE", help="named pose of the description")
    for option, dest, form, help in (
        ("--joint", "joints", "JOINT=VALUE", "position, such as 30deg, 5cm or 1,2,30deg; overrides --pose"),
        ("--pulse", "pulses", "JOINT=PULSE", "pulse sent to the servo; overrides --pose"),
    ):
        state.add_argument(option, action="append", default=[], metavar=form, dest=dest, help=help)
    look = command.add_argument_group("appearance")
    look.add_argument(
        "--from",
        dest="view",
        default="iso",
        metavar="VIEW",
        help="camera: iso, front, side, top or AZIMUTH,ELEVATION (30deg,20deg); default: iso",
    )
    look.add_argument("--size", default="1280x800", metavar="WxH", help="size in pixels; default: 1280x800")
    look.add_argument(
        "--collision", action="store_true", help="show collision shapes of all links; default: of links without visuals"
    )
    look.add_argument("--frames", action="store_true", help="show published frames with their names")
    look.add_argument(
        "--frame",
        action="append",
        default=[],
        metavar="FRAME",
        dest="chosen",
        help="show a frame; repeatable",
    )
    command.add_modes("on", look)
    look.add_argument(
        "--theme", choices=("light", "dark"), default="light", help="colours of background and floor; default: light"
    )
    look.add_argument(
        "--transparent", action="store_true", help="draw only the robot and its shadow, on a transparent background"
    )
    command.add_result()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Write a picture of a robot."""
    from rosorin_compile import api
    from rosorin_compile.language.sections.servos.pulses import NoPulse

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
