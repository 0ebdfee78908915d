"""Write the intermediate representation of a xacro as the files of a description, in one pass.

What nothing uses is left out: the files are written again until what is used does not grow any more.
"""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple
from xml.sax.saxutils import escape

from rosorin_compile.formats.imported import Imported, Outputs
from rosorin_compile.formats.urdf.read import NUMBERS as ATTRIBUTES
from rosorin_compile.formats.urdf.read import SHAPES
from rosorin_compile.formats.urdf.reading import ANGLES, LENGTHS
from rosorin_compile.source import files
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map
from rosorin_compile.source.yaml_text import Scalar

from ..description import _Document, _written, tree_of
from ..key_order import in_order, sorted_sections
from ..layout import Expression, Remarks, Verbatim, cleaned, in_degrees, layout
from .choices import any_of, conditional, covers, merged, node_of
from .dimensions import declare_dimensions
from .formulas import Formulas, all_of, as_angle, folded, in_words, literal, negated, type_of_values, written
from .ir import (
    ANY,
    ARGUMENT,
    FLAG,
    LET,
    LIST,
    NUMBER,
    PARAMETER,
    TEXT,
    Call,
    Comment,
    Element,
    File,
    If,
    Macro,
    Pieces,
    Program,
    Unsupported,
    Variable,
    Words,
    comments_before,
    flattened,
    usable,
    walk,
)
from .wording import OPTIONS, Found, Spot, outputs_for
from .wording import Words as WordsOf

# What is made of the xacro begins and ends a file, in this order; what other files than the xacro say is between.
_HEAD = ("rosorin_compile", "robot", "source", "include", "args", "let", "materials", "parts", "links", "joints", "use")
_TAIL = ("urdf_elements", "accept", "outputs")
_NUMBER = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?([eE][-+]?\d+)?")
_WITHOUT_EFFECT = {"fixed": ("axis", "limit", "mimic", "dynamics"), "floating": ("axis", "limit")}
_JOINT_PARTS = ("limit", "mimic", "dynamics", "calibration", "safety_controller")
_OPTIONAL = {"xyz": "0 0 0", "rpy": "0 0 0"}  # attributes that a block may leave out
_FULL_TURN, _LONG, _WIDTH = 6.2832, 20, 90
_BYTES = 2_000_000
PROBE = "probe_"  # a text that an argument has in no condition

Item = tuple[str, Any, ast.expr | None]  # a key of an entry, its value, and its condition


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


class _Whole(list[Any]):
    """The items of a list that a named value has."""

    whole = ""


class GiveUp(Exception):
    """Something that cannot be written: a macro, or what a formula outside of macros depends on."""

    def __init__(self, macro: Macro | None, problem: Unsupported, explicit: bool = False) -> None:
        super().__init__(problem.reason)
        self.macro = macro
        self.problem = problem
        self.explicit = explicit  # the names of the macro have to keep their prefix


@dataclass(eq=False)
class Documents:
    """The documents of a translation by file name, with comments; ``places`` says which macro an entry is from."""

    files: dict[str, dict[str, Any]] = field(default_factory=dict)
    comments: dict[str, dict[tuple[Any, ...], list[str]]] = field(default_factory=dict)
    plain: dict[Spot, str] = field(default_factory=dict)  # elements without expressions
    counts: dict[tuple[Any, ...], int] = field(default_factory=dict)  # of elements, by file and part
    labels: dict[str, list[str]] = field(default_factory=dict)  # of elements that became entries, by section
    conditions: dict[str, list[ast.expr | None]] = field(default_factory=dict)  # on which options are needed

    def section(self, file: str, key: str) -> dict[str, Any]:
        return self.files.setdefault(file, {}).setdefault(key, {})  # type: ignore[no-any-return]

    def remark(self, file: str, path: tuple[Any, ...], comments: Any) -> None:
        lines = [line for comment in comments for line in cleaned(comment)]
        if lines:
            self.comments.setdefault(file, {}).setdefault(path, []).extend(lines)


@dataclass(eq=False)
class WrittenFiles:
    """The files of a description, with what they were made of and the packages that they need."""

    files: dict[str, str]
    program: Program
    packages: dict[str, Path]
    documents: Documents
    used: set[Variable]
    choices: dict[str, list[str]]
    unfound: tuple[str, ...] = ()
    empty: tuple[str, ...] = ()  # macros that make nothing but materials


class Writer:
    """Writes a program. ``explicit`` are the keys of macros whose names keep their prefix."""

    def __init__(self, program: Program, target: Target, explicit: set[str], words: Mapping[Spot, WordsOf]) -> None:
        self.program = program
        self.target = target
        self.explicit = explicit
        self.words = words
        self.used: set[Variable] = set()
        self.printed: set[Variable] = set()
        self.file_names: set[Variable] = set()  # parameters that are names of files
        self.formulas = Formulas(program.variables, self.use)
        self.formulas.found, self.formulas.address = self.find_package, self.address
        self.named = Packages({}, os.environ, target.folder / Description.ROOT_FILE)
        self.packages: dict[str, Path] = {}
        self.unfound: dict[str, None] = {}
        self.data: dict[str, str] = {}
        self.documents = Documents()
        self.macro: Macro | None = None
        self.prefix: dict[Macro, tuple[Variable, str]] = {}
        self.mount: dict[Macro, Variable] = {}
        self.pose: dict[Macro, dict[str, Variable]] = {}
        self.part_entry: dict[str, Any] | None = None  # the part that is written
        self.is_xml = False
        self.is_passing = False  # what is written is given to a part, and not printed
        self.kind: Any = ""  # the type of the joint that is written
        self.position = ""  # the unit of the joint that is written
        self.shape_comments: dict[str, list[list[str]]] = {}  # of the shapes of a link
        self.inner: list[str] = []  # comments within the entry that is written

    # The whole.

    def render(self) -> Documents:
        """Return the documents. Raises GiveUp for what cannot be written."""
        program = self.program
        self.set_types()
        self.name_parts()
        self.copy_data()
        before = -1
        while before != len(self.used) + len(self.file_names):
            before = len(self.used) + len(self.file_names)
            self.name_variables()
            self.documents = Documents()
            self.keys: set[str] = set()
            self.results: dict[Macro, tuple[dict[str, Any], Any]] = {}
            self.alternatives: dict[tuple[int, str], list[Any]] = {}
            for macro in program.macros.values():
                with _Within(self, macro):
                    self.one_macro(macro)
            with _Within(self, None):
                self.body(program.body, None)
                self.let_values()
                self.arguments()
        return self.documents

    def set_types(self) -> None:
        for variable in self.program.variables.values():
            variable.type = type_of_values(variable.values, variable.kind == ARGUMENT)
            if variable.kind == ARGUMENT:
                texts = [one for one in variable.candidates if isinstance(literal(one), str)]
                variable.type = TEXT if texts or variable.type not in (NUMBER, FLAG) else variable.type
            elif variable.type == ANY and variable.kind == LET and variable.node is not None:
                variable.type = self.formulas.type(variable.node)
        for variable in self.program.variables.values():  # a value that several calls give
            if variable.kind == LET and variable.node is not None and isinstance(variable.node, ast.IfExp):
                variable.type = self.formulas.type(variable.node) or variable.type

    def use(self, variable: Variable) -> ast.expr | None:
        owner = self.program.macros.get(variable.owner)
        if variable.kind == LET and owner is not None and owner.level != "robot" and variable.node is not None:
            return self.formulas.node(variable.node)  # a named value has no properties of its own
        self.used.add(variable)
        if self.macro is not None and variable.owner == self.macro.key:
            prefix = self.prefix.get(self.macro)
            if prefix is not None and variable is prefix[0] and not prefix[1] and self.knows_prefix(self.macro):
                return ast.Name("prefix", ast.Load())
            if self.mount.get(self.macro) is variable:
                return ast.Constant("mount")
        return None

    def knows_prefix(self, macro: Macro) -> bool:
        """Return True if ``prefix`` is the prefix of a part in it, and not the name of something else."""
        others = [one for one in self.program.variables.values() if one.kind != PARAMETER and not one.owner]
        own = [one for one in macro.parameters.values() if one is not self.prefix[macro][0]]
        return all(one.name != "prefix" for one in (*others, *own))

    def find_package(self, name: str) -> None:
        folder = self.program.answer["packages"].get(name)
        if folder is None:
            raise Unsupported(f'the package "{name}" is not found')
        if not self.finds(name):
            self.packages[name] = Path(folder)
            self.unfound[name] = None

    def finds(self, package: str) -> bool:
        """Return True if the description finds a package by its name."""
        folder, own = self.program.answer["packages"].get(package), self.named.find(package)
        if folder is None or own is None or files.resolve(own) != files.resolve(Path(folder)):
            return False
        self.packages[package] = Path(folder)
        return True

    def package_address(self, file: File, text: str) -> str:
        """Return the address at which the package of a xacro has the same description, or nothing."""
        folder = next((one for one in Path(file.path).absolute().parents if Packages.name_of(one)), None)
        if folder is None or Path(self.program.files[0].path).absolute().is_relative_to(folder):
            return ""
        for there in sorted((folder / Description.FOLDER).glob(f"**/{Path(file.name).name}")):
            if (
                there.stat().st_size <= _BYTES
                and files.read_text(there) == text
                and self.finds(Packages.name_of(folder))
            ):
                return f"package://{Packages.name_of(folder)}/{there.relative_to(folder).as_posix()}"
        return ""

    def copy_data(self) -> None:
        """Copy the YAML files that are loaded, unless the description finds their package."""
        for name, path in self.program.answer["loaded"].items():
            package, _, rest = name.removeprefix("package://").partition("/")
            is_in_package = name.startswith("package://")
            if is_in_package and self.finds(package):
                continue
            if Path(name).is_absolute() or ".." in Path(name).parts:
                raise GiveUp(None, Unsupported(f"{name} is not a file of the xacro or its packages"))
            try:
                if Path(path).stat().st_size <= _BYTES:
                    self.data[rest if is_in_package else name] = files.read_text(Path(path))
            except (OSError, ValueError) as problem:
                raise GiveUp(None, Unsupported(f"{Path(path).name} cannot be read: {problem}")) from None

    def address(self, name: str) -> str:
        """Return the name of a file that is loaded as the description has it."""
        package, _, rest = name.removeprefix("package://").partition("/")
        return name if not name.startswith("package://") or self.finds(package) else rest

    # Names.

    def name_variables(self) -> None:
        """Give the macros and the properties that are used names that are unique where they are read."""
        taken: set[str] = set()
        for variable in self.program.variables.values():
            if variable.kind == ARGUMENT:  # people set it by its name
                variable.ours = usable(variable.name, taken, shadows=True)
                taken.add(variable.ours)
        for macro in self.program.macros.values():
            macro.ours = macro.name.replace(".", "_") if macro.level == "robot" else usable(macro.name, taken)
            if macro.level != "robot":
                taken.add(macro.ours)
        parts: set[str] = set()
        for macro in self.program.macros.values():
            name, number = macro.ours, 1
            while macro.level == "robot" and macro.ours in parts:
                number += 1
                macro.ours = f"{name}_{number}"
            parts.add(macro.ours)
        for variable in self.program.variables.values():
            if variable.kind == LET and not variable.owner and variable in self.used:
                variable.ours = usable(variable.name, taken)
                taken.add(variable.ours)
        for macro in self.program.macros.values():
            own: set[str] = set()
            for variable in macro.parameters.values():
                variable.ours = usable(variable.name, own)
                own.add(variable.ours)
            for variable in self.program.variables.values():
                if variable.owner == macro.key and variable.kind == LET and variable in self.used:
                    variable.ours = usable(variable.name, own | taken)
                    own.add(variable.ours)

    def name_parts(self) -> None:
        """Find the prefix of each part, its mount, and what is the pose of its uses."""
        parts = [one for one in self.program.macros.values() if one.level == "robot"]
        names: dict[Macro, list[Pieces]] = {}
        for macro in parts:
            named = [one for one in walk(macro.body) if isinstance(one, Element) and one.tag in ("link", "joint")]
            names[macro] = [one.attributes.get("name", []) for one in named]
            found = self.own_prefix(macro, names[macro])
            if found is not None and macro.key not in self.explicit:
                self.prefix[macro] = found
        self.own_names = {
            macro: {_spelt(rest) for name in names[macro] if (rest := self.short(name, prefix)) is not None}
            for macro, prefix in self.prefix.items()
        }
        changed = True
        while changed:
            changed = False
            for macro in parts:
                calls = [one for one in walk(macro.body) if isinstance(one, Call) and one.macro.level == "robot"]
                makes = [one for one in calls if self.makes_names(one.macro, set())]
                if macro not in self.prefix and macro.key not in self.explicit and not names[macro] and makes:
                    lead = self.prefix_of(makes[0])[:1]
                    variable = self.program.variables.get(getattr(lead[0], "id", "")) if lead else None
                    if makes[0].macro in self.prefix and variable in macro.parameters.values():
                        self.prefix[macro], changed = (variable, ""), True  # type: ignore[assignment]
                        self.own_names[macro] = set()
                if macro in self.prefix:
                    for one in makes:
                        fits = (
                            one.macro in self.prefix and self.short(self.prefix_of(one), self.prefix[macro]) is not None
                        )
                        if not fits:
                            self.explicit.add(macro.key)
                            del self.prefix[macro]
                            changed = True
                            break
        for macro in parts:
            self.find_mount(macro)

    def makes_names(self, macro: Macro, visited: set[Macro]) -> bool:
        if macro in visited:
            return False
        visited.add(macro)
        nodes = list(walk(macro.body))
        if any(isinstance(one, Element) and one.tag in ("link", "joint") for one in nodes):
            return True
        return any(
            self.makes_names(one.macro, visited)
            for one in nodes
            if isinstance(one, Call) and one.macro.level == "robot"
        )

    def own_prefix(self, macro: Macro, names: list[Pieces]) -> tuple[Variable, str] | None:
        """Return the parameter that all names of a part begin with, and the text behind it."""
        leads = {getattr(name[0], "id", "") if name else "" for name in names}
        variable = self.program.variables.get(leads.pop()) if len(leads) == 1 else None
        if variable is None or variable not in macro.parameters.values() or any(len(name) < 2 for name in names):
            return None
        parted = all(isinstance(name[1], str) and name[1].startswith("_") for name in names)
        parted = parted and all(len(name) > 2 or name[1] != "_" for name in names)
        return variable, "_" if parted else ""

    def short(self, pieces: Pieces, prefix: tuple[Variable, str]) -> Pieces | None:
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
        node = call.given[variable.name][0]
        return flattened([node, more])

    def find_mount(self, macro: Macro) -> None:
        """Find the parameter that is only the parent of joints, and those that are only the origin of these joints."""
        joints = [one for one in walk(macro.body) if isinstance(one, Element) and one.tag == "joint"]
        counts = self.occurrences(macro)
        for variable in macro.parameters.values():
            on_mount = [one for one in joints if _sole(one, "parent", "link") == variable.id]
            is_prefix = variable is self.prefix.get(macro, (None, ""))[0]
            if not on_mount or counts.get(variable.id) != len(on_mount) or is_prefix or macro in self.mount:
                continue
            if any("mount" in map(str, one.attributes.get("name", [])) for one in joints):
                continue
            self.mount[macro] = variable
            for key in ("xyz", "rpy"):
                names = {_sole(one, "origin", key) for one in on_mount}
                found = self.program.variables.get(names.pop()) if len(names) == 1 else None
                is_only = found in macro.parameters.values() and counts.get(found.id) == len(on_mount)  # type: ignore[union-attr]
                if found is not None and is_only and (key == "xyz" or "xyz" in self.pose.get(macro, ())):
                    self.pose.setdefault(macro, {})[key] = found

    def occurrences(self, macro: Macro) -> dict[str, int]:
        """Return how often a macro reads each of its variables, and inserts each of its blocks."""
        counts: dict[str, int] = {}

        def count(node: ast.AST) -> None:
            for one in ast.walk(node):
                if isinstance(one, ast.Name):
                    counts[one.id] = counts.get(one.id, 0) + 1

        def visit(nodes: list[Any]) -> None:
            for node in nodes:
                pieces: list[Any] = []
                if isinstance(node, Element):
                    pieces = [piece for text in node.attributes.values() for piece in text]
                elif isinstance(node, Words):
                    pieces = node.pieces
                elif isinstance(node, If):
                    pieces = [node.test]
                elif isinstance(node, Call):
                    pieces = [one for one, _ in node.given.values()]
                for piece in pieces:
                    if not isinstance(piece, str):
                        count(piece)
                visit(getattr(node, "body", []) if not isinstance(node, Call) else [])

        visit(macro.body)
        for variable in self.program.variables.values():
            if variable.kind == LET and variable.owner == macro.key and variable.node is not None:
                count(variable.node)
        return counts

    # Bodies.

    def body(self, nodes: list[Any], when: ast.expr | None) -> None:
        """Write what is at the level of links: of the robot, or of the part in ``self.part_entry``."""
        comments: list[str] = []
        for node in nodes:
            if isinstance(node, Comment):
                comments.append(node.text)
                continue
            if isinstance(node, If):
                condition = all_of([one for one in (when, self.condition(node)) if one is not None])
                if condition is None or folded(condition) is not False:
                    inner = [*map(Comment, comments), *node.body]
                    self.body(inner, condition)
            elif isinstance(node, Call):
                with _Within(self, self.macro, node):
                    self.use_part(node, when, [*comments, *node.comments])
            elif isinstance(node, Element):
                with _Within(self, self.macro, node):
                    self.entry(node, when, [*comments, *node.comments])
            elif isinstance(node, Words):
                raise Unsupported("text among links", None)
            comments = []

    def place_of(self, node: Element | Call) -> tuple[str, tuple[Any, ...], dict[str, Any]]:
        """Return where a node is written: the file, the path in that, and the mapping."""
        if self.part_entry is not None and self.macro is not None:
            return self.macro_file(), ("parts", self.macro.ours), self.part_entry
        file = self.program.file_of(node.place).name
        return file, (), self.documents.files.setdefault(file, {})

    def entry(self, node: Element, when: ast.expr | None, comments: list[str]) -> None:
        file, path, document = self.place_of(node)
        if node.tag == "material":
            self.material(node, when, file, comments)
        elif node.tag in ("link", "joint"):
            section = document.setdefault(f"{node.tag}s", {})
            key = self.text(node.attributes.get("name", []), name=True)
            self.inner = []
            shapes = self.shape_comments = {}
            value = self.link(node) if node.tag == "link" else self.joint(node)
            self.put(section, key, value, when)
            here = (*path, f"{node.tag}s", key)
            self.documents.remark(file, here, [*comments, *self.inner])
            for name, lists in shapes.items():
                for index, lines in enumerate(lists):
                    if lines and isinstance(section[key].get(name), list) and index < len(section[key][name]):
                        self.documents.remark(file, (*here, name, index), lines)
        else:
            text = self.in_words(node, when, comments)
            if text:
                made = document.setdefault("urdf_elements", [])
                self.documents.remark(file, (*path, "urdf_elements", len(made)), comments)
                made.append(conditional(text, when))

    def in_words(self, node: Element, when: ast.expr | None, comments: list[str]) -> Any:
        """Write the entries that an element becomes, if there are any, and return what is left of it."""
        text, (file, path, target) = self.xml_text(node), self.place_of(node)
        documents, macro = self.documents, self.macro
        at = (file, *path)
        number = documents.counts[at] = documents.counts.get(at, 0) + 1
        spot = (file, number, *path[1:])
        if not isinstance(text, Expression):
            documents.plain[spot] = text
        words = self.words.get(spot)
        if (
            words is None
            or words.text != text
            or (macro is not None and (when is not None or not self.may_have(words, macro)))
        ):
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
                section, key = target.setdefault(entry.section, {}), entry.name
                while key in section:
                    key = Expression(f"{key}${{''}}")
                section[key] = conditional(entry.value, when)
                where = path if macro is not None else ()
                documents.remark(
                    file, (*where, entry.section, key), (*([] if words.rest else comments), *entry.comments)
                )
        return words.rest

    def may_have(self, words: WordsOf, macro: Macro) -> bool:
        """Return True if a part may have entries: sensors, and hardware if the robot always has the part."""
        sections = {entry.section for entry in words.entries}
        return sections == {"sensors"} or (sections == {"control"} and self.is_always_used(macro))

    def is_always_used(self, macro: Macro) -> bool:
        top = {id(one) for one in self.program.body}
        return any(call.caller is None and id(call) in top for call in macro.calls)

    def macro_file(self) -> str:
        return self.program.file_of(self.macro.place).name if self.macro is not None else Description.ROOT_FILE

    def put(self, section: dict[Any, Any], key: Any, value: Any, when: ast.expr | None) -> None:
        """Add an entry; entries of one name on different conditions become one."""
        known = self.alternatives.setdefault((id(section), str(key)), [])
        known.append((value, when))
        if len(known) == 1:
            section[key] = conditional(value, when)
            return
        chosen = merged("", known)
        if chosen is not None:
            section[key] = chosen
            return
        while key in section:
            key = Expression(f"{key}${{''}}")
        section[key] = conditional(value, when)

    def material(self, node: Element, when: ast.expr | None, file: str, comments: list[str]) -> None:
        """Write a material, which the whole robot shares."""
        name = self.text(node.attributes.get("name", []))
        value = self.finished(self.fragment(node.body, "material"))
        holder = next((one for one in self.documents.files.values() if name in one.get("materials", ())), None)
        section = holder["materials"] if holder is not None else self.documents.section(file, "materials")
        known = self.alternatives.get((id(section), str(name)), [])
        if not known or known[-1][1] is not None:
            self.put(section, name, value, when)
            self.documents.remark(file, ("materials", name), comments)

    # Links and joints.

    def condition(self, node: If) -> ast.expr:
        made = self.formulas.flag(node.test)
        return made if node.holds else negated(made)

    def fragment(self, nodes: list[Any], level: str) -> list[Item]:
        """Return the keys that the content of an element has, with their conditions."""
        items: list[Item] = []
        comments: list[str] = []
        for node in nodes:
            if isinstance(node, Comment):
                comments.append(node.text)
                continue
            if isinstance(node, If):
                condition = self.condition(node)
                decided = folded(condition)
                if decided is not False:
                    for key, value, when in self.fragment(node.body, level):
                        both = all_of([one for one in (condition, when) if one is not None])
                        items.append((key, value, both))
            elif isinstance(node, Call):
                items += self.call_items(node)
            elif isinstance(node, Element):
                made = list(self.piece(node, level))
                if level == "link" and node.tag in ("visual", "collision"):
                    self.shape_comments.setdefault(node.tag, []).append(comments)
                    comments = []
                items += made
            self.inner += comments
            comments = []
        self.inner += comments
        return items

    def piece(self, node: Element, level: str) -> Iterator[Item]:
        """Yield the keys of one element in a link, a joint, or what those contain."""
        tag = node.tag
        if level == "link" and tag == "inertial":
            yield tag, self.finished(self.fragment(node.body, tag)), None
        elif level == "link" and tag in ("visual", "collision"):
            name = node.attributes.get("name")
            items: list[Item] = [("name", self.text(name), None)] if name else []
            call = self.sole_call(node) if not items else None
            yield tag, [call or self.finished([*items, *self.fragment(node.body, tag)])], None
        elif tag == "origin" and level in ("inertial", "visual", "collision", "joint"):
            if "quat_xyzw" in node.attributes:
                raise Unsupported("quat_xyzw has no word")
            yield from ((key, value, None) for key, value in self.numbers(node).items())
        elif level == "inertial" and tag == "mass":
            yield tag, self.numbers(node).get("value", Verbatim("0")), None
        elif level == "inertial" and tag == "inertia":
            yield tag, self.numbers(node), None
        elif level in ("visual", "collision") and tag == "geometry":
            yield from self.fragment(node.body, "geometry")
        elif level == "visual" and tag == "material":
            name = node.attributes.get("name", [])
            if name:
                yield tag, self.text(name), None
            yield from self.fragment(node.body, "material")
        elif level == "material" and tag == "color":
            yield "rgba", self.numbers(node)["rgba"], None
        elif level == "material" and tag == "texture":
            if node.attributes.get("filename"):
                yield tag, self.text(node.attributes["filename"], file=True), None
        elif level == "geometry" and tag in SHAPES:
            made = {"file": self.text(node.attributes["filename"], file=True)} if "filename" in node.attributes else {}
            yield tag, {**made, **self.numbers(node)}, None
        elif level == "joint" and tag in ("parent", "child"):
            yield tag, self.text(node.attributes.get("link", []), name=True), None
        elif level == "joint" and tag == "axis":
            yield tag, self.numbers(node)["xyz"], None
        elif level == "joint" and tag in _JOINT_PARTS:
            made = {"joint": self.text(node.attributes["joint"], name=True)} if tag == "mimic" else {}
            if tag == "limit" and self.kind in ("revolute", "prismatic"):
                made = {"lower": Verbatim("0"), "upper": Verbatim("0")}
            yield tag, {**made, **self.numbers(node)}, None
        elif level in ("link", "joint", "visual", "collision"):
            yield "urdf_elements", [self.xml_text(node)], None
        else:
            raise Unsupported(f"<{tag}> in <{level}> has no word")

    def finished(self, items: list[Item]) -> dict[str, Any]:
        """Return an entry of its keys; those that several conditions have are one value that chooses."""
        made: dict[str, Any] = {}
        for key in dict.fromkeys(one[0] for one in items):
            found = [(value, when) for name, value, when in items if name == key]
            first, only = found[0]
            if isinstance(first, list) and (key in ("visual", "collision", "urdf_elements")):
                if len(found) == 1 and isinstance(first, _Whole) and first.whole and only is None:
                    made[key] = Expression(first.whole)
                    continue
                made[key] = [conditional(item, when) for value, when in found for item in value]
                chosen = merged(key, found) if len(found) == 2 and all(when for _, when in found) else None
                made[key] = chosen if isinstance(chosen, list) else made[key]
                continue
            if len(found) == 1 and only is not None and isinstance(first, Expression) and _is_conditional(first):
                made[key] = Expression(f"${{{first[2:-1]} if {written(only)} else none}}")
                continue
            value = conditional(first, only)
            if len(found) > 1 or (only is not None and not isinstance(first, dict)):
                value = merged(key, found)
            if value is None:
                raise Unsupported(f"{key} has several values on different conditions")
            made[key] = value
        return in_order(made)

    def sole_call(self, node: Element) -> Any:
        """Return the call of a named value that an element consists of, or None."""
        body = [one for one in node.body if not isinstance(one, Comment)]
        if len(body) == 1 and isinstance(body[0], Element) and body[0].tag == "geometry":
            body = [one for one in body[0].body if not isinstance(one, Comment)]
        if len(body) != 1 or not isinstance(body[0], Call) or body[0].macro.level == "xml":
            return None
        self.call_items(body[0])
        single = self.results[body[0].macro][1]
        return None if single else Expression(f"${{{written(self.call_node(body[0]))}}}")

    def link(self, node: Element) -> Any:
        return self.sole_call(node) or self.finished(self.fragment(node.body, "link"))

    def joint(self, node: Element) -> dict[str, Any]:
        self.kind = kind = self.text(node.attributes.get("type", []))
        turns, slides = kind in ("revolute", "continuous"), kind in ("prismatic", "planar")
        self.position = ANGLES if turns else LENGTHS if slides else ""
        made = self.finished([("type", kind, None), *self.fragment(node.body, "joint")])
        for key in _WITHOUT_EFFECT.get(str(kind), ()):
            made.pop(key, None)
        limit = made.get("limit")
        if isinstance(kind, Expression) and isinstance(limit, dict) and kind.startswith("${") and kind.count("${") == 1:
            zero = Expression(f"${{0 if {kind[2:-1]} in ['revolute', 'prismatic'] else none}}")
            made["limit"] = {**{key: zero for key in ("lower", "upper") if key not in limit}, **limit}
        if made.get("dynamics") == {}:
            del made["dynamics"]
        return made

    def numbers(self, node: Element) -> dict[str, Any]:
        """Return the numbers of an element by attribute, without those that are defaults anyway."""
        made: dict[str, Any] = {}
        for name, (count, unit) in ATTRIBUTES[node.tag].items():
            pieces = node.attributes.get(name)
            pose = self.pose.get(self.macro, {}) if self.macro is not None else {}
            if pieces is None or (name in pose and node.tag == "origin" and _is_name(pieces, pose[name])):
                continue
            unit = self.position if unit == "q" else unit
            value = self.list_of(pieces, count, unit) if count > 1 else self.number(pieces, unit)
            plain = value if isinstance(value, list) else [value]
            is_zero = all(isinstance(one, Verbatim) and one == "0" for one in plain)
            if is_zero and (name in ("xyz", "rpy", "ixy", "ixz", "iyz") and node.tag in ("origin", "inertia")):
                continue
            if node.tag == "mesh" and all(one == "1" for one in plain):
                continue
            made[name] = value
        return made

    # Values.

    def number(self, pieces: Pieces, unit: str = "") -> Any:
        if all(isinstance(piece, str) for piece in pieces):
            return _number("".join(pieces).strip(), unit)
        return self.in_unit(self.formulas.of_number(_join(pieces)), unit)

    def in_unit(self, node: ast.expr, unit: str) -> Any:
        if unit == ANGLES:
            value = folded(node)
            if value == 0:
                return Verbatim("0")
            degrees = in_degrees(float(value), "deg") if isinstance(value, (int, float)) else ""
            if degrees:
                return Verbatim(degrees)
            node = as_angle(node)
        return _value(node, unit)

    def list_of(self, pieces: Pieces, count: int, unit: str = "") -> Any:
        words = in_words(pieces)
        if len(words) == count:
            return [self.number(word, unit) for word in words]
        if len(words) != 1 or (isinstance(words[0][0], str) and len(words[0]) == 1):
            raise Unsupported(f"{len(words)} numbers, not {count}")
        node = self.formulas.as_list(words[0][0] if len(words[0]) == 1 else _join(words[0]))
        if isinstance(node, ast.List):
            return [_value(item, unit) for item in node.elts]
        return Expression(f"${{{written(node)}}}")

    def text(self, pieces: Pieces, name: bool = False, file: bool = False) -> Any:
        """Return a text with the expressions in it; a name without the prefix of the part."""
        prefix = self.prefix.get(self.macro) if self.macro is not None else None
        if prefix is not None and pieces:
            short = self.short(pieces, prefix)
            if short is not None and name and short and self.may_be_own(short):
                pieces = short
            elif short is not None and prefix[1] and self.macro is not None and self.knows_prefix(self.macro):
                pieces = [ast.Name("prefix", ast.Load()), *short]
        if file:
            pieces = self.file_name(pieces)
        return self.joined(pieces)

    def may_be_own(self, short: Pieces) -> bool:
        macro: Any = self.macro
        if _spelt(short) in self.own_names.get(macro, ()) or self.is_xml:
            return _spelt(short) in self.own_names.get(macro, ())
        calls = [one.macro for one in walk(macro.body) if isinstance(one, Call) and one.macro.level == "robot"]
        return any(self.makes_names(one, set()) for one in calls)

    def file_name(self, pieces: Pieces) -> Pieces:
        """Return the name of a file: of a package by its address."""
        first = pieces[0] if pieces else ""
        if first == "file://":
            return self.file_name(pieces[1:])
        named = self.program.variables.get(getattr(first, "id", ""))
        if named is not None and named.kind == PARAMETER and len(pieces) == 1:
            self.file_names.add(named)
        node: Any = first
        seen = 0
        while isinstance(node, ast.Name) and seen < len(self.program.variables):
            variable = self.program.variables.get(node.id)
            inner = (
                flattened([variable.node]) if variable is not None and variable.kind == LET and variable.node else []
            )
            if not inner or not (_is_find(inner[0]) or isinstance(inner[0], ast.Name)):
                break
            pieces, node, seen = [*inner, *pieces[1:]], inner[0], seen + 1
        if _is_find(node):
            return flattened([f"package://{node.args[0].value}", *pieces[1:]])
        if self.target.meshes and isinstance(first, str) and "://" not in first and not first.startswith("/"):
            return flattened([f"{self.target.meshes.rstrip('/')}/{first}", *pieces[1:]])
        return pieces

    def joined(self, pieces: Pieces, spelt: Any = lambda text: text) -> Any:
        """Return pieces as one text."""
        made, plain = "", True
        for piece in flattened(pieces):
            if isinstance(piece, str):
                made += spelt(piece).replace("${", "$${")
                continue
            if not self.is_passing:
                self.printed |= {one for one in self.program.variables_in(piece) if isinstance(piece, ast.Name)}
            node = self.formulas.printed(piece)
            if self.formulas.type(piece) == LIST and not isinstance(node, ast.Constant):
                node = self.formulas.as_text(piece)
            value = folded(node)
            if isinstance(value, str) or (isinstance(value, int) and not isinstance(value, bool)):
                made += spelt(str(value)).replace("${", "$${")
                continue
            made, plain = f"{made}${{{written(node)}}}", False
        return made.replace("$${", "${") if plain else Expression(made)

    def value(self, node: ast.expr, kind: str, unit: str = "") -> Any:
        """Return a formula as a value of a given type."""
        if isinstance(node, ast.Constant) and node.value is None:
            return None
        plain = literal(node.value) if isinstance(node, ast.Constant) else None
        if isinstance(node, ast.Dict):
            keys = [str(one.value) if isinstance(one, ast.Constant) else "" for one in node.keys]
            return {key: self.value(one, self.formulas.type(one)) for key, one in zip(keys, node.values, strict=True)}
        if isinstance(node, ast.List) and any(isinstance(one, (ast.Dict, ast.List)) for one in node.elts):
            return [self.value(one, self.formulas.type(one)) for one in node.elts]
        if kind == LIST:
            return self.list_value(node, unit)
        if kind == FLAG:
            made = self.formulas.flag(node)
            decided = folded(made)
            return decided if isinstance(decided, bool) else Expression(f"${{{written(made)}}}")
        if kind == NUMBER and isinstance(node, ast.Constant):
            return _number(str(node.value), "")
        if kind == TEXT:
            pieces = flattened([node])
            if len(pieces) > 1 and _is_find(pieces[0]) and str(pieces[-1]).endswith((".yaml", ".yml")):
                pieces = flattened([f"package://{pieces[0].args[0].value}", *pieces[1:]])
                pieces[0] = self.address(pieces[0])
            self.is_passing = len(pieces) == 1
            made = self.text(pieces)
            self.is_passing = False
            return made
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            return str(node.value)
        if isinstance(plain, bool):
            return plain
        if kind == ANY and isinstance(node, ast.Call) and getattr(node.func, "id", "") == "__join":
            return self.joined([node])
        return _value(self.formulas.node(node), "")

    def list_value(self, node: ast.expr, unit: str) -> Any:
        if isinstance(node, ast.Constant) and len(words := str(node.value).split()) > 1:
            return [_number(word, unit) for word in words]
        made = self.formulas.as_list(node) if not isinstance(node, ast.List) else self.formulas.node(node)
        if isinstance(made, ast.List):
            return [self.in_unit(item, unit) for item in made.elts]
        return Expression(f"${{{written(made)}}}")

    def argument(self, node: ast.expr, kind: str) -> ast.expr:
        """Return a formula as an argument of a named value."""
        if kind == LIST:
            return self.formulas.as_list(node)
        if kind == FLAG:
            return self.formulas.flag(node)
        if kind == NUMBER and isinstance(node, ast.Constant):
            return self.formulas.constant(literal(node.value))
        return self.formulas.node(node)

    # Calls.

    def call_node(self, call: Call) -> ast.expr:
        """Return the call of a named value as an expression."""
        macro, arguments = call.macro, []
        for name, variable in macro.parameters.items():
            node = call.given[name][0]
            if variable in self.file_names:
                node = _join(self.file_name(flattened([node])))
            made = self.argument(node, variable.type)
            if variable.name.endswith("rpy") and isinstance(made, ast.List):
                made = ast.List([_in_degrees(one) for one in made.elts], ast.Load())
            arguments.append(made)
        return ast.Call(ast.Name(macro.ours, ast.Load()), arguments, [])

    def call_items(self, call: Call) -> list[Item]:
        """Return the keys that the call of a named value has."""
        if call.macro not in self.results:
            inner, shapes = self.inner, self.shape_comments
            with _Within(self, call.macro):
                self.one_macro(call.macro)
            self.inner, self.shape_comments = inner, shapes
        entry, single = self.results[call.macro]
        node = self.call_node(call)
        text = written(node)
        items: list[Item] = []
        for key, value in entry.items():
            if isinstance(value, list) and key in ("visual", "collision", "urdf_elements"):
                inner = _Whole(
                    Expression(f"${{{text}}}" if single else f"${{{text}.{key}[{at}]}}") for at in range(len(value))
                )
                inner.whole = "" if single else f"${{{text}.{key}}}"
                items.append((key, inner, None))
            elif _is_conditional(value):
                items.append((key, Expression(f"${{get({text}, {key!r})}}"), None))
            else:
                items.append((key, Expression(f"${{{text}}}" if single else f"${{{text}.{key}}}"), None))
        return items

    def one_macro(self, macro: Macro) -> None:
        """Write a macro: a part, a named value, or a named text."""
        if macro in self.results:
            return
        if macro.level == "robot":
            self.part(macro)
            return
        file, inside = self.macro_file(), []
        if macro.level == "xml":
            lines = self.xml_lines(macro.body, "")
            text = "\n".join(lines)
            value: Any = Expression(text) if "${" in text else text
            self.results[macro] = ({}, True)
        else:
            self.shape_comments, self.inner = {}, []
            value = self.finished(self.fragment(macro.body, macro.level))
            single = len(value) == 1 and not _is_conditional(next(iter(value.values())))
            if any(
                isinstance(one, list) and any(map(_is_conditional, one))
                for key, one in value.items()
                if key in ("visual", "collision")
            ):
                raise Unsupported("it has a shape on a condition")
            only: Any = next(iter(value.values()), {})
            if single and isinstance(only, list) and only and isinstance(only[0], dict):
                single = len(only) == 1
                only = only[0]
            self.results[macro] = (value, single)
            value, inside = only if single else value, self.inner
        key = f"{macro.ours}({', '.join(one.ours for one in macro.parameters.values())})"
        self.documents.section(file, "let")[key] = value
        self.documents.remark(file, ("let", key), [*macro.comments, *inside])

    def part(self, macro: Macro) -> None:
        file = self.macro_file()
        made: dict[str, Any] = {}
        path = ("parts", macro.ours)
        self.part_entry = made
        self.body(macro.body, None)
        self.part_entry = None
        params = self.params(macro)
        lets: dict[str, Any] = {}
        for variable in self.program.variables.values():
            if variable.owner == macro.key and variable.kind == LET and variable in self.used:
                lets[variable.ours] = self.let_value(variable)
                self.documents.remark(file, (*path, "let", variable.ours), variable.comments)
        head = {**({"params": params} if params else {}), **({"let": lets} if lets else {})}
        order = ("links", "joints", "use", "urdf_elements")
        rest = {key: made[key] for key in order if made.get(key)} | {k: v for k, v in made.items() if k not in order}
        if rest:
            self.documents.section(file, "parts")[macro.ours] = {**head, **rest}
            self.documents.remark(file, path, macro.comments)
        else:
            self.documents.files.setdefault(file, {})

    def is_implied(self, macro: Macro, variable: Variable) -> bool:
        """Return True if a part has a parameter anyway: its prefix, its mount."""
        prefix = self.prefix.get(macro)
        is_prefix = prefix is not None and variable is prefix[0]
        needs = prefix is not None and variable in self.used and (prefix[1] or not self.knows_prefix(macro))
        is_pose = variable in self.pose.get(macro, {}).values()
        return (is_prefix and not needs) or variable is self.mount.get(macro) or is_pose

    def default_of(self, macro: Macro, name: str) -> ast.expr | None:
        """Return the default of a parameter, if it is the same in all calls."""
        nodes = {ast.dump(one.given[name][0]): one.given[name][0] for one in macro.calls if one.given[name][1]}
        if len(nodes) != 1:
            return None
        node = next(iter(nodes.values()))
        found = self.program.variables_in(node)
        shadowed = any(one.ours == macro.parameters[name].ours for one in found)
        return node if {one.owner for one in found} <= {""} and not shadowed else None

    def params(self, macro: Macro) -> dict[str, Any]:
        made: dict[str, Any] = {}
        for name, variable in macro.parameters.items():
            if self.is_implied(macro, variable):
                continue
            made[variable.ours] = {"type": variable.type} if variable.type else {}
            default = self.default_of(macro, name)
            if isinstance(default, ast.Constant) and default.value is None:
                made[variable.ours] = {"default": Expression("${none}")}
            elif default is not None:
                made[variable.ours]["default"] = self.value(default, variable.type)
        return made

    def use_part(self, call: Call, when: ast.expr | None, comments: list[str]) -> None:
        """Write a call of a macro that is a part."""
        macro = call.macro
        if self.is_empty(macro):
            return
        made: dict[str, Any] = {"part": macro.ours}
        first, prefix = self.key(call)
        variable = self.mount.get(macro)
        if variable is not None:
            made["parent"] = self.text(flattened([call.given[variable.name][0]]), name=True)
        given: dict[str, Any] = {}
        for name, one in macro.parameters.items():
            if self.is_implied(macro, one):
                continue
            node, defaulted = call.given[name]
            if one in self.file_names:
                given[one.ours] = self.text(flattened([node]), file=True)
            elif not defaulted or self.default_of(macro, name) is None:
                given[one.ours] = self.value(node, one.type, ANGLES if name.endswith("rpy") else "")
        for key, one in self.pose.get(macro, {}).items():
            value = self.value(call.given[one.name][0], LIST, ANGLES if key == "rpy" else LENGTHS)
            made |= {key: value} if value != [Verbatim("0")] * 3 else {}
        if given:
            made["with"] = given
        file, path, document = self.place_of(call)
        section = document.setdefault("use", {})
        taken: Any = section if path else self.keys
        key, number = first, 1
        while key in taken:
            number += 1
            key = f"{first}_{macro.ours}" if number == 2 and first != macro.ours else f"{first}_{number}"
        if not path:
            self.keys.add(key)
        if prefix != f"{key}_":
            made = {"part": made.pop("part"), "prefix": prefix, **made}
        section[key] = conditional(made, when)
        self.documents.remark(file, (*path, "use", key), comments)

    def is_empty(self, macro: Macro) -> bool:
        """Return True if a part makes nothing but materials, which the robot shares."""

        def empty(node: Any) -> bool:
            if isinstance(node, If):
                return all(map(empty, node.body))
            if isinstance(node, Call):
                return node.macro.level == "robot" and self.is_empty(node.macro)
            return isinstance(node, Comment) or (isinstance(node, Element) and node.tag == "material")

        return all(map(empty, macro.body))

    def key(self, call: Call) -> tuple[str, Any]:
        """Return the name of a use, and its prefix."""
        macro = call.macro
        if macro not in self.prefix:
            names = ["name", *(one.name for one in self.leads(macro))]
            found = next((call.given[name][0] for name in names if name in call.given), None)
            last = flattened([found])[-1:] if found is not None else []
            text = last[0].strip("_") if last and isinstance(last[0], str) else ""
            return _as_key(text) or macro.ours, ""
        pieces = self.prefix_of(call)
        outer = self.prefix.get(self.macro) if self.macro is not None else None
        if outer is not None:
            short = self.short(pieces, outer)
            if short is None:
                raise GiveUp(self.macro, Unsupported("its names do not compose"), explicit=True)
            pieces = short
        text = self.joined(pieces)
        if isinstance(text, Expression):
            tail = pieces[-1].strip("_") if isinstance(pieces[-1], str) else ""
            return _as_key(tail) or macro.ours, text
        return _as_key(text.strip("_")) or macro.ours, text

    def leads(self, macro: Macro) -> Iterator[Variable]:
        """Yield the parameters that names of links begin with."""
        for one in walk(macro.body):
            if isinstance(one, Element) and one.tag in ("link", "joint"):
                for piece in one.attributes.get("name", []):
                    variable = self.program.variables.get(getattr(piece, "id", ""))
                    if variable is not None and variable in macro.parameters.values():
                        yield variable

    # Elements that are kept as text.

    def xml_text(self, node: Element) -> Any:
        self.is_xml = True
        lines = self.xml_lines([node], "")
        self.is_xml = False
        whole = "".join(line.strip() for line in lines)
        if len(lines) == 3 and len(whole) <= _WIDTH and "<!--" not in whole:
            lines = [whole]
        text = lines[0] if len(lines) == 1 else "\n".join([*lines, ""])
        return Expression(text) if "${" in text else text

    def xml_lines(self, nodes: list[Any], pad: str) -> list[str]:
        lines: list[str] = []
        for at, node in enumerate(nodes):
            if isinstance(node, Words):
                lines += [
                    pad + line.strip() for line in str(self.joined(node.pieces, escape)).splitlines() if line.strip()
                ]
            elif isinstance(node, Comment):
                if "--" not in node.text and "${" not in node.text:
                    lines += [f"{pad}{line.strip()}" for line in f"<!--{node.text}-->".splitlines()]
            elif isinstance(node, If):
                before = nodes[at - 1] if at else None
                if isinstance(before, If) and self.is_opposite(before, node):
                    continue
                lines += self.xml_choice(node, nodes[at + 1] if at + 1 < len(nodes) else None, pad)
            elif isinstance(node, Call):
                lines.append(f"{pad}${{{written(self.call_node(node))}}}")
            else:
                lines += self.xml_element(node, pad)
        return lines

    def is_opposite(self, one: If, other: If) -> bool:
        return ast.dump(one.test) == ast.dump(other.test) and one.holds != other.holds

    def xml_choice(self, node: If, after: Any, pad: str) -> list[str]:
        condition = self.condition(node)
        decided = folded(condition)
        other = after.body if isinstance(after, If) and self.is_opposite(node, after) else []
        if isinstance(decided, bool):
            return self.xml_lines(node.body if decided else other, pad)
        sides = []
        for body in (node.body, other):
            text = " ".join(self.xml_lines([one for one in body if not isinstance(one, Comment)], ""))
            made = node_of(Expression(text) if "${" in text else text) if text else ast.Constant("")
            if made is None:
                raise Unsupported("a condition in a kept element has expressions of its own")
            sides.append(made)
        if all(isinstance(one, ast.Constant) and one.value == "" for one in sides):
            return []
        return [f"{pad}${{{written(ast.IfExp(condition, *sides))}}}"]

    def xml_element(self, node: Element, pad: str) -> list[str]:
        head = node.tag
        for name, pieces in node.attributes.items():
            if not name.startswith("xmlns"):
                text = self.text(pieces, name=name in ("reference", "link", "joint") or node.tag in ("link", "joint"))
                value = (
                    str(self.joined(pieces, lambda one: escape(one, {'"': "&quot;"})))
                    if "&" in str(text) or "<" in str(text) or '"' in str(text)
                    else str(text)
                )
                head += f' {name}="{value}"'
        inner = self.xml_lines(node.body, f"{pad}  ")
        if not inner:
            return [f"{pad}<{head}/>"]
        only = len(node.body) == 1 and isinstance(node.body[0], Words)
        if len(inner) == 1 and (only or len(pad) + len(head) + len(inner[0].strip()) + len(node.tag) + 5 <= _WIDTH):
            return [f"{pad}<{head}>{inner[0].strip()}</{node.tag}>"]
        return [f"{pad}<{head}>", *inner, f"{pad}</{node.tag}>"]

    # Properties and arguments.

    def let_value(self, variable: Variable) -> Any:
        node: Any = variable.node
        if variable.raw:
            return _number(variable.raw, "")
        if isinstance(node, ast.Constant) and variable.type == ANY:
            return self.value(node, type_of_values([node.value]))
        return self.value(node, variable.type)

    def let_values(self) -> None:
        for variable in self.program.variables.values():
            if variable.kind == LET and not variable.owner and variable in self.used:
                file = self.program.file_of(variable.place).name
                self.documents.section(file, "let")[variable.ours] = self.let_value(variable)
                self.documents.remark(file, ("let", variable.ours), variable.comments)

    def arguments(self) -> None:
        """Write the arguments that anything uses; one that is made of others is behind them, in the first file."""
        composed: list[tuple[Variable, dict[str, Any]]] = []
        for variable in self.program.arguments.values():
            if variable not in self.used:
                continue
            declared: dict[str, Any] = {"type": variable.type}
            declared["default"] = self.value(variable.node or ast.Constant(""), variable.type)
            allowed = self.allowed(variable)
            if allowed:
                declared["one_of"] = allowed
            if isinstance(declared["default"], Expression):
                composed.append((variable, declared))
            else:
                self.declare(self.program.file_of(variable.place).name, variable, declared)
        for variable, declared in composed:
            self.declare(Description.ROOT_FILE, variable, declared)

    def declare(self, file: str, variable: Variable, declared: dict[str, Any]) -> None:
        self.documents.section(file, "args")[variable.ours] = declared
        self.documents.remark(file, ("args", variable.ours), variable.comments)

    def allowed(self, variable: Variable) -> list[str]:
        """Return the texts that an argument may be, or nothing if it may be any."""
        texts = [str(one) for one in self.compared(variable)]
        if variable.type != TEXT or not texts or variable in self.printed or "" in texts:
            return []
        allowed = list(dict.fromkeys([str(variable.values[0]), *sorted(texts)]))
        return allowed if len(allowed) > 1 else []

    def compared(self, variable: Variable) -> list[Any]:
        """Return what an argument is compared with, itself or by the parameters and properties that it becomes."""
        found: list[Any] = []
        reached, waiting = {variable.id}, [variable]
        while waiting:
            one = waiting.pop()
            found += one.candidates
            if one in self.printed:
                self.printed.add(variable)
            for other in self.receivers().get(one.id, ()):
                if other.id not in reached:
                    reached.add(other.id)
                    waiting.append(other)
        return list(dict.fromkeys(found))

    def receivers(self) -> dict[str, list[Variable]]:
        """Return the parameters that are given a variable as it is, by that variable."""
        if not hasattr(self, "_receivers"):
            self._receivers: dict[str, list[Variable]] = {}
            for macro in self.program.macros.values():
                for call in macro.calls:
                    for name, (node, _) in call.given.items():
                        while isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("__flag", "__number"):
                            node = node.args[0]
                        if isinstance(node, ast.Name):
                            self._receivers.setdefault(node.id, []).append(macro.parameters[name])
            for variable in self.program.variables.values():
                if variable.kind == LET and variable.node is not None:
                    for one in self.program.variables_in(variable.node):
                        self._receivers.setdefault(one.id, []).append(variable)
        return self._receivers


class _Within:
    """Sets the macro that is written, and reports what cannot be written."""

    def __init__(self, writer: Writer, macro: Macro | None, node: Any = None) -> None:
        self.writer, self.macro, self.node = writer, macro, node

    def __enter__(self) -> None:
        self.before, self.writer.macro = self.writer.macro, self.macro

    def __exit__(self, kind: Any, problem: Any, _: Any) -> None:
        self.writer.macro = self.before
        if isinstance(problem, Unsupported):
            macro = self.macro
            if macro is None and isinstance(self.node, Call):
                macro = self.node.macro
            if macro is None and problem.node is None and self.node is not None:
                problem.node = _formula_of(self.node)
            raise GiveUp(macro, problem) from None


def _formula_of(node: Element) -> ast.expr:
    """Return all formulas in an element as one."""
    found: list[ast.expr] = []
    for one in [node, *walk(node.body)]:
        pieces = [p for text in one.attributes.values() for p in text] if isinstance(one, Element) else []
        pieces += one.pieces if isinstance(one, Words) else [one.test] if isinstance(one, If) else []
        found += [piece for piece in pieces if not isinstance(piece, str)]
    return ast.List(found, ast.Load())


def _number(text: str, unit: str) -> Verbatim:
    """Return a number as it is written. Raises Unsupported if the text is none."""
    value = literal(text)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or value != value or abs(value) == float("inf"):
        raise Unsupported(f'"{text[:40]}" is no number')
    if value == 0:
        return Verbatim("0")
    if unit == ANGLES and (degrees := in_degrees(float(value), "deg")):
        return Verbatim(degrees)
    made = text if _NUMBER.fullmatch(text) else exact(value)
    if (unit == ANGLES and abs(value) > _FULL_TURN) or (unit == LENGTHS and abs(value) > _LONG):
        made += " rad" if unit == ANGLES else " m"
    return Verbatim(made)


def _value(node: ast.expr, unit: str) -> Any:
    """Return an expression of the language as a value."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    sign = isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant)
    if isinstance(node, ast.Constant) or sign:
        value = folded(node)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return _number(written(node) if not sign else written(node).replace(" ", ""), unit)
    if isinstance(node, ast.Name) and node.id in ("true", "false", "none"):
        return {"true": True, "false": False, "none": None}[node.id]
    return Expression(f"${{{written(node)}}}")


def _in_degrees(node: ast.expr) -> ast.expr:
    value = folded(node)
    text = in_degrees(float(value), "deg") if isinstance(value, (int, float)) and value else ""
    return ast.Name(f"({text})" if text.startswith("-") else text) if text else node


def _is_name(pieces: Pieces, variable: Variable) -> bool:
    return len(pieces) == 1 and isinstance(pieces[0], ast.Name) and pieces[0].id == variable.id


def _sole(node: Element, tag: str, name: str) -> str:
    """Return the variable that an attribute of a child is, or nothing."""
    found = [one.attributes.get(name, []) for one in node.body if isinstance(one, Element) and one.tag == tag]
    is_name = len(found) == 1 and len(found[0]) == 1 and isinstance(found[0][0], ast.Name)
    return found[0][0].id if is_name else ""


def _join(pieces: Pieces) -> ast.expr:
    """Return a text as one formula."""
    parts = [ast.Constant(one) if isinstance(one, str) else one for one in pieces]
    return ast.Call(ast.Name("__join"), parts, [])


def _is_find(node: Any) -> bool:
    return isinstance(node, ast.Call) and getattr(node.func, "id", "") == "find"


def _is_conditional(value: Any) -> bool:
    return (isinstance(value, dict) and "if" in value) or (isinstance(value, Expression) and value.startswith("${get("))


def _spelt(pieces: Pieces) -> str:
    return "|".join(piece if isinstance(piece, str) else ast.dump(piece) for piece in pieces)


def _as_key(text: str) -> str:
    made = re.sub(r"[^\w-]+", "_", text).strip("_")
    return made if made and isinstance(Scalar(made).value, str) else ""


def write(
    program: Program,
    target: Target,
    explicit: set[str],
    imported: Imported,
    wanted: Outputs,
    accepts: list[Any],
    words: Found | None = None,
    shares: frozenset[str] | None = None,
) -> WrittenFiles:
    """Return the files of a description. Raises GiveUp."""
    words = words or Found()
    writer = Writer(program, target, explicit, words.spots)
    documents = writer.render()
    declare_dimensions(documents.files)
    options: dict[str, Any] = {}
    for option in sorted(documents.conditions.keys() & words.options.keys()):
        value, conditions = words.options[option], documents.conditions[option]
        when = None if covers(conditions) else any_of(conditions)
        options[option] = value if when is None else Expression(f"${{{value!r} if {written(when)} else none}}")
    tree, root = tree_of(imported), Description.ROOT_FILE
    beside: dict[str, str] = {}
    included: list[str] = []
    for file in program.files[1:]:
        sections = {key: value for key, value in documents.files.get(file.name, {}).items() if value}
        if not sections:
            continue
        text, name = _layout(sections, documents, file, ""), file.name
        address = writer.package_address(file, text)
        if target.sharing is not None and shares is not None and not writer.data:  # tables are named from the file
            name, text = target.sharing.placed(program, file, text, file.name in shares)
        included.append(address or name)
        beside |= {} if address else {name: text}
    with _Within(writer, None):
        is_text = all(isinstance(piece, str) for piece in program.name)
        name = target.name or (str(tree["robot"]) if is_text else writer.joined(program.name))
    head: dict[str, Any] = {"rosorin_compile": Verbatim("1"), "robot": name}
    head |= {"source": dict(tree["source"])} if "source" in tree else {}
    head |= {"include": included} if included else {}
    tail: dict[str, Any] = {**_other_sections(tree), **({"accept": accepts} if accepts else {})}
    tail["outputs"] = {one: _written(entry) for one, entry in outputs_for(wanted, options).entries.items()}
    sections = {**head, **(documents.files.get(root) or {}), **tail}
    texts = {root: _layout(sections, documents, program.files[0], target.schema), **beside, **writer.data}
    empty = tuple(one.key for one in program.macros.values() if one.level == "robot" and writer.is_empty(one))
    choices = {one.name: choices_of(writer, one) for one in program.arguments.values() if one in writer.used}
    return WrittenFiles(
        texts, program, dict(writer.packages), documents, writer.used, choices, tuple(writer.unfound), empty
    )


def choices_of(writer: Writer, variable: Variable) -> list[str]:
    """Return the values of an argument that are compiled; the first is its default."""
    default = str(variable.values[0])
    compared = [str(one) for one in writer.compared(variable)]
    if variable.type == FLAG:
        others = ["false" if literal(default) is True else "true"]
    elif variable.type == NUMBER:
        others = [one for one in compared if isinstance(literal(one), (int, float))]
    else:
        others = sorted(compared)
        is_free = not writer.allowed(variable) and not variable.names_file
        if is_free and (compared or variable in writer.printed) and not re.search(r"[\s/]", default):
            others.append(PROBE)
    return list(dict.fromkeys([default, *others]))


def _layout(sections: Mapping[str, Any], documents: Documents, file: File, schema: str) -> str:
    document = {key: sections[key] for key in sorted(sections, key=_rank) if sections[key]}
    head = [f"yaml-language-server: $schema={schema}"] if schema and file.name == Description.ROOT_FILE else []
    for text in comments_before(file):
        head += cleaned(text)
    return layout(document, Remarks({(): head, **documents.comments.get(file.name, {})}))


def _other_sections(tree: Map) -> dict[str, Any]:
    """Return the sections that other files than the xacro say."""
    document = _Document(tree)
    others = sorted_sections({name: value for name, value in tree.items() if name not in (*_HEAD, *_TAIL)})
    return {name: document.value(value, (name,), None) for name, value in others.items()}


def _rank(key: str) -> int:
    return _HEAD.index(key) if key in _HEAD else 100 + _TAIL.index(key) if key in _TAIL else 50
