"""Package: the files of a ROS 2 package that carries the artifacts of a robot and shows them.

Values of its launch files are spelt as each of the three forms reads them; its views are those of RViz.
"""

from __future__ import annotations

import dataclasses
import math
import posixpath
import shlex
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...diagnostics import NOTE, Diagnostic, error
from ...diagnostics.registry import PACKAGES, Rule
from ...formats import FORMATS, Artifact, feeds, is_built_in, names_meshes, published
from ...formats.static_tf import StaticTransform, describe, numbers_of, static_in_modes, static_transforms
from ...formats.templating import BUILTIN, Templates, comment
from ...frontend.yaml_text import quoted
from ...model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Edge, Robot
from ...rules.case import feeding
from ...rules.conditions import combinations, holds, modes_in
from . import meshes
from .naming import file_name

if TYPE_CHECKING:
    from ...formats.mesh_files import Searched

RULES = (
    Rule("package-no-urdf", "No output is a URDF.", "Add an output with the backend `urdf`.", PACKAGES),
    Rule(
        "package-same-place",
        "Two outputs have one file name in two folders, and a package has one folder for both.",
        "Let the file names differ.",
        PACKAGES,
    ),
    Rule(
        "package-defaults",
        "A note: nobody said who maintains the package, or its licence.",
        "`--maintainer`, `--license`",
        PACKAGES,
    ),
)


BUILD_TYPES = ("ament_cmake", "ament_python")
FOLDERS = ("config", "doc", "launch", "meshes", "rviz")  # beside those that formats ask for
LAUNCH = "description.launch"
_NODES = ("joint_state_publisher", "joint_state_publisher_gui", "robot_state_publisher", "rviz2", "tf2_ros")
# Where what a format does not place stands, by the ending of its file.
_BY_ENDING = {".rviz": "rviz", ".launch.py": "launch"}
_BY_ENDING |= dict.fromkeys((".dot", ".html", ".md", ".mmd", ".svg"), "doc")


@dataclasses.dataclass(frozen=True)
class Options:
    """What a package is called and what its package.xml says; ``topics`` are topics by the name of the sensor."""

    name: str
    build_type: str = BUILD_TYPES[0]
    version: str = "0.1.0"
    maintainer: str = "nobody yet"
    email: str = "nobody@example.com"
    license: str = "LicenseRef-not-stated"
    description: str = ""
    topics: Mapping[str, str] = dataclasses.field(default_factory=dict)


class Argument(NamedTuple):
    """An argument of the launch files."""

    name: str
    default: str
    help: str


ARGUMENTS = (
    Argument("use_sim_time", "false", "take the time from /clock, as simulators and recordings publish it"),
    Argument("joint_state_publisher", "false", "publish all joints at zero, where no driver does"),
    Argument("joint_state_publisher_gui", "false", "publish the joints from sliders in a window"),
    Argument("rviz", "false", "show the robot in RViz"),
)


class Package(NamedTuple):
    """The files of a package, bytes by relative name, and what is to say about them."""

    files: dict[str, bytes]
    diagnostics: list[Diagnostic]


def make(
    robot: Robot,
    artifacts: Sequence[Artifact],
    options: Options,
    sources: Sequence[Path],
    target: Path,
    searched: Searched | None = None,
) -> Package:
    """Return the package of a robot, whose meshes were ``searched``.

    ``sources`` are folders in which other files are looked for that the description names; ``target`` is where the
    package will stand, which may hold such files already.
    """
    main = next((one for one in artifacts if feeds(one.backend, ROBOT_STATE_PUBLISHER)), None)
    if main is None:
        help = f"add an output with the backend {published().name}"
        return Package(
            {}, [error("package-no-urdf", "no output is a URDF, and a package is nothing without", None, help)]
        )
    carried: dict[str, Artifact] = {}
    for artifact in artifacts:
        place = place_of(artifact, main)
        if place and carried.setdefault(place, artifact) is not artifact:
            return Package({}, [_twice(place, carried[place], artifact)])
    files: dict[str, bytes] = {}
    needs: set[str] = set()
    diagnostics: list[Diagnostic] = []
    for place, artifact in carried.items():
        text = artifact.text
        beside = FORMATS[artifact.backend].beside
        if names_meshes(artifact):
            settled = meshes.settle(text, options.name, sources, target, searched)
            text = settled.text
            needs.update(settled.packages)
            diagnostics += settled.diagnostics
            files.update({name: path.read_bytes() for name, path in settled.files.items()})
        elif beside is not None:
            meshes_of = _meshes(artifact, searched)
            names = [
                name for name in dict.fromkeys(beside(text)) if not _copied(place, name, meshes_of, sources, files)
            ]
            diagnostics += meshes.beside(place, names, target)
        files[place] = text.encode()
    files.update(_made(robot, options, place_of(main, main), list(carried.items()), needs))
    return Package(files, [*diagnostics, *_defaults(options)])


def _twice(place: str, one: Artifact, other: Artifact) -> Diagnostic:
    message = f"the outputs {one.output} and {other.output} would both be {place} in the package"
    return error("package-same-place", message, None, "let their file names differ, not their folders alone")


def place_of(artifact: Artifact, main: Artifact) -> str:
    """Return where an artifact stands in a package; empty for the launch file, which the package has of its own."""
    if not FORMATS[artifact.backend].packaged:
        return ""
    otherwise = published().file.format("robot") if artifact is main else artifact.file.rpartition("/")[2]
    return f"{folder_of(artifact)}/{file_name(artifact.file, otherwise)}"


def folder_of(artifact: Artifact) -> str:
    """Return the folder of an artifact: as its format says, else by the ending of its name."""
    own, file = FORMATS[artifact.backend].folder, artifact.file
    if own:
        return own
    formats = (one.folder for one in FORMATS.values() if one.read and one.folder and file.endswith(one.endings))
    others = (folder for ending, folder in _BY_ENDING.items() if file.endswith(ending))
    return next(others, "") or next(formats, "config")


def _meshes(artifact: Artifact, searched: Searched | None) -> Mapping[str, bytes]:
    """Return the mesh files that belong to an artifact, by their names as seen from it."""
    folder = artifact.file.rpartition("/")[0]
    return {posixpath.relpath(name, folder or "."): data for name, data in (searched.files if searched else {}).items()}


def _copied(
    place: str, name: str, found: Mapping[str, bytes], sources: Sequence[Path], files: dict[str, bytes]
) -> bool:
    """Copy a file that an artifact names beside it; say whether it is known."""
    if name.startswith("/") or ".." in name.split("/"):
        return False
    data = found.get(posixpath.normpath(name))
    if data is None:
        source = next((folder / name for folder in sources if (folder / name).is_file()), None)
        data = None if source is None else source.read_bytes()
    if data is not None:
        files[posixpath.join(posixpath.dirname(place), posixpath.normpath(name))] = data
    return data is not None


def _made(
    robot: Robot, options: Options, urdf: str, carried: Sequence[tuple[str, Artifact]], needs: set[str]
) -> dict[str, bytes]:
    """Return the files that are made for the package alone."""
    package = options if options.description else dataclasses.replace(options, description=f"The robot {robot.name}.")
    rviz = "robot.rviz" if "/" in robot.name else file_name(f"{robot.name}.rviz", "robot.rviz")
    statics, modes = spelt_statics(robot, [argument.name for argument in ARGUMENTS])
    of_modes = [
        Argument(name, "false", f"the robot is run in the mode {mode}: true or false") for mode, name in modes.items()
    ]
    launch = ("ament_index_python", "launch", "launch_ros", "launch_xml", "launch_yaml", "ros2launch")
    values: dict[str, Any] = {
        "robot": robot,
        "package": dataclasses.asdict(package),
        "depends": sorted({*_NODES, *launch, *needs}),
        "folders": _folders(carried),
        "arguments": [*ARGUMENTS, *of_modes],
        "urdf": urdf.removeprefix("urdf/"),
        "rviz": rviz,
        "publisher": moved_by(robot),
        "statics": statics,
        "literal": repr,
        "quoted": quoted,
        "plain": plain,
        "eval": evaluated,
        "modes": modes,
        "comment": comment,
        "contents": _contents(carried, rviz),
        "others": [_other(edge) for edge in robot.edges if edge.publisher.kind != STATIC_TRANSFORM_PUBLISHER],
        **_view(robot, options),
    }
    names = {f"{LAUNCH}.{form}": f"launch.{form}" for form in ("py", "xml", "yaml")}
    templates = {f"launch/{name}": template for name, template in names.items()}
    templates |= {f"rviz/{rviz}": "rviz", "package.xml": "package.xml", "README.md": "README.md"}
    python = {"setup.py": "setup.py", "setup.cfg": "setup.cfg"}
    templates |= python if options.build_type == "ament_python" else {"CMakeLists.txt": "CMakeLists.txt"}
    engine = Templates()
    made = {n: engine.render(f"{BUILTIN}package_{t}.jinja", values).encode() for n, t in templates.items()}
    return made | ({f"resource/{options.name}": b""} if options.build_type == "ament_python" else {})


def _folders(carried: Sequence[tuple[str, Artifact]]) -> list[str]:
    """Return the folders that a package installs: those of the tool's own formats, and those of its artifacts."""
    own = (one.folder for one in FORMATS.values() if one.folder and is_built_in(one.name))
    return sorted({*FOLDERS, *own, *(place.partition("/")[0] for place, _ in carried)})


def _view(robot: Robot, options: Options) -> dict[str, Any]:
    """Return what the RViz configuration needs: its fixed frame is the root of the URDF."""
    joints = robot.in_urdf()
    links = dict.fromkeys([joint.parent for joint in joints] + [joint.child for joint in joints])
    children = {joint.child for joint in joints}
    root = next((link for link in links if link not in children), robot.root)
    size = round_number(reach(robot, links))
    return {
        "fixed_frame": root,
        "displays": displays(robot, options.topics),
        "visual": any(robot.link[link].visual for link in links or [root]),
        "size": round_number(size / 2),
        "scale": min(1.0, size),
        "distance": round_number(3 * size),
    }


def _contents(carried: Sequence[tuple[str, Artifact]], rviz: str) -> list[tuple[str, str]]:
    """Return the files of a package with what each is."""
    rows = [(place, FORMATS[artifact.backend].about) for place, artifact in carried]
    return sorted(
        [*rows, (f"launch/{LAUNCH}.*", "one launch file in three forms"), (f"rviz/{rviz}", "a view for RViz")]
    )


def _other(edge: Edge) -> str:
    when = f", when {edge.when}" if edge.when else ""
    return f"{edge.parent} -> {edge.child}: {edge.publisher.name}{when}"


def _defaults(options: Options) -> list[Diagnostic]:
    """Return what package.xml says by default and its reader should decide."""
    usual = Options(options.name)
    open_ones = [
        option
        for option, mine, default in (
            ("--maintainer", options.email, usual.email),
            ("--license", options.license, usual.license),
        )
        if mine == default
    ]
    if not open_ones:
        return []
    message = f"package.xml does not say yet who maintains the package or how it is licensed ({', '.join(open_ones)})"
    help = "--maintainer 'NAME <MAIL>', --license with an SPDX name such as Apache-2.0"
    return [Diagnostic("package-defaults", NOTE, message, None, (), help)]


_ON = '("true", "1", "on")'


class Static(NamedTuple):
    """A static_transform_publisher: its name, its arguments one by one and as one text, where its numbers come from.

    ``condition`` is an expression of Python over launch arguments, empty for always: its pieces are text and the name
    of an argument in turns, text first and last.
    """

    name: str
    spelt_name: str
    arguments: tuple[str, ...]
    args: str
    source: str
    condition: tuple[str, ...] = ()


def plain(text: str) -> str:
    """Return a text as XML and YAML launch files say it where no substitution is meant."""
    return text.replace("\\", "\\\\").replace("$", "\\$")


def spelt_statics(robot: Robot, taken: Iterable[str]) -> tuple[list[Static], dict[str, str]]:
    """Return the static transforms of a robot, and the launch arguments of the modes that they depend on.

    ``taken`` are names of launch arguments that are no modes. Numbers are printed as the outputs of the robot ask for.
    """
    numbers = numbers_of(*feeding(robot, STATIC_TRANSFORM_PUBLISHER, FORMATS))
    in_modes = static_in_modes(robot, numbers)
    names = set(taken)
    arguments = {
        mode: f"mode_{mode}" if mode in names else mode for mode in modes_in(robot, [one.when for one in in_modes])
    }
    statics = [_static(transform, ()) for transform in static_transforms(robot, numbers)[0]]
    statics += [_static(one, _condition(one.when, modes_in(robot, [one.when]), arguments)) for one in in_modes]
    return statics, arguments


def evaluated(condition: Sequence[str]) -> str:
    """Return a condition as the argument of ``$(eval '...')``."""
    return "".join(f"$(var {piece})" if index % 2 else piece for index, piece in enumerate(condition))


def _static(transform: StaticTransform, condition: tuple[str, ...]) -> Static:
    args = " ".join(plain(shlex.quote(argument)) for argument in transform.arguments)
    name = transform.name
    return Static(name, plain(name), transform.arguments, args, describe(transform.source), condition)


def _condition(when: str, modes: list[str], arguments: Mapping[str, str]) -> tuple[str, ...]:
    """Return a condition over modes as every combination of them in which it holds."""
    pieces = [""]
    for index, states in enumerate(states for states in combinations(modes) if holds(when, states)):
        for number, (mode, is_on) in enumerate(states.items()):
            pieces[-1] += " and " if number else " or " if index else ""
            pieces[-1] += '"'
            pieces += [arguments[mode], f'".lower() {"in" if is_on else "not in"} {_ON}']
    return tuple(pieces) if len(pieces) > 1 else ("False",)


def moved_by(robot: Robot) -> str:
    """Return the name of the node that publishes the joints of the URDF."""
    joints = robot.published_by(ROBOT_STATE_PUBLISHER)
    return joints[0].publisher.name if joints else ROBOT_STATE_PUBLISHER


# What shows the messages of a sensor of a type: a class of rviz_default_plugins and the type of its messages.
DISPLAYS: Mapping[str, str] = {
    "lidar_2d": "LaserScan",
    "lidar_3d": "PointCloud2",
    "camera": "Image",
    "depth_camera": "PointCloud2",
    "range_finder": "Range",
}
_SMALLEST = 0.2


class Display(NamedTuple):
    """A display of RViz: its class, its name, and its topic; without a topic it is switched off."""

    kind: str
    name: str
    topic: str


def displays(robot: Robot, topics: Mapping[str, str]) -> list[Display]:
    """Return the displays of the sensors of a robot; ``topics`` by the name of the sensor, as far as they are known."""
    displays = []
    for sensor in robot.sensors:
        kind = DISPLAYS.get(sensor.type)
        if kind is not None:
            topic = topics.get(sensor.name, "")
            displays.append(Display(kind, sensor.name if topic else f"{sensor.name} (choose its topic)", topic))
    return displays


def reach(robot: Robot, links: Iterable[str]) -> float:
    """Return the largest distance of a frame from the root of a robot (m, all joints at zero), 0.2 at least."""
    root = robot.root
    return max([_SMALLEST, *(math.hypot(*robot.transform(root, link, {}).xyz) for link in links)])


def round_number(value: float) -> float:
    """Return a number rounded to one digit, so that small changes of a robot leave its view as it is.

    >>> round_number(0.234), round_number(17.0)
    (0.2, 20.0)
    """
    return float(f"{value:.1g}")
