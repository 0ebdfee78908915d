"""Names: what a ROS 2 package may be called, and what the files in it are called.

The mapping says where in a folder the artifacts of a robot stand, in a small file there.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from pathlib import Path

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import error
from rosorin_compile.source.load import LoadError, load_mapping
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.yaml_text import Scalar

RULES = (
    Rule(
        "deploy-mapping",
        "The file that remembers `--map` is damaged.",
        "Remove it, and say `--map` once more.",
        Heading.PACKAGES,
    ),
)


# REP 144: lowercase letters, digits and single underscores, a letter first, at least two characters.
_LEGAL = re.compile(r"(?=.{2})[a-z](_?[a-z0-9])*")
_PLAIN = re.compile(r"[A-Za-z0-9_.+-]+")

# What a package may start besides the publishers of the frames.
CONTROL, MOVEIT, NAV2 = STARTS = ("control", "moveit", "nav2")

OF_A_NAME = "lowercase letters, digits and single underscores, a letter first, at least two characters"


def is_legal(name: str) -> bool:
    """Say whether a name is one for a ROS 2 package (REP 144)."""
    return _LEGAL.fullmatch(name) is not None


def package_name(robot: str) -> str:
    """Return the default name of the package of a robot, always a legal one.

    >>> package_name("rosorin"), package_name("My Robot-2"), package_name("2wd")
    ('rosorin_description', 'my_robot_2_description', 'robot_2wd_description')
    """
    plain = unicodedata.normalize("NFKD", robot).encode("ascii", "ignore").decode().lower()
    name = re.sub("[^a-z0-9]+", "_", plain).strip("_")
    name = name if name[:1].isalpha() else f"robot_{name}".rstrip("_")
    return f"{name}_description"


def file_name(file: str, otherwise: str) -> str:
    """Return the last part of the name of an artifact, or another one if a launch file could not say it as it is."""
    last = file.rpartition("/")[2]
    return last if _PLAIN.fullmatch(last) else otherwise


FILE = ".rosorin-compile-deploy.yaml"
NOWHERE = "none"


def read(folder: Path, robot: str) -> dict[str, str]:
    """Return the places by output that the file in ``folder`` remembers for a robot; none if there is no file.

    Raises LoadError for a file that is damaged.
    """
    path = folder / FILE
    if not files.is_file(path):
        return {}
    robots = load_mapping(path, str(path)).get("robots")
    mapping = robots.get(robot) if isinstance(robots, dict) else None
    if (
        robots is None
        or not isinstance(mapping, dict | None)
        or not all(isinstance(v, str) for v in (mapping or {}).values())
    ):
        message = f"{path} does not say robots: {{ROBOT: {{OUTPUT: PLACE}}}}"
        raise LoadError(error("deploy-mapping", message, None, "remove it, and say --map once more"))
    return dict(mapping or {})


def text(folder: Path, robot: str, places: Mapping[str, str]) -> str:
    """Return the text of the file that remembers ``places`` for a robot beside what it says of others.

    Raises LoadError for a file that is damaged.
    """
    path = folder / FILE
    robots = dict(load_mapping(path, str(path)).get("robots") or {}) if files.is_file(path) else {}
    robots[robot] = dict(places)
    lines = [f"# Where rosorin-compile deploy puts artifacts in this folder ({NOWHERE}: not here).", "robots:"]
    for name in sorted(robots):
        lines.append(f"  {Scalar(name).quoted()}:")
        entries = sorted(robots[name].items())
        lines += [f"    {Scalar(output).quoted()}: {Scalar(place).quoted()}" for output, place in entries]
    return "\n".join(lines) + "\n"
