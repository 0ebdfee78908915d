"""The tree of a YAML file: dicts and lists with the position of every entry. Do not modify a finished tree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from .diagnostics import Related, Span, Use
from .wording import and_more

Path = tuple[str | int, ...]


class Instance(NamedTuple):
    """The include, part or loop iteration that inserted YAML into the tree, and its position.

    A part is a group of YAML entries, which each entry of "use" inserts. ``parent`` is the include or part around it.
    """

    message: str
    span: Span
    parent: Instance | None = None
    made: bool = False  # True for a part or a loop, False for an include
    prefix: str = ""  # the prefix of names in the part, including the prefixes of enclosing parts

    def stack(self) -> Iterator[Related]:
        """Yield the includes, parts and loops around a value, innermost first; if there are many, omit some."""
        steps: list[Related] = []
        here: Instance | None = self
        while here is not None:
            steps.append((Use if here.made else Related)(here.message, here.span))
            here = _including(here.parent, here.span)
        if len(steps) > 12:
            steps[6:-5] = [Related(and_more(len(steps) - 11).strip(), None)]
        yield from steps


class Include(Instance):
    """The inclusion of a file; ``included``, shared by all includes, maps the path of each file to its ``Include``."""

    included: dict[str, Include]


def _including(via: Instance | None, span: Span) -> Instance | None:
    return via.included.get(span.source.path) if isinstance(via, Include) else via


class Map(dict[str, "Any"]):
    """A YAML mapping with the spans of its keys and values; ``via`` is the ``Instance`` that inserted it, or None."""

    __slots__ = ("key_spans", "span", "value_spans", "via")

    def __init__(self, span: Span, via: Instance | None = None) -> None:
        self.span, self.via = span, via
        self.key_spans: dict[str, Span] = {}
        self.value_spans: dict[str, Span] = {}

    def put(self, key: str, value: Any, key_span: Span, value_span: Span) -> None:
        self[key] = value
        self.key_spans[key] = key_span
        self.value_spans[key] = value_span

    def put_from(self, other: Map, key: str) -> None:
        self.put(key, other[key], other.key_spans[key], other.value_spans[key])

    def setdefault_at(self, key: str, value: Any, span: Span) -> None:
        if key not in self:
            self.put(key, value, span, span)

    def locate(self, path: Sequence[str | int], key: bool = False) -> Place:
        """Return the position of the value at a path (or of its key), or of the nearest parent if there is no value."""
        node: Any = self
        span, via = self.span, self.via
        for depth, step in enumerate(path):
            if not has(node, step):
                break
            of_key = key and depth == len(path) - 1 and isinstance(node, Map)
            span, node = (node.key_spans if of_key else node.value_spans)[step], node[step]
            via = nearer(via, getattr(node, "via", None))
        return Place(span, via)

    def expression_keys(self) -> list[str]:
        return [key for key, value in self.items() if "${" in str(value)]

    def copy(self) -> Map:
        """Return a copy of the mapping to which entries may be added."""
        made = self.made_by(self.via)
        made.key_spans, made.value_spans = self.key_spans.copy(), self.value_spans.copy()
        return made

    def with_changes(self, changes: Mapping[str, Any]) -> Map:
        """Return a copy with some values replaced. It shares the spans of keys, so do not add keys to it."""
        made = self.made_by(self.via)
        made.update(changes)
        return made

    def made_by(self, via: Instance | None) -> Map:
        """Return a copy in which ``via`` is replaced. It shares the spans of keys, so do not add keys to it."""
        made = Map(self.span, via)
        made.update(self)
        made.key_spans, made.value_spans = self.key_spans, self.value_spans
        return made


class Seq(list["Any"]):
    """A YAML sequence with the spans of its items; ``via`` is the ``Instance`` that inserted it, or None."""

    __slots__ = ("span", "value_spans", "via")

    def __init__(self, span: Span, via: Instance | None = None) -> None:
        self.span, self.via = span, via
        self.value_spans: list[Span] = []

    def put(self, value: Any, span: Span) -> None:
        self.append(value)
        self.value_spans.append(span)


class Text(str):
    """A string that is quoted in YAML. An unquoted string is a plain ``str``; both are equal."""

    __slots__ = ()


class XmlText(Text):
    """A string of XML elements in a description; ``via`` is the part or loop that inserted it."""

    __slots__ = ("via",)
    via: Instance | None

    def __new__(cls, text: str, via: Instance | None = None) -> XmlText:
        made = super().__new__(cls, text)
        made.via = via
        return made


class Place(NamedTuple):
    """The position of a value, and the include, part or loop that inserted it (None: it is in the main file)."""

    span: Span
    via: Instance | None

    def stack(self) -> tuple[Related, ...]:
        via = self.via
        if via is not None and via.span != self.span:
            via = _including(via, self.span)
        while via is not None and not via.made and via.span != self.span and via.span.source == self.span.source:
            via = via.parent
        return tuple(via.stack()) if via else ()


def nearer(outer: Instance | None, own: Instance | None) -> Instance | None:
    """Return the ``Instance`` that inserted a value: ``own`` or, if that is None, ``outer``, which inserted its parent.

    If several parts or loop iterations share the value, ``own`` may be the wrong one; then return ``outer``.
    """
    is_shared = own is not None and outer is not None and outer.made and not _is_within(own, outer)
    return outer if is_shared else own or outer


def _is_within(inner: Instance | None, outer: Instance | None) -> bool:
    while inner is not None and inner is not outer:
        inner = inner.parent
    return inner is outer


def maker(tree: Map, path: Path) -> Instance | None:
    """Return the innermost include, part or loop whose names the expression at a path can use, or None."""
    own: Instance | None = value_at(tree, path[:-1]).via
    near = tree.locate(path[:-1]).via if own is not None and own.made else own
    return own if near is not None and _is_within(near, own) else near  # parts may share a value


def prefix_at(tree: Map, path: Path, outside: bool = False) -> str:
    """Return the prefix of names in the part that contains a value, or in the enclosing part if ``outside`` is True."""
    via, prefixes = tree.locate(path).via, []
    while via is not None:
        prefixes += [via.prefix] if via.prefix else []
        via = via.parent
    return next(iter(prefixes[outside:]), "")


def written_place(tree: Map, path: Path, key: bool = False, within: bool = False) -> tuple[Place, Span | None]:
    """Return where a value is written and, if an alias or a part inserts it elsewhere, the span of that entry.

    With ``key``, return the place of the key. With ``within``, do so too, unless the value is a mapping or list that is
    defined elsewhere: then return the place of the definition.
    """
    reached = follow(tree, path)
    missing, path = reached < len(path), path[:reached]  # a missing key is reported at the key of its mapping
    place = tree.locate(path, key=key or missing or within)
    use: Span | None = None
    node: Any = tree
    for depth, step in enumerate(path, 1):
        span, node = node.value_spans[step], node[step]
        if not isinstance(node, (Map, Seq)) or (node.span.source.path, node.span.line) == (span.source.path, span.line):
            continue
        if depth < len(path) or missing or not key:
            use = use or span
            place = Place(node.span, node.via or place.via) if depth == len(path) else place
    return place, use


def exists(tree: Map, path: Path) -> bool:
    """Return True if the tree has a value at the path."""
    return follow(tree, path) == len(path)


def value_at(tree: Map, path: Path) -> Any:
    """Return the value at a path, or None if the path does not exist."""
    node: Any = tree
    for step in path:
        node = node[step] if has(node, step) else None
    return node


def follow(tree: Map, path: Path) -> int:
    """Return how many steps of a path, from the root on, exist in the tree."""
    return next((depth for depth, step in enumerate(path) if not has(value_at(tree, path[:depth]), step)), len(path))


def has(node: Any, step: str | int) -> bool:
    """Return True if a mapping has the key ``step``, or a list has the index ``step``."""
    if isinstance(node, Map):
        return step in node
    return isinstance(node, Seq) and isinstance(step, int) and -1 < step < len(node)
