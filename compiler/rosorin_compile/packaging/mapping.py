"""The mapping: where in a folder the artifacts of a robot stand, kept in a small file in that folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..diagnostic import error
from ..load import LoadError, load_mapping
from ..registry import PACKAGES, Rule
from ..yaml_text import quoted

RULES = (
    Rule(
        "deploy-mapping",
        "The file that remembers `--map` is damaged.",
        "Remove it, and say `--map` once more.",
        PACKAGES,
    ),
)

FILE = ".rosorin-compile-deploy.yaml"
NOWHERE = "none"


def read(folder: Path, robot: str) -> dict[str, str]:
    """Return the places by output that the file in ``folder`` remembers for a robot; none if there is no file.

    Raises LoadError for a file that is damaged.
    """
    path = folder / FILE
    if not path.is_file():
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
    robots = dict(load_mapping(path, str(path)).get("robots") or {}) if path.is_file() else {}
    robots[robot] = dict(places)
    lines = [f"# Where rosorin-compile deploy puts artifacts in this folder ({NOWHERE}: not here).", "robots:"]
    for name in sorted(robots):
        lines.append(f"  {quoted(name)}:")
        lines += [f"    {quoted(output)}: {quoted(place)}" for output, place in sorted(robots[name].items())]
    return "\n".join(lines) + "\n"
