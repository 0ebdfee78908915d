"""check parameters: what parameter files and remaps say, held against one robot."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rosorin_compile.model import Controller
from rosorin_compile.model.joint import NODE
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import (
    ERROR,
    NOTE,
    WARNING,
    Diagnostic,
    RequestError,
    Source,
    Span,
    count_of,
    error,
    has_errors,
    phrase,
    quote,
)
from rosorin_compile.source.files import is_file
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.project import no_file

from ..controllers import against_robot, missing, of_type
from ..controllers.filled import derive
from ..parameters.files import PARAMETERS, NoParameters, Section, read_file
from ..parameters.tables import MANAGER
from ..ports import full_type
from . import owners, topics
from .nodes import Node, check_node, nodes_in_files
from .topics import launch_remaps, parse_remap

# Keys of the configuration files of MoveIt, which are no parameter files.
_MOVEIT = re.compile(
    r"\b(cartesian_limits|joint_limits|kinematics_solver|moveit_controller_manager|moveit_simple_controller_manager"
    r"|octomap_frame|planner_configs|planning_plugins?|sensor_plugin|trajectory_execution)\s*:"
)


@dataclass(frozen=True)
class CheckedParameters:
    """What was checked: the edges of nodes that were judged, the publishers that no file has, and unknown nodes.

    ``robot`` is empty if errors of the description kept it from being checked.
    """

    robot: str = ""
    judged: int = 0
    absent: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


def check_parameters(
    robot: FilePath | Request,
    files: Sequence[FilePath],
    arguments: Values = None,
    packages: Packages = None,
    *,
    controllers: Sequence[FilePath] = (),
    launch: Sequence[FilePath] = (),
    remaps: Sequence[str] = (),
    namespace: str = "",
    distribution: str | None = None,
    trust: bool = False,
) -> CheckedParameters:
    """Check parameter files of ROS nodes against a robot: frames, publishers, controllers and odometry topics.

    Args:
        files: The parameter files.
        controllers: Parameter files of a controller_manager.
        launch: Launch files to read remappings from.
        remaps: Further remappings, as ``"NODE:FROM:=TO"``.
        namespace: The namespace of the nodes.
        distribution: The ROS 2 distribution; by default that of the outputs of the robot, if they agree.

    Raises:
        RequestError: A file does not exist, or a remap is invalid.
    """
    paths, managers, launches = ([Path(file) for file in some] for some in (files, controllers, launch))
    for path in (*paths, *managers, *launches):
        if not is_file(path):
            raise RequestError(no_file(path))
    moved = [parse_remap(word) for word in remaps]
    understood = Request.of(robot, arguments, packages, trust=trust).understand()
    case = understood.case
    if case is None:
        return CheckedParameters(diagnostics=tuple(one for one in understood.diagnostics if one.severity == ERROR))
    if not distribution:
        every = {str(one.options["distribution"]) for one in case.robot.outputs if "distribution" in one.options}
        distribution = every.pop() if len(every) == 1 else ""
    found: list[Diagnostic] = []
    sections = _read((*managers, *paths), found)
    for path in launches:
        more, wrong = launch_remaps(path)
        moved += more
        found += wrong
    known, wrong = nodes_in_files(sections, namespace, distribution, case.robot.controllers)
    found += wrong
    if managers and not any(node.type for node in known) and not has_errors(found):
        help = f"{MANAGER}: {{ros__parameters: {{NAME: {{type: TYPE}}}}}}"
        first = [section.span for of_file in sections for section in of_file]
        span = first[0] if first else Span(Source(str(managers[0]), ""), 1, 1)
        found.append(error("controllers-none", "no controller has a type here", span, help))
    for node in known:
        found += _check(case, node, distribution)
    claims = owners.claims(known, moved)
    found += owners.check(case, claims)
    found += owners.check_frames(case, known, claims)
    found += topics.check(case.robot, known, moved, distribution)
    publishers = case.robot.publishers
    of_nodes = [edge.publisher for edge in case.robot.edges if edge.publisher.kind == NODE]
    judged = [one for one in of_nodes if any(node.kind and node.is_of(one, publishers) for node in known)]
    absent = dict.fromkeys(one.name for one in of_nodes if one not in judged)
    unknown = [node for node in known if node.kind is None]
    names = (node.shown for node in unknown if any(node.is_of(one, publishers) for one in publishers))
    return CheckedParameters(case.robot.name, len(judged), tuple(absent), tuple(names), tuple(arrange(found)))


def _check(case: Case, node: Node, distribution: str) -> Iterator[Diagnostic]:
    """Yield what is wrong with the parameters of a node, of a controller also by what the robot knows of it."""
    wrong = of_type(node.shown, node.type, distribution) if node.type else None
    if wrong is not None:
        yield wrong.place(node.type_span)
        if wrong.severity == ERROR:
            return  # of which no key would be right
    diagnostics = list(check_node(node))
    yield from diagnostics
    if not node.type:
        return
    if wrong is None and (needed := missing(node.kind, node.parameters)):
        message = f"{node.shown} needs {quote(needed, most=4)}: it does not start"
        yield error("controller-missing", message, node.span, f"add {needed[0]}: VALUE")
    places = {one.span for one in diagnostics}
    values = {key: value for key, value in node.values.items() if node.parameters[key].span not in places}
    kind = full_type(node.type)
    known = derive(case.robot, Controller(node.name, kind, values), kind)
    moving = any(not joint.is_fixed for joint in case.robot.joints)
    for one in against_robot(node.shown, kind, values, known, case.robot, ERROR):
        if one.rule == "controller-name" and not moving:
            continue  # a description of where things are mounted
        if wrong is not None:  # of a package that is not known, whose keys may mean something else
            one = one._replace(severity=WARNING)
        drive = [case.related("the drive of the robot", ("drive",), key=True)]
        yield one.place(node.setting(one.key).span, drive if one.rule == "controller-differs" else [])


def _read(paths: Iterable[Path], diagnostics: list[Diagnostic]) -> list[list[Section]]:
    """Return the sections of each file. What is wrong is added to ``diagnostics``; files of MoveIt are a note."""
    read: list[list[Section]] = []
    for path in paths:
        try:
            sections, wrong = read_file(path)
        except NoParameters as problem:
            found = problem.diagnostic
            text = found.span.source.text if found.span is not None else ""
            if _MOVEIT.search(text) and PARAMETERS not in text:
                message = (
                    f"{path.name} is not checked: it has no parameters of a node, and launch files of MoveIt read it"
                )
                found = Diagnostic("parameters-syntax", NOTE, message)
            diagnostics.append(found)
        else:
            read.append(sections)
            diagnostics += wrong
    return read


def summary(looked: CheckedParameters) -> str:
    """Return what was judged, in a line."""
    severities = [one.severity for one in looked.diagnostics]
    counts = phrase(count_of(severities.count(s), s) for s in ("error", "warning", "note") if s in severities)
    line = f"{count_of(looked.judged, 'edge')} of nodes compared with the files: {counts or 'as described'}"
    if looked.absent:
        line += f"; no known parameters of {phrase(looked.absent)}"
    return line
