"""Find how the macros that become parts name their links: their prefix, the link that they hang on, and their pose.

All names of a part begin with a parameter: that is the prefix of its uses. A parameter that is only the parent of
joints is the ``parent`` of its uses, and those that are only the origin of these joints are their pose. This module
runs in the child process.
"""

from __future__ import annotations

from collections import Counter

from .ir import Call, Element, Macro, expressions_in, walk
from .nodes import as_text, usable, variables_in
from .symbols import Pieces, Symbol, Variable, join_pieces, pieces_of

Prefix = tuple[Variable, str]  # the parameter that names begin with, and the text after it


class PartNames:
    """The prefix, the mount and the pose of each macro that becomes a part, among the ``variables`` of a program."""

    def __init__(self, parts: list[Macro], variables: list[Variable]) -> None:
        self.variables = variables
        self.prefix: dict[Macro, Prefix] = {}
        self.mount: dict[Macro, Variable] = {}
        self.pose: dict[Macro, dict[str, Variable]] = {}
        self.own_names: dict[Macro, set[str]] = {}
        # "prefix" is the prefix of a part in it, unless it is the name of something else.
        self.knows_prefix = not any(one.ours == "prefix" and one.kind != "parameter" for one in variables)
        for macro in parts:
            names = [one.attributes.get("name", []) for one in _named(macro)]
            prefix = _common_prefix(macro, names)
            if prefix is not None:
                self.prefix[macro] = prefix
                if not prefix[1] and self.knows_prefix:
                    prefix[0].ours = "prefix"
                self.own_names[macro] = {_spelt(short(name, prefix) or []) for name in names}
        while any(self._drop_prefix(macro) for macro in parts):
            pass
        for macro in parts:
            self._find_mount(macro)

    def short(self, macro: Macro | None, pieces: Pieces) -> Pieces | None:
        """Return a name without the prefix of a part, or None if it does not begin with it."""
        return short(pieces, self.prefix[macro]) if macro is not None and macro in self.prefix else None

    def prefix_of(self, call: Call) -> Pieces:
        """Return what precedes the names that a call makes."""
        if call.macro not in self.prefix:
            return []
        variable, more = self.prefix[call.macro]
        return pieces_of(join_pieces([call.given[variable.name][0], more]))

    def is_own(self, macro: Macro, rest: Pieces, is_xml: bool) -> bool:
        """Return True if a name without the prefix is that of a link or joint of the part or of its uses."""
        if _spelt(rest) in self.own_names[macro] or is_xml:
            return _spelt(rest) in self.own_names[macro]
        return any(one.macro in self.prefix for one in _part_calls(macro))

    def leads(self, macro: Macro) -> list[str]:
        """Return the parameters that names of links and joints contain."""
        pieces = [piece for one in _named(macro) for piece in one.attributes.get("name", [])]
        found = [one.variable for one in pieces if isinstance(one, Symbol)]
        return [one.name for one in found if one is not None and one in macro.parameters.values()]

    def is_implied(self, macro: Macro, variable: Variable) -> bool:
        """Return True if a part has a parameter anyway: its prefix, its mount, its pose."""
        if macro in self.prefix and variable is self.prefix[macro][0]:
            return not (variable.used and (self.prefix[macro][1] or not self.knows_prefix))
        return variable is self.mount.get(macro) or variable in self.pose.get(macro, {}).values()

    def _drop_prefix(self, macro: Macro) -> bool:
        """Drop the prefix of a part if a part that it uses makes names without it; return True if so."""
        if macro not in self.prefix:
            return False
        made = [self.prefix_of(one) for one in _part_calls(macro) if _makes_names(one.macro)]
        if all(self.short(macro, one) is not None for one in made):
            return False
        variable, _ = self.prefix.pop(macro)
        variable.ours = usable(variable.name, macro.names)
        return True

    def _find_mount(self, macro: Macro) -> None:
        joints = [one for one in _named(macro) if one.tag == "joint"]
        counts = self._occurrences(macro)
        is_named = any("mount" in map(str, one.attributes.get("name", [])) for one in joints)
        for variable in macro.parameters.values():
            on_mount = [one for one in joints if _sole(one, "parent", "link") is variable]
            is_prefix = macro in self.prefix and variable is self.prefix[macro][0]
            if not on_mount or counts[variable] != len(on_mount) or is_prefix or is_named:
                continue
            self.mount[macro] = variable
            for key in ("xyz", "rpy"):
                found = {_sole(one, "origin", key) for one in on_mount}
                only = found.pop() if len(found) == 1 else None
                is_only = only in macro.parameters.values() and counts[only] == len(on_mount)  # type: ignore[index]
                if only is not None and is_only and (key == "xyz" or "xyz" in self.pose.get(macro, ())):
                    self.pose.setdefault(macro, {})[key] = only
            return

    def _occurrences(self, macro: Macro) -> Counter[Variable]:
        """Count how often a macro reads each variable."""
        lets = [one for one in self.variables if one.kind == "let" and one.owner == macro.key and one.symbol]
        nodes = [one.symbol.node for one in lets if one.symbol]
        return Counter(variables_in([*nodes, *(node for one in walk(macro.body) for node in expressions_in(one))]))


def short(pieces: Pieces, prefix: Prefix) -> Pieces | None:
    """Return a name without a prefix, or None if it does not begin with it."""
    variable, more = prefix
    if not pieces or not isinstance(pieces[0], Symbol) or pieces[0].variable is not variable:
        return None
    rest = pieces[1:]
    if not more:
        return rest
    if not rest or not isinstance(rest[0], str) or not rest[0].startswith(more):
        return None
    return [one for one in (rest[0].removeprefix(more), *rest[1:]) if one != ""]


def _named(macro: Macro) -> list[Element]:
    return [one for one in walk(macro.body) if isinstance(one, Element) and one.tag in ("link", "joint")]


def _part_calls(macro: Macro) -> list[Call]:
    return [one for one in walk(macro.body) if isinstance(one, Call) and one.macro.level == "robot"]


def _makes_names(macro: Macro) -> bool:
    return bool(_named(macro)) or any(_makes_names(one.macro) for one in _part_calls(macro))


def _common_prefix(macro: Macro, names: list[Pieces]) -> Prefix | None:
    """Return the parameter that all names of a part begin with, and the text after it."""
    leads = {name[0].variable if name and isinstance(name[0], Symbol) else None for name in names}
    variable = leads.pop() if len(leads) == 1 else None
    if variable is None or variable not in macro.parameters.values() or any(len(name) < 2 for name in names):
        return None
    if any(one.name == "prefix" and one is not variable for one in macro.parameters.values()):
        return None  # "prefix" is another value there
    parted = all(
        isinstance(name[1], str) and name[1].startswith("_") and (len(name) > 2 or name[1] != "_") for name in names
    )
    return variable, "_" if parted else ""


def _sole(node: Element, tag: str, name: str) -> Variable | None:
    """Return the variable that an attribute of a child is, or None."""
    found = [one.attributes.get(name, []) for one in node.body if isinstance(one, Element) and one.tag == tag]
    is_symbol = len(found) == 1 and len(found[0]) == 1 and isinstance(found[0][0], Symbol)
    return found[0][0].variable if is_symbol else None


def _spelt(pieces: Pieces) -> str:
    return "|".join(piece if isinstance(piece, str) else as_text(piece.node) for piece in pieces)
