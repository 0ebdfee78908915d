"""A robot under other names of links and joints: all that names one follows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.frontend.expand import expand
from rosorin_compile.frontend.lower import lower
from rosorin_compile.meaning.renaming import renamed
from rosorin_compile.model import Robot
from support import naming

PLACES = {place.path: place for place in naming.places() if place.kind in ("link", "joint") and not place.gives}


def texts(value: Any) -> Iterator[str]:
    """Yield every text of a model, keys too."""
    if isinstance(value, str):
        yield value
    elif is_dataclass(value):
        for field in fields(value):
            yield from texts(getattr(value, field.name))
    elif isinstance(value, Mapping):
        for key, one in value.items():
            yield from (*texts(key), *texts(one))
    elif isinstance(value, (tuple, list, frozenset)):
        for one in value:
            yield from texts(one)


def robot_of(path: str, folder: Path) -> Robot:
    """Return the robot that has something at a place."""
    expanded = expand(naming.dumped(folder, naming.plain(PLACES[path].fragment)), {}, None)
    assert expanded.tree is not None
    robot = lower(expanded.tree).robot
    assert robot is not None
    return robot


@pytest.mark.parametrize("path", PLACES)
def test_what_names_a_link_or_a_joint_follows(path: str, tmp_path: Path) -> None:
    robot = robot_of(path, tmp_path)
    links, joints = {name: f"of_{name}" for name in robot.link}, {name: f"by_{name}" for name in robot.joint}
    other = renamed(robot, links, joints)
    assert [one for one in texts(other) if one in links or one in joints] == []
    back = renamed(other, *({new: old for old, new in names.items()} for names in (links, joints)))
    assert back == robot
