"""Parameters of ROS 2 nodes: what is known of them, and values held against that.

Formats write such parameters, and ``check parameters`` reads those that people have: ``files``. ``tables`` has the
kinds of nodes with the keys of each and the values that these take, ``checking`` what is wrong with one node.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.format import DISTRIBUTIONS, Format

from ..ports import facts

if TYPE_CHECKING:
    from .files import Parameters

# What every format that is a parameter file has.
DISTRIBUTION: Mapping[str, Any] = {
    "enum": DISTRIBUTIONS,
    "description": "The distribution of ROS 2 whose nodes it is for; default jazzy.",
}


def parameter_file(name: str, **more: Any) -> Format:
    """Return the format of a parameter file by its name, with the fields that it does not share with others."""
    return Format(
        name=name,
        article="a",
        options={"distribution": DISTRIBUTION, **facts("ros2_options")[name]},
        read=_read,
        names_robot=False,
        syntax=lambda text: _read(text).node,
        folder="config",
        deploys=True,
        **more,
    )


def _read(text: str) -> Parameters:
    from .files import read

    return read(text)
