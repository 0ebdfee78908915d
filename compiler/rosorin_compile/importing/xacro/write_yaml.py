"""Write the intermediate representation of a xacro as the files of a description.

What nothing uses is left out: the files are written again until what is used does not grow any more.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.imported import Imported, Outputs
from rosorin_compile.language.expression.functions import OF_DESCRIPTIONS, functions
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Element
from rosorin_compile.source.yaml_text import Scalar

from ..description import _Document, _written, tree_of
from ..key_order import sorted_sections
from ..layout import Expression, Remarks, Verbatim, cleaned, layout
from .build import GiveUp, Program
from .choices import conditional, merged
from .expressions import all_of, written
from .names import as_key, lead, name_parts, plain_given, prefix_of, without_prefix, words_apart
from .resolve import usable
from .source import Flat
from .texts import TEXT, Unsupported
from .tree import (
    ANY,
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
    Body,
    Call,
    Entry,
    File,
    Macro,
    Named,
    Piece,
    Text,
    Variable,
    Whens,
    place_of,
    references,
)
from .values import Documents, Values, declared_type, default_of, has_expression, leaf_type
from .wording import OPTIONS, Found, Spot, Words, any_of, wishes

PROBE = "probe_"  # a value of an argument that is compared with other texts
# What is made of the xacro begins and ends a file, in this order; what other files than the xacro say is between.
_HEAD = ("rosorin_compile", "robot", "source", "include", "args", "let", "materials", "parts", "links", "joints", "use")
_TAIL = ("urdf_elements", "accept", "outputs")


class Target(NamedTuple):
    """Where a description is going to be, and what it has other than the xacro.

    ``schema`` is the address of the schema for editors; ``name`` another name of the robot; ``meshes`` is put before
    relative names of meshes. ``verbatim`` keeps elements for which the language has words. ``sharing`` are the other
    robots of the package.
    """

    folder: Path
    schema: str = ""
    name: str | None = None
    meshes: str | None = None
    verbatim: bool = False
    sharing: Any = None


class WrittenFiles(NamedTuple):
    """The files of a description, with what they were made of and the packages that they need."""

    files: dict[str, str]
    program: Program
    packages: dict[str, Path]
    documents: Documents
    used: set[Variable]
    unfound: tuple[str, ...] = ()


class Writer:
    """Writes a program; ``words`` are what elements become, by their place."""

    def __init__(
        self, program: Program, choices: Mapping[str, list[str]], target: Target, words: Mapping[Spot, Words]
    ) -> None:
        self.program = program
        self.choices = choices
        self.words = words
        self.values = Values(program, choices, target.folder, target.meshes or "")
        self.names = {one: one.ours for one in program.globals}
        self.names |= {one: one.ours for macro in program.kept if macro.body for one in macro.body.locals}
        self.keys: set[str] = set()
        self.reserved: dict[Macro | None, set[str]] = {}
        self.apart: dict[Call, str] = {}
        self.alternatives: dict[tuple[int, str], list[Any]] = {}

    @property
    def documents(self) -> Documents:
        return self.values.documents

    def render(self) -> Documents:
        """Return the documents. Raises GiveUp for what cannot be written."""
        program, values = self.program, self.values
        self.name_macros()
        name_parts(program.kept, program.plan.explicit)
        values.knows_prefix = all(one.ours != "prefix" for one in (*program.names.arguments.values(), *program.globals))
        self.reserve()
        before = -1
        while before != len(values.used):
            before = len(values.used)
            self.name_variables()
            values.documents = Documents()
            values.looks = {}
            self.keys, self.alternatives = set(), {}
            inner = [macro.body for macro in program.kept if macro.body is not None]
            for body in (*(file.body for file in program.files.values()), *inner):
                for named in body.materials:
                    with self.within(body.macro, named.element):
                        self.material(named, body)
            for file in program.files.values():
                self.file(file)
            for macro in program.kept:
                try:
                    if macro.body is None:
                        self.named_value(macro)
                    elif not macro.body.is_empty():
                        self.part(macro)
                except Unsupported as problem:
                    raise GiveUp(macro, problem) from None
            self.let_values()
            self.arguments()
        attribute = program.root.document.root.attributes.get("name")
        if attribute is not None and "$" in attribute.value:
            values.macro = None
            self.documents.name = values.text(
                program.names.resolve(attribute.value, program.scope, NAME, attribute.span)
            )
        return self.documents

    # Names.

    def name_macros(self) -> None:
        """Give each macro that is kept the name of its part or its value."""
        program = self.program
        taken = {one.ours for one in (*program.names.arguments.values(), *program.globals)}
        taken |= {*functions(), *OF_DESCRIPTIONS}
        for macro in program.kept:
            macro.ours = macro.name.replace(".", "_")
            if macro.body is None:
                macro.ours = usable(macro.name, taken)
                taken.add(macro.ours)

    def name_variables(self) -> None:
        """Give the properties that are used names that are unique where they are read."""
        program, used = self.program, self.values.used
        taken = {one.ours for one in program.names.arguments.values()}
        for variable in program.globals:
            if variable in used:
                variable.ours = usable(self.names[variable], taken)
                taken.add(variable.ours)
        for macro in program.kept:
            own = {"name", "prefix", *taken}
            own |= {one.ours for one in (*macro.variables.values(), *macro.implicit.values())}
            for variable in macro.body.locals if macro.body else ():
                if variable in used:
                    variable.ours = usable(self.names[variable], own)
                    own.add(variable.ours)

    def reserve(self) -> None:
        """Find the parts whose uses are named by the parameter ``name``; these names are theirs."""
        bodies: list[tuple[Macro | None, list[Call]]] = [(m, m.body.uses) for m in self.program.kept if m.body]
        bodies.append((None, [use for file in self.program.files.values() for use in file.body.uses]))
        spoilt: set[Macro] = set()
        for owner, uses in bodies:
            self.values.macro = owner
            seen: dict[str, Macro] = {}
            for use in uses:
                if use.macro.prefix is not None or "name" not in use.macro.variables:
                    continue
                key = self.name_given(use)
                if not key or key in seen or not isinstance(Scalar(key).value, str) or "/" in key:
                    spoilt |= {use.macro, *([seen[key]] if key in seen else [])}
                seen[key] = use.macro
        for macro in self.program.kept:
            kind = macro.variables["name"].kind() if "name" in macro.variables else ""
            fits = macro.body is not None and macro.prefix is None and kind in (WORDS, ANY)
            macro.by_key = fits and bool(macro.uses) and macro not in spoilt
        for owner, uses in bodies:
            self.values.macro = owner
            self.reserved[owner] = {self.name_given(use) for use in uses if use.macro.by_key}
        self.values.macro = None

    def name_given(self, use: Call) -> str:
        """Return what a use gives for ``name`` as text; empty if that is nothing."""
        given = use.given.get("name")
        try:
            return str(self.values.text(given.for_use(NAME))) if given is not None else ""
        except Unsupported:  # reported where it is used
            return ""

    # Files, parts and named values.

    @contextmanager
    def within(self, macro: Macro | None, element: Element | None) -> Iterator[None]:
        """Set the macro that is written, and report what cannot be written with its element."""
        self.values.macro = macro
        try:
            yield
        except Unsupported as problem:
            if element is None and macro is not None:
                raise GiveUp(macro, problem) from None
            if element is None:
                raise
            raise GiveUp(element, problem) from None

    def file(self, file: File) -> None:
        self.values.macro = None
        self.body(file.body, file.name, (), self.documents.files.setdefault(file.name, {}))
        if self.values.extra:
            self.documents.section(file.name, "let").update(self.values.extra)

    def part(self, macro: Macro) -> None:
        """Write a macro that is a part."""
        values, file = self.values, macro.file.name
        values.macro = macro
        made: dict[str, Any] = {}
        self.documents.section(file, "parts")[macro.ours] = made
        body: Any = macro.body
        self.body(body, file, ("parts", macro.ours), made)
        params = self.params(macro)
        lets = self.locals(body, file, ("parts", macro.ours, "let")) | values.extra
        rest = dict(made)
        made.clear()
        made.update({**({"params": params} if params else {}), **({"let": lets} if lets else {}), **rest})
        self.documents.remark(file, ("parts", macro.ours), macro.comments)
        values.macro = None

    def named_value(self, macro: Macro) -> None:
        """Write a macro that is a named value, or a named text, with parameters."""
        values = self.values
        values.macro = macro
        if macro.text is not None:
            values.named_texts = False  # they would need the parameters of this value
            lines = [line for item in values.content(macro.text) for line in values.lines_of(item, "")]
            values.named_texts = True
            text = "\n".join(lines)
            value: Any = Expression(text) if "${" in text else text
        else:
            entry = macro.entry or Entry()
            keys = entry.keys()
            value = values.entry(entry, ("let", macro.ours))
            if len(keys) == 1 and isinstance(value, dict) and not entry.may_lack(keys[0]):
                value = value.get(keys[0], next(iter(value.values()), {}))
        given = [variable.ours for _, variable in values.parameters(macro)]
        for block in macro.block_levels:
            leaves = values.leaves(macro, block)
            if leaves is None:
                raise Unsupported(f'what is handed over as "{block}" has no word as a value', macro.element.span)
            given += [leaf.name for leaf in leaves]
        key = f"{macro.ours}({', '.join(given)})"
        self.documents.section(macro.file.name, "let")[key] = value
        self.documents.remark(macro.file.name, ("let", key), macro.comments)
        values.macro = None

    def body(self, body: Body, file: str, path: tuple[Any, ...], target: dict[str, Any]) -> None:
        self.values.extra = {}
        for section, entries in (("links", body.links), ("joints", body.joints)):
            for named in entries:
                with self.within(body.macro, named.element):
                    self.named(named, target.setdefault(section, {}), file, (*path, section))
        self.values.macro = body.macro
        self.tell_apart(body.uses)
        for use in (one for one in body.uses if one.macro.body and not one.macro.body.is_empty()):
            try:
                self.use(use, target.setdefault("use", {}), file, (*path, "use"))
            except Unsupported as problem:
                raise GiveUp(use.element, problem) from None
        for number, flat in enumerate(body.flat):
            self.flat(flat, target, file, number)
        self.elements(body, target, file, path)
        for section in ("links", "joints", "use", "urdf_elements"):
            if section in target and not target[section]:
                del target[section]

    def flat(self, flat: Flat, target: dict[str, Any], file: str, number: int) -> None:
        """Write an entry as xacro expands it."""
        if flat.section == "urdf_elements":
            text = self.in_words((file, -1 - number), self.values.laid_out(flat.value), None, target, ())
            if text:
                target.setdefault(flat.section, []).append(text)
        elif flat.section == "materials":
            if not any(flat.name in one.get("materials", ()) for one in self.documents.files.values()):
                target.setdefault(flat.section, {})[flat.name] = flat.value
        else:
            target.setdefault(flat.section, {}).setdefault(flat.name, flat.value)

    def named(self, named: Named, section: dict[Any, Any], file: str, path: tuple[Any, ...]) -> None:
        """Write a link or a joint."""
        when = self.values.condition(named.when)
        if isinstance(when, ast.Constant) and not when.value:
            return
        key = self.values.text(named.name)
        value = self.values.entry(named.entry, (*path, key), file)
        known = self.alternatives.setdefault((id(section), str(key)), [])
        known.append((value, when))
        chosen = merged("", known) if len(known) > 1 else None
        while key in section and chosen is None:
            key = Expression(f"{key}${{''}}")
        section[key] = conditional(value, when) if chosen is None else chosen
        self.documents.elements[file, str(path[-1]), str(key)] = place_of(named.element.span)
        self.documents.remark(file, (*path, key), named.comments)

    def material(self, named: Named, body: Body) -> None:
        """Write a material, which the whole robot shares."""
        values, file = self.values, body.file.name
        name, entry, when = values.text(named.name), values.entry(named.entry), values.condition(named.when)
        if isinstance(when, ast.Constant) and not when.value:
            return
        depends = when is not None or isinstance(name, Expression) or any(map(has_expression, entry.values()))
        if body.macro is not None and depends:
            raise GiveUp(body.macro, Unsupported("a material of a macro", named.element.span))
        holder = next((one for one in self.documents.files.values() if name in one.get("materials", ())), None)
        if holder is not None:
            known = self.alternatives.setdefault((id(holder["materials"]), str(name)), [])
            chosen = merged("", [*known, (entry, when)]) if known and known[-1][1] is not None else None
            if chosen is not None:
                known.append((entry, when))
                holder["materials"][name] = chosen
            return
        section = self.documents.section(file, "materials")
        self.alternatives[id(section), str(name)] = [(entry, when)]
        section[name] = conditional(entry, when)
        if isinstance(entry.get("rgba"), list) and not has_expression(entry["rgba"]):
            values.looks[name] = entry["rgba"]
        self.documents.remark(file, ("materials", name), named.comments)

    # Elements that are kept.

    def elements(self, body: Body, target: dict[str, Any], file: str, path: tuple[Any, ...]) -> None:
        made = target.pop("urdf_elements", [])
        for variable, known, when in body.guards:
            self.values.macro = body.macro
            self.guard(variable, known, when, made)
        for number, listed in enumerate(body.elements):
            with self.within(body.macro, listed.element):
                condition = self.values.condition(listed.when)
                if isinstance(condition, ast.Constant) and not condition.value:
                    continue
                element = self.values.element(listed.value)
            text = self.in_words((file, number, *path[1:]), element, condition, target, listed.comments)
            if text:
                self.documents.remark(file, (*path, "urdf_elements", len(made)), listed.comments)
                made.append(conditional(text, condition))
        if made:
            target["urdf_elements"] = made

    def guard(self, variable: Variable, known: list[str], when: Whens, made: list[Any]) -> None:
        """Refuse the values of an argument that would include files which were not translated."""
        condition = self.values.condition(when)
        is_text = variable.kind() in (WORDS, ANY)
        if (isinstance(condition, ast.Constant) and not condition.value) or (
            is_text and known and self.allowed(variable)
        ):
            return
        self.values.used.add(variable)
        name: ast.expr = ast.Name(variable.ours)
        name = name if is_text else ast.Call(ast.Name("str"), [name], [])
        others = [ast.Compare(name, [ast.NotIn()], [ast.List([ast.Constant(one) for one in known], ast.Load())])]
        node = all_of([*([condition] if condition is not None else []), *(others if known else [])])
        text = f"there is no file for this {variable.name} here: translate it, and add it to include"
        made.append(conditional(Expression(f"${{error({text!r})}}"), node))

    def in_words(
        self, spot: Spot, text: Any, when: ast.expr | None, target: dict[str, Any], comments: tuple[str, ...]
    ) -> Any:
        """Write the words for an element, if there are any, and return what is left of it."""
        documents, macro = self.documents, self.values.macro
        (documents.evaluated if isinstance(text, Expression) else documents.plain)[spot] = text
        words = self.words.get(spot)
        if words is None or (macro is not None and (when is not None or not self.may_have(words, macro))):
            return text
        for entry in words.entries:
            if entry.section == "drive" and (when is not None or "drive" in target):
                continue  # a robot has one drive, whatever its arguments
            documents.asked.setdefault(OPTIONS.get(entry.section, ""), []).append(when)
            documents.said.setdefault(entry.section, []).append(entry.called)
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
            path = ("parts", *spot[2:]) if macro is not None else ()
            documents.remark(spot[0], (*path, entry.section, key), (*comments, *entry.comments))
            comments = () if not words.rest else comments
        return text if words.rest == words.text else words.rest

    def may_have(self, words: Words, macro: Macro) -> bool:
        """Return True if a part may have words: sensors, and hardware if the robot always has the part."""
        sections = {entry.section for entry in words.entries}
        return sections == {"sensors"} or (sections == {"control"} and self.is_always_used(macro, 0))

    def is_always_used(self, macro: Macro, depth: int) -> bool:
        bodies = [file.body for file in self.program.files.values()]
        bodies += [one.body for one in self.program.kept if one.body is not None and depth < len(self.program.kept)]
        return any(
            use.macro is macro and not use.when and (body.macro is None or self.is_always_used(body.macro, depth + 1))
            for body in bodies
            for use in body.uses
        )

    # Uses of parts.

    def use(self, use: Call, section: dict[Any, Any], file: str, path: tuple[Any, ...]) -> None:
        """Write a call of a macro that is a part."""
        values, macro = self.values, use.macro
        when = values.condition(use.when)
        if isinstance(when, ast.Constant) and not when.value:
            return
        first, prefix = self.key(use)
        made: dict[str, Any] = {"part": macro.ours, "prefix": prefix}
        if macro.mount is not None:
            name = next(name for name, variable in macro.variables.items() if variable is macro.mount)
            text = use.given.get(name) or macro.defaults.get(name) or Text([])
            made["parent"] = values.text(text.for_use(NAME))
            pose = values.entry(use.blocks[macro.origin]) if macro.origin in use.blocks else {}
            if not isinstance(pose, dict):
                raise Unsupported("a pose that a macro makes", use.element.span)
            made |= pose
        given = self.given(use)
        if given:
            made["with"] = given
        key = self.free_key(first, section, path, use)
        if prefix is None or prefix == f"{key}_":
            del made["prefix"]
            if prefix is None and key != first:
                made["prefix"] = f"{first}_"
        section[key] = conditional(made, when)
        self.documents.elements[file, "use", str(key)] = place_of(use.element.span)
        self.documents.remark(file, (*path, key), use.comments)

    def key(self, use: Call) -> tuple[Any, Any]:
        """Return the name of a use, and its prefix; None if that is its name and ``_``."""
        values, macro = self.values, use.macro
        given = use.given.get("name")
        if macro.prefix is None:
            if given is not None:
                key = values.text(given.for_use(NAME))
                if macro.by_key:
                    return key, ""
                if key and not isinstance(key, Expression):
                    return as_key(str(key)) or macro.ours, ""
            found = next(
                (one[0] for link in (macro.body.links if macro.body else ()) if (one := lead(link.name))), None
            )
            word = plain_given(use, found) if found is not None and found in macro.variables.values() else ""
            return as_key(word) or macro.ours, ""
        pieces = prefix_of(use)
        if values.macro is not None and values.macro.prefix is not None:
            pieces = without_prefix(pieces, values.macro.prefix) or []
        text = values.joined(pieces, Text(pieces, NAME, use.element.span))
        if isinstance(text, Expression):
            tail = pieces[-1].value.strip("_") if pieces[-1].kind == TEXT else ""
            return as_key(tail) or macro.ours, text
        if text.endswith("_") and len(text) > 1 and Scalar(text[:-1]).value == text[:-1]:
            return text[:-1], None
        plain = as_key(given.plain) if given is not None and given.plain else ""
        return as_key(text.strip("_")) or plain or macro.ours, text

    def tell_apart(self, uses: list[Call]) -> None:
        """Find names for uses that would have one name, by what they give, or by what they are uses of."""
        self.apart = {}
        groups: dict[str, list[Call]] = {}
        for use in uses:
            try:
                groups.setdefault(str(self.key(use)[0]), []).append(use)
            except Unsupported:  # reported where it is written
                continue
        mixed = {use.macro for group in groups.values() if len({one.macro for one in group}) > 1 for use in group}
        for key, group in groups.items():
            for macro in dict.fromkeys(use.macro for use in group if not use.macro.by_key):
                same = [use for use in group if use.macro is macro]
                found = words_apart(same) if len(same) > 1 else [key]
                for use, word in zip(same, found, strict=False) if len(group) > 1 or macro in mixed else ():
                    part = macro.ours if macro in mixed and word != macro.ours else ""
                    part = part or ("" if macro in mixed or as_key(word.strip("_")) else key)
                    self.apart[use] = as_key(f"{word}_{part}" if macro in mixed else f"{part}_{word}")

    def free_key(self, key: Any, section: dict[Any, Any], path: tuple[Any, ...], use: Call) -> Any:
        """Return a name that no other use has; those of all files share one set of names."""
        taken = section if path[0] == "parts" else self.keys
        key = self.apart.get(use) or key
        name, number = key, 1
        while not use.macro.by_key and (name in taken or name in self.reserved.get(self.values.macro, ())):
            number += 1
            name = f"{key}_{number}"
        if path[0] != "parts":
            self.keys.add(name)
        return name

    def given(self, use: Call) -> dict[str, Any]:
        """Return what a use gives to its part."""
        values, macro = self.values, use.macro
        made: dict[str, Any] = {}
        for name, variable in values.parameters(macro):
            if self.is_known(macro, name, variable):
                continue
            text = use.given.get(name)
            default = macro.defaults.get(name)
            if text is None and default is not None and self.shadows(macro, name):
                text = default
            if text is None:
                continue
            is_relative = variable is macro.relative and values.macro is not None and values.macro.prefix is not None
            found = values.text(text.for_use(NAME)) if is_relative else values.of_variable(text, variable)
            if default is None or self.shadows(macro, name) or found != values.of_variable(default, variable):
                made[variable.ours] = found
        for name, entry in use.blocks.items():
            if name == macro.origin or name not in macro.block_levels:
                continue
            leaves = values.leaves(macro, name)
            if leaves is None:
                reason = f'what is handed over as "{name}" has no word as a value'
                raise GiveUp(macro, Unsupported(reason, use.element.span))
            found_by = {leaf: values.leaf(entry, leaf) for leaf in leaves}
            made |= {leaf.name: one for leaf, one in found_by.items() if leaf.always or one != default_of(leaf)}
        return made

    def is_known(self, macro: Macro, name: str, variable: Variable) -> bool:
        """Return True if a part knows a parameter anyway: its mount, its prefix, its name."""
        prefix = macro.prefix
        is_prefix = prefix is not None and self.values.knows_prefix and variable is prefix[0] and not prefix[1]
        return variable is macro.mount or is_prefix or (macro.by_key and name == "name")

    def shadows(self, macro: Macro, name: str) -> bool:
        """Return True if the default of a parameter is made of a value that has the name of the parameter."""
        default = macro.defaults.get(name)
        return default is not None and any(one.ours == macro.variables[name].ours for one in references(default))

    def params(self, macro: Macro) -> dict[str, Any]:
        values = self.values
        made: dict[str, Any] = {}
        for name, variable in values.parameters(macro):
            if self.is_known(macro, name, variable):
                continue
            kind = declared_type(variable)
            if kind in ("length", "mass") and {macro.name, macro.ours} & self.program.plan.plain:
                kind = "number"
            made[variable.ours] = {"type": kind} if kind else {}
            default = macro.defaults.get(name)
            if default is not None and not self.shadows(macro, name):
                made[variable.ours]["default"] = values.of_variable(default, variable)
        for block in macro.block_levels:
            for leaf in values.leaves(macro, block) or () if block != macro.origin else ():
                made[leaf.name] = {"type": leaf_type(leaf)} if leaf_type(leaf) else {}
                if not leaf.always:
                    made[leaf.name]["default"] = default_of(leaf)
        return made

    # Properties and arguments.

    def locals(self, body: Body, file: str, path: tuple[Any, ...]) -> dict[str, Any]:
        """Return the properties of a part that it uses."""
        made: dict[str, Any] = {}
        for variable in body.locals:
            if variable in self.values.used:
                made[variable.ours] = self.property(variable)
                self.documents.remark(file, (*path, variable.ours), variable.comments)
        return made

    def property(self, variable: Variable) -> Any:
        try:
            return self.values.of_variable(variable.values[0], variable)
        except Unsupported as problem:
            raise GiveUp(variable, problem) from None

    def let_values(self) -> None:
        """Write the properties of files that anything uses."""
        self.values.macro = None
        for variable in self.program.globals:
            if variable in self.values.used:
                file = (variable.file or self.program.root).name
                self.documents.section(file, "let")[variable.ours] = self.property(variable)
                self.documents.remark(file, ("let", variable.ours), variable.comments)

    def arguments(self) -> None:
        """Write the arguments that anything uses; one that is made of others is behind them, in the first file."""
        composed: list[tuple[Variable, dict[str, Any]]] = []
        for variable in self.program.names.arguments.values():
            if variable in self.values.used:
                declared = self.declared(variable)
                if isinstance(declared.get("default"), Expression):
                    composed.append((variable, declared))
                else:
                    self.argument((variable.file or self.program.root).name, variable, declared)
        for variable, declared in composed:
            self.argument(self.program.root.name, variable, declared)

    def argument(self, file: str, variable: Variable, declared: dict[str, Any]) -> None:
        self.documents.section(file, "args")[variable.ours] = declared
        self.documents.remark(file, ("args", variable.ours), variable.comments)

    def declared(self, variable: Variable) -> dict[str, Any]:
        """Return the entry of an argument."""
        kind, named = variable.kind(), argument_type(variable)
        declared: dict[str, Any] = {
            "type": "number" if named in ("length", "mass") and "" in self.program.plan.plain else named
        }
        given = self.program.names.given.get(variable.name)
        text = Text([Piece(TEXT, given)]) if given is not None else variable.values[0] if variable.values else None
        if text is not None:
            declared["default"] = self.values.of_variable(text, variable, WORDS if kind in (LIST, TABLE, ANY) else kind)
        if allowed := self.allowed(variable):
            declared["one_of"] = allowed
        return declared

    def allowed(self, variable: Variable) -> list[str]:
        """Return the texts that an argument may be; nothing if it may be any."""
        choices = [one for one in self.choices.get(variable.name, ()) if one != PROBE]
        only = argument_type(variable) == "text" and is_choice(variable) and len(choices) > 1
        return choices if only else []


def is_choice(variable: Variable) -> bool:
    """Return True if an argument is only compared with texts, so that these are all that it may be."""
    evidence = variable.head().evidence
    compared = {one for one in evidence if one.startswith("=")}
    return "=" not in compared and bool(compared) and not evidence & {NAME, FILE, XML, *NUMBERS, *LISTS, "reckoned"}


def argument_type(variable: Variable) -> str:
    """Return the type of an argument."""
    kind = variable.kind()
    return declared_type(variable) if kind == NUMBER else "boolean" if kind == FLAG else "text"


def write(
    program: Program,
    choices: Mapping[str, list[str]],
    target: Target,
    imported: Imported,
    wanted: Outputs,
    accepts: list[Any],
    words: Found | None = None,
    shares: frozenset[str] | None = None,
) -> WrittenFiles:
    """Return the files of a description."""
    words = words or Found()
    writer = Writer(program, choices, target, words.spots)
    documents = writer.render()
    data = writer.values.data
    asked: dict[str, Any] = {}
    for option in sorted(documents.asked.keys() & words.options.keys()):
        value, when = words.options[option], any_of(documents.asked[option])
        asked[option] = value if when is None else Expression(f"${{{value!r} if {written(when)} else none}}")
    tree, root = tree_of(imported), program.root.name
    included: list[str] = []
    beside: dict[str, str] = {}
    for file in program.files.values():
        sections = {key: value for key, value in documents.files.get(file.name, {}).items() if value}
        if file.name == root or not sections:
            continue
        text, name = _layout(sections, documents, file, ""), file.name
        address = data.address_of(file, text)
        if target.sharing is not None and shares is not None and not data.files:  # tables are named from the file
            name, text = target.sharing.placed(program, file, text, file.name in shares)
        documents.elements |= {(name, *key[1:]): at for key, at in documents.elements.items() if key[0] == file.name}
        included.append(address or name)
        beside |= {} if address else {name: text}
    head: dict[str, Any] = {
        "rosorin_compile": Verbatim("1"),
        "robot": target.name or documents.name or str(tree["robot"]),
    }
    head |= {"source": dict(tree["source"])} if "source" in tree else {}
    head |= {"include": included} if included else {}
    tail: dict[str, Any] = {**_other_sections(tree), **({"accept": accepts} if accepts else {})}
    tail["outputs"] = {name: _written(entry) for name, entry in wishes(wanted, asked).entries.items()}
    sections = {**head, **(documents.files.get(root) or {}), **tail}
    texts = {root: _layout(sections, documents, program.root, target.schema), **beside, **data.files}
    return WrittenFiles(texts, program, dict(data.used), documents, writer.values.used, tuple(writer.values.unfound))


def _layout(sections: Mapping[str, Any], documents: Documents, file: File, schema: str) -> str:
    document = {key: sections[key] for key in sorted(sections, key=_rank) if sections[key]}
    is_root = file.name == Description.ROOT_FILE
    head = [f"yaml-language-server: $schema={schema}"] if schema and is_root else []
    for remark in file.document.before:
        if remark.kind == "comment" and "autogenerated by xacro" not in remark.text:
            head += cleaned(remark.text)
    return layout(document, Remarks({(): head, **documents.comments.get(file.name, {})}))


def _other_sections(tree: Map) -> dict[str, Any]:
    """Return the sections that other files than the xacro say."""
    document = _Document(tree)
    others = sorted_sections({name: value for name, value in tree.items() if name not in (*_HEAD, *_TAIL)})
    return {name: document.value(value, (name,), None) for name, value in others.items()}


def _rank(key: str) -> int:
    return _HEAD.index(key) if key in _HEAD else 100 + _TAIL.index(key) if key in _TAIL else 50
