"""rosorin-compile graph: show the ROS 2 nodes of a robot and the topics between them, or write them as a picture."""

from pathlib import Path

from rosorin_compile.output import OutputError, may_replace, write_file
from rosorin_compile.ros.graph import graph

from . import command as cli
from .console import FINE, PROBLEMS
from .run import Run


@cli.command("graph", exits="0 shown or written, 1 errors or open ends")
@cli.robot_argument
@cli.option("-o", "--output FILE.svg", help="write a drawing")
@cli.force_option
@cli.robot_options
def run(options: cli.Options) -> int:
    """Show the nodes of a robot, the topics between them, and topics that no node publishes."""
    run, description = Run.alone(options)
    found = graph(run.request(description))
    failed = run.show(found)
    if not found.robot:
        return run.no_robot(description)
    if options.output is None:
        run.give(found, found.text)
        return PROBLEMS if failed else FINE
    try:
        write_file(Path(options.output), found.svg().encode(), (), None if options.force else may_replace)
    except OutputError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    run.give(found, lambda: f"{found.robot}: {options.output}")
    return PROBLEMS if failed else FINE
