"""The tree of a YAML file: dicts and lists with the position of every entry, which are not modified later."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from .diagnostics import Related, Span, Use
from .wording import and_more

Path = tuple[str | int, ...]


class Instance(NamedTuple):
    """How a value got into the tree: by an include, a part or a loop iteration, whose position is ``span``."""

    message: str
    span: Span
    parent: Instance | None = None
    made: bool = False  # created by a part or a loop
    prefix: str = ""  # the prefix of names in the part, after the prefixes of enclosing parts

    def stack(self) -> Iterator[Related]:
        """Yield the includes and parts that led here, innermost first; of more than 12 only the first and last ones."""
        steps: list[Related] = []
        here: Instance | None = self
        while here is not None:
            steps.append((Use if here.made else Related)(here.message, here.span))
            here = _including(here.parent, here.span)
        if len(steps) > 12:
            steps[6:-5] = [Related(and_more(len(steps) - 11).strip(), None)]
        yield from steps


class Include(Instance):
    """An include of a file; ``included`` maps each file of the description to its include."""

    included: dict[str, Include]


def _including(via: Instance | None, span: Span) -> Instance | None:
    """Return the include of the file that ``span`` is in; ``via`` may be the include of another file."""
    return via.included.get(span.source.path) if isinstance(via, Include) else via


class Map(dict[str, "Any"]):
    """A mapping with the spans of its keys and values; ``via`` is how it got into the tree (None: in the root file)."""

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
        """Set a key to the value that it has in another mapping, with its spans."""
        self.put(key, other[key], other.key_spans[key], other.value_spans[key])

    def setdefault_at(self, key: str, value: Any, span: Span) -> None:
        if key not in self:
            self.put(key, value, span, span)

    def locate(self, path: Sequence[str | int], key: bool = False) -> Place:
        """Return the place of the value at ``path`` or its longest existing prefix; with ``key``, of its last key."""
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
        """Return the keys whose values contain expressions."""
        return [key for key, value in self.items() if "${" in str(value)]

    def copy(self) -> Map:
        """Return a copy to which entries may be added."""
        made = self.made_by(self.via)
        made.key_spans, made.value_spans = self.key_spans.copy(), self.value_spans.copy()
        return made

    def like(self, changes: Mapping[str, Any]) -> Map:
        """Return a copy with some values changed; no keys may be added to it."""
        made = self.made_by(self.via)
        made.update(changes)
        return made

    def made_by(self, via: Instance | None) -> Map:
        """Return a copy that got into the tree by ``via``; no keys may be added to it."""
        made = Map(self.span, via)
        made.update(self)
        made.key_spans, made.value_spans = self.key_spans, self.value_spans
        return made


class Seq(list["Any"]):
    """A sequence with the spans of its items."""

    __slots__ = ("span", "value_spans", "via")

    def __init__(self, span: Span, via: Instance | None = None) -> None:
        self.span, self.via = span, via
        self.value_spans: list[Span] = []

    def put(self, value: Any, span: Span) -> None:
        self.append(value)
        self.value_spans.append(span)


class Text(str):
    """A string with quotes in YAML, equal to the same string without quotes, which is a plain ``str``."""

    __slots__ = ()


class XmlText(Text):
    """XML elements in a part or a loop: a string with ``via``, which is how it got into the tree."""

    __slots__ = ("via",)
    via: Instance | None

    def __new__(cls, text: str, via: Instance | None = None) -> XmlText:
        made = super().__new__(cls, text)
        made.via = via
        return made


class Place(NamedTuple):
    """Where a value of the tree was written, and how it got into the tree."""

    span: Span
    via: Instance | None

    def stack(self) -> tuple[Related, ...]:
        """Return the includes and parts that led here, innermost first."""
        via = self.via
        if via is not None and via.span != self.span:
            via = _including(via, self.span)
        while via is not None and not via.made and via.span != self.span and via.span.source == self.span.source:
            via = via.parent
        return tuple(via.stack()) if via else ()


def nearer(outer: Instance | None, own: Instance | None) -> Instance | None:
    """Return how a value got into the tree: ``own``, or ``outer`` of its parent if several parts share the value."""
    is_shared = own is not None and outer is not None and outer.made and not _is_within(own, outer)
    return outer if is_shared else own or outer


def _is_within(inner: Instance | None, outer: Instance | None) -> bool:
    while inner is not None and inner is not outer:
        inner = inner.parent
    return inner is outer


def maker(tree: Map, path: Path) -> Instance | None:
    """Return the instance of the mapping or list at ``path[:-1]``, which determines the scope of its expressions."""
    own: Instance | None = value_at(tree, path[:-1]).via
    near = tree.locate(path[:-1]).via if own is not None and own.made else own
    return own if near is not None and _is_within(near, own) else near  # ``own`` may be another use of the same part


def prefix_at(tree: Map, path: Path, outside: bool = False) -> str:
    """Return the prefix of the part that a value was written in; if ``outside``, that of the enclosing part."""
    via, prefixes = tree.locate(path).via, []
    while via is not None:
        prefixes += [via.prefix] if via.prefix else []
        via = via.parent
    return next(iter(prefixes[outside:]), "")


def written_place(tree: Map, path: Path, key: bool = False, within: bool = False) -> tuple[Place, Span | None]:
    """Return where the value (or key) at a path was written, and the span where it is used if that is elsewhere."""
    reached = follow(tree, path)
    missing, path = reached < len(path), path[:reached]  # for a missing key, the place is the key of its entry
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
    """Return the value at a path, or None if there is none."""
    node: Any = tree
    for step in path:
        node = node[step] if has(node, step) else None
    return node


def follow(tree: Map, path: Path) -> int:
    """Return the number of leading steps of a path that exist in the tree."""
    return next((depth for depth, step in enumerate(path) if not has(value_at(tree, path[:depth]), step)), len(path))


def has(node: Any, step: str | int) -> bool:
    """Return True if a mapping has the key ``step``, or a list has the index ``step``."""
    if isinstance(node, Map):
        return step in node
    return isinstance(node, Seq) and isinstance(step, int) and -1 < step < len(node)
