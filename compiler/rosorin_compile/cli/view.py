"""rosorin-compile view: show a robot in the browser, and follow its files; or write it as one page."""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING, Any

from rosorin_compile.cli.console import Console
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.viewer.server import LOOPBACK, LiveRobot, bound

from .answer import FINE, PROBLEMS
from .command import Options, command, flag, option, page_options, robot_argument, robot_options
from .run import Run

if TYPE_CHECKING:
    from rosorin_compile.viewer.showing import Shown

_LAST_PORT = 65535


@command("view", exits="0 stopped with Ctrl-C or SIGTERM, or page written, 1 errors (with --html)")
@robot_argument
@page_options("write the page to a file instead of serving it")
@flag("--no-open", help="do not open a browser")
@option("--port", type=int, metavar="NUMBER", help="port of the server; default: 8642, or another one if it is in use")
@option(
    "--host",
    default=LOOPBACK,
    metavar="ADDRESS",
    help="address of the server, to make the page accessible from other machines; default: this machine only",
)
@robot_options
def run(options: Options) -> int:
    """Show a robot."""
    from rosorin_compile import api

    run, description = Run.alone(options, "a page shows one robot", "rosorin-compile view ROBOT")
    console, request, port, host = run.console, run.request(description), options.port, options.host
    if options.html is not None:
        page = api.view(request, options.html, meshes=not options.no_meshes, max_megabytes=options.max_megabytes)
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
    if options.no_meshes or options.max_megabytes is not None:
        raise RequestError("--no-meshes and --max-megabytes go with --html FILE")
    if port is not None and not 0 <= port <= _LAST_PORT:
        raise RequestError(f"there is no port {port}: they go from 0 to {_LAST_PORT}")
    robot = LiveRobot(request, Console("text", options.quiet), contacts)
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
