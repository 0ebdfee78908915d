"""Options and arguments that several commands have, as decorators."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

from . import complete
from .command import argument, combined, option

Decorated = TypeVar("Decorated", bound=Callable[..., Any])
Decorator = Callable[[Decorated], Decorated]

SEVERITIES = ("error", "warning", "never")
PAGE_MEGABYTES = 40  # of the meshes of a page
ROBOT_HELP = "name of a robot in descriptions/, or a folder or file"
ROBOTS_HELP = f"{ROBOT_HELP}; default: all robots"
POSITIONS = "Joint positions (default: zero)"
_ARGUMENTS = "Arguments of the description or the xacro file"


class _Path(click.ParamType):  # type: ignore[type-arg] # not generic before click 8.4
    """The name of a file or folder, which must not be empty."""

    name = "path"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the name."""
        if not value:
            self.fail("the name is empty", param, ctx)
        return value

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[Any]:
        """Let the shell complete files."""
        folders = "FOLDER" in str(param.metavar)
        return [click.shell_completion.CompletionItem(incomplete, type="dir" if folders else "file")]


class _Seconds(click.ParamType):  # type: ignore[type-arg] # not generic before click 8.4
    """A time in whole seconds."""

    name = "seconds"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number of seconds."""
        text = str(value)
        if not (text.isascii() and text.isdigit() and len(text) < 9 and int(text) > 0):
            self.fail(f'"{text[:20]}" is no number of whole seconds', param, ctx)
        return int(text)


PATH = _Path()


def words_argument(
    metavar: str, help: str = "", required: bool = False, offers: complete.Offers = ()
) -> Decorator[Any]:
    """Return the arguments of a command as ``words``; ``offers`` are the kinds of names that a shell completes."""
    return argument(
        "words", nargs=-1, required=required, metavar=metavar, help=help, shell_complete=complete.of(*offers)
    )


def robots_argument(
    metavar: str = "[ROBOT ...]", help: str = ROBOTS_HELP, offers: complete.Offers = ("robot", "argument")
) -> Decorator[Any]:
    """Return the robots of a command that handles several, with the options that every robot takes."""
    return combined(words_argument(metavar, help, offers=offers), robot_options)


robot_argument = words_argument("[ROBOT]", f"{ROBOT_HELP}; required if there are several", offers=("robot", "argument"))

robot_options = combined(
    option(
        "--package",
        "packages",
        multiple=True,
        metavar="NAME=PATH",
        help="folder of a ROS package, for $(find NAME) and package://NAME; repeatable",
    ),
    option("--trust", is_flag=True, help="do not warn about code that a xacro file can run"),
    option("--xacro-seconds", type=_Seconds(), metavar="S", help="time limit for a xacro file in seconds; default: 60"),
    option(
        "-a",
        "--arg",
        multiple=True,
        metavar="NAME=VALUE",
        help="set an argument; NAME:=VALUE without -a is the same",
        section=_ARGUMENTS,
        shell_complete=complete.of("argument="),
    ),
    option(
        "--args",
        "args_files",
        multiple=True,
        metavar="FILE",
        help="read arguments from a YAML file; -a overrides them",
        section=_ARGUMENTS,
        shell_complete=complete.files,
    ),
)

output_folder_option = option(
    "-o",
    "--output",
    type=PATH,
    metavar="FOLDER",
    help="folder of the artifacts, with a subfolder for each of several robots; default: outputs/ROBOT",
)

summary_option = option("--summary", type=PATH, metavar="FILE", help="also append the messages to a file, as Markdown")

notes_option = option("--notes", is_flag=True, help="list notes and stand-ins instead of counting them")

fail_on_option = option(
    "--fail-on",
    type=click.Choice(SEVERITIES),
    metavar="SEVERITY",
    default="error",
    help="exit with 1 if a message has this severity or a higher one: error, warning or never; default: error",
)


def hook_option(more: str = "") -> Decorator[Any]:
    """Return the option for pre-commit."""
    text = f"for pre-commit: take changed files as arguments and use all robots of their projects{more}"
    return option("--hook", is_flag=True, help=text)


def check_options(
    metavar: str = "[ROBOT ...]", help: str = ROBOTS_HELP, offers: complete.Offers = ("robot", "argument")
) -> Decorator[Any]:
    """Return what every check takes: robots, the folder of the artifacts, a summary and the severity that fails."""
    return combined(robots_argument(metavar, help, offers), output_folder_option, summary_option, fail_on_option)


def page_options(what: str) -> Decorator[Any]:
    """Return the options of an HTML page; ``what`` describes it."""
    return combined(
        option("--html", type=PATH, metavar="FILE", help=what),
        option("--no-meshes", is_flag=True, help="with --html: leave out the meshes"),
        option(
            "--max-megabytes",
            type=float,
            metavar="NUMBER",
            help=f"with --html: size limit for all meshes together, in MB; default: {PAGE_MEGABYTES}",
        ),
    )


def depfile_options(target: str) -> Decorator[Any]:
    """Return the options for depfiles; ``target`` describes the default target."""
    return combined(
        option(
            "--depfile", type=PATH, metavar="FILE", help="write the files that were read as a Make and Ninja depfile"
        ),
        option("--depfile-target", type=PATH, metavar="NAME", help=f"target in the depfile; {target}"),
    )


def mode_option(unnamed: str, section: str = "") -> Decorator[Any]:
    """Return the option that switches modes; ``unnamed`` describes the state of the other modes."""
    return option(
        "--mode",
        "modes",
        multiple=True,
        metavar="MODE",
        section=section,
        shell_complete=complete.of("mode"),
        help=f'switch a mode on or off: slam, "not slam" or slam=off; other modes: {unnamed}',
    )


def pose_option(help: str, section: str = "") -> Decorator[Any]:
    """Return the option that names a pose of the description."""
    return option("--pose", default="", metavar="POSE", help=help, section=section, shell_complete=complete.of("pose"))


def position_options(sweep: bool = False) -> Decorator[Any]:
    """Return the options that set the positions of joints; ``sweep`` adds one that takes several in turn."""
    overridden = "--pose and --pulse" if sweep else "--pose"
    options = [
        pose_option("named pose of the description", POSITIONS),
        _positions("--pulse", "pulses", "JOINT=PULSE", "pulse sent to the servo; overrides --pose"),
        _positions(
            "--joint", "joints", "JOINT=VALUE", f"position, such as 30deg, 5cm or 1,2,30deg; overrides {overridden}"
        ),
    ]
    if sweep:
        help = "use COUNT positions in turn; repeatable: all combinations"
        options.append(_positions("--sweep", "sweeps", "JOINT=FROM:TO:COUNT", help))
    return combined(*options)


def _positions(name: str, dest: str, metavar: str, help: str) -> Decorator[Any]:
    return option(
        name,
        dest,
        multiple=True,
        metavar=metavar,
        help=help,
        section=POSITIONS,
        shell_complete=complete.of("joint="),
    )
