"""Find how the macros that become parts name their links: their prefix, the link that they hang on, and their pose.

All names of a part begin with a parameter: that is the prefix of its uses. A parameter that is only the parent of
joints is the ``parent`` of its uses, and those that are only the origin of these joints are their pose.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator, Mapping

from .ir import LET, PARAMETER, Call, Comment, Element, If, Macro, Pieces, Program, Variable, Words, flattened, walk

Prefix = tuple[Variable, str]  # the parameter that names begin with, and the text after it


class PartNames:
    """The prefix, the mount and the pose of each macro of a program that becomes a part.

    ``explicit`` are the keys of macros whose names keep their prefix.
    """

    def __init__(self, program: Program, explicit: set[str]) -> None:
        self.program, self.explicit = program, explicit
        self.prefix: dict[Macro, Prefix] = {}
        self.mount: dict[Macro, Variable] = {}
        self.pose: dict[Macro, dict[str, Variable]] = {}
        parts = [one for one in program.macros.values() if one.level == "robot"]
        names = {macro: [one.attributes.get("name", []) for one in _named(macro)] for macro in parts}
        for macro in parts:
            found = _common_prefix(macro, names[macro], program.variables)
            if found is not None and macro.key not in explicit:
                self.prefix[macro] = found
        self.own_names = {
            macro: {_spelt(rest) for name in names[macro] if (rest := self.short(name, prefix)) is not None}
            for macro, prefix in self.prefix.items()
        }
        while any(self._find_prefix_of_calls(macro, bool(names[macro])) for macro in parts):
            pass
        for macro in parts:
            self._find_mount(macro)

    def short(self, pieces: Pieces, prefix: Prefix) -> Pieces | None:
        """Return a name without a prefix, or None if it does not begin with it."""
        variable, more = prefix
        if not pieces or getattr(pieces[0], "id", "") != variable.id:
            return None
        rest = pieces[1:]
        if not more:
            return rest
        if not rest or not isinstance(rest[0], str) or not rest[0].startswith(more):
            return None
        return [one for one in (rest[0].removeprefix(more), *rest[1:]) if one != ""]

    def prefix_of(self, call: Call) -> Pieces:
        """Return what precedes the names that a call makes."""
        if call.macro not in self.prefix:
            return []
        variable, more = self.prefix[call.macro]
        return flattened([call.given[variable.name][0], more])

    def is_own(self, macro: Macro, short: Pieces, is_xml: bool) -> bool:
        """Return True if a name without the prefix is that of a link or joint of the part or of its uses."""
        if _spelt(short) in self.own_names.get(macro, ()) or is_xml:
            return _spelt(short) in self.own_names.get(macro, ())
        return any(_makes_names(one.macro, set()) for one in _part_calls(macro))

    def knows_prefix(self, macro: Macro) -> bool:
        """Return True if ``prefix`` is the prefix of a part in it, and not the name of something else."""
        others = [one for one in self.program.variables.values() if one.kind != PARAMETER and not one.owner]
        own = [one for one in macro.parameters.values() if one is not self.prefix[macro][0]]
        return all(one.name != "prefix" for one in (*others, *own))

    def is_implied(self, macro: Macro, variable: Variable, is_used: bool) -> bool:
        """Return True if a part has a parameter anyway: its prefix, its mount, its pose."""
        prefix = self.prefix.get(macro)
        if prefix is not None and variable is prefix[0]:
            return not (is_used and (prefix[1] or not self.knows_prefix(macro)))
        return variable is self.mount.get(macro) or variable in self.pose.get(macro, {}).values()

    def leads(self, macro: Macro) -> Iterator[Variable]:
        """Yield the parameters that names of links and joints contain."""
        for one in _named(macro):
            for piece in one.attributes.get("name", []):
                variable = self.program.variables.get(getattr(piece, "id", ""))
                if variable is not None and variable in macro.parameters.values():
                    yield variable

    def _find_prefix_of_calls(self, macro: Macro, has_names: bool) -> bool:
        """Find the prefix of a macro that only calls parts, or drop one that does not compose; return True if so."""
        makes = [one for one in _part_calls(macro) if _makes_names(one.macro, set())]
        found = False
        if macro not in self.prefix and macro.key not in self.explicit and not has_names and makes:
            lead = self.prefix_of(makes[0])[:1]
            variable = self.program.variables.get(getattr(lead[0], "id", "")) if lead else None
            if variable is not None and variable in macro.parameters.values():
                self.prefix[macro], self.own_names[macro], found = (variable, ""), set(), True
        if macro in self.prefix:
            for one in makes:
                if one.macro not in self.prefix or self.short(self.prefix_of(one), self.prefix[macro]) is None:
                    self.explicit.add(macro.key)
                    del self.prefix[macro]
                    return True
        return found

    def _find_mount(self, macro: Macro) -> None:
        joints = [one for one in _named(macro) if one.tag == "joint"]
        counts = self._occurrences(macro)
        for variable in macro.parameters.values():
            on_mount = [one for one in joints if _sole(one, "parent", "link") == variable.id]
            is_prefix = macro in self.prefix and variable is self.prefix[macro][0]
            if not on_mount or counts[variable.id] != len(on_mount) or is_prefix:
                continue
            if any("mount" in map(str, one.attributes.get("name", [])) for one in joints):
                continue
            self.mount[macro] = variable
            for key in ("xyz", "rpy"):
                names = {_sole(one, "origin", key) for one in on_mount}
                found = self.program.variables.get(names.pop()) if len(names) == 1 else None
                is_only = found in macro.parameters.values() and counts[found.id] == len(on_mount)  # type: ignore[union-attr]
                if found is not None and is_only and (key == "xyz" or "xyz" in self.pose.get(macro, ())):
                    self.pose.setdefault(macro, {})[key] = found
            return

    def _occurrences(self, macro: Macro) -> Counter[str]:
        """Count how often a macro reads each variable."""
        formulas = [
            one.node
            for one in self.program.variables.values()
            if one.kind == LET and one.owner == macro.key and one.node is not None
        ]
        for node in walk(macro.body):
            formulas += formulas_of(node)
        return Counter(one.id for node in formulas for one in ast.walk(node) if isinstance(one, ast.Name))


def makes_only_materials(macro: Macro) -> bool:
    """Return True if a part makes nothing but materials, which the robot shares."""

    def is_empty(node: object) -> bool:
        if isinstance(node, If):
            return all(map(is_empty, node.body))
        if isinstance(node, Call):
            return node.macro.level == "robot" and makes_only_materials(node.macro)
        return isinstance(node, Comment) or (isinstance(node, Element) and node.tag == "material")

    return all(map(is_empty, macro.body))


def formulas_of(node: object) -> list[ast.expr]:
    """Return the formulas of a node, without those of its body."""
    pieces: Pieces = []
    if isinstance(node, Element):
        pieces = [piece for text in node.attributes.values() for piece in text]
    elif isinstance(node, Words):
        pieces = node.pieces
    elif isinstance(node, If):
        pieces = [node.test]
    elif isinstance(node, Call):
        pieces = [one for one, _ in node.given.values()]
    return [piece for piece in pieces if not isinstance(piece, str)]


def _named(macro: Macro) -> list[Element]:
    return [one for one in walk(macro.body) if isinstance(one, Element) and one.tag in ("link", "joint")]


def _part_calls(macro: Macro) -> list[Call]:
    return [one for one in walk(macro.body) if isinstance(one, Call) and one.macro.level == "robot"]


def _makes_names(macro: Macro, visited: set[Macro]) -> bool:
    if macro in visited:
        return False
    visited.add(macro)
    return bool(_named(macro)) or any(_makes_names(one.macro, visited) for one in _part_calls(macro))


def _common_prefix(macro: Macro, names: list[Pieces], variables: Mapping[str, Variable]) -> Prefix | None:
    """Return the parameter that all names of a part begin with, and the text after it."""
    leads = {getattr(name[0], "id", "") if name else "" for name in names}
    variable = variables.get(leads.pop()) if len(leads) == 1 else None
    if variable is None or variable not in macro.parameters.values() or any(len(name) < 2 for name in names):
        return None
    parted = all(
        isinstance(name[1], str) and name[1].startswith("_") and (len(name) > 2 or name[1] != "_") for name in names
    )
    return variable, "_" if parted else ""


def _sole(node: Element, tag: str, name: str) -> str:
    """Return the variable that an attribute of a child is, or nothing."""
    found = [one.attributes.get(name, []) for one in node.body if isinstance(one, Element) and one.tag == tag]
    is_name = len(found) == 1 and len(found[0]) == 1 and isinstance(found[0][0], ast.Name)
    return found[0][0].id if is_name else ""


def _spelt(pieces: Pieces) -> str:
    return "|".join(piece if isinstance(piece, str) else ast.dump(piece) for piece in pieces)
