"""The nodes that parameter files speak of: what each is, and what holds for it, given or by default."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from rosorin_compile.model import Controller, Publisher
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span, error, nearest

from ..parameters.files import Parameter, Section
from ..parameters.tables import MANAGER, Kind, by_name, by_signs, controller, controller_by_keys, is_of, plugins
from ..ports import full_type

DEFAULT = "by default"


class Setting(NamedTuple):
    """What holds for a key of a node: its value, the place that says so, and whether that is its default alone.

    The value is None where nobody knows it: there is no default, or a launch file puts it in.
    """

    value: Any
    span: Span
    given: bool

    @property
    def how(self) -> str:
        """The end of a sentence about it: nothing, or that it is a default."""
        return "" if self.given else f" {DEFAULT}"


@dataclass(frozen=True, eq=False)
class Node:
    """A node of the files: its full name, the place that names it, its kind if it is known, and its parameters.

    ``type`` is that of a controller, empty for other nodes, and ``said`` where that stands. ``shared`` are keys that
    stand under a wildcard, where other nodes read them as well.
    """

    full: str
    span: Span
    kind: Kind | None
    parameters: Mapping[str, Parameter]
    type: str = ""
    said: Span | None = None
    shared: Collection[str] = ()

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

    def is_of(self, publisher: Publisher, publishers: Iterable[Publisher]) -> bool:
        """Say whether it is the node that a description calls a publisher."""
        return is_of(self.name, self.kind, publisher, publishers)

    def setting(self, key: str, default: Any = None) -> Setting:
        """Return what holds for a key: what is given, else the default of the tables, else ``default``."""
        given = self.parameters.get(key)
        if given is not None and given.substituted:
            return Setting(None, given.span, True)
        if given is not None:
            return Setting(given.value, given.span, True)
        known = self.kind.key(key) if self.kind else None
        value = known.default if known is not None and known.default is not None else default
        return Setting(value, self.span, False)


class Files(NamedTuple):
    """What was read: a list of sections for each file; and the controllers of the description."""

    sections: Sequence[Sequence[Section]]
    namespace: str
    distribution: str
    controllers: Sequence[Controller] = ()


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
    types = _types(named, files)
    for full in types:
        named.setdefault(full, [])
    told += _homeless(named, types)
    return [_node(full, sections, types.get(full), files.distribution) for full, sections in named.items()], told


def _full(section: Section, namespace: str) -> str:
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
    return {name: value for section in sections for name, value in section.parameters.items()}


class _Type(NamedTuple):
    """The type of a controller, and where it stands."""

    name: str
    span: Span


def _types(named: Mapping[str, list[Section]], files: Files) -> dict[str, _Type]:
    """Return the types of controllers by full name.

    The manager says them, or the node itself (the spawner reads it), or the description of a controller of that name.
    """
    described = {one.name: full_type(one.type) for one in files.controllers}
    found: dict[str, _Type] = {}
    for full, sections in named.items():
        space, _, name = full.rpartition("/")
        merged = _merged(sections)
        own = merged.get("type")
        if name == MANAGER:
            keys = ((key, one) for key, one in merged.items() if key.endswith(".type") and key.count(".") == 1)
            texts = ((key.removesuffix(".type"), one) for key, one in keys if isinstance(one.value, str))
            found |= {f"{space}/{key}": _Type(one.value, one.span) for key, one in texts}
        elif own is not None and isinstance(own.value, str) and _is_type(own.value):
            found.setdefault(full, _Type(own.value, own.span))
        elif name in described:
            found.setdefault(full, _Type(described[name], sections[0].span))
    return found


def _is_type(text: str) -> bool:
    return text in plugins("") or nearest(text, plugins("")) is not None


def _homeless(named: dict[str, list[Section]], types: Mapping[str, _Type]) -> Iterator[Diagnostic]:
    bare = {full.rpartition("/")[2]: full for full in types if not any(not one.of_any for one in named[full])}
    for full in [one for one in named if one not in types]:
        name = full.rpartition("/")[2]
        if name in bare:
            sections = named.pop(full)
            named[bare[name]] += sections
            yield _reaches_nobody(sections[0], bare[name])
        elif name != MANAGER and (meant := nearest(name, bare)) and _fits(named[full], types[bare[meant]].name):
            sections = named.pop(full)
            named[bare[meant]] += sections
            message = f'no controller is called "{name}": no node reads these parameters'
            yield error("parameters-reach-nobody", message, sections[0].span, f'did you mean "{meant}"?')


def _fits(sections: Sequence[Section], of_type: str) -> bool:
    kind, keys = controller(of_type, ""), _merged(sections)
    return kind is not None and 2 * sum(key in kind for key in keys) > len(keys)


def _node(full: str, sections: list[Section], of_type: _Type | None, distribution: str) -> Node:
    parameters = _merged(sections)
    own = [section for section in sections if not section.of_any]
    spans = [section.span for section in own or sections]
    shared = parameters.keys() - _merged(own).keys()
    if of_type is None:
        kind = by_name(full.rpartition("/")[2], distribution) or controller_by_keys(parameters, distribution)
        return Node(full, spans[0], kind or by_signs(parameters, distribution), parameters, shared=shared)
    kind = controller(of_type.name, distribution)
    if kind is None and of_type.name not in plugins(""):
        kind = controller_by_keys(parameters, distribution)
    return Node(full, spans[0] if spans else of_type.span, kind, parameters, of_type.name, of_type.span, shared)
