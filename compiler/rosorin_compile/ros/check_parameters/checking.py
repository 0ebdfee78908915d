"""check parameters: what parameter files and remaps say, held against one robot."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rosorin_compile.model import Controller
from rosorin_compile.model.joint import NODE
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import Case, report
from rosorin_compile.source.diagnostics import (
    ERROR,
    NOTE,
    WARNING,
    Diagnostic,
    Related,
    RequestError,
    Source,
    Span,
    counted,
    error,
    has_errors,
    listed,
)
from rosorin_compile.source.files import is_file
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.project import no_file

from ..controllers.checking import against_robot, missing, of_type
from ..controllers.derived import derived
from ..controllers.filled import intended_topic
from ..graph import End, Graph, mismatched_qos
from ..parameters.files import PARAMETERS, NoParameters, Section, read_file
from ..parameters.tables import MANAGER
from ..ports import IMU, ODOMETRY, VELOCITY, controller_ports, full_topic, full_type, ports, short_type
from . import owners, sources
from .nodes import Files, Node, check_node, found
from .remaps import Remap, of_launch, of_word

_USUAL = "odom"
# Keys of the configuration files of MoveIt, which are no parameter files.
_MOVEIT = re.compile(
    r"\b(cartesian_limits|joint_limits|kinematics_solver|moveit_controller_manager|moveit_simple_controller_manager"
    r"|octomap_frame|planner_configs|planning_plugins?|sensor_plugin|trajectory_execution)\s*:"
)
_OF_CONTROLLER = re.compile(r"_controller/odom(etry)?\Z")  # as controllers of a drive are called


@dataclass(frozen=True)
class ParameterFiles:
    """Parameter files of nodes, and how the nodes are started.

    ``controllers`` are the files that must have controllers, ``launch`` launch files to read remappings from.
    ``remaps`` are further ones as NODE:FROM:=TO. Without a distribution, parameters of all ROS 2 distributions are
    accepted, or of the one that the outputs of the robot name.
    """

    files: Sequence[Path] = ()
    controllers: Sequence[Path] = ()
    launch: Sequence[Path] = ()
    remaps: Sequence[str] = ()
    namespace: str = ""
    distribution: str = ""

    def remappings(self) -> list[Remap]:
        """Return the remappings. Raises RequestError for one that is invalid."""
        found = []
        for word in self.remaps:
            remap = of_word(word)
            if remap is None:
                raise RequestError(f'"{word}" is no remap: write NODE:FROM:=TO, as in controller:~/tf_odometry:=/tf')
            found.append(remap)
        return found

    def check(self) -> None:
        """Raise RequestError for a file that does not exist."""
        for path in (*self.files, *self.controllers, *self.launch):
            if not is_file(path):
                raise RequestError(no_file(path))


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
    """
    nodes, managers, launches = ([Path(file) for file in paths] for paths in (files, controllers, launch))
    asked = ParameterFiles(nodes, managers, launches, remaps, namespace, distribution or "")
    asked.check()
    asked.remappings()
    understood = Request.of(robot, arguments, packages, trust=trust).understand()
    if understood.case is None:
        return CheckedParameters(diagnostics=tuple(one for one in understood.diagnostics if one.severity == ERROR))
    return look(understood.case, asked)


def look(case: Case, asked: ParameterFiles) -> CheckedParameters:
    """Check parameter files against a robot. Raises RequestError."""
    told: list[Diagnostic] = []
    sections = _read((*asked.controllers, *asked.files), told)
    remaps = asked.remappings()
    for path in asked.launch:
        more, said = of_launch(path)
        remaps += more
        told += said
    distribution = asked.distribution or _distribution(case)
    nodes, said = found(Files(sections, asked.namespace, distribution, case.robot.controllers))
    told += said
    if asked.controllers and not any(node.type for node in nodes) and not has_errors(told):
        told.append(_none(sections, asked.controllers[0]))
    for node in nodes:
        told += _of_node(case, node, distribution)
    claims = owners.claims(nodes, remaps, told)
    told += owners.check(case, claims)
    told += owners.check_frames(case, nodes, claims)
    made = _graph(nodes, remaps, distribution)
    told += _unheard(nodes, made, distribution)
    told += sources.check(case.robot, nodes, made)
    judged, absent = _judged(case, nodes)
    unknown = [node.shown for node in nodes if node.kind is None and _could_publish(case, node)]
    return CheckedParameters(case.robot.name, judged, tuple(absent), tuple(unknown), tuple(arrange(told)))


def _none(files: Sequence[Sequence[Section]], path: Path) -> Diagnostic:
    help = f"{MANAGER}: {{ros__parameters: {{NAME: {{type: TYPE}}}}}}"
    first = next((section.span for sections in files for section in sections), Span(Source(str(path), ""), 1, 1))
    return error("controllers-none", "no controller has a type here", first, help)


def _of_node(case: Case, node: Node, distribution: str) -> Iterator[Diagnostic]:
    wrong = of_type(node.shown, node.type, distribution) if node.type else None
    if wrong is not None:
        yield wrong.at(node.said)
    if wrong is not None and wrong.severity == ERROR:
        return  # of which no key would be right
    told = list(check_node(node))
    yield from told
    if not node.type:
        return
    if wrong is None:
        yield from (one.at(node.span) for one in missing(node.shown, node.kind, node.parameters))
    places = {one.span for one in told}
    fine = {key: one for key, one in node.parameters.items() if not one.substituted and one.span not in places}
    plain = {key: one.value for key, one in fine.items()}
    kind = full_type(node.type)
    knows = derived(case.robot, Controller(node.name, kind, plain), kind)
    moving = any(not joint.is_fixed for joint in case.robot.joints)
    for one in against_robot(node.shown, kind, plain, knows, case.robot, ERROR):
        if one.rule == "controller-name" and not moving:
            continue  # a description of where things are mounted
        if wrong is not None:  # of a package that is not known, whose keys may mean something else
            one = one._replace(severity=WARNING)
        yield one.at(node.setting(one.key).span, _drive(case, one.rule))


def _drive(case: Case, rule: str) -> list[Related]:
    return [case.related("the drive of the robot", ("drive",), key=True)] if rule == "controller-differs" else []


def _distribution(case: Case) -> str:
    said = {str(one.options["distribution"]) for one in case.robot.outputs if "distribution" in one.options}
    return said.pop() if len(said) == 1 else ""


def _read(paths: Iterable[Path], told: list[Diagnostic]) -> list[list[Section]]:
    read: list[list[Section]] = []
    for path in paths:
        try:
            sections, said = read_file(path)
        except NoParameters as problem:
            found = problem.diagnostic
            text = found.span.source.text if found.span is not None else ""
            if _MOVEIT.search(text) and PARAMETERS not in text:
                message = (
                    f"{path.name} has no parameters of a node: launch files of MoveIt read it, and it is not checked"
                )
                found = Diagnostic("parameters-syntax", NOTE, message)
            told.append(found)
            continue
        read.append(sections)
        told += said
    return read


def _judged(case: Case, nodes: Sequence[Node]) -> tuple[int, list[str]]:
    publishers = case.robot.publishers
    judged, absent = 0, []
    for edge in case.robot.edges:
        if edge.publisher.kind != NODE:
            continue
        mine = [node for node in nodes if node.is_of(edge.publisher, publishers)]
        if any(node.kind is not None for node in mine):
            judged += 1
        elif edge.publisher.name not in absent:
            absent.append(edge.publisher.name)
    return judged, absent


def _could_publish(case: Case, node: Node) -> bool:
    return any(node.is_of(publisher, case.robot.publishers) for publisher in case.robot.publishers)


def summary(looked: CheckedParameters) -> str:
    """Return what was judged, in a line."""
    severities = [one.severity for one in looked.diagnostics]
    told = listed(counted(severities.count(s), s) for s in ("error", "warning", "note") if s in severities)
    line = f"{counted(looked.judged, 'edge')} of nodes held against the files: {told or 'as described'}"
    if looked.absent:
        line += f"; no known parameters of {listed(looked.absent)}"
    return line


def _graph(nodes: Sequence[Node], remaps: Sequence[Remap], distribution: str) -> Graph:
    """Return the topics of all nodes that are in the table of ports, but for those that a launch file names."""
    made = Graph()
    for node in nodes:
        kind = node.kind.name if node.kind is not None else ""
        known = ports(distribution, node=kind) if kind and not node.type else ()
        values = {key: one.value for key, one in node.parameters.items() if not one.substituted}
        every = (*known, *controller_ports(full_type(node.type), distribution))
        those = [one for one in every if not one.each and node.setting(one.parameter).value != ""]
        those = [one for one in those if one.parameter in values or one.parameter not in node.parameters]
        moved = [(one.name, one.to) for one in reversed(remaps) if one.node in ("", node.name)]
        made.add(node.full, those, values, node.namespace, moved)
    return made


def _unheard(nodes: Sequence[Node], made: Graph, distribution: str) -> Iterator[Diagnostic]:
    """Yield topics that nodes read and no node publishes, if a controller publishes a similar one, and wrong types."""
    by_name = {node.full: node for node in nodes}
    for end in made.read:
        there, role, node = made.publishers(end), end.port.role, by_name[end.node]
        sources = [one for one in made.published if one.port.role == role and one.port.group == "control"]
        fitting = [one for one in there if one.type == end.type]
        if mismatch := mismatched_qos(end, fitting):
            help = f"qos_overrides.{end.topic}.publisher.reliability: reliable"
            yield report("parameters-topic", mismatch, node.span, help)
        if fitting:
            continue
        if there and distribution and role == VELOCITY:
            message = f"{node.shown} takes {short_type(end.type)} on {end.topic}, and {there[0].node.strip('/')} sends "
            message += f"{short_type(there[0].type)}: {end.port.missing}"
            help = "give both the same value of enable_stamped_cmd_vel"
            yield report("parameters-topic", message, node.span, help)
        elif role == ODOMETRY and sources:
            yield from _unpublished_odometry(node, end, {by_name[one.node]: one.topic for one in sources})
        elif role == IMU and sources and not there:
            message = f"{node.shown} listens to the IMU {end.topic}, and in the files {sources[0].node.strip('/')} "
            message += f"publishes {sources[0].topic}"
            help = f"{end.key}: {sources[0].topic.strip('/')}; or say the remap: --remap NODE:FROM:=TO"
            yield report("parameters-topic", message, node.setting(end.key).span, help, severity=NOTE)


def _unpublished_odometry(node: Node, end: End, sources: Mapping[Node, str]) -> Iterator[Diagnostic]:
    heard, setting = end.topic, node.setting(end.key)
    meant = intended_topic(heard, {source.full.strip("/"): topic for source, topic in sources.items()})
    of_drive = heard in (full_topic(_USUAL, node.namespace, ""), f"/{_USUAL}") or _OF_CONTROLLER.search(heard)
    if not meant and not of_drive:
        return  # of somebody else, such as a camera
    source, topic = next((one for one in sources.items() if one[1] == meant), next(iter(sources.items())))
    message = f'{node.shown} listens to the odometry {heard} ("{end.key}"{setting.how}), and no node in the files '
    message += f"publishes that: {source.shown} publishes {topic}"
    help = f"{end.key}: {topic.strip('/')}" + ("" if meant else "; or say the remap: --remap NODE:FROM:=TO")
    related = (Related(f"{source.shown} is here", source.span),)
    yield report("parameters-odometry", message, setting.span, help, related, WARNING if meant else NOTE)
