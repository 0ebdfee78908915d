"""rosorin-compile view and picture: show a robot in the browser, or write it as one page or as a PNG file."""

import re
from typing import Any

import click

from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.viewer.robot_view import RobotView, view
from rosorin_compile.viewer.server import LOOPBACK, LiveRobot, create_server

from . import command as cli
from .console import FINE, PROBLEMS
from .run import Run


@cli.command("view", exits="0 stopped with Ctrl-C or SIGTERM, or page written, 1 errors (with --html)")
@cli.robot_argument
@cli.page_options("write the page to a file instead of serving it")
@cli.flag("--no-open", help="do not open a browser")
@cli.option("--port NUMBER", type=click.IntRange(0, 65535), help="port of the server; default: 8642, or a free one")
@cli.option("--host ADDRESS", default=LOOPBACK, help="address, for access from other machines; default: this one only")
@cli.robot_options
def run_view(run: Run) -> int:
    """Show a robot in the browser, or write it as one page."""
    description = run.only_robot()
    console, request = run.console, run.request(description)
    if run.html is not None:
        page = view(request, run.html, meshes=not run.no_meshes, max_megabytes=run.max_megabytes)
        console.show(page.diagnostics)
        if not page.written:
            return PROBLEMS
        if page.left_out:
            console.warn(f"not shown: {page.left_out}")
        console.say(f"{description.name}: {page.file}, {page.bytes / 1e6:.1f} MB")
        return run.give(page)
    if run.format != "text":
        raise RequestError("JSON goes with --html FILE: without a file there is a page to look at, and no answer")
    robot = LiveRobot(request, console, find_overlaps)
    try:
        server = create_server(robot.page, run.host, run.port)
    except (OSError, UnicodeError) as problem:
        raise RequestError(f"the page cannot be served at {run.host}, port {run.port or 'any'}: {problem}") from None
    robot.serve(server, open_browser=not run.no_open)
    return FINE


def find_overlaps(shown: RobotView) -> Any:
    """Return an ``OverlapFinder``, which finds links of a robot that overlap at some joint positions."""
    from rosorin_compile.mujoco.physics import OverlapFinder

    return OverlapFinder(shown.case, shown.meshes)


@cli.command("picture", exits="0 drawn, 1 errors or a missing extra")
@cli.robot_argument
@cli.option("-o", "--output FILE", required=True, help="picture to write: FILE.png")
@cli.force_option
@cli.position_options()
@cli.option("--from VIEW", "view", default="iso", help="camera: iso, front, side, top or angles (30deg,20deg)")
@cli.option("--size WxH", default="1280x800", help="size in pixels")
@cli.flag("--collision", help="show collision shapes of all links; default: of links without visuals")
@cli.flag("--frames", "published_frames", help="show published frames with their names")
@cli.repeatable("--frame FRAME", "frames", help="show a frame; repeatable", offers="frame")
@cli.mode_option("on")
@cli.option("--theme light|dark", default="light", help="colours of background and floor")
@cli.flag("--transparent", help="draw only the robot and its shadow, on a transparent background")
@cli.robot_options
def run_picture(run: Run) -> int:
    """Write a robot as a PNG file."""
    from rosorin_compile.viewer.picture.draw import picture

    if (size := re.fullmatch(r"([0-9]{1,5})[xX]([0-9]{1,5})", run.size)) is None:
        raise RequestError(f'"{run.size}" is not WIDTHxHEIGHT in pixels, such as 1280x800')
    picked = run.pick("pose joints pulses modes view collision published_frames frames theme transparent force")
    result = picture(run.request(run.only_robot()), run.output, **picked, size=(int(size[1]), int(size[2])))
    run.console.show(result.diagnostics)
    if not result.drawn:
        return PROBLEMS
    run.console.say(f"{result.robot}: {result.file}, {result.width} x {result.height}")
    return run.give(result)
