"""The input of the rules: a robot, the description that it was built from, and methods to report problems."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from rosorin_compile.language.expand.provenance import mistake_place
from rosorin_compile.language.expand.scope import Scope
from rosorin_compile.language.schema import TEMPLATE
from rosorin_compile.language.suggestions import suggest_name
from rosorin_compile.language.suppressions import names_at
from rosorin_compile.language.symbols import Symbol, SymbolTable
from rosorin_compile.model import Joint, Link, Output, Robot, Shape
from rosorin_compile.source.diagnostics import Diagnostic, Help, Related, Span, Suggestion, diagnostic
from rosorin_compile.source.rule_registry import find_declared
from rosorin_compile.source.tree import Map, Path, exists, follow, value_at

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

    from .magnitudes import Remarkable


@dataclass(frozen=True)
class Case:
    """The input of the rules: a robot, the YAML tree that it was built from, and helpers to report problems.

    ``places`` maps (kind, name), such as ("joint", "elbow"), to paths in the tree. ``remarkable`` has the suspicious
    values of the tree (see ``magnitudes.collect``), ``formats`` the output formats by name, ``scope`` the variables of
    expressions (None if unknown), and ``wanted`` the names of the requested outputs (empty for all).
    """

    robot: Robot
    tree: Map
    places: Mapping[tuple[str, str], Path]
    remarkable: Remarkable
    formats: Mapping[str, Format] = field(default_factory=dict)
    scope: Scope | None = None
    wanted: Collection[str] = ()

    def outputs_read_by(self, publisher: str) -> list[Output]:
        """Return the outputs that a kind of publisher, such as "robot_state_publisher", reads."""
        return outputs_read_by(self.robot, publisher, self.formats)

    @cached_property
    def symbols(self) -> SymbolTable:
        """The symbol table of the names that the description defines and refers to."""
        return SymbolTable(self.tree)

    @cached_property
    def definitions(self) -> tuple[Symbol, ...]:
        """The definitions of names, in the order of the schema."""
        return tuple(self.symbols.definitions())

    @cached_property
    def references(self) -> tuple[Symbol, ...]:
        """The references to names of all kinds except modes, in the order of the schema."""
        return tuple(self.symbols.references())

    def mentions(self, *kinds: str) -> Iterator[Symbol]:
        """Yield the references to names of ``kinds`` ("link", ...), except to names defined within ``moveit``."""
        own = {"moveit": self.robot.moveit.own_names} if self.robot.moveit else {}
        for reference in (one for one in self.references if one.kind in kinds):
            if reference.name not in own.get(str(reference.path[0]), {}).get(reference.kind, ()):
                yield reference

    def section(self, name: str) -> Mapping[str, Any]:
        """Return the entries of a section by name, or an empty mapping if the description lacks the section."""
        entries: Mapping[str, Any] = self.tree.get(name) or {}
        return entries

    def joint(self, joint: Joint, *rest: str | int) -> Path:
        """Return the path of a joint, extended by ``rest``. The joint of a sensor has the path of the sensor."""
        return (*(self.places.get(("joint", joint.name)) or ("joints", joint.name)), *rest)

    def link(self, name: str, *rest: str | int) -> Path:
        """Return the path of a link, extended by ``rest``."""
        return (*(self.places.get(("link", name)) or ("links", name)), *rest)

    def shapes(self, *links: Link) -> Iterator[tuple[Link, Path, Shape]]:
        """Yield (link, path, shape) for each visual and collision shape of ``links``, by default of all links."""
        for link in links or self.robot.links:
            for purpose, shapes in (("visual", link.visual), ("collision", link.collision)):
                for index, shape in enumerate(shapes):
                    yield link, self.link(link.name, purpose, index), shape

    def end(self, joint: Joint, which: str) -> Path:
        """Return the path of the "parent" or "child" (``which``) of a joint."""
        path = self.joint(joint)
        if path[0] != "sensors":
            return (*path, which)
        if which == "parent" and path[-1] == "optical":
            return (*path[:-1], "frame")
        return (*path, "parent" if which == "parent" else "frame")

    def edge(self, index: int, key: str) -> Path:
        """Return the path of a key ("parent", "child", "publisher" or "when") of ``robot.edges[index]``.

        For a transform in a joint's list of publishers, return the path of ``by`` or ``when`` in the list entry.
        """
        turn = self.places.get(("edge", str(index)))
        if turn is None:
            return ("edges", index, key)
        return (*turn, "when") if key == "when" and exists(self.tree, (*turn, "when")) else (*turn, "by")

    def publisher(self, joint: Joint) -> Path:
        """Return the path of the key "publisher" of a joint, or the path of the joint if it has no such key."""
        path = self.joint(joint)
        mount = path[:-1] if path[-1] == "optical" and not exists(self.tree, (*path, "publisher")) else path
        return (*mount, "publisher") if exists(self.tree, (*mount, "publisher")) else path

    def value(self, path: Path, *keys: str | int) -> Path:
        """Return ``path`` extended by ``keys``, or ``path`` itself if the tree has no value there."""
        return (*path, *keys) if exists(self.tree, (*path, *keys)) else path

    def problem(
        self,
        rule: str,
        message: str,
        path: Path,
        help: Help = "",
        *,
        related: Iterable[Related | tuple[str, Path]] = (),
        severity: str = "",
        key: bool = False,
        within: bool = False,
    ) -> Diagnostic:
        """Return a diagnostic at the value with this path, or at the nearest enclosing entry if the value is missing.

        ``key`` reports at the key instead of the value, ``within`` at the key or definition of a mapping. A value from
        ``let`` or from an argument of a part is reported where it is defined; its uses become related places. Severity
        and help default to those of the rule.
        """
        known = find_declared(rule)
        place, uses = mistake_place(self.scope, self.tree, path, rule, key, within)
        seconds = [one if isinstance(one, Related) else self.related_place(*one) for one in related]
        found = (*seconds, *uses, *place.stack())
        made = diagnostic(rule, severity or known.severity, message, place.span, help or known.hint, found)
        return replace(made, of=names_at(self.tree, path))

    def related_place(self, message: str, path: Path, key: bool = False) -> Related:
        """Return a related place at a value, or at its key if ``key`` is set or the value is a mapping."""
        return Related(message, self._place(path, key or isinstance(value_at(self.tree, path), Map)))

    def unknown(self, rule: str, message: str, uses: Sequence[Symbol], help: Help) -> Iterator[Diagnostic]:
        """Yield a problem at the first reference to an unknown name; other references become related places.

        A reference in a part that is used several times is reported for each use.
        """
        spans = [self._place(use.path, use.key) for use in uses]
        others = {span: use.what for use, span in zip(uses, spans, strict=True) if span != spans[0]}
        related = [Related(f"also used here: {what}", span) for span, what in others.items()]
        for use, span in zip(uses, spans, strict=True):
            if span == spans[0]:
                yield self.problem(rule, f"{message} ({use.what})", use.path, help, related=related, key=uses[0].key)
                related = []

    def _place(self, path: Path, key: bool = False) -> Span:
        return mistake_place(self.scope, self.tree, path, "", key)[0].span

    @property
    def suggest(self) -> Callable[..., Suggestion]:
        """The function ``suggest_name`` for this description; it suggests a fix for an unknown name."""
        return partial(suggest_name, self.tree)

    def stand_in(self, path: Path) -> str:
        """Return " (a stand-in)" for messages if the nearest ``source`` marks the value as a stand-in, else ""."""
        nodes = [value_at(self.tree, path[:depth]) for depth in range(follow(self.tree, path) + 1)]
        sources = [node.get("source") for node in nodes if isinstance(node, Map)]
        status = [source.get("status") for source in sources if isinstance(source, Map)]
        return " (a stand-in)" if status[-1:] == ["stand_in"] else ""


def outputs_read_by(robot: Robot, publisher: str, formats: Mapping[str, Format]) -> list[Output]:
    """Return the outputs that a kind of publisher, such as "robot_state_publisher", reads."""
    known = [(output, formats[output.backend]) for output in robot.outputs if output.backend in formats]
    return [output for output, format in known if publisher in format.feeds and not format.is_withheld(output)]


def first_fed(robot: Robot, publisher: str, formats: Mapping[str, Format]) -> Output | None:
    """Return the first output that a kind of publisher can read, or None if there is no such output.

    Outputs are recognised by format or file extension, because a user's template can also generate a URDF.
    """
    others = [one for one in robot.outputs if one.backend == TEMPLATE or one.backend not in formats]
    readable = [one for one in formats.values() if one.load is not None and publisher in one.feeds] if others else []
    endings = tuple(ending for one in readable for ending in one.endings)
    fed = [*outputs_read_by(robot, publisher, formats), *(one for one in others if one.file.endswith(endings))]
    return fed[0] if fed else None


def number(value: float) -> str:
    """Format a number for a message, with up to six digits."""
    return f"{float(value):.6g}"


def report(
    rule: str,
    message: str,
    span: Span | None = None,
    help: Help = "",
    related: Iterable[Related] = (),
    severity: str = "",
) -> Diagnostic:
    """Return a diagnostic without a path in the description. Severity and help default to those of the rule."""
    known = find_declared(rule)
    return diagnostic(rule, severity or known.severity, message, span, help or known.hint, related)
