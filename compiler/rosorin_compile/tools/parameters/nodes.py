"""The nodes that parameter files speak of: what each is, and what holds for it, given or by default."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from ...diagnostics import WARNING, Diagnostic, Span, did_you_mean, error
from ...diagnostics.registry import PARAMETERS, Rule
from .files import Parameter, Section
from .tables import Kind, by_name, by_signs, controller, controller_by_keys, controller_types

RULES = (
    Rule(
        "parameters-unknown-type",
        "There is no stock controller of a type; a warning where it may be a controller of your own.",
        "Correct the type.",
        PARAMETERS,
    ),
    Rule(
        "parameters-reach-nobody",
        "A warning: a node in a namespace does not get parameters that name it without.",
        "`/NAMESPACE/NODE:`, or `/**/NODE:`.",
        PARAMETERS,
    ),
)

MANAGER = "controller_manager"
DEFAULT = "by default"


class Setting(NamedTuple):
    """What holds for a key of a node: its value, the place that says so, and whether that is its default alone."""

    value: Any
    span: Span
    given: bool

    @property
    def how(self) -> str:
        """The end of a sentence about it: nothing, or that it is a default."""
        return "" if self.given else f" {DEFAULT}"


@dataclass(frozen=True)
class Node:
    """A node of the files: its full name, the place that names it, its kind if it is known, and its parameters."""

    full: str
    span: Span
    kind: Kind | None
    parameters: Mapping[str, Parameter]

    @property
    def name(self) -> str:
        """The name without the namespace."""
        return self.full.rsplit("/", 1)[-1]

    @property
    def namespace(self) -> str:
        """The namespace; / for none."""
        return self.full.rsplit("/", 1)[0] or "/"

    @property
    def shown(self) -> str:
        """What messages call it."""
        return self.full.strip("/")

    def setting(self, key: str, default: Any = None) -> Setting:
        """Return what holds for a key: what is given, else the default of the tables, else ``default``."""
        given = self.parameters.get(key)
        if given is not None:
            return Setting(given.value, given.span, True)
        known = self.kind.key(key) if self.kind else None
        value = known.default if known is not None and known.default is not None else default
        return Setting(value, self.span, False)


class Files(NamedTuple):
    """What was read: a list of sections for each file."""

    sections: Sequence[Sequence[Section]]
    namespace: str
    distribution: str


def found(files: Files) -> tuple[list[Node], list[Diagnostic]]:
    """Return the nodes that files speak of, each once, and what is wrong with what they are.

    Wildcards of a file hold for the nodes that it names; where it names none, it is of one node, which its keys tell.
    """
    named: dict[str, list[Section]] = {}
    told: list[Diagnostic] = []
    for sections in files.sections:
        nodes = [section for section in sections if not section.of_any]
        for section in nodes:
            full = _full(section, files.namespace)
            if not section.matches(full):
                told.append(_reaches_nobody(section, full))
            mine = [one for one in sections if one is section or (one.of_any and one.matches(full))]
            named.setdefault(full, []).extend(mine)
        if not nodes and sections:
            merged = _merged(sections)
            kind = by_signs(merged, files.distribution)
            if kind is not None:
                named.setdefault(f"{files.namespace.rstrip('/')}/{kind.names[0]}", []).extend(sections)
    types = dict(_types(named))
    for full, (plugin, parameter) in types.items():
        told += _unknown_type(plugin, parameter)
        named.setdefault(full, [])
    return [_node(full, sections, types, files) for full, sections in named.items()], told


def _full(section: Section, namespace: str) -> str:
    """Return the full name of the node that a section names: in its own namespace, or that of the run."""
    words = section.name.strip("/").split("/")
    own = [word for word in words if word not in ("*", "**")]
    if own != words or (len(words) == 1 and namespace.strip("/")):
        return "/" + "/".join([*filter(None, namespace.strip("/").split("/")), *own])
    return section.name


def _reaches_nobody(section: Section, full: str) -> Diagnostic:
    message = f'"{section.name.strip("/")}" does not reach the node {full}, which has its defaults then'
    help = f"write {full} or /**{section.name}, unless the launch file rewrites the file for the namespace"
    return Diagnostic("parameters-reach-nobody", WARNING, message, section.span, help=help)


def _merged(sections: Sequence[Section]) -> dict[str, Parameter]:
    """Return the parameters of sections; the later ones win."""
    return {name: value for section in sections for name, value in section.parameters.items()}


def _types(named: Mapping[str, list[Section]]) -> Iterator[tuple[str, tuple[str, Parameter]]]:
    """Yield the controllers that managers name: full name, type, and the parameter that says so."""
    for full, sections in named.items():
        space, _, name = full.rpartition("/")
        for key, parameter in _merged(sections).items():
            own = name == MANAGER and key.endswith(".type") and key.count(".") == 1
            if own and isinstance(parameter.value, str):
                yield f"{space}/{key.removesuffix('.type')}", (parameter.value, parameter)


def _unknown_type(plugin: str, parameter: Parameter) -> Iterator[Diagnostic]:
    if plugin in controller_types():
        return
    near = did_you_mean(plugin, controller_types())
    if near.startswith("did"):
        yield error("parameters-unknown-type", f'there is no controller "{plugin}"', parameter.span, near)


def _node(full: str, sections: list[Section], types: Mapping[str, tuple[str, Parameter]], files: Files) -> Node:
    parameters = _merged(sections)
    spans = [section.span for section in sections if not section.of_any] or [section.span for section in sections]
    if full in types:
        plugin, says = types[full]
        kind = controller(plugin, files.distribution)
        if kind is None and plugin not in controller_types():
            kind = controller_by_keys(parameters, files.distribution)
        return Node(full, spans[0] if spans else says.key, kind, parameters)
    name = full.rsplit("/", 1)[-1]
    if name == MANAGER:
        return Node(full, spans[0], None, parameters)
    own = parameters.get("type")
    kind = controller(own.value, files.distribution) if own is not None and isinstance(own.value, str) else None
    kind = kind or by_name(name, files.distribution) or controller_by_keys(parameters, files.distribution)
    kind = kind or by_signs(parameters, files.distribution)
    return Node(full, spans[0], kind, parameters)
