"""rosorin-compile view: show a robot in the browser, and follow its files; or write it as one page."""

import errno
from typing import Any

import click

from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.viewer.server import LOOPBACK, LiveRobot, bound
from rosorin_compile.viewer.showing import Shown, view

from .command import Options, command, flag, option, page_options, robot_argument, robot_options
from .console import FINE, PROBLEMS
from .run import Run


@command("view", exits="0 stopped with Ctrl-C or SIGTERM, or page written, 1 errors (with --html)")
@robot_argument
@page_options("write the page to a file instead of serving it")
@flag("--no-open", help="do not open a browser")
@option("--port NUMBER", type=click.IntRange(0, 65535), help="port of the server; default: 8642, or a free one")
@option("--host ADDRESS", default=LOOPBACK, help="address, for access from other machines; default: this one only")
@robot_options
def run(options: Options) -> int:
    """Show a robot."""
    run, description = Run.alone(options)
    console, request, port, host = run.console, run.request(description), options.port, options.host
    if options.html is not None:
        page = view(request, options.html, meshes=not options.no_meshes, max_megabytes=options.max_megabytes)
        console.show(page.diagnostics)
        if not page.written:
            console.warn(f"{description.name}: no page was written")
            return PROBLEMS
        if page.left_out:
            console.warn(f"not shown: {page.left_out}")
        console.say(f"{description.name}: {page.file}, {page.bytes / 1e6:.1f} MB")
        return run.give(page)
    if options.format != "text":
        raise RequestError("JSON goes with --html FILE: without a file there is a page to look at, and no answer")
    robot = LiveRobot(request, console, contacts)
    try:
        server = bound(robot.page, host, port)
    except (OSError, UnicodeError) as problem:
        if getattr(problem, "errno", None) == errno.EADDRINUSE:
            raise RequestError(f"port {port} is taken; without --port a free one is found") from None
        reason = getattr(problem, "strerror", None)
        where = f"{host} is no address of this machine" if port is None else f"port {port} of {host} cannot be used"
        raise RequestError(f"{where}{f' ({reason})' if reason else ''}") from None
    robot.serve(server, open_browser=not options.no_open)
    return FINE


def contacts(shown: Shown) -> Any:
    """Return the engine that finds links of a robot that are inside each other."""
    from rosorin_compile.mujoco.physics.checking import OverlapFinder

    return OverlapFinder(shown.case, shown.meshes)
