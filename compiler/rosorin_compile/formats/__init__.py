"""The registry of formats for export and import: ``FORMATS`` maps names to ``Format`` objects."""

import json
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module

from rosorin_compile.language.schema import authoring_schema, schema
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Output, Robot
from rosorin_compile.rules.case import outputs_read_by
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.plugins import installed_plugins
from rosorin_compile.source.project import data_folder

from .format import Artifact, Format, ImportFile

__all__ = ["FORMATS", "Artifact", "Format", "Formats", "ImportFile", "plugged_diagnostics"]
__all__ += ["schema_names", "schema_text"]

# Formats by package. The module of a format defines ``FORMAT`` and is imported on first use.
_PACKAGES = {
    "formats": ("urdf", "frames", "robot_model", "static_tf"),
    "importing": ("xacro",),
    "mujoco": ("mjcf", "scene"),
    "ros": ("controllers", "nav2", "robot_localization", "srdf"),
    "viewer": ("page",),
}
_MODULES = {name: f"rosorin_compile.{package}.{name}" for package, names in _PACKAGES.items() for name in names}
_MODULES |= {"sdf": "rosorin_compile.sdf", "template": "rosorin_compile.formats.templating"}
_MODULES |= {"static_tf_json": _MODULES["static_tf"], "frames_picture": "rosorin_compile.viewer.frames"}
# JSON Schemas that do not belong to a format, with a description of each.
_SCHEMAS = {
    "authoring": "a description as written, with expressions, parts and loops (default)",
    "description": "a description after includes, arguments and expressions are evaluated",
    "robot_diff": "the result of diff --format json",
    "recording": "the result of verify --format json",
    "envelope": "the output of any command with --format json",
}


class Formats(Mapping[str, Format]):
    """A mapping from names to formats, in the order in which users see them; formats of plug-ins come last."""

    def __getitem__(self, name: str) -> Format:
        return _built_in(name) or _plugged()[0][name]

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and (name in _MODULES or name in _plugged()[0])

    def __iter__(self) -> Iterator[str]:
        return iter(_names())

    def __len__(self) -> int:
        return len(_names())

    def is_own(self, name: str) -> bool:
        return name in _MODULES

    def outputs_read_by(self, robot: Robot, publisher: str) -> list[Output]:
        return outputs_read_by(robot, publisher, self)

    def feeds(self, artifact: Artifact, publisher: str) -> bool:
        return publisher in self[artifact.backend].feeds and not artifact.withheld

    def names_meshes(self, artifact: Artifact) -> bool:
        """Return True if an artifact is a URDF, or refers to mesh files in the same way as a URDF."""
        by_name = (one.meshes and artifact.file.endswith(one.endings) for one in self.values())
        return self[artifact.backend].meshes or any(by_name)

    def endings(self, *, include: bool = False) -> tuple[str, ...]:
        """Return the file extensions that can be imported or, with ``include``, included in a description."""
        readable = [one for one in self.values() if one.load is not None and (one.include or not include)]
        return tuple(dict.fromkeys(ending for one in readable for ending in one.endings))

    def published_format(self) -> Format:
        """Return the format that robot_state_publisher reads (URDF)."""
        return next(one for one in self.values() if one.write and one.load and ROBOT_STATE_PUBLISHER in one.feeds)


FORMATS = Formats()


@cache
def _names() -> tuple[str, ...]:
    groups = (filter(None, map(_built_in, _MODULES)), _plugged()[0].values())
    return tuple(one.name for group in groups for one in sorted(group, key=lambda one: (one.rank, one.name)))


@cache
def _built_in(name: str) -> Format | None:
    module = import_module(_MODULES[name]) if name in _MODULES else None
    format: Format | None = module.FORMAT if module else None
    return module.LIST if module and format and format.name != name else format


def _plugged() -> tuple[Mapping[str, Format], tuple[Diagnostic, ...]]:
    if not any(plugin.group == "formats" for plugin in installed_plugins()):
        return {}, ()
    from .plugin_formats import plugin_formats

    return plugin_formats(tuple(filter(None, map(_built_in, _MODULES))))


def plugged_diagnostics() -> tuple[Diagnostic, ...]:
    """Return the diagnostics about plug-ins that define invalid formats."""
    return _plugged()[1]


def schema_names() -> dict[str, str]:
    """Map the name of each JSON Schema to a description of the schema."""
    return {**_SCHEMAS, **{one.schema: f"the artifact {one.name}" for one in FORMATS.values() if one.schema}}


def schema_text(name: str) -> str:
    """Return a JSON Schema as text. The schemas of descriptions include sections that plug-ins define."""
    if name == "description":
        return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"
    path = data_folder("schemas") / f"{name}.schema.json"
    return authoring_schema() if name == "authoring" else path.read_text("utf-8")
