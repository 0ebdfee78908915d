"""Generate the launch files that publish frames, and copy the description that is compiled at launch.

The copy is stored in ``descriptions/`` with the same relative paths as in the project, so that references between its
files work in the install space.
"""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats import FORMATS, static_tf
from rosorin_compile.formats.format import Artifact, describe
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Robot
from rosorin_compile.rules.case import report
from rosorin_compile.rules.publishers import modes_in
from rosorin_compile.source.diagnostics import Diagnostic, Source, Span
from rosorin_compile.source.files import read_bytes
from rosorin_compile.source.load import yaml_of
from rosorin_compile.source.project import Description, tool_folders

from .copies import file_names
from .options import Options, is_legal

if TYPE_CHECKING:
    from rosorin_compile.formats.compilation import CompileResult
    from rosorin_compile.language.arguments import Argument
    from rosorin_compile.request import Request

PREFIX = "$(var frame_prefix)"
LAUNCH = "description.launch"
# XML and YAML launch files include PUBLISHER. If the description is compiled at launch, all include STATICS instead.
PUBLISHER, STATICS = "robot_state_publisher.launch.py", "static_frames.launch.py"
# Launch configuration with the path and the arguments of the description, in the form of a command line.
WORDS = "rosorin_compile_words"
_RULE = "package-not-carried"


class LaunchArgument(NamedTuple):
    """A launch argument; ``default`` is None if it is required, ``choices`` is empty if any value is allowed.

    Its value is passed on to the argument ``passed_as`` of the description, unless it equals ``own``, the default value
    in the description.
    """

    name: str
    default: str | None
    help: str
    choices: tuple[str, ...] = ()
    passed_as: str = ""
    own: str | None = None


class PackageFile(NamedTuple):
    """A file that is generated from a template; ``place`` is its path, ``about`` its description in README.md."""

    place: str
    template: str
    about: str


ARGUMENTS = (
    *(LaunchArgument(name, "", help) for name, help in static_tf.ARGUMENTS.items()),
    LaunchArgument("use_sim_time", "false", "take the time from /clock, as simulators and recordings publish it"),
    LaunchArgument("joint_state_publisher", "false", "publish all joints at zero, where no driver does"),
    LaunchArgument("joint_state_publisher_gui", "false", "publish the joints from sliders in a window"),
    LaunchArgument("rviz", "false", "show the robot in RViz"),
)


def mode_arguments(robot: Robot) -> dict[str, str]:
    """Map each mode that static transforms depend on to the name of its launch argument."""
    modes = modes_in(robot, [one.when for one in static_tf.static_transforms(robot)[1]])
    return static_tf.free_names(modes, [argument.name for argument in ARGUMENTS], "mode_")


def launch_values(robot: Robot, carried: CarriedDescription | None) -> dict[str, Any]:
    """Return the template variables of launch files; ``carried`` is the description to compile at launch, or None."""
    always, in_modes, _ = static_tf.static_transforms(robot, FORMATS.outputs_read_by(robot, STATIC_TRANSFORM_PUBLISHER))
    modes = mode_arguments(robot)
    conditions = {one.when: static_tf.condition(robot, one.when) for one in in_modes}
    about = "the robot is run in the mode"
    more = [LaunchArgument(name, "false", f"{about} {mode}", static_tf.STATES) for mode, name in modes.items()]
    more += carried.passed if carried else ()
    common = (*static_tf.ARGUMENTS, *(() if carried else ("use_sim_time",)))
    passed_on, commands = [one for one in ARGUMENTS if one.name in common], ("Command",) if carried else ()
    joints = robot.published_by(ROBOT_STATE_PUBLISHER)

    def plain(text: str) -> str:
        return text.replace("\\", "\\\\").replace("$", "\\$")

    def in_args(text: str) -> str:
        return plain(shlex.quote(text))

    def args(transform: static_tf.StaticTransform) -> str:
        words = (f"{flag} {PREFIX if is_frame else ''}{in_args(value)}" for flag, value, is_frame in transform.words())
        return " ".join(words)

    return {
        "arguments": [*ARGUMENTS, *more],
        "passed_on": [*passed_on, *(more if carried else ())],
        "included": STATICS if carried else PUBLISHER,
        "publisher": joints[0].publisher.name if joints else ROBOT_STATE_PUBLISHER,
        "statics": [*always, *in_modes],
        "modes": modes,
        "conditions": {when: static_tf.in_python(one, modes, 4) for when, one in conditions.items()},
        "python_conditions": {when: static_tf.if_condition(one, modes, 12) for when, one in conditions.items()},
        "frontend_conditions": {when: static_tf.in_frontends(one, modes) for when, one in conditions.items()},
        "describe": describe,
        "args": args,
        "imports": static_tf.import_substitutions(conditions.values(), "LaunchConfiguration", *commands),
        "plain": plain,
        "in_args": in_args,
        "prefix": PREFIX,
        "screen": ("joint_state_publisher", "joint_state_publisher_gui", "rviz2"),
        "carried": carried,
        "words": WORDS,
    }


def launch_files(carried: CarriedDescription | None) -> Iterator[PackageFile]:
    """Yield the launch files that publish the frames; ``carried`` is the description to compile at launch, or None."""
    kind, about = "compiled_launch" if carried else "launch", "publishers of the frames; the three forms do the same"
    yield from (PackageFile(f"launch/{LAUNCH}.{form}", f"{kind}.{form}", about) for form in ("py", "xml", "yaml"))
    if carried:
        about = "publishers of the static frames; the three forms include it"
        yield PackageFile(f"launch/{STATICS}", "compiled_statics.launch.py", about)
    else:
        about = "robot_state_publisher; the XML and the YAML form include it"
        yield PackageFile(f"launch/{PUBLISHER}", "publisher.launch.py", about)


class CarriedDescription(NamedTuple):
    """A description that is copied into a package and compiled at launch.

    ``description`` is the path of its main file, ``passed`` are its arguments as launch arguments. ``urdf`` and
    ``statics`` are the outputs to compile; ``packages`` are the ROS packages that the description reads.
    """

    description: str
    files: Mapping[str, bytes]
    passed: tuple[LaunchArgument, ...]
    urdf: str
    statics: str
    packages: tuple[str, ...]

    @property
    def required(self) -> bool:
        """Whether the description has an argument without a default."""
        return any(one.default is None for one in self.passed)


def carry(
    compiled: CompileResult, request: Request, options: Options
) -> tuple[CarriedDescription | None, list[Diagnostic]]:
    """Return (description, errors); the description is None unless the package options require compiling at launch.

    The argument values of the request become the defaults at launch. Raises LoadError.
    """
    from rosorin_compile.language.arguments import declared_arguments

    main = next((one for one in compiled.artifacts if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)), None)
    if not options.at_launch or compiled.robot is None or main is None:
        return None, []
    path, values, packages = request.description.path, request.values(), {**compiled.packages, **request.packages}
    elsewhere = [tool_folders()["parts_library"], *compiled.python_packages, *map(_absolute, packages.values())]
    inputs = [_absolute(one) for one in compiled.files_read]
    own = [one for one in inputs if not any(map(one.is_relative_to, elsewhere))]
    # Copy the folder "descriptions" if it contains all files, else its parent folder. If there is no such folder, copy
    # the folder of the main file.
    top, prefix = _absolute(path).parent, f"{Description.FOLDER}/"
    if (folder := next((one for one in (top, *top.parents) if one.name == Description.FOLDER), None)) is None:
        prefix += f"{top.name if top.name.isprintable() and top.name.strip('.') else 'robot'}/"
    else:
        top = folder if all(one.is_relative_to(folder) for one in own) else folder.parent
    if problems := list(_problems(top, own, main, options.name)):
        return None, problems
    places = {one: prefix + one.relative_to(top).as_posix() for one in own}
    taken = [*(argument.name for argument in ARGUMENTS), *mode_arguments(compiled.robot).values(), WORDS]
    arguments = declared_arguments(path, values)[0]
    names = static_tf.free_names([one.name for one in arguments], taken, "arg_")
    read = {name for name, at in packages.items() if any(one.is_relative_to(at) for one in inputs)}
    read |= {name for name, at in packages.items() if str(at) in main.text}
    return CarriedDescription(
        description=places[_absolute(path)],
        files={place: read_bytes(file) for file, place in places.items()},
        passed=tuple(_passed(one, names[one.name], values) for one in arguments),
        urdf=main.output,
        statics=next((one.output for one in compiled.artifacts if one.backend == "static_tf_json"), "static_tf_json"),
        packages=tuple(sorted(name for name in read if is_legal(name) and name != options.name)),
    ), []


def _absolute(path: Path) -> Path:
    return Path(os.path.abspath(path))


def _problems(top: Path, files: Sequence[Path], main: Artifact, package: str) -> Iterator[Diagnostic]:
    """Report files and meshes of the description that nodes would not find in the package."""
    for one in [one for one in files if not one.is_relative_to(top)]:
        message = f"{one} is read, and is outside the project {top}: no package can carry it"
        yield report(_RULE, message, _mention(one.name, files))
    if span := _mention(f"{top}{os.sep}", files):
        message = "a file is named by its absolute path, which another machine does not have"
        yield report(_RULE, message, span, "name it relative to the file that names it")
    for name in [name for name in file_names(main.text) if "://" not in name and not name.startswith("/")]:
        message = f"mesh {name} is named by a path, and a URDF that is compiled at launch is in no folder"
        inside = name if name.startswith("meshes/") else f"meshes/{name.rpartition('/')[2]}"
        help = f"write package://{package}/{inside} in the description; the file is copied into the package"
        yield report(_RULE, message, _mention(name, files), help)


def _mention(name: str, files: Iterable[Path]) -> Span | None:
    for file in (one for one in files if one.suffix in Description.ENDINGS):
        source = Source(str(file), read_bytes(file).decode("utf-8", "replace"))
        if name in source.text:
            return source.span(source.text.index(name), len(name))
    return None


def _passed(one: Argument, launch_name: str, values: Mapping[str, Any]) -> LaunchArgument:
    own = default = None if one.required else _unquoted(one.default)
    if one.name in values and not one.required:
        value = values[one.name]
        default = value if isinstance(value, str) else _unquoted(one.value)
    choices = [_unquoted(text) for text in one.allowed]
    choices += [default] if default is not None and choices and default not in choices else []
    is_shortened = any(text.endswith("...") for text in choices)
    help = one.help or f"the argument {one.name} of the description"
    help += f" ({one.name} of the description)" if one.help and launch_name != one.name else ""
    return LaunchArgument(launch_name, default, help, () if is_shortened else tuple(choices), one.name, own)


def _unquoted(written: str) -> str:
    if written[:1] not in ("'", '"'):
        return written
    try:
        value = yaml_of(written)
    except ValueError:  # the text was shortened with "..."
        return written
    return value if isinstance(value, str) else written
