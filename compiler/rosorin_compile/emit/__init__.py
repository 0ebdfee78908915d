"""Backends: one module each, all in the table ``BACKENDS``.

A backend turns the model into the text of one artifact. It sees the model, the templates and diagnostics, never YAML,
the disk or the terminal.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple, Protocol, cast

if TYPE_CHECKING:
    from ..diagnostic import Diagnostic
    from ..model import Output, Robot
    from ..templating import Templates

# The name in ``outputs:`` and the module that emits it; modules are imported only when a robot asks for them.
BACKENDS: Mapping[str, str] = {
    "urdf": "urdf",
    "mjcf": "mjcf",
    "static_tf": "static_tf",
    "static_tf_json": "static_tf_json",
    "robot_model": "robot_model",
    "frames": "frames",
    "frames_picture": "frames_picture",
    "template": "template",
}


class Artifact(NamedTuple):
    """One emitted file: its name in the outputs folder, its text, the backend that made it."""

    file: str
    text: str
    backend: str
    output: str

    def __repr__(self) -> str:
        """Return all but the text, which may be long."""
        return f"<Artifact {self.file}: {self.backend}, {len(self.text):,} characters>"


class Fact(NamedTuple):
    """What a fact is about: ``kind`` joint, link, frame or pose; its name; the quantity, such as "origin z"."""

    kind: str
    name: str
    quantity: str


class Value(NamedTuple):
    """The value of a fact: a number in SI units with the half width of what was printed, or a text."""

    value: float | str
    unit: str = ""
    tolerance: float = 0.0


Facts = dict[Fact, Value]


class Backend(Protocol):
    """What each module in the table offers."""

    def emit(self, robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
        """Return the text of the artifact, and what the format cannot say."""

    def read(self, text: str) -> Facts:
        """Return what an artifact of this kind says, for comparison by meaning. Raises ValueError if it is damaged."""


def backend(name: str) -> Backend:
    """Return the backend of that name. Raises KeyError if there is none."""
    return cast(Backend, import_module(f".{BACKENDS[name]}", __name__))
