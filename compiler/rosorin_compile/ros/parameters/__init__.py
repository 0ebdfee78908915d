"""Parameters of ROS 2 nodes: what is known of them, and values held against that.

Formats write such parameters (``files``), and ``check parameters`` reads those that people have. ``tables`` says
which kinds of nodes there are and which keys each has, ``values`` which values fit a type and what its validators
refuse, ``checking`` what is wrong with the parameters of one node.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.format import DISTRIBUTIONS

from ..ports import facts

if TYPE_CHECKING:
    from .files import Parameters

# What every format that is a parameter file has.
DISTRIBUTION: Mapping[str, Any] = {
    "enum": DISTRIBUTIONS,
    "description": "The distribution of ROS 2 whose nodes it is for; default jazzy.",
}


def options_of(name: str) -> dict[str, Any]:
    """Return the options of an output that is a parameter file, by the name of its format."""
    return {"distribution": DISTRIBUTION, **facts("ros2_options")[name]}


def read(written: str) -> Parameters:
    """Return what a parameter file contains. Raises ValueError for a damaged text."""
    from .files import read

    return read(written)


def syntax(written: str) -> object:
    """Return the values of a parameter file without layout and comments. Raises ValueError."""
    from .files import nodes_of

    return nodes_of(written)
