"""Parse users' launch files without running them, and check their static transforms against the description."""

import ast
import math
import operator
import re
import shlex
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Joint, Pose, Robot, Transform
from rosorin_compile.output.atomic_files import is_generated
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Source, Span
from rosorin_compile.source.files import read_bytes
from rosorin_compile.source.load import LoadError, parse_yaml, python_of
from rosorin_compile.source.numbers import METRE_DIGITS, RADIAN_DIGITS, to_fixed
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import MarkupError, parse

from .package.package_files import is_launch_file

Names = Mapping[str, Any]
_CHANGES = ("append", "clear", "extend", "insert", "pop", "remove", "reverse", "sort", "update")
_OPERATORS: Mapping[Any, Any] = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Div: operator.truediv}
_CONVERSIONS: Mapping[str, Callable[[Any], Any]] = {"math.radians": math.radians, "float": float, "str": str}
# An escaped character, a launch argument, or another substitution, whose value is only known at launch.
_SUBSTITUTION = re.compile(r"\\(.)|\$\((?:var|arg) ([^\s()$]+)\)|\$\([^()]*\)?")
_UNKNOWN = "\0"

_MAX_LAUNCH = 1_000_000  # bytes
# Tolerances for the rounding of hand-written numbers: 0.01 mm, 0.006 deg.
METRES, RADIANS = 1e-5, 1e-4
_XYZ = ("--x", "--y", "--z")
_RPY = ("--roll", "--pitch", "--yaw")
_QUATERNION = ("--qx", "--qy", "--qz", "--qw")
_FRAMES = ("--frame-id", "--child-frame-id")
# The flags that positional arguments correspond to, by number of arguments. Yaw comes before pitch and roll.
_WITHOUT_FLAGS = {8: (*_XYZ, "--yaw", "--pitch", "--roll", *_FRAMES), 9: (*_XYZ, *_QUATERNION, *_FRAMES)}


class LaunchError(Exception):
    """A launch file that cannot be parsed; the message is the reason."""


class _Unknown(Exception):
    """The value of an expression is only known at runtime."""


class Remap(NamedTuple):
    """A remap with the names as written in the file; ``node`` is the name of the node, or "" for all nodes."""

    name: str
    to: str
    span: Span | None = None
    node: str = ""


class LaunchNode(NamedTuple):
    """A node in a launch file, or remaps for all nodes if ``name`` is ""; None is a value only known at launch."""

    name: str
    executable: str
    arguments: tuple[str | None, ...] | None
    remaps: tuple[Remap, ...] | None
    span: Span


def nodes_of(source: Source) -> Iterator[LaunchNode]:
    """Yield the nodes of a launch file in Python, YAML or XML, by its file extension. Raises LaunchError."""
    read = {".py": _python, ".yaml": _yaml, ".yml": _yaml}.get(Path(source.path).suffix, _xml)
    try:
        yield from read(source)
    except RecursionError:
        raise LaunchError("nested too deep") from None


def _xml(source: Source) -> Iterator[LaunchNode]:
    try:
        elements = list(parse(source).root.iter())
    except MarkupError as problem:
        raise LaunchError(f"not XML: {problem.diagnostic.message}") from None
    passed = {id(inner) for one in elements if one.tag == "include" for inner in one.iter()}  # to an included file
