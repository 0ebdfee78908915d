"""Names: what a ROS 2 package may be called, and what the files in it are called."""

from __future__ import annotations

import re
import unicodedata

# REP 144: lowercase letters, digits and single underscores, a letter first, at least two characters.
_LEGAL = re.compile(r"(?=.{2})[a-z](_?[a-z0-9])*")
_PLAIN = re.compile(r"[A-Za-z0-9_.+-]+")

RULES = "lowercase letters, digits and single underscores, a letter first, at least two characters"


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
