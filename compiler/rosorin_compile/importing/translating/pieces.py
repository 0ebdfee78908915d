"""Pieces: what the files of a translation are made of before it is known of which kind each value is."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.xml.markup import Document, Element

from .scopes import Scope, Value, Variable
from .texts import Parameter


class When(NamedTuple):
    """A condition of ``xacro:if``; ``holds`` is false for ``xacro:unless``."""

    value: Value
    holds: bool


Whens = tuple[When, ...]


class Item(NamedTuple):
    """A key of an entry with its value: a Value, an Entry, a list of Listed, a Call, or what is final already."""

    key: str
    value: Any
    when: Whens = ()


class Listed(NamedTuple):
    """An item of a list."""

    value: Any
    when: Whens = ()
    comments: tuple[str, ...] = ()
    at: Element | None = None


class Entry:
    """A mapping to be; a key may stand several times, under different conditions."""

    def __init__(self) -> None:
        self.items: list[Item] = []

    def put(self, key: str, value: Any, when: Whens = ()) -> None:
        """Add a key."""
        self.items.append(Item(key, value, when))

    def add(self, key: str, value: Any, when: Whens = (), comments: tuple[str, ...] = ()) -> None:
        """Add an item to the list of a key."""
        for item in self.items:
            if item.key == key and isinstance(item.value, list):
                item.value.append(Listed(value, when, comments))
                return
        self.items.append(Item(key, [Listed(value, when, comments)]))

    def each(self) -> list[Item]:
        """Return the items, of those with one key the first."""
        return list({item.key: item for item in reversed(self.items)}.values())[::-1]

    def may_lack(self, key: str) -> bool:
        """Say whether a key is there on conditions."""
        whens = [item.when for item in self.items if item.key == key]
        if len(whens) == 2 and all(len(one) == 1 for one in whens):
            (one,), (other,) = whens  # <xacro:if> and <xacro:unless> of one condition
            if one.value.text == other.value.text and one.value.scope.begun() is other.value.scope.begun():
                return one.holds == other.holds
        return any(whens)

    def names(self) -> list[str]:
        """Return the keys, each once."""
        return list(dict.fromkeys(item.key for item in self.items))


@dataclass(eq=False)
class File:
    """A file of the source; ``name`` is its file in the description, ``space`` the ``ns`` of its include."""

    path: str
    document: Document
    name: str
    space: str = ""
    body: Body = field(init=False)


@dataclass(eq=False)
class Macro:
    """A macro: where it stands, what it takes, and what becomes of it."""

    name: str
    element: Element
    file: File
    parameters: list[Parameter]
    comments: tuple[str, ...] = ()
    scope: Scope = field(default_factory=Scope)
    variables: dict[str, Variable] = field(default_factory=dict)
    implicit: dict[str, Variable] = field(default_factory=dict)
    body: Body | None = None
    level: str = ""
    entry: Entry | None = None
    text: list[Any] | None = None
    ours: str = ""
    uses: list[Use] = field(default_factory=list)
    called: bool = False
    prefix: tuple[Variable, str] | None = None
    mount: Variable | None = None
    origin: str = ""
    relative: Variable | None = None
    by_key: bool = False
    block_levels: dict[str, str] = field(default_factory=dict)
    block_keys: dict[str, list[str]] = field(default_factory=dict)
    blocks_given: dict[str, list[Entry]] = field(default_factory=dict)
    sets: list[tuple[str, Value | None, Whens]] = field(default_factory=list)  # of its caller; None: nobody can read it

    @property
    def place(self) -> Span:
        return self.element.span


@dataclass(eq=False)
class Named:
    """A link or a joint."""

    name: Value
    entry: Entry
    when: Whens
    comments: tuple[str, ...]
    element: Element
    at: Element  # at the top of a file


@dataclass(eq=False)
class Use:
    """A call of a macro that is a part."""

    macro: Macro
    given: dict[str, Value]
    blocks: dict[str, Entry]
    scope: Scope
    when: Whens
    comments: tuple[str, ...]
    element: Element
    at: Element


@dataclass(eq=False)
class Call:
    """A call of a macro that is a named value with parameters."""

    macro: Macro
    given: dict[str, Value]
    blocks: dict[str, Entry]
    scope: Scope
    element: Element


class Given(NamedTuple):
    """What a call of a named value gives under one key, or one item of a list there."""

    call: Call
    key: str
    at: int = -1


class Handed(NamedTuple):
    """A block that a macro is handed over, where it is inserted."""

    parameter: Parameter
    scope: Scope


@dataclass(eq=False)
class Xml:
    """Elements that are kept as text: tag, attributes and content. Without a tag, a group under a condition."""

    tag: str
    attributes: list[tuple[str, Value]] = field(default_factory=list)
    content: list[Any] = field(default_factory=list)
    when: Whens = ()
    element: Element | None = None


@dataclass(eq=False)
class Body:
    """What a file holds beside its macros, or what a macro holds."""

    file: File
    macro: Macro | None
    scope: Scope
    links: list[Named] = field(default_factory=list)
    joints: list[Named] = field(default_factory=list)
    uses: list[Use] = field(default_factory=list)
    elements: list[Listed] = field(default_factory=list)
    materials: list[Named] = field(default_factory=list)
    locals: list[Variable] = field(default_factory=list)
    flat: list[Any] = field(default_factory=list)
    guards: list[tuple[str, list[str], Whens, Element]] = field(default_factory=list)

    def is_empty(self) -> bool:
        """Say whether it makes nothing."""
        return not (self.links or self.joints or self.uses or self.elements or self.materials)
