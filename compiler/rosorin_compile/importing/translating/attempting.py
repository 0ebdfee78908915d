"""Attempting: one translation of a xacro, written as files, with what is known by then to be wrong left out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.imported import Imported, Outputs, ReadOptions
from rosorin_compile.language.expression.functions import expression_names
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map

from ..description import tree_of
from ..key_order import sorted_sections
from ..layout import Expression, Remarks, Verbatim, cleaned, layout
from .chosen import said_by_uses
from .data import Data
from .expressions import written as spelt
from .fixing import pins
from .flattened import Place
from .naming import name_parts
from .pieces import File, Macro
from .program import Program
from .proving import PROBE, Source, choices_of
from .rendering import Renderer
from .scopes import Variable
from .sharing import Sharing
from .values import Documents
from .walking import Walker
from .wording import Found, any_of, wishes

# What is made of the xacro begins and ends a file, in this order; what stands between comes as it is read.
_HEAD = ("rosorin_compile", "robot", "source", "include", "args", "let", "materials", "parts", "links", "joints", "use")
_TAIL = ("urdf_elements", "accept", "outputs")


class Changed(NamedTuple):
    """Where a description is going to stand, and what of it is to be otherwise than in the xacro.

    ``schema`` is where editors find the schema; ``name`` another name of the robot; ``meshes`` is put before relative
    names of meshes. ``verbatim`` keeps elements that there are words for as they stand. ``sharing`` is what it has
    together with other robots.
    """

    folder: Path
    schema: str = ""
    name: str | None = None
    meshes: str | None = None
    verbatim: bool = False
    sharing: Sharing | None = None


class Attempt(NamedTuple):
    """The files of one translation, and the program and the documents that they were made of.

    ``chosen``: uses say what their part would choose.
    """

    files: dict[str, str]
    program: Program
    macros: list[Macro]
    packages: dict[str, Path]
    documents: Documents
    chosen: bool = False


class How(NamedTuple):
    """How one attempt is made: with which macros written out, and with which in long names.

    ``texts``: vectors may be texts in tables; ``turns``: angles may be more than a full turn. ``shares``: files are
    shared with other robots, and of these what is there is taken for what this robot needs; None: nothing is shared.
    ``chains``: what is chosen among many is chosen in the part, not by its uses. ``plain``: macros that reckon with
    masses and lengths as with numbers; ``ARGUMENTS`` among them are the arguments. ``lacking``: what a named value
    gives may not be there; ``spelt``: the elements whose text is true or false as Python prints it.
    """

    imported: Imported
    wanted: Outputs
    changed: Changed
    inlined: frozenset[str]
    explicit: frozenset[str]
    accepts: list[Any]
    flat: frozenset[Place]
    trees: list[Map]
    unsaid: Mapping[str, str]
    texts: bool
    turns: bool
    fixed: Mapping[str, str]
    lifted: frozenset[Place] = frozenset()
    changing: frozenset[str] = frozenset()
    words: Found = Found()
    shares: frozenset[str] | None = None
    chains: bool = False
    plain: frozenset[str] = frozenset()
    lacking: bool = False
    spelt: frozenset[str] = frozenset()


def attempt(path: Path, options: ReadOptions, how: How) -> Attempt:
    """Return the files of a translation with some macros written out and some with long names."""
    program = Program(path, options.packages, options.arguments, how.unsaid, how.fixed, how.changing)
    walker = Walker(program, how.inlined, how.flat, how.trees, pins(program), how.lifted)
    walker.walk()
    walker.seen.sort(key=lambda macro: (list(program.files).index(macro.file.path), macro.element.start))
    chosen = not how.chains and said_by_uses(walker.seen)
    _name_macros(program, walker.seen)
    name_parts(walker.seen, how.explicit)
    choices = choices_of(program.arguments, options.arguments)
    data = Data(program, how.changed.folder)
    renderer = Renderer(program, walker.seen, choices, data)
    renderer.vectors_are_texts, renderer.turns = how.texts, how.turns
    renderer.plain, renderer.lacking, renderer.spelt = how.plain, how.lacking, how.spelt
    renderer.meshes = how.changed.meshes or ""
    renderer.words = how.words.spots
    documents = renderer.render()
    for variable in renderer.used:
        variable.used = True
    wanted = wishes(how.wanted, _asked(documents, how.words))
    tail = {**_sections(how.imported), **_tail(how.accepts, wanted)}
    files = {**_files(program, documents, how, tail, data), **data.files}
    return Attempt(files, program, walker.seen, {**options.packages, **data.used}, documents, chosen)


def _asked(documents: Documents, words: Found) -> dict[str, Any]:
    """Return what the URDF is asked for: for what there are words for, on the conditions on which they are there."""
    made: dict[str, Any] = {}
    for option in sorted(documents.asked.keys() & words.options.keys()):
        value, when = words.options[option], any_of(documents.asked[option])
        made[option] = value if when is None else Expression(f"${{{value!r} if {spelt(when)} else none}}")
    return made


def _name_macros(program: Program, macros: list[Macro]) -> None:
    """Give each macro that is kept the name of its part, or of its value."""
    from .expressions import usable

    known = expression_names()
    taken = {one.ours for one in program.scope.names.values() if isinstance(one, Variable)}
    for macro in macros:
        if macro.body is not None:
            macro.ours = macro.name.replace(".", "_")
        else:
            macro.ours = usable(
                macro.name, lambda name: name in taken or name in known.functions or name in known.of_descriptions
            )
            taken.add(macro.ours)


def _files(program: Program, documents: Documents, how: How, tail: Mapping[str, Any], data: Data) -> dict[str, str]:
    """Return the texts of the files; one that stands in its own package already is included from there."""
    tree = tree_of(how.imported)
    root = program.root.name
    included: list[str] = []
    beside: dict[str, str] = {}
    for file in program.files.values():
        sections = documents.files.get(file.name)
        if file.name != root and sections:
            text = _text_of(sections, program, documents, file.name, how)
            address = data.address_of(file, text)
            name, text = _shared(program, file, text, how, data)
            documents.elements |= {
                (name, *key[1:]): at for key, at in documents.elements.items() if key[0] == file.name
            }
            included.append(address or name)
            beside |= {} if address else {name: text}
    head: dict[str, Any] = {
        "rosorin_compile": Verbatim("1"),
        "robot": how.changed.name or documents.name or str(tree["robot"]),
    }
    if "source" in tree:
        head["source"] = dict(tree["source"])
    if included:
        head["include"] = included
    sections = {**head, **(documents.files.get(root) or {}), **tail}
    return {root: _text_of(sections, program, documents, root, how), **beside}


def _shared(program: Program, file: File, text: str, how: How, data: Data) -> tuple[str, str]:
    """Return the name of a file and its text: those of a file of other robots where they have it, too."""
    sharing = how.changed.sharing
    if sharing is None or how.shares is None or data.files:  # tables are named as seen from the file
        return file.name, text
    return sharing.placed(program, file, text, file.name in how.shares)


def _text_of(sections: Mapping[str, Any], program: Program, documents: Documents, name: str, how: How) -> str:
    document = {key: sections[key] for key in sorted(sections, key=_rank) if sections[key]}
    return layout(document, _remarks(program, documents, name, how.changed.schema))


def accepted(source: Source, probes: bool = True) -> list[Any]:
    """Return what the robots of all combinations of arguments have to be accepted for; each rule once."""
    made: dict[tuple[str, str], dict[str, Any]] = {}
    for combination, imported in source.known.items():
        if not probes and any(text == PROBE for _, text in combination):
            continue
        for entry in (imported.tree.get("accept") if imported.tree is not None else None) or ():
            key = (str(entry["rule"]), str(entry.get("reason") or ""))
            known = made.setdefault(key, {"rule": key[0], "of": [], "reason": key[1]})
            known["of"] += [str(one) for one in entry.get("of") or () if str(one) not in known["of"]]
    return [{name: value for name, value in entry.items() if value} for entry in made.values()]


def _sections(imported: Imported) -> dict[str, Any]:
    """Return the sections that other files than the xacro say."""
    from ..description import _Document

    tree = tree_of(imported)
    document = _Document(tree)
    others = sorted_sections({name: value for name, value in tree.items() if name not in (*_HEAD, *_TAIL)})
    return {name: document.value(value, (name,), None) for name, value in others.items()}


def _tail(accepts: list[Any], wanted: Outputs) -> dict[str, Any]:
    from ..description import _written

    made: dict[str, Any] = {"accept": accepts} if accepts else {}
    made["outputs"] = {name: _written(entry) for name, entry in wanted.entries.items()}
    return made


def _rank(key: str) -> int:
    return _HEAD.index(key) if key in _HEAD else 100 + _TAIL.index(key) if key in _TAIL else 50


def _remarks(program: Program, documents: Documents, name: str, schema: str) -> Remarks:
    file = next(one for one in program.files.values() if one.name == name)
    head = [f"yaml-language-server: $schema={schema}"] if schema and name == Description.ROOT_FILE else []
    for remark in file.document.before:
        if remark.kind == "comment" and "autogenerated by xacro" not in remark.text:
            head += cleaned(remark.text)
    return Remarks({(): head, **documents.comments.get(name, {})})
