"""Rendering: pieces of a description as the documents of its files, once it is known of which kind each value is.

What nothing uses is left out: rendering is repeated until what is used does not grow any more.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from types import MappingProxyType
from typing import Any

from rosorin_compile.source.xml.markup import Element
from rosorin_compile.source.yaml_text import Scalar

from ..layout import Expression
from .blocks import inserted, leaves, type_of
from .choices import conditional, merged
from .expressions import all_of, negated, written
from .flattened import Flat, place_of
from .kept import Elements
from .naming import lead_of, prefix_pieces, variables_in, without_prefix, words_apart
from .pieces import Body, Entry, File, Macro, Named, Use, Whens
from .problems import AtTop, InMacro, InProperty
from .proving import PROBE
from .scopes import (
    ANY,
    ARGUMENT,
    FILE,
    FLAG,
    LIST,
    LISTS,
    NAME,
    NUMBER,
    NUMBERS,
    TABLE,
    WORDS,
    XML,
    Value,
    Variable,
    is_plain,
)
from .texts import TEXT, Unsupported
from .values import ARGUMENTS, Documents, declared_type, default_of, final, has_expression
from .wording import OPTIONS, Spot, Words


class Renderer(Elements):
    """Renders one walk; ``words`` are what elements at the top of files become, by their place."""

    words: Mapping[Spot, Words] = MappingProxyType({})

    def render(self) -> Documents:
        """Return the documents."""
        self.reserve()
        before, self.again = -1, False
        while before != len(self.used) or self.again:
            before, self.again = len(self.used), False
            self.documents = Documents()
            self.looks, self.shares, self.keys, self.alternatives = {}, {}, set(), {}
            inner = [macro.body for macro in self.macros if macro.body is not None]
            for body in (*(file.body for file in self.program.files.values()), *inner):
                self.macro = body.macro
                for named in body.materials:
                    with self.at_top(named.at, body.macro, named.element):
                        self.material(named, body.file.name)
            for file in self.program.files.values():
                self.file(file)
            for macro in self.macros:
                try:
                    if macro.body is not None:
                        self.part(macro)
                    elif macro.entry is not None or macro.text is not None:
                        self.called(macro)
                except Unsupported as problem:
                    raise InMacro(macro, problem) from None
            self.robot_name()
            self.named_values()
            self.arguments()
            if self.shares:
                self.documents.section(self.program.root.name, "let").update(self.shares)
        return self.documents

    def robot_name(self) -> None:
        """Take the name of the robot where an argument has a say in it."""
        attribute = self.program.root.document.root.attributes.get("name")
        if attribute is not None and "$" in attribute.value:
            self.macro = None
            self.documents.name = self.text(Value(attribute.value, self.program.scope, NAME, attribute.span))

    def reserve(self) -> None:
        """Find the parts whose uses are called as what they are given for ``name``; these names are theirs."""
        bodies = [one.body for one in self.macros if one.body is not None]
        groups: list[tuple[Macro | None, list[Use]]] = [(body.macro, body.uses) for body in bodies]
        groups.append((None, [use for file in self.program.files.values() for use in file.body.uses]))
        spoilt: set[Macro] = set()
        for owner, uses in groups:
            self.macro = owner
            seen: dict[str, Macro] = {}
            for use in uses:
                if use.macro.prefix is not None or "name" not in use.macro.variables:
                    continue
                value = use.given.get("name")
                key = self.name_in(value) if value is not None else ""
                if not key or key in seen or not isinstance(Scalar(key).value, str) or "/" in key:
                    spoilt.add(use.macro)
                    spoilt.update([seen[key]] if key in seen else [])
                seen[key] = use.macro
        for macro in self.macros:
            kind = macro.variables["name"].kind() if "name" in macro.variables else ""
            wanted = macro.body is not None and macro.prefix is None and kind in (WORDS, ANY)
            macro.by_key = wanted and macro not in spoilt and bool(macro.uses)
        for owner, uses in groups:
            self.macro = owner
            values = [use.given["name"] for use in uses if use.macro.by_key]
            self.reserved[owner] = {self.name_in(one) for one in values}
        self.macro = None

    def name_in(self, value: Value) -> str:
        """Return a value as a name; empty where it cannot be said, which is told where it is used."""
        try:
            return str(self.text(Value(value.text, value.scope, NAME, value.span)))
        except Unsupported:
            return ""

    def called(self, macro: Macro) -> None:
        """Write a macro that is a named value with parameters."""
        before, self.macro = self.macro, macro
        keys = macro.entry.names() if macro.entry else []
        path = ("let", macro.ours)
        value: Any = self.entry(macro.entry or Entry(), path) if macro.text is None else self.text_of(macro)
        if len(keys) == 1 and isinstance(value, dict) and macro.entry and not macro.entry.may_lack(keys[0]):
            value = value.get(keys[0], next(iter(value.values()), {}))
        given = [variable.ours for _, variable in self.parameters(macro)]
        for block in inserted(macro):
            given += [leaf.name for leaf in self.leaves_of(macro, block)]
        names = ", ".join(given)
        key = f"{macro.ours}({names})"
        self.documents.section(macro.file.name, "let")[key] = value
        self.documents.remark(macro.file.name, ("let", key), macro.comments)
        self.macro = before

    def text_of(self, macro: Macro) -> Any:
        """Return the text that a macro makes among elements that are kept."""
        lines: list[str] = []
        self.named_texts = False  # they would need the parameters of this value
        for item in self.merged(macro.text or []):
            lines += self.lines_of(item, "")
        self.named_texts = True
        text = "\n".join(lines)
        return Expression(text) if "${" in text else text

    def file(self, file: File) -> None:
        """Write what stands at the top of a file."""
        self.macro = None
        self.body(file.body, file.name, ())
        lets = self.locals(file.body, ("let",))
        if lets:
            self.documents.section(file.name, "let").update(lets)

    def part(self, macro: Macro) -> None:
        """Write a macro that is a part."""
        self.macro = macro
        file = macro.file.name
        parts = self.documents.section(file, "parts")
        made: dict[str, Any] = {}
        parts[macro.ours] = made
        self.body(macro.body, file, ("parts", macro.ours), made)  # type: ignore[arg-type]
        params = self.params(macro)
        lets = self.locals(macro.body, ("parts", macro.ours, "let"))  # type: ignore[arg-type]
        if macro.body is not None and self.extra:
            lets |= self.extra
        head = {**({"params": params} if params else {}), **({"let": lets} if lets else {})}
        rest = dict(made)
        made.clear()
        made.update({**head, **rest})
        self.documents.remark(file, ("parts", macro.ours), macro.comments)
        self.extra = {}
        self.macro = None

    def body(self, body: Body, file: str, path: tuple[Any, ...], into: dict[str, Any] | None = None) -> None:
        self.extra = {}
        target = into if into is not None else self.documents.files.setdefault(file, {})
        for section, entries in (("links", body.links), ("joints", body.joints)):
            for named in entries:
                with self.at_top(named.at, body.macro, named.element):
                    self.named(named, target.setdefault(section, {}), file, (*path, section))
        self.tell_apart(body.uses)
        for use in body.uses:
            with self.at_top(use.at, body.macro, None):
                self.use(use, target.setdefault("use", {}), file, (*path, "use"))
        for number, flat in enumerate(body.flat):
            self.flat(flat, target, file, number)
        self.elements(body, target, file, path)
        for section in ("links", "joints", "use", "urdf_elements"):
            if section in target and not target[section]:
                del target[section]
        if into is None and self.extra:
            self.documents.section(file, "let").update(self.extra)
            self.extra = {}

    @contextmanager
    def at_top(self, element: Element | None, macro: Macro | None, own: Element | None) -> Iterator[None]:
        """Give an Unsupported of the block its element: that at the top of the file, or ``own`` of the macro."""
        try:
            yield
        except Unsupported as problem:
            problem.element = problem.element or own
            if macro is not None:
                raise InMacro(macro, problem) from None
            if element is None:
                raise
            raise AtTop(element, problem) from None

    def flat(self, flat: Flat, target: dict[str, Any], file: str, number: int) -> None:
        """Write an entry as xacro has expanded it."""
        when = self.condition(flat.when)
        if isinstance(when, ast.Constant) and not when.value:
            return
        if flat.section == "urdf_elements":
            text = self.in_words((file, -1 - number), self.laid_out(flat.value), when, target, flat.comments)
            if text:
                target.setdefault(flat.section, []).append(conditional(text, when))
            return
        section = target.setdefault(flat.section, {})
        if flat.name not in section:
            section[flat.name] = conditional(flat.value, when)
            self.documents.remark(file, (flat.section, flat.name), flat.comments)

    def named(self, named: Named, section: dict[Any, Any], file: str, path: tuple[Any, ...]) -> None:
        when = self.condition(named.when)
        if isinstance(when, ast.Constant) and not when.value:
            return
        key = self.text(named.name)
        value = self.entry(named.entry, (*path, key), file)
        known = self.alternatives.setdefault((id(section), str(key)), [])
        known.append((value, when))
        chosen = merged("", known) if len(known) > 1 else None
        while key in section and chosen is None:
            key = Expression(f"{key}${{''}}")
        section[key] = conditional(value, when) if chosen is None else chosen
        self.documents.elements[file, str(path[-1]), str(key)] = place_of(named.at.span)
        self.documents.remark(file, (*path, key), named.comments)

    def guard(self, name: str, known: list[str], when: Whens, made: list[Any]) -> None:
        """Refuse the values of an argument that would include files which are not here."""
        variable = self.program.arguments.get(name)
        condition = self.condition(when)
        if variable is None or (isinstance(condition, ast.Constant) and not condition.value):
            return
        named = variable.kind() in (WORDS, ANY)
        if known and named and self.allowed(name, variable):  # no other value is
            return
        self.used.add(variable)
        name_of: ast.expr = ast.Name(variable.ours)
        name_of = name_of if named else ast.Call(ast.Name("str"), [name_of], [])
        others = [] if not known else [ast.Compare(name_of, [ast.NotIn()], [_list_of(known)])]
        node = all_of([*([condition] if condition is not None else []), *others])
        text = f"there is no file for this {name} here: translate it, and add it to include"
        made.append(conditional(Expression(f"${{error({text!r})}}"), node))

    def elements(self, body: Body, target: dict[str, Any], file: str, path: tuple[Any, ...]) -> None:
        made = target.pop("urdf_elements", [])
        for name, known, when, element in body.guards:
            with self.at_top(element, body.macro, None):
                self.guard(name, known, when, made)
        for number, item in enumerate(body.elements):
            with self.at_top(item.at, body.macro, item.value.element):
                condition = self.condition(item.when)
                if isinstance(condition, ast.Constant) and not condition.value:
                    continue
                element = self.element(item.value)
            spot = (file, number, *path[1:])
            text = self.in_words(spot, element, condition, target, item.comments)
            if text:
                self.documents.remark(file, (*path, "urdf_elements", len(made)), item.comments)
                made.append(conditional(text, condition))
        if made:
            target["urdf_elements"] = made

    def in_words(
        self, spot: Spot, text: Any, when: ast.expr | None, target: dict[str, Any], comments: tuple[str, ...]
    ) -> Any:
        """Write the words for an element of a file or a part, if there are any, and return what is left of it."""
        texts = self.documents.evaluated if isinstance(text, Expression) else self.documents.plain
        texts[spot] = text
        words = self.words.get(spot)
        if words is None:
            return text
        if self.macro is not None and (when is not None or not self.sayable(words)):
            return text
        for entry in words.entries:
            if entry.section == "drive" and (when is not None or "drive" in target):
                continue  # a robot has one drive, whatever its arguments
            self.documents.asked.setdefault(OPTIONS.get(entry.section, ""), []).append(when)
            self.documents.said.setdefault(entry.section, []).append(entry.called)
            if entry.section == "edges":
                target.setdefault(entry.section, []).append(conditional(entry.value, when))
                continue
            if not entry.name:
                target[entry.section] = entry.value
                continue
            section, key = target.setdefault(entry.section, {}), entry.name
            while key in section:
                key = Expression(f"{key}${{''}}")
            section[key] = conditional(entry.value, when)
            path = ("parts", *spot[2:]) if self.macro is not None else ()
            self.documents.remark(spot[0], (*path, entry.section, key), (*comments, *entry.comments))
            comments = () if not words.rest else comments
        return text if words.rest == words.text else words.rest

    def sayable(self, words: Words) -> bool:
        """Say whether a part may have words: sensors; what outputs warn of where it is not there if it always is."""
        sections = {entry.section for entry in words.entries}
        return sections == {"sensors"} or (sections == {"control"} and self.always_used(self.macro, 0))

    def always_used(self, macro: Macro | None, depth: int) -> bool:
        """Say whether a robot has a part whatever its arguments."""
        callers = self.macros if depth < len(self.macros) else []
        bodies = [file.body for file in self.program.files.values()]
        bodies += [one.body for one in callers if one.body is not None]
        return any(
            use.macro is macro and not use.when and (body.macro is None or self.always_used(body.macro, depth + 1))
            for body in bodies
            for use in body.uses
        )

    def material(self, named: Named, file: str) -> None:
        name, entry = self.text(named.name), self.entry(named.entry)
        when = self.condition(named.when)
        if isinstance(when, ast.Constant) and not when.value:
            return
        section = self.documents.section(file, "materials")
        if isinstance(name, Expression) and self.macro is not None:
            raise Unsupported("a material of a macro", named.element.span)
        if self.macro is not None and (when is not None or any(map(has_expression, entry.values()))):
            raise Unsupported("a material of a macro", named.element.span)
        holder = next((one for one in self.documents.files.values() if name in one.get("materials", ())), None)
        if holder is not None:
            known = self.alternatives[id(holder["materials"]), str(name)]
            chosen = merged("", [*known, (entry, when)]) if known[-1][1] is not None else None
            if chosen is not None:  # of several on conditions each may be meant; after one on none no other is
                known.append((entry, when))
                holder["materials"][name] = chosen
            return
        self.alternatives[id(section), str(name)] = [(entry, when)]
        section[name] = conditional(entry, when)
        if "rgba" in entry and isinstance(entry["rgba"], list) and not has_expression(entry["rgba"]):
            self.looks[name] = entry["rgba"]
        self.documents.remark(file, ("materials", name), named.comments)

    def use(self, use: Use, section: dict[Any, Any], file: str, path: tuple[Any, ...]) -> None:
        """Write a call of a macro that is a part."""
        when = self.condition(use.when)
        if isinstance(when, ast.Constant) and not when.value:
            return
        macro = use.macro
        made: dict[str, Any] = {}
        key, prefix = self.key(use)
        made["part"] = macro.ours
        made["prefix"] = prefix
        if macro.mount is not None:
            name = next(name for name, variable in macro.variables.items() if variable is macro.mount)
            value = use.given.get(name) or self.default(macro, name, use.scope)
            made["parent"] = self.text(Value(value.text, value.scope, NAME, value.span))
            made |= self.pose(use)
        given = self.with_of(use)
        if given:
            made["with"] = given
        key = self.free_key(key, section, path, use)
        if prefix is None or prefix == f"{key}_":
            del made["prefix"]
            if prefix is None and key != self.key(use)[0]:
                made["prefix"] = f"{self.key(use)[0]}_"
        section[key] = conditional(made, when)
        self.documents.elements[file, "use", str(key)] = place_of(use.at.span)
        self.documents.remark(file, (*path, key), use.comments)

    def key(self, use: Use) -> tuple[Any, Any]:
        """Return the name of a use, and its prefix; None where that is its name and ``_``."""
        macro = use.macro
        if macro.prefix is None:
            value = use.given.get("name")
            if value is not None:
                key = self.text(Value(value.text, value.scope, NAME, value.span))
                if macro.by_key:
                    return key, ""
                if key and not isinstance(key, Expression):
                    return _as_key(str(key)) or macro.ours, ""
            found = lead_of(use)
            return _as_key(found) or macro.ours, ""
        pieces = prefix_pieces(use)
        if self.macro is not None and self.macro.prefix is not None:
            pieces = without_prefix(pieces, self.macro.prefix) or []
        text = self.joined(pieces, Value("", use.scope, NAME, use.element.span))
        if isinstance(text, Expression):
            tail = pieces[-1][0].text.strip("_") if pieces[-1][0].kind == TEXT else ""
            return _as_key(tail) or macro.ours, text
        if text.endswith("_") and len(text) > 1 and Scalar(text[:-1]).value == text[:-1]:
            return text[:-1], None
        name = use.given.get("name")
        plain = _as_key(name.text) if name is not None and is_plain(name.text) else ""
        return _as_key(text.strip("_")) or plain or macro.ours, text

    def tell_apart(self, uses: list[Use]) -> None:
        """Find names for uses that would be called alike, by what they give, or by what they are uses of."""
        keys: dict[Use, str] = {}
        for use in uses:
            with suppress(Unsupported):  # told where it is written
                keys[use] = str(self.key(use)[0])
        alike: dict[str, list[Use]] = {}
        for use, key in keys.items():
            alike.setdefault(key, []).append(use)
        mixed = {use.macro for group in alike.values() if len({one.macro for one in group}) > 1 for use in group}
        self.told_apart = {}
        for key, group in alike.items():
            for macro in dict.fromkeys(use.macro for use in group if not use.macro.by_key):
                same = [use for use in group if use.macro is macro]
                words = words_apart(same) if len(same) > 1 else [key]
                for use, word in zip(same, words, strict=False) if len(group) > 1 or macro in mixed else ():
                    of = (
                        macro.ours
                        if macro in mixed and word != macro.ours
                        else key
                        if not _as_key(word.strip("_"))
                        else ""
                    )
                    self.told_apart[id(use)] = _as_key(f"{word}_{of}" if macro in mixed else f"{of}_{word}")

    def free_key(self, key: Any, section: dict[Any, Any], path: tuple[Any, ...], use: Use) -> Any:
        """Return a name that no other use has; those of all files share one set of names."""
        key = self.told_apart.get(id(use)) or key
        name, number = key, 1
        taken = section if path[0] == "parts" else self.keys
        if use.macro.by_key:
            self.keys.add(key)
            return key
        while name in taken or name in self.reserved.get(self.macro, ()):
            number += 1
            name = f"{key}_{number}"
        if path[0] != "parts":
            self.keys.add(name)
        return name

    def pose(self, use: Use) -> dict[str, Any]:
        """Return the pose of a use: that of the block that is the origin of what hangs on its mount."""
        macro = use.macro
        if not macro.origin or macro.origin not in use.blocks:
            return {}
        made = self.entry(use.blocks[macro.origin])
        if not isinstance(made, dict):
            raise Unsupported("a pose that a macro makes", use.element.span)
        return made

    def with_of(self, use: Use) -> dict[str, Any]:
        """Return what a use gives to its part."""
        macro, made = use.macro, {}
        for name, variable in self.parameters(macro):
            if variable is macro.mount or self.is_own_prefix(macro, variable):
                continue
            if macro.by_key and name == "name":
                continue
            value = use.given.get(name)
            if value is None and name in macro.variables and self.shadows(macro, name):
                value = self.default(macro, name, use.scope)
            if value is None and name not in macro.variables:
                value = Value(f"${{{name}}}", use.scope, "free", use.element.span)
            if value is not None:
                if variable is macro.relative and self.macro is not None and self.macro.prefix is not None:
                    found = self.text(Value(value.text, value.scope, NAME, value.span))
                else:
                    found = self.of_variable(value, variable)
                if not self.is_default(macro, name, found, variable):
                    made[variable.ours] = found
        for name, entry in use.blocks.items():
            if name != macro.origin:
                made |= self.block_of(use, name, entry)
        return made

    def block_of(self, use: Use, name: str, entry: Entry) -> dict[str, Any]:
        """Return what a use hands over of a block: value by value, or as a table."""
        known = leaves(use.macro, name, self.program.scope)
        if known is None:
            return {self.block_name(name): self.entry(entry)}
        found = {leaf: self.leaf(entry, leaf) for leaf in known}
        return {leaf.name: value for leaf, value in found.items() if leaf.always or value != default_of(leaf)}

    def is_own_prefix(self, macro: Macro, variable: Variable) -> bool:
        """Say whether a parameter is what a part knows anyway: all that stands before its names."""
        prefix = macro.prefix
        return prefix is not None and self.knows_prefix and variable is prefix[0] and not prefix[1]

    def said_default(self, macro: Macro, name: str) -> str | None:
        return next((one.default for one in macro.parameters if one.name == name), None)

    def shadows(self, macro: Macro, name: str) -> bool:
        """Say whether the default of a parameter is made of a value that is called as the parameter is."""
        default = self.said_default(macro, name)
        if default is None or is_plain(default):
            return False
        found = variables_in(Value(default, self.program.scope, "free"))
        return any(one.ours == macro.variables[name].ours for one in found)

    def is_default(self, macro: Macro, name: str, found: Any, variable: Variable) -> bool:
        """Say whether a use would say what the part takes by default."""
        default = self.said_default(macro, name)
        if default is None or self.shadows(macro, name):
            return False
        return bool(found == self.of_variable(Value(default, self.program.scope, "free"), variable))

    def params(self, macro: Macro) -> dict[str, Any]:
        made: dict[str, Any] = {}
        for name, variable in self.parameters(macro):
            if variable is macro.mount or self.is_own_prefix(macro, variable):
                continue
            if macro.by_key and name == "name":
                continue
            declared: dict[str, Any] = {}
            kind = declared_type(variable)
            if kind:
                plain = kind in ("length", "mass") and {macro.name, macro.ours} & self.plain
                declared["type"] = "number" if plain else kind
            default = None if self.shadows(macro, name) else self.said_default(macro, name)
            if default is not None:
                declared["default"] = self.of_variable(
                    Value(default, self.program.scope, "free", macro.place), variable
                )
            made[variable.ours] = declared
        for block in inserted(macro):
            if block != macro.origin:
                made |= self.block_params(macro, block)
        return made

    def block_params(self, macro: Macro, name: str) -> dict[str, Any]:
        """Return the parameters of a part that stand for a block."""
        known = leaves(macro, name, self.program.scope)
        if known is None:
            return {self.block_name(name): {"type": "table"}}
        made: dict[str, Any] = {}
        for leaf in known:
            kind = type_of(leaf)
            made[leaf.name] = {"type": kind} if kind else {}
            if not leaf.always:
                made[leaf.name]["default"] = default_of(leaf)
        return made

    def locals(self, body: Body, path: tuple[Any, ...]) -> dict[str, Any]:
        """Return the properties of a macro that it uses; ``path`` is where they are going to stand."""
        made: dict[str, Any] = {}
        for variable in body.locals:
            if variable in self.used:
                try:
                    made[variable.ours] = self.defined(variable.definitions, variable)
                    self.documents.remark(body.file.name, (*path, variable.ours), variable.comments)
                except Unsupported as problem:
                    if body.macro is not None:
                        raise
                    variable.unsaid = problem.reason  # told where it is used, once all is rendered anew
                    self.used.remove(variable)
                    self.again = True
        return made

    def defined(self, definitions: list[tuple[Value, Whens]], variable: Variable) -> Any:
        """Return the value of a property; one that depends on conditions is a choice."""
        if len(definitions) == 1 and not definitions[0][1]:
            value = definitions[0][0]
            return self.mapping_of(value) or self.of_variable(value, variable)
        chosen: ast.expr | None = None
        for value, when in definitions:
            condition = self.condition(when)
            if isinstance(condition, ast.Constant) and not condition.value:
                continue
            node = self.expressions().value(value)
            if variable.kind() == WORDS and isinstance(node, ast.List) and is_plain(value.text):
                node = ast.Constant(value.text)
            if condition is None:
                chosen = node
            elif chosen is None:
                chosen = ast.IfExp(condition, node, ast.Constant(None))
            else:
                chosen = _choice(condition, node, chosen)
        if chosen is None:
            return None
        return final(chosen)

    def named_values(self) -> None:
        """Write the properties that anything uses."""
        self.macro = None
        for name, definitions in self.program.properties.items():
            variable = self.program.scope.names.get(name)
            if not isinstance(variable, Variable) or variable.where == ARGUMENT or variable not in self.used:
                continue
            file = self.program.property_files[name].name
            found = [(one.value, one.when) for one in definitions]
            try:
                value = self.defined(found, variable)
            except Unsupported as problem:
                raise InProperty(name, problem.reason) from None
            self.documents.section(file, "let")[variable.ours] = value
            self.documents.remark(file, ("let", variable.ours), self.program.property_comments.get(name, ()))

    def arguments(self) -> None:
        """Write the arguments that anything uses; one that is made of others stands behind them, in the first file."""
        composed: list[tuple[Variable, dict[str, Any]]] = []
        for name, variable in self.program.arguments.items():
            if variable not in self.used:
                continue
            declared = self.declared(name, variable)
            if isinstance(declared.get("default"), Expression):
                composed.append((variable, declared))
            else:
                self.argument(self.program.argument_files[name].name, variable, declared)
        for variable, declared in composed:
            self.argument(self.program.root.name, variable, declared)

    def argument(self, file: str, variable: Variable, declared: dict[str, Any]) -> None:
        self.documents.section(file, "args")[variable.ours] = declared
        self.documents.remark(file, ("args", variable.ours), variable.comments)

    def declared(self, name: str, variable: Variable) -> dict[str, Any]:
        """Return the entry of an argument."""
        kind = variable.kind()
        kind_of = argument_type(variable)
        plain = kind_of in ("length", "mass") and ARGUMENTS in self.plain
        declared: dict[str, Any] = {"type": "number" if plain else kind_of}
        given = self.program.given.get(name)
        text = given if given is not None else variable.values[0].text if _own(variable) else None
        if text is not None:
            kind = WORDS if kind in (LIST, TABLE, ANY) else kind
            declared["default"] = self.of_variable(Value(text, self.program.scope, "free"), variable, kind)
        if allowed := self.allowed(name, variable):
            declared["one_of"] = allowed
        return declared

    def allowed(self, name: str, variable: Variable) -> list[str]:
        """Return the texts that an argument may be; nothing where it may be any."""
        choices = [one for one in self.choices.get(name, ()) if one != PROBE]
        one_of = argument_type(variable) == "text" and is_choice(variable) and len(choices) > 1
        return choices if one_of else []


def _list_of(texts: list[str]) -> ast.expr:
    return ast.List([ast.Constant(text) for text in texts], ast.Load())


def _choice(condition: ast.expr, node: ast.expr, other: ast.expr) -> ast.expr:
    """Return a choice; of one whose other is chosen by the opposite of the condition that is just the other."""
    if isinstance(other, ast.IfExp) and isinstance(other.orelse, ast.Constant) and other.orelse.value is None:
        if written(other.test) == written(negated(condition)):
            return ast.IfExp(other.test, other.body, node)
        if isinstance(node, ast.Constant) and node.value is None:
            return other
    return ast.IfExp(condition, node, other)


def _as_key(text: str) -> str:
    made = re.sub(r"[^\w-]+", "_", text).strip("_")
    return made if made and isinstance(Scalar(made).value, str) else ""


def _own(variable: Variable) -> bool:
    return bool(variable.values)


def is_choice(variable: Variable) -> bool:
    """Say whether an argument is nothing but compared with texts, so that these are all that it may be."""
    evidence = variable.head().evidence
    compared = {one for one in evidence if one.startswith("=")}
    return "=" not in compared and bool(compared) and not evidence & {NAME, FILE, XML, *NUMBERS, *LISTS, "reckoned"}


def argument_type(variable: Variable) -> str:
    """Return the type of an argument."""
    kind = variable.kind()
    if kind == NUMBER:
        return declared_type(variable)
    return "boolean" if kind == FLAG else "text"
