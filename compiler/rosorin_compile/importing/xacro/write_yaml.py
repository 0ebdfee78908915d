"""Write the intermediate representation of a xacro as the files of a description, in one pass.

What nothing uses is left out: the files are written again until what is used does not grow any more.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from typing import Any

from rosorin_compile.formats.imported import Imported, Outputs
from rosorin_compile.formats.urdf.reading import ANGLES, LENGTHS
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map
from rosorin_compile.source.yaml_text import Scalar

from ..description import _Document, _written, sorted_sections, tree_of
from ..layout import Expression, Remarks, Verbatim, cleaned, layout
from .arguments import ArgumentValues, declare_dimensions
from .choices import any_of, conditional, covers, merged
from .documents import Documents, GiveUp, PackageFiles, Target, WrittenFiles, within
from .entries import Entries
from .formulas import Formulas, all_of, folded, literal, type_of_values, written
from .ir import (
    ANY,
    ARGUMENT,
    FLAG,
    LET,
    LIST,
    NUMBER,
    TEXT,
    Call,
    Comment,
    Element,
    File,
    If,
    Macro,
    Program,
    Unsupported,
    Variable,
    Words,
    comments_before,
    flattened,
    usable,
)
from .part_names import PartNames, makes_only_materials
from .values import Values, number
from .wording import OPTIONS, Found, Spot, outputs_for
from .wording import Words as WordsOf

# What is made of the xacro begins and ends a file, in this order; other sections are between.
_HEAD = ("rosorin_compile", "robot", "source", "include", "args", "let", "materials", "parts", "links", "joints", "use")
_TAIL = ("urdf_elements", "accept", "outputs")


class Writer:
    """Writes a program. ``explicit`` are the keys of macros whose names keep their prefix."""

    def __init__(self, program: Program, target: Target, explicit: set[str], words: Mapping[Spot, WordsOf]) -> None:
        self.program, self.target, self.words = program, target, words
        self.used: set[Variable] = set()
        self.packages = PackageFiles(program, target.folder)
        self.documents = Documents()
        self._set_types()
        self.names = PartNames(program, explicit)
        formulas = Formulas(program.variables, self._use)
        formulas.found, formulas.address = self.packages.find, self.packages.address
        self.values = Values(program, self.names, formulas, target.meshes, self.packages.address)
        self.arguments = ArgumentValues(program, self.values.printed)
        self._part: dict[str, Any] | None = None  # the part that is written

    def render(self) -> Documents:
        """Return the documents. Raises GiveUp for what cannot be written."""
        program = self.program
        before = -1
        while before != len(self.used) + len(self.values.file_names):
            before = len(self.used) + len(self.values.file_names)
            self._name_variables()
            self.documents = Documents()
            self.entries = Entries(program, self.values, self.documents)
            self._keys: set[str] = set()
            self._alternatives: dict[tuple[int, str], list[Any]] = {}
            for macro in program.macros.values():
                with within(self.values, macro):
                    if macro.level == "robot":
                        self._write_part(macro)
                    else:
                        self.entries.named_value(macro)
            with within(self.values, None):
                self._body(program.body, None)
                for variable in self._lets(""):
                    file = program.file_of(variable.place).name
                    self.documents.section(file, "let")[variable.ours] = self._let_value(variable)
                    self.documents.remark(file, ("let", variable.ours), variable.comments)
                self._write_arguments()
        return self.documents

    def _set_types(self) -> None:
        formulas = Formulas(self.program.variables, lambda _: None)
        variables = self.program.variables.values()
        for variable in variables:
            variable.type = type_of_values(variable.values, variable.kind == ARGUMENT)
            if variable.kind == ARGUMENT:
                has_texts = any(isinstance(literal(one), str) for one in variable.candidates)
                variable.type = TEXT if has_texts or variable.type not in (NUMBER, FLAG) else variable.type
            elif variable.type == ANY and variable.kind == LET and variable.node is not None:
                variable.type = formulas.type(variable.node)
        for variable in variables:  # a value that several calls give
            if variable.kind == LET and isinstance(variable.node, ast.IfExp):
                variable.type = formulas.type(variable.node) or variable.type

    def _use(self, variable: Variable) -> ast.expr | None:
        """Record that a variable is read; return what is written for it, if that is not its name."""
        owner, macro = self.program.macros.get(variable.owner), self.values.macro
        if variable.kind == LET and owner is not None and owner.level != "robot" and variable.node is not None:
            return self.values.formulas.node(variable.node)  # a named value has no properties of its own
        self.used.add(variable)
        if macro is not None and variable.owner == macro.key:
            prefix = self.names.prefix.get(macro)
            if prefix is not None and variable is prefix[0] and not prefix[1] and self.names.knows_prefix(macro):
                return ast.Name("prefix", ast.Load())
            if self.names.mount.get(macro) is variable:
                return ast.Constant("mount")
        return None

    # Names.

    def _name_variables(self) -> None:
        """Give the macros and the properties that are used names that are unique where they are read."""
        program = self.program
        taken: set[str] = set()
        parts: set[str] = set()
        for variable in program.arguments.values():  # people set it by its name
            variable.ours = usable(variable.name, taken, shadows=True)
            taken.add(variable.ours)
        for macro in program.macros.values():
            name, number = macro.name.replace(".", "_"), 1
            macro.ours = name if macro.level == "robot" else usable(macro.name, taken)
            while macro.level == "robot" and macro.ours in parts:
                number += 1
                macro.ours = f"{name}_{number}"
            (parts if macro.level == "robot" else taken).add(macro.ours)
        for variable in self._lets(""):
            variable.ours = usable(variable.name, taken)
            taken.add(variable.ours)
        for macro in program.macros.values():
            own: set[str] = set()
            for variable in macro.parameters.values():
                variable.ours = usable(variable.name, own)
                own.add(variable.ours)
            for variable in self._lets(macro.key):
                variable.ours = usable(variable.name, own | taken)
                own.add(variable.ours)

    def _lets(self, owner: str) -> list[Variable]:
        """Return the properties of a macro, or of the robot, that are used."""
        variables = self.program.variables.values()
        return [one for one in variables if one.kind == LET and one.owner == owner and one in self.used]

    # What is at the level of links.

    def _body(self, nodes: list[Any], when: ast.expr | None) -> None:
        """Write what is at the level of links: of the robot, or of the part that is written."""
        comments: list[str] = []
        for node in nodes:
            if isinstance(node, Comment):
                comments.append(node.text)
                continue
            if isinstance(node, If):
                condition = all_of([one for one in (when, self.entries.condition(node)) if one is not None])
                if condition is None or folded(condition) is not False:
                    self._body([*map(Comment, comments), *node.body], condition)
            elif isinstance(node, Call):
                with within(self.values, self.values.macro, node):
                    self.use_part(node, when, [*comments, *node.comments])
            elif isinstance(node, Element):
                with within(self.values, self.values.macro, node):
                    self._entry(node, when, [*comments, *node.comments])
            elif isinstance(node, Words):
                raise Unsupported("text among links", None)
            comments = []

    def _place_of(self, node: Element | Call) -> tuple[str, tuple[Any, ...], dict[str, Any]]:
        """Return where a node is written: the file, the path in it, and the mapping."""
        macro = self.values.macro
        if self._part is not None and macro is not None:
            return self.program.file_of(macro.place).name, ("parts", macro.ours), self._part
        file = self.program.file_of(node.place).name
        return file, (), self.documents.files.setdefault(file, {})

    def _entry(self, node: Element, when: ast.expr | None, comments: list[str]) -> None:
        file, path, document = self._place_of(node)
        if node.tag == "material":
            self._material(node, when, file, comments)
        elif node.tag in ("link", "joint"):
            section = document.setdefault(f"{node.tag}s", {})
            key = self.values.text(node.attributes.get("name", []), name=True)
            value = self.entries.link(node) if node.tag == "link" else self.entries.joint(node)
            shapes, here = self.entries.shapes, (*path, f"{node.tag}s", key)
            self._put(section, key, value, when)
            self.documents.remark(file, here, [*comments, *self.entries.inner])
            for name, lists in shapes.items():
                written_shapes = section[key].get(name)
                for index, lines in enumerate(lists):
                    if isinstance(written_shapes, list) and index < len(written_shapes):
                        self.documents.remark(file, (*here, name, index), lines)
        else:
            text = self._in_words(node, when, comments)
            if text:
                made = document.setdefault("urdf_elements", [])
                self.documents.remark(file, (*path, "urdf_elements", len(made)), comments)
                made.append(conditional(text, when))

    def _in_words(self, node: Element, when: ast.expr | None, comments: list[str]) -> Any:
        """Write the entries that an element becomes, if there are any, and return what is left of it."""
        text, (file, path, target) = self.entries.xml.text(node), self._place_of(node)
        documents, macro = self.documents, self.values.macro
        at = (file, *path)
        count = documents.counts[at] = documents.counts.get(at, 0) + 1
        spot = (file, count, *path[1:])
        if not isinstance(text, Expression):
            documents.plain[spot] = text
        words = self.words.get(spot)
        may_have = macro is None or (when is None and words is not None and self._may_have(words, macro))
        if words is None or words.text != text or not may_have:
            return text
        for entry in words.entries:
            if entry.section == "drive" and (when is not None or "drive" in target):
                continue  # a robot has one drive, whatever its arguments
            documents.conditions.setdefault(OPTIONS.get(entry.section, ""), []).append(when)
            documents.labels.setdefault(entry.section, []).append(entry.label)
            if entry.section == "edges":
                target.setdefault(entry.section, []).append(conditional(entry.value, when))
            elif not entry.name:
                target[entry.section] = entry.value
            else:
                section = target.setdefault(entry.section, {})
                key = _free_key(section, entry.name)
                section[key] = conditional(entry.value, when)
                where = path if macro is not None else ()
                remarks = [*([] if words.rest else comments), *entry.comments]
                documents.remark(file, (*where, entry.section, key), remarks)
        return words.rest

    def _may_have(self, words: WordsOf, macro: Macro) -> bool:
        """Return True if a part may have entries: sensors, and hardware if the robot always has the part."""
        sections = {entry.section for entry in words.entries}
        top = {id(one) for one in self.program.body}
        is_always_used = any(call.caller is None and id(call) in top for call in macro.calls)
        return sections == {"sensors"} or (sections == {"control"} and is_always_used)

    def _put(self, section: dict[Any, Any], key: Any, value: Any, when: ast.expr | None) -> None:
        """Add an entry; entries of one name on different conditions become one."""
        known = self._alternatives.setdefault((id(section), str(key)), [])
        known.append((value, when))
        chosen = merged("", known) if len(known) > 1 else None
        if chosen is not None:
            section[key] = chosen
        else:
            section[_free_key(section, key)] = conditional(value, when)

    def _material(self, node: Element, when: ast.expr | None, file: str, comments: list[str]) -> None:
        """Write a material, which the whole robot shares."""
        name = self.values.text(node.attributes.get("name", []))
        value = self.entries.finished(self.entries.fragment(node.body, "material"))
        holder = next((one for one in self.documents.files.values() if name in one.get("materials", ())), None)
        section = holder["materials"] if holder is not None else self.documents.section(file, "materials")
        known = self._alternatives.get((id(section), str(name)), [])
        if not known or known[-1][1] is not None:
            self._put(section, name, value, when)
            self.documents.remark(file, ("materials", name), comments)

    # Parts and their uses.

    def _write_part(self, macro: Macro) -> None:
        file, path = self.program.file_of(macro.place).name, ("parts", macro.ours)
        made: dict[str, Any] = {}
        self._part = made
        self._body(macro.body, None)
        self._part = None
        params = self._params(macro)
        lets = {variable.ours: self._let_value(variable) for variable in self._lets(macro.key)}
        for variable in self._lets(macro.key):
            self.documents.remark(file, (*path, "let", variable.ours), variable.comments)
        head = {key: value for key, value in (("params", params), ("let", lets)) if value}
        order = ("links", "joints", "use", "urdf_elements")
        rest = {key: made[key] for key in order if made.get(key)} | {k: v for k, v in made.items() if k not in order}
        if rest:
            self.documents.section(file, "parts")[macro.ours] = {**head, **rest}
            self.documents.remark(file, path, macro.comments)
        else:
            self.documents.files.setdefault(file, {})

    def _given(self, macro: Macro) -> list[tuple[str, Variable]]:
        """Return the parameters that a part declares, by their names in the xacro."""
        parameters = macro.parameters.items()
        return [one for one in parameters if not self.names.is_implied(macro, one[1], one[1] in self.used)]

    def _default_of(self, macro: Macro, name: str) -> ast.expr | None:
        """Return the default of a parameter, if it is the same in all calls."""
        nodes = {ast.dump(one.given[name][0]): one.given[name][0] for one in macro.calls if one.given[name][1]}
        if len(nodes) != 1:
            return None
        node = next(iter(nodes.values()))
        found = self.program.variables_in(node)
        is_hidden = any(one.owner or one.ours == macro.parameters[name].ours for one in found)
        return None if is_hidden else node

    def _params(self, macro: Macro) -> dict[str, Any]:
        made: dict[str, Any] = {}
        for name, variable in self._given(macro):
            entry: dict[str, Any] = {"type": variable.type} if variable.type else {}
            default = self._default_of(macro, name)
            if isinstance(default, ast.Constant) and default.value is None:
                entry = {"default": Expression("${none}")}
            elif default is not None:
                entry["default"] = self.values.value(default, variable.type)
            made[variable.ours] = entry
        return made

    def use_part(self, call: Call, when: ast.expr | None, comments: list[str]) -> None:
        """Write a call of a macro that is a part."""
        macro, values = call.macro, self.values
        if makes_only_materials(macro):
            return
        made: dict[str, Any] = {"part": macro.ours}
        first, prefix = self._key(call)
        mount = self.names.mount.get(macro)
        if mount is not None:
            made["parent"] = values.text(flattened([call.given[mount.name][0]]), name=True)
        given: dict[str, Any] = {}
        for name, variable in self._given(macro):
            node, defaulted = call.given[name]
            if variable in values.file_names:
                given[variable.ours] = values.text(flattened([node]), file=True)
            elif not defaulted or self._default_of(macro, name) is None:
                given[variable.ours] = values.value(node, variable.type, ANGLES if name.endswith("rpy") else "")
        for key, variable in self.names.pose.get(macro, {}).items():
            value = values.value(call.given[variable.name][0], LIST, ANGLES if key == "rpy" else LENGTHS)
            made |= {key: value} if value != [Verbatim("0")] * 3 else {}
        if given:
            made["with"] = given
        file, path, document = self._place_of(call)
        section = document.setdefault("use", {})
        taken: Any = section if path else self._keys
        key, count = first, 1
        while key in taken:
            count += 1
            key = f"{first}_{macro.ours}" if count == 2 and first != macro.ours else f"{first}_{count}"
        if not path:
            self._keys.add(key)
        if prefix != f"{key}_":
            made = {"part": made.pop("part"), "prefix": prefix, **made}
        section[key] = conditional(made, when)
        self.documents.remark(file, (*path, "use", key), comments)

    def _key(self, call: Call) -> tuple[str, Any]:
        """Return the name of a use, and its prefix."""
        macro = call.macro
        if macro not in self.names.prefix:
            leads = ["name", *(one.name for one in self.names.leads(macro))]
            found = next((call.given[name][0] for name in leads if name in call.given), None)
            last = flattened([found])[-1:] if found is not None else []
            return _as_key(last[0] if last and isinstance(last[0], str) else "") or macro.ours, ""
        pieces = self.names.prefix_of(call)
        outer = self.names.prefix.get(self.values.macro) if self.values.macro is not None else None
        if outer is not None:
            short = self.names.short(pieces, outer)
            if short is None:
                raise GiveUp(self.values.macro, Unsupported("its names do not compose"), explicit=True)
            pieces = short
        text = self.values.joined(pieces)
        tail = text
        if isinstance(text, Expression):
            tail = pieces[-1] if isinstance(pieces[-1], str) else ""
        return _as_key(tail) or macro.ours, text

    # Properties and arguments.

    def _let_value(self, variable: Variable) -> Any:
        node: Any = variable.node
        if variable.raw:
            return number(variable.raw, "")
        is_any = isinstance(node, ast.Constant) and variable.type == ANY
        return self.values.value(node, type_of_values([node.value]) if is_any else variable.type)

    def _write_arguments(self) -> None:
        """Write the arguments that are used; one that is made of others is after them, in the first file."""
        composed: list[tuple[str, Variable, dict[str, Any]]] = []
        plain: list[tuple[str, Variable, dict[str, Any]]] = []
        for variable in self.program.arguments.values():
            if variable not in self.used:
                continue
            default = self.values.value(variable.node or ast.Constant(""), variable.type)
            declared = {"type": variable.type, "default": default}
            allowed = self.arguments.allowed(variable)
            if allowed:
                declared["one_of"] = allowed
            if isinstance(default, Expression):
                composed.append((Description.ROOT_FILE, variable, declared))
            else:
                plain.append((self.program.file_of(variable.place).name, variable, declared))
        for file, variable, declared in (*plain, *composed):
            self.documents.section(file, "args")[variable.ours] = declared
            self.documents.remark(file, ("args", variable.ours), variable.comments)


def write(
    program: Program,
    target: Target,
    explicit: set[str],
    imported: Imported,
    wanted: Outputs,
    accepts: list[Any],
    words: Found | None = None,
) -> WrittenFiles:
    """Return the files of a description. Raises GiveUp."""
    words = words or Found()
    writer = Writer(program, target, explicit, words.spots)
    data, documents = writer.packages.copied(), writer.render()
    declare_dimensions(documents.files)
    options: dict[str, Any] = {}
    for option in sorted(documents.conditions.keys() & words.options.keys()):
        value, conditions = words.options[option], documents.conditions[option]
        when = None if covers(conditions) else any_of(conditions)
        options[option] = value if when is None else Expression(f"${{{value!r} if {written(when)} else none}}")
    tree, root = tree_of(imported), Description.ROOT_FILE
    others: dict[str, str] = {}
    included: list[str] = []
    for file in program.files[1:]:
        sections = {key: value for key, value in documents.files.get(file.name, {}).items() if value}
        if not sections:
            continue
        text, name = _layout(sections, documents, file, ""), file.name
        if target.sharing is not None and not data:  # tables are named from the file
            name, text = target.sharing.placed(program, file, text)
        included.append(name)
        others[name] = text
    with within(writer.values, None):
        is_text = all(isinstance(piece, str) for piece in program.name)
        name = target.name or (str(tree["robot"]) if is_text else writer.values.joined(program.name))
    head: dict[str, Any] = {"rosorin_compile": Verbatim("1"), "robot": name}
    head |= {"source": dict(tree["source"])} if "source" in tree else {}
    head |= {"include": included} if included else {}
    tail: dict[str, Any] = {**_other_sections(tree), **({"accept": accepts} if accepts else {})}
    tail["outputs"] = {one: _written(entry) for one, entry in outputs_for(wanted, options).entries.items()}
    sections = {**head, **(documents.files.get(root) or {}), **tail}
    texts = {root: _layout(sections, documents, program.files[0], target.schema), **others, **data}
    empty = tuple(one.key for one in program.macros.values() if one.level == "robot" and makes_only_materials(one))
    used = [one for one in program.arguments.values() if one in writer.used]
    choices = {one.name: writer.arguments.choices(one) for one in used}
    return WrittenFiles(
        texts,
        program,
        dict(writer.packages.folders),
        documents,
        writer.used,
        choices,
        tuple(writer.packages.unfound),
        empty,
    )


def _as_key(text: str) -> str:
    made = re.sub(r"[^\w-]+", "_", text.strip("_")).strip("_")
    return made if made and isinstance(Scalar(made).value, str) else ""


def _free_key(section: Mapping[Any, Any], key: str) -> str:
    """Return a key that is not taken, and has the same value."""
    while key in section:
        key = Expression(f"{key}${{''}}")
    return key


def _layout(sections: Mapping[str, Any], documents: Documents, file: File, schema: str) -> str:
    document = {key: sections[key] for key in sorted(sections, key=_rank) if sections[key]}
    head = [f"yaml-language-server: $schema={schema}"] if schema and file.name == Description.ROOT_FILE else []
    for text in comments_before(file):
        head += cleaned(text)
    return layout(document, Remarks({(): head, **documents.comments.get(file.name, {})}))


def _other_sections(tree: Map) -> dict[str, Any]:
    """Return the sections that come from other files than the xacro."""
    document = _Document(tree)
    others = sorted_sections({name: value for name, value in tree.items() if name not in (*_HEAD, *_TAIL)})
    return {name: document.value(value, (name,), None) for name, value in others.items()}


def _rank(key: str) -> int:
    return _HEAD.index(key) if key in _HEAD else 100 + _TAIL.index(key) if key in _TAIL else 50
