"""Write texts, entries and elements of the intermediate representation as values of a description."""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple
from xml.sax.saxutils import escape

from rosorin_compile.language.expression.functions import reserved_names
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import Description
from rosorin_compile.source.xml.markup import COMMENT, Element, MarkupError, Remark, parse
from rosorin_compile.source.yaml_text import Scalar

from ..key_order import default_of_key, in_order
from ..layout import Expression, Verbatim, cleaned, in_degrees
from .build import GiveUp, Program
from .choices import conditional, merged, node_of
from .elements import ORIGIN_LEVELS
from .expressions import (
    Translator,
    all_of,
    as_text,
    bare,
    folded,
    is_text,
    kind_of,
    negated,
    numbers_as_text,
    printed,
    written,
)
from .names import may_be_own, without_prefix
from .resolve import usable
from .texts import EXPRESSION, TEXT, Unsupported
from .tree import (
    ANY,
    FILE,
    FLAG,
    FOLDER,
    LIST,
    LISTS,
    LOADED,
    NAME,
    NUMBER,
    NUMBERS,
    TABLE,
    WORDS,
    XML,
    Call,
    Entry,
    File,
    Given,
    Handed,
    Item,
    Listed,
    Macro,
    Piece,
    Place,
    Ref,
    Text,
    Variable,
    Whens,
    Xml,
    literal,
    words,
)

_DEGREES = {"angle": "deg", "speed": "deg/s"}
_OWN = "own prefix"
_SHORT, _MOST_LEAVES = 90, 6
_MOST_FILES, _BYTES = 200, 2_000_000
_OPTIONAL = ("xyz", "rpy", "scale")  # what a call may leave out of a block
_ORIGIN: dict[tuple[str, ...], tuple[str, bool]] = {("xyz",): ("length3", False), ("rpy",): ("angle3", False)}
_LEAF_TYPES = {
    **dict.fromkeys(LISTS, "list"),
    **{one: one for one in NUMBERS},
    "speed": "",
    "file": "text",
    "name": "text",
    TABLE: TABLE,
    LIST: LIST,
}


class Leaf(NamedTuple):
    """A parameter that is one value of a block: its place in the block, its name, and whether all calls give it."""

    path: tuple[str, ...]
    name: str
    sink: str
    always: bool


class Documents:
    """The documents of a translation by file name, with comments, and where their entries come from."""

    def __init__(self) -> None:
        self.files: dict[str, dict[str, Any]] = {}
        self.comments: dict[str, dict[tuple[Any, ...], list[str]]] = {}
        self.elements: dict[tuple[str, str, str], Place] = {}
        self.name: Any = ""
        self.plain: dict[tuple[Any, ...], str] = {}  # elements of files and parts without expressions, by place
        self.evaluated: dict[tuple[Any, ...], str] = {}  # those with expressions
        self.said: dict[str, list[str]] = {}  # what became words, by section
        self.asked: dict[str, list[ast.expr | None]] = {}  # on which conditions outputs are asked for something

    def section(self, file: str, key: str) -> dict[str, Any]:
        return self.files.setdefault(file, {}).setdefault(key, {})  # type: ignore[no-any-return]

    def remark(self, file: str, path: tuple[Any, ...], comments: tuple[str, ...]) -> None:
        lines = [line for comment in comments for line in cleaned(comment)]
        if lines:
            self.comments.setdefault(file, {})[path] = lines


class DataFiles:
    """The YAML files that a xacro loads: named by their package if the description finds that, else copied."""

    def __init__(self, program: Program, folder: Path) -> None:
        self.program = program
        self.named = Packages({}, os.environ, folder / "robot.yaml")
        self.files: dict[str, str] = {}
        self.used: dict[str, Path] = {}

    def name(self, text: str, rest: bool) -> str:
        """Return the name of a file in the description, or its beginning if there is a ``rest`` behind it."""
        text = text.removeprefix("file://")
        if text.startswith("package://"):
            package, _, file = text.removeprefix("package://").partition("/")
            folder = self.program.packages.find(package)
            if folder is None:
                raise Unsupported(f'the package "{package}" is not found')
            if self.finds(package):
                return text
            self.copy(folder, file, rest)
            return file
        folders = [Path(path).parent for path in self.program.files]
        above = text.rpartition("/")[0]
        folder = next(
            (one for one in folders if files.exists(one / text) or (above and files.exists(one / above))), None
        )
        if Path(text).is_absolute() or folder is None or ".." in Path(text).parts:
            raise Unsupported(f"{text} is not a file of the xacro or its packages")
        self.copy(folder, text, rest)
        return text

    def finds(self, package: str) -> bool:
        """Return True if the description finds a package by its name."""
        folder, own = self.program.packages.find(package), self.named.find(package)
        if folder is None or own is None or files.resolve(own) != files.resolve(folder):
            return False
        self.used[package] = folder
        return True

    def address_of(self, file: File, text: str) -> str:
        """Return the address at which the package of a xacro has the same description, or nothing."""
        folder = next((one for one in Path(file.path).parents if Packages.name_of(one)), None)
        if folder is None or Path(self.program.root.path).is_relative_to(folder):
            return ""
        there = sorted((folder / Description.FOLDER).glob(f"**/{Path(file.name).name}"))
        same = next((one for one in there if is_file_with(one, text)), None)
        if same is None or not self.finds(Packages.name_of(folder)):
            return ""
        return f"package://{Packages.name_of(folder)}/{same.relative_to(folder).as_posix()}"

    def copy(self, folder: Path, file: str, rest: bool) -> None:
        """Copy a file of a folder; with ``rest``, all files whose names begin with ``file``."""
        if not rest and not files.is_folder(folder / file):
            found = [folder / file]
        else:
            above = folder / file.rpartition("/")[0] if rest else folder / file
            found = [one for one in sorted(above.glob("**/*")) if one.suffix in (".yaml", ".yml")][:_MOST_FILES]
        for one in found:
            try:
                if one.stat().st_size <= _BYTES:
                    self.files[one.relative_to(folder).as_posix()] = files.read_text(one)
            except (OSError, ValueError) as problem:
                raise Unsupported(f"{one.name} cannot be read: {problem}") from None


def is_file_with(path: Path, text: str) -> bool:
    """Return True if a file has exactly a text."""
    try:
        return path.stat().st_size <= _BYTES and files.read_text(path) == text
    except (OSError, ValueError):
        return False


class Values:
    """Writes values, entries and calls of named values, for the macro ``self.macro`` or for a file."""

    def __init__(self, program: Program, choices: Mapping[str, list[str]], folder: Path, meshes: str = "") -> None:
        self.program = program
        self.plan = program.plan
        self.choices = choices
        self.data = DataFiles(program, folder)
        self.meshes = meshes
        self.used: set[Variable] = set()
        self.documents = Documents()
        self.macro: Macro | None = None
        self.unfound: dict[str, None] = {}  # packages that the description does not find by itself
        self.looks: dict[str, Any] = {}
        self.extra: dict[str, Any] = {}
        self.named_texts = True  # what is on a condition in a kept element may be a named value
        self.translator = Translator(self.used.add, self.own_name)
        self.translator.folder = self.share
        self.translator.loaded = self.data.name
        self.knows_prefix = True

    def own_name(self, variable: Variable) -> ast.expr | None:
        """Return the name ``prefix`` for the parameter that is the prefix of the part."""
        prefix = self.macro.prefix if self.macro else None
        if prefix is not None and self.knows_prefix and variable is prefix[0] and not prefix[1]:
            made: Any = ast.Name("prefix", ast.Load())
            made.kind = WORDS
            return made  # type: ignore[no-any-return]
        return None

    def share(self, package: str) -> ast.expr:
        """Return the folder of a package."""
        folder = self.program.packages.find(package)
        if folder is None:
            raise Unsupported(f'the package "{package}" is not found')
        made: Any = ast.Call(ast.Name("find", ast.Load()), [ast.Constant(package)], [])
        made.kind = WORDS
        if not self.data.finds(package):
            self.data.used[package] = folder
            self.unfound[package] = None
        return made  # type: ignore[no-any-return]

    def condition(self, when: Whens) -> ast.expr | None:
        """Return conditions as one; None if there is none."""
        nodes = []
        for on in when:
            node = self.translator.condition(on.test)
            value = folded(node)
            node = ast.Constant(bool(value)) if value is not None else node
            nodes.append(node if on.holds else negated(node))
        return all_of(nodes)

    # Values.

    def value(self, text: Text) -> Any:
        """Return a text as ``layout`` takes it."""
        if text.sink in LISTS:
            return self.list_of(text)
        if text.sink in NUMBERS:
            return self.number(text.pieces, text.sink, text)
        return self.text(text)

    def node_of(self, pieces: list[Piece], text: Text) -> ast.expr:
        try:
            return self.translator.pieces(pieces)
        except Unsupported as problem:
            problem.span = problem.span or text.span
            raise

    def number(self, pieces: list[Piece], sink: str, text: Text) -> Any:
        if all(piece.kind == TEXT for piece in pieces):
            return number_text("".join(piece.value for piece in pieces), sink, text)
        node = self.node_of(pieces, text)
        if len(pieces) > 1 and is_text(node):
            node = ast.Call(ast.Name("float", ast.Load()), [node], [])
        if sink in _DEGREES:
            value = folded(node)
            degrees = in_degrees(value, _DEGREES[sink]) if isinstance(value, (int, float)) else ""
            if degrees:
                return Verbatim(degrees)
        if sink != "angle":
            node = bare(node)
        elif self.plan.turns:
            node = ast.BinOp(node, ast.Mult(), ast.Name("rad", ast.Load()))
        if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
            return number_text(str(node.value), sink, text)
        return Expression(f"${{{written(node)}}}")

    def list_of(self, text: Text) -> Any:
        """Return several numbers."""
        parts, sink = words(text.pieces), text.sink[:-1]
        if len(parts) == int(text.sink[-1]):
            return [self.number(part, sink, text) for part in parts]
        if len(parts) != 1 or (len(parts[0]) == 1 and parts[0][0].kind == TEXT):
            raise Unsupported(f"{len(parts)} numbers, not {text.sink[-1]}", text.span)
        node = self.node_of(parts[0], text)
        if isinstance(node, ast.List):
            values = [(item, folded(item)) for item in node.elts]
            return [
                number_text(str(value), sink, text)
                if isinstance(value, (int, float)) and not isinstance(value, bool)
                else Expression(f"${{{written(item)}}}")
                for item, value in values
            ]
        may_be_text = getattr(node, "is_open", False) or (self.plan.texts and not getattr(node, "is_list", False))
        if kind_of(node) == WORDS or is_text(node) or may_be_text:
            return Expression(f"${{numbers({written(node)})}}")
        return Expression(f"${{{written(node)}}}")

    def text(self, text: Text) -> Any:
        """Return a text with the expressions in it; a name without the prefix of the part."""
        pieces = text.pieces
        if text.sink == NAME and self.macro is not None:
            if self.macro.mount is not None and text.variable() is self.macro.mount:
                return "mount"
            short = without_prefix(pieces, self.macro.prefix) if self.macro.prefix is not None else None
            pieces = short if short and may_be_own(self.macro, short) else pieces
        if text.sink == FILE:
            pieces = self.address(pieces)
        return self.joined(pieces, text)

    def address(self, pieces: list[Piece]) -> list[Piece]:
        """Return the name of a file: of a package by its address, however it is written."""
        if len(pieces) > 1 and pieces[0] == (TEXT, "file://"):
            pieces = pieces[1:]
        first = pieces[0] if pieces else Piece(TEXT, "/")
        if first.kind == FOLDER:
            rest = pieces[1].value if len(pieces) > 1 and pieces[1].kind == TEXT else ""
            return [Piece(TEXT, f"package://{first.value}{rest}"), *pieces[2 if rest else 1 :]]
        plain = first.value if first.kind == TEXT else "/"
        if self.meshes and "://" not in plain and not plain.startswith("/"):
            return [Piece(TEXT, f"{self.meshes.rstrip('/')}/{plain}"), *pieces[1:]]
        return pieces

    def joined(self, pieces: list[Piece], text: Text, spelt: Any = lambda text: text) -> Any:
        """Return pieces as one text."""
        made, plain = "", True
        for piece in self.with_own_prefix(pieces):
            if piece.kind == TEXT:
                made += spelt(piece.value).replace("${", "$${")
                continue
            if piece.kind == _OWN:
                made, plain = f"{made}${{prefix}}", False
                continue
            node = self.node_of([piece], text)
            if piece.kind == EXPRESSION:
                node = printed(node)
            if isinstance(node, ast.List) or kind_of(node) == LIST:
                node = as_text(node)
            value = folded(node)
            if isinstance(value, str) or (isinstance(value, int) and not isinstance(value, bool)):
                made += spelt(str(value)).replace("${", "$${")
                continue
            made, plain = f"{made}${{{written(node)}}}", False
        return made.replace("$${", "${") if plain else Expression(made)

    def with_own_prefix(self, pieces: list[Piece]) -> list[Piece]:
        """Return a text in which what precedes all names of the part is called ``prefix``."""
        prefix = self.macro.prefix if self.macro else None
        if prefix is None or not self.knows_prefix or not prefix[1]:
            return pieces
        if prefix[0] in self.used and prefix[0].ours == "prefix":
            return pieces
        made: list[Piece] = []
        for piece in pieces:
            before = made[-1].value if made else None
            of_part = isinstance(before, Ref) and before.variable is prefix[0]
            if of_part and piece.kind == TEXT and piece.value.startswith(prefix[1]):
                made[-1] = Piece(_OWN, "")
                piece = Piece(TEXT, piece.value.removeprefix(prefix[1]))
            made.append(piece)
        return made

    # Entries.

    def entry(self, entry: Entry, path: tuple[Any, ...] = (), file: str = "") -> Any:
        """Return an entry as ``layout`` takes it; an expression if a named value gives all of it."""
        origin = self.macro.origin if self.macro else ""
        items = [item for item in entry.items if not (item.key == "&" and origin and item.value.name == origin)]
        whole = _sole_call(items)
        if whole is not None:
            return Expression(f"${{{self.call(whole)}}}")
        groups: dict[str, list[tuple[Any, ast.expr | None]]] = {}
        for item in items:
            for key, value, when in self.pairs(item, path, file):
                if not (isinstance(when, ast.Constant) and not when.value):
                    groups.setdefault(key, []).append((value, when))
        made: dict[Any, Any] = {}
        for key in in_order(groups):
            self.settle(made, key, groups[key])
        return made

    def pairs(self, item: Item, path: tuple[Any, ...], file: str) -> list[tuple[str, Any, ast.expr | None]]:
        """Return the keys and values that an item makes, each with its condition."""
        when, value = self.condition(item.when), item.value
        if isinstance(when, ast.Constant) and not when.value:
            return []
        if isinstance(value, Given):
            return [(item.key, self.given(value), self.given_at_all(value, when))]
        if isinstance(value, Handed):
            leaves = self.leaves(value.macro, value.name)
            if leaves is None:
                raise GiveUp(value.macro, Unsupported(f'what is handed over as "{value.name}" cannot be a parameter'))
            made: dict[str, Any] = {}
            for leaf in leaves:
                inner = made
                for key in leaf.path[:-1]:
                    inner = inner.setdefault(key, {})
                inner[leaf.path[-1]] = Expression(f"${{{leaf.name}}}")
            return [(key, one, when) for key, one in made.items()]
        if isinstance(value, list):
            found = self.listed(value, (*path, item.key), file, item.key)
            return [(item.key, found, when)] if found else []
        if isinstance(value, Entry):
            return [(item.key, self.entry(value, (*path, item.key), file), when)]
        return [(item.key, self.value(value) if isinstance(value, Text) else value, when)]

    def settle(self, made: dict[Any, Any], key: str, found: list[tuple[Any, ast.expr | None]]) -> None:
        """Put a key; one that occurs several times on conditions is spelt differently each time."""
        chosen = merged(key, found) if len(found) > 1 else None
        if chosen is not None:
            made[key] = chosen
            return
        is_named = self.macro is not None and self.macro.entry is not None
        if key in ("xyz", "rpy") and found == [(["0", "0", "0"], None)] and not is_named:
            return
        if len(found) == 2 and found[0][1] is None and found[1][1] is not None and not isinstance(found[0][0], dict):
            found = found[::-1]
        if is_named and len(found) > 1:
            raise Unsupported(f"several {key} on conditions that may hold together")
        for number, (value, when) in enumerate(found):
            made[key if not number else Expression(key + "${''}" * number)] = conditional(value, when)

    def listed(self, items: list[Listed], path: tuple[Any, ...], file: str, key: str) -> Any:
        """Return the items of a list; what a named value gives as a whole as an expression."""
        first = items[0].value
        if isinstance(first, Given) and first.call.macro.entry is not None:
            of_macro = next((one.value for one in first.call.macro.entry.items if one.key == key), ())
            whole = [Given(first.call, key, index) for index in range(len(of_macro))]
            if whole == [item.value for item in items if not item.when] and len(whole) == len(items):
                return self.given(Given(first.call, key))
        made: list[Any] = []
        for item in items:
            when = self.condition(item.when)
            if isinstance(when, ast.Constant) and not when.value:
                continue
            if isinstance(item.value, Xml):
                value = self.element(item.value)
            elif isinstance(item.value, Given):
                value = self.given(item.value)
            else:
                value = self.entry(item.value, (*path, len(made)), file)
                if isinstance(value, dict):
                    self.settle_look(value)
            if file:
                self.documents.remark(file, (*path, len(made)), item.comments)
            made.append(conditional(value, when))
        return made

    def settle_look(self, visual: dict[Any, Any]) -> None:
        """Remove the name of a material that looks different from the first of that name."""
        name, rgba = visual.get("material"), visual.get("rgba")
        if not isinstance(name, str) or isinstance(name, Expression) or not isinstance(rgba, list):
            return
        if has_expression(rgba) or "texture" in visual:
            return
        if [float(one) for one in self.looks.setdefault(name, rgba)] != [float(one) for one in rgba]:
            del visual["material"]

    # Named values and their blocks.

    def given(self, given: Given) -> Expression:
        """Return what a call of a named value gives under a key."""
        entry, text = given.call.macro.entry, self.call(given.call)
        if entry is not None and entry.may_lack(given.key):
            text = f"get({text}, '{given.key}')"
        elif entry is None or len(entry.keys()) > 1:
            text = f"{text}.{given.key}"
        return Expression(f"${{{text}{f'[{given.at}]' if given.at >= 0 else ''}}}")

    def given_at_all(self, given: Given, when: ast.expr | None) -> ast.expr | None:
        """Return the condition on which a call of a named value gives something."""
        entry = given.call.macro.entry
        if not self.plan.lacking or given.at >= 0 or entry is None or not entry.may_lack(given.key):
            return when
        found = ast.parse(self.given(given)[2:-1], mode="eval").body
        there = ast.Compare(found, [ast.NotEq()], [ast.Constant(None)])
        return all_of([*([when] if when is not None else []), there])

    def call(self, call: Call) -> str:
        """Return the call of a named value as an expression."""
        given = []
        for name, variable in self.parameters(call.macro):
            text = call.given.get(name) or call.macro.defaults.get(name) or Text([])
            node = self.translator.text(text)
            if variable.kind() == WORDS and isinstance(node, ast.List) and text.plain is not None:
                node = ast.Constant(text.plain)
            elif variable.kind() == LIST and isinstance(node, ast.Constant) and isinstance(node.value, str):
                node = self.translator.pieces([Piece(TEXT, node.value)])
            given.append(written(node))
        for name in call.macro.block_levels:
            leaves = self.leaves(call.macro, name)
            nodes = [node_of(self.leaf(call.blocks[name], leaf)) for leaf in leaves or ()]
            if leaves is None or None in nodes:
                reason = f'what is handed over as "{name}" has no word as a value'
                raise GiveUp(call.macro, Unsupported(reason, call.element.span))
            given += [written(node) for node in nodes if node is not None]
        return f"{call.macro.ours}({', '.join(given)})"

    def parameters(self, macro: Macro) -> list[tuple[str, Variable]]:
        """Return the parameters that a macro uses."""
        every = (*macro.variables.items(), *macro.implicit.items())
        return [(name, variable) for name, variable in every if variable in self.used]

    def leaves(self, macro: Macro, block: str, depth: int = 0) -> list[Leaf] | None:
        """Return the parameters that stand for a block, or None if there are none that fit all calls."""
        found: list[dict[tuple[str, ...], tuple[str, bool]]] = []
        for entry in macro.blocks_given.get(block, ()):
            values = list(self._leaf_values(entry.items, depth))
            if not all(sink for _, sink in values) or len({path for path, _ in values}) < len(values):
                found = []
                break
            found.append(dict(values))  # type: ignore[arg-type]
        made: dict[tuple[str, ...], tuple[str, bool]] = {}
        for path in dict.fromkeys(path for one in found for path in one):
            sinks = [one[path] for one in found if path in one]
            always = len(sinks) == len(found) and all(is_always for _, is_always in sinks)
            if len({sink for sink, _ in sinks}) > 1 or (not always and path[-1] not in _OPTIONAL):
                made = {}
                break
            made[path] = (sinks[0][0], always)
        is_origin = macro.block_levels.get(block) in ORIGIN_LEVELS
        if found and is_origin and made.keys() <= _ORIGIN.keys():
            made = {**_ORIGIN}  # whatever the calls give: who writes another one may turn it
        if not made or len(made) > _MOST_LEAVES or len({path[-1] for path in made}) < len(made):
            made = self._whole_block(macro, block)
        if not made:
            return None
        variables = [*macro.variables.values(), *macro.implicit.values(), *(macro.body.locals if macro.body else ())]
        taken = {one.ours for one in (*variables, *self.program.names.arguments.values(), *self.program.globals)}
        clashes = [path[-1] in taken or path[-1] in self._other_blocks(macro, block, depth) for path in made]
        names = [f"{block}_{path[-1]}" if any(clashes) else path[-1] for path in made]
        return [Leaf(path, usable(name), *made[path]) for path, name in zip(made, names, strict=True)]

    def _other_blocks(self, macro: Macro, block: str, depth: int) -> set[str]:
        """Return the last keys of the values in the other blocks of a macro."""
        others = [one for name, given in macro.blocks_given.items() if name != block for one in given]
        return {path[-1] for entry in others for path, _ in self._leaf_values(entry.items, depth)}

    def _whole_block(self, macro: Macro, block: str) -> dict[tuple[str, ...], tuple[str, bool]]:
        """Return the keys of a block of a part, if all calls give the same ones."""
        entries = macro.blocks_given.get(block, ())
        if not entries or macro.body is None:
            return {}
        items = entries[0].items
        if any([item.key for item in one.items] != [item.key for item in items] for one in entries):
            return {}
        every = [item for entry in entries for item in entry.items]
        if any(item.when or not isinstance(item.value, (Entry, Given, list)) for item in every):
            return {}
        return {(item.key,): (LIST if isinstance(item.value, list) else TABLE, True) for item in items}

    def _leaf_values(self, items: list[Item], depth: int) -> Iterator[tuple[tuple[str, ...], tuple[str, bool] | None]]:
        for item in items:
            value = item.value
            if isinstance(value, Handed) and not item.when and depth < 20:
                outer = self.leaves(value.macro, value.name, depth + 1)
                if outer is None:
                    yield ("&",), None
                yield from ((leaf.path, (leaf.sink, leaf.always)) for leaf in outer or ())
            elif isinstance(value, Entry) and not item.when:
                yield from (((item.key, *path), sink) for path, sink in self._leaf_values(value.items, depth))
            else:
                fits = isinstance(value, Text) and not item.when and value.sink in _LEAF_TYPES
                yield (item.key,), (value.sink, True) if fits else None

    def leaf(self, entry: Entry, leaf: Leaf) -> Any:
        """Return what a block gives for a parameter."""
        found: Any = entry
        for key in leaf.path:
            items = {item.key: item.value for item in found.items} if isinstance(found, Entry) else {}
            found = items.get("&", items.get(key))
            if isinstance(found, Handed):
                outer = self.leaves(found.macro, found.name) or ()
                name = next((one.name for one in outer if one.path == leaf.path), "")
                return Expression(f"${{{name}}}") if name else default_of(leaf)
        if isinstance(found, Entry):
            return self.entry(found)
        if isinstance(found, Given):
            return self.given(found)
        if isinstance(found, list):
            return self.listed(found, (), "", leaf.path[-1])
        return self.value(found) if found is not None else default_of(leaf)

    # Values of variables.

    def of_variable(self, text: Text, variable: Variable, kind: str = "") -> Any:
        """Return a value of a variable."""
        kind = kind or variable.kind()
        evidence = variable.head().evidence
        node = text.pieces[0].value if len(text.pieces) == 1 and text.pieces[0].kind == EXPRESSION else None
        table = self.mapping(node) if kind in (TABLE, ANY) and node is not None else None
        if table is not None:
            return table
        others = {"length3", "number3", "number4", "indexed"}
        is_angle = kind == LIST and "angle3" in evidence and not evidence & others
        sink = "angle" if is_angle or (kind == NUMBER and declared_type(variable) == "angle") else "number"
        if {LOADED, FILE} & evidence and kind in (WORDS, ANY):
            pieces = self.address(text.pieces)
            if LOADED in evidence and pieces and pieces[0].kind != TEXT:
                for folder, name in self.program.names.loaded:
                    self.data.copy(folder, name, False)
            elif LOADED in evidence and pieces:
                pieces = [Piece(TEXT, self.data.name(pieces[0].value, len(pieces) > 1)), *pieces[1:]]
            if LOADED in evidence or len(pieces) > 1 or text.plain is None:
                return self.joined(pieces, text)
        return self.of_kind(text, kind, sink)

    def of_kind(self, text: Text, kind: str, sink: str) -> Any:
        pieces, parts = text.pieces, words(text.pieces)
        if text.plain is not None:
            return _literal_of(text.plain, kind, sink, text)
        if kind == LIST and len(parts) > 1:
            return [self.number(part, sink, text) for part in parts]
        if kind in (WORDS, ANY) and len(pieces) > 1:
            return self.joined(pieces, text)
        node = self.node_of(pieces, text)
        if kind == WORDS:
            node = numbers_as_text(node)
        if kind == NUMBER and len(pieces) > 1 and is_text(node):
            node = ast.Call(ast.Name("float", ast.Load()), [node], [])
        if kind == LIST and kind_of(node) == WORDS:
            return Expression(f"${{numbers({written(node)})}}")
        if kind == LIST and isinstance(node, ast.List):
            return [self._item(one, sink, text) for one in node.elts]
        if kind == NUMBER and isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
            return number_text(str(node.value), sink, text)
        if kind == NUMBER and sink != "angle":
            node = bare(node)
        return final(node)

    def _item(self, node: ast.expr, sink: str, text: Text) -> Any:
        value = folded(node)
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        return number_text(str(value), sink, text) if is_number else Expression(f"${{{written(node)}}}")

    def mapping(self, tree: ast.expr) -> Any:
        """Return a table that Python makes (``dict(a=1)``, ``{'a': 1}``) as a mapping, or None."""
        called = ast.unparse(tree.func) if isinstance(tree, ast.Call) else ""
        if isinstance(tree, ast.Dict) and all(isinstance(key, ast.Constant) for key in tree.keys):
            pairs = [(key.value, item) for key, item in zip(tree.keys, tree.values, strict=True)]  # type: ignore
        elif called in ("xacro.dotify", "dotify") and tree.args:  # type: ignore[attr-defined]
            return self.mapping(tree.args[0])  # type: ignore[attr-defined]
        elif called == "dict" and not tree.args:  # type: ignore[attr-defined]
            pairs = [(keyword.arg, keyword.value) for keyword in tree.keywords if keyword.arg]  # type: ignore
        else:
            return None
        return {str(key): self.mapping(item) or final(self.translator.node(item)) for key, item in pairs}

    # Elements that are kept as text.

    def element(self, node: Xml) -> Any:
        """Return an element that is kept, as text."""
        lines = self.lines(node, "")
        text = "\n".join(lines)
        text = f"{text}\n" if len(lines) > 1 else text
        return Expression(text) if "${" in text else text

    def laid_out(self, text: str) -> str:
        """Return a plain element in the layout of all elements."""
        if "$" in text or "<?" in text:
            return text
        try:
            return str(self.element(_xml_of(parse(Source("", text)).root)))
        except MarkupError:
            return text

    def lines(self, node: Xml, pad: str) -> list[str]:
        """Return the lines of an element."""
        attributes = [f' {name}="{self.attribute(text, node.tag, name)}"' for name, text in node.attributes]
        start = f"<{node.tag}{''.join(attributes)}"
        named = next((text.plain for name, text in node.attributes if name == "name"), None) or node.tag
        content: list[str] = []
        plain = True
        for item in self.content(node.content):
            if named in self.plan.printed and isinstance(item, Text):
                content.append(f"{pad}  {self.printed_flag(item)}")
            else:
                content += self.lines_of(item, f"{pad}  ")
            plain = plain and isinstance(item, Text)
        if not content:
            return [f"{pad}{start}/>"]
        inside = " ".join(line.strip() for line in content)
        if (plain and "\n" not in inside) or (len(content) == 1 and len(content[0]) < _SHORT // 2):
            return [f"{pad}{start}>{inside}</{node.tag}>"]
        return [f"{pad}{start}>", *content, f"{pad}</{node.tag}>"]

    def printed_flag(self, text: Text) -> str:
        """Return a text that is true or false as Python prints it."""
        pieces = _stripped(text.pieces)
        if len(pieces) != 1 or pieces[0].kind != EXPRESSION:
            return str(self.joined(pieces, text, escape))
        node = ast.IfExp(self.node_of(pieces, text), ast.Constant("True"), ast.Constant("False"))
        return f"${{{written(node)}}}"

    def lines_of(self, item: Any, pad: str) -> list[str]:
        if isinstance(item, Text):
            return [f"{pad}{self.joined(_stripped(item.pieces), item, escape)}"]
        if isinstance(item, Remark):
            return [f"{pad}<!--{item.text.replace('${', '$${')}-->"]
        if isinstance(item, Call):
            return [f"{pad}${{{self.call(item)}}}"]
        return [f"{pad}{item}"] if isinstance(item, str) else self.lines(item, pad)

    def attribute(self, text: Text, tag: str, name: str) -> str:
        """Return the value of an attribute; what names a link or a joint of the part has its short name."""
        pieces, prefix = text.pieces, self.macro.prefix if self.macro else None
        if prefix is not None and (tag, name) in (("gazebo", "reference"), ("joint", "name")):
            pieces = without_prefix(pieces, prefix) or pieces
        return str(self.joined(pieces, text, lambda text: escape(text, {'"': "&quot;"})))

    def content(self, content: list[Any]) -> list[Any]:
        """Return the content of an element, with each group on a condition as an expression that gives its text."""
        made: list[Any] = []
        previous: tuple[str, ast.expr] | None = None
        for item in content:
            if not (isinstance(item, Xml) and not item.tag):
                if not (isinstance(item, Text) and item.plain is not None and not item.plain.strip()):
                    made.append(item)
                    previous = None
                continue
            when = self.condition(item.when)
            if isinstance(when, ast.Constant) and not when.value:
                continue
            if when is None:
                made += self.content(item.content)
                continue
            text = self.group(item)
            if not text:
                continue
            if previous is not None and written(previous[1]) == written(negated(when)):
                made[-1] = f"${{{previous[0]} if {written(previous[1])} else {text}}}"
                previous = None
            else:
                made.append(f"${{{text} if {written(when)} else ''}}")
                previous = (text, when)
        return made

    def group(self, group: Xml) -> str:
        """Return the text of a group as an expression: itself if it is short, else the name of a value."""
        items = [item for item in self.content(group.content) if not isinstance(item, Remark)]
        lines = [line for item in items for line in self.lines_of(item, "") if line.strip()]
        text = "\n".join(lines)
        if not text:
            return ""
        if "${" not in text and len(lines) == 1 and len(text) <= _SHORT:
            return repr(text)
        if len(lines) == 1 and text.startswith("${") and text.endswith("}") and text.count("${") == 1:
            return text[2:-1]  # evaluated only where the condition holds: a list may be shorter elsewhere
        if not self.named_texts:
            node = node_of(Expression(" ".join(line.strip() for line in lines)))
            if node is None:
                raise Unsupported("a condition in elements that are kept")
            return written(node)
        value = Expression(text) if "${" in text else text
        for name, known in self.extra.items():
            if known == value:
                return name
        name = usable(name_of(text), {*self.extra, *self.taken()})
        self.extra[name] = value
        return name

    def taken(self) -> set[str]:
        """Return the names that a text cannot have."""
        macro = self.macro
        own = [*macro.variables.values(), *macro.implicit.values()] if macro else []
        own += macro.body.locals if macro and macro.body else []
        names = {one.ours for one in (*self.program.names.arguments.values(), *self.program.globals, *own)}
        names |= {one.ours for one in self.program.kept} | reserved_names()
        for document in self.documents.files.values():
            names |= {key.partition("(")[0] for key in document.get("let", ())}
        return names | {"prefix", "mount", "name", "parent"}


def _sole_call(items: list[Item]) -> Call | None:
    """Return the call that gives all of an entry, under several keys; None if there is none such."""
    calls: set[Any] = set()
    for item in items:
        inner: list[Any] = list(item.value) if isinstance(item.value, list) else [item]
        if item.when or any(one.when or not isinstance(one.value, Given) for one in inner):
            return None
        calls.update(one.value.call for one in inner)
    if len(calls) != 1:
        return None
    (call,) = calls
    keys = [item.key for item in items]
    return call if call.macro.entry is not None and keys == call.macro.entry.keys() and len(keys) > 1 else None


def default_of(leaf: Leaf) -> Any:
    """Return what a block is taken to give that gives nothing."""
    return [Verbatim(exact(number)) for number in default_of_key(leaf.path[-1])]


def leaf_type(leaf: Leaf) -> str:
    """Return the type of a parameter for a block; empty if any value fits."""
    return _LEAF_TYPES[leaf.sink]


def number_text(text: str, sink: str, value: Text) -> Any:
    """Return a plain number as it is written. Raises Unsupported for another text."""
    found = literal(text.strip())
    if isinstance(found, bool) or not isinstance(found, (int, float)):
        raise Unsupported(f'"{text}" is no number', value.span)
    if found == 0:
        return Verbatim("0")
    degrees = in_degrees(float(found), _DEGREES[sink]) if sink in _DEGREES else ""
    if degrees:
        return Verbatim(degrees)
    digits = text.strip().removeprefix("+")
    read = Scalar(digits).value
    if isinstance(read, bool) or type(read) not in (int, float) or float(read) != float(found):
        digits = exact(found)
    unit = " rad" if sink == "angle" and abs(found) > 6.2832 else " m" if sink == "length" and abs(found) > 20 else ""
    return Verbatim(f"{digits}{unit}")


def _literal_of(text: str, kind: str, sink: str, value: Text) -> Any:
    """Return a plain text as a value of a kind."""
    found = literal(text)
    if kind == FLAG and (found in (0, 1) or found in ("true", "True", "false", "False")):
        return found in (1, "true", "True")
    if kind == LIST:
        numbers = str(found).split() if isinstance(found, str) else text.split()
        if len(numbers) > 1:
            return [number_text(word, sink, value) for word in numbers]
    if kind == WORDS:
        is_number = isinstance(found, (int, float, list))
        return text if is_number else str(found)
    if isinstance(found, (int, float)) and not isinstance(found, bool):
        return number_text(text.strip(), sink, value)
    return text if isinstance(found, list) else found


def final(node: ast.expr) -> Any:
    """Return an expression as a value of a document."""
    value = folded(node)
    if isinstance(value, bool) or (isinstance(value, str) and isinstance(node, ast.Constant)):
        return value
    number = node.operand if isinstance(node, ast.UnaryOp) else node
    if isinstance(number, ast.Constant) and isinstance(value, (int, float)):
        return Verbatim(exact(value))
    if isinstance(node, ast.List):
        return [final(item) for item in node.elts]
    return Expression(f"${{{written(node)}}}")


def has_expression(value: Any) -> bool:
    """Return True if anything in a list of values is evaluated."""
    return any(map(has_expression, value)) if isinstance(value, list) else isinstance(value, Expression)


def declared_type(variable: Variable) -> str:
    """Return the type of a parameter; empty if any value fits."""
    kind, evidence = variable.kind(), variable.head().evidence
    if kind == NUMBER:
        dimensions = [one for one in ("length", "angle", "mass") if one in evidence]
        return dimensions[0] if len(dimensions) == 1 and "number" not in evidence else "number"
    return {FLAG: "boolean", WORDS: "text", TABLE: "table", LIST: "list"}.get(kind, "")


def _stripped(pieces: list[Piece]) -> list[Piece]:
    """Return pieces without white space at their ends."""
    made = list(pieces)
    if made and made[0].kind == TEXT:
        made[0] = Piece(TEXT, made[0].value.lstrip())
    if made and made[-1].kind == TEXT:
        made[-1] = Piece(TEXT, made[-1].value.rstrip())
    return [piece for piece in made if piece.kind != TEXT or piece.value]


def _xml_of(element: Element) -> Xml:
    made = Xml(element.tag)
    made.attributes = [(name, Text([Piece(TEXT, one.value)], XML)) for name, one in element.attributes.items()]
    for item in element.content:
        if isinstance(item, Element):
            made.content.append(_xml_of(item))
        else:
            made.content.append(item if item.kind == COMMENT else Text([Piece(TEXT, item.text)], XML))
    return made


_TAG = re.compile(r"<([A-Za-z_]\w*)((?:[^<>\"']|\"[^\"]*\"|'[^']*')*?)(/?)>|</[^>]*>")
_NAME = re.compile(r"\bname\s*=\s*[\"']([^\"']*)")


def name_of(text: str) -> str:
    """Return a name for some elements: the package of their plug-in, their name, or what they are.

    >>> name_of("<plugin>mock_components/GenericSystem</plugin><param name='a'>1</param>")
    'mock_components'
    >>> name_of('<gpio name="${prefix}tool_io"/>'), name_of('<joint name="a"><b/></joint><joint name="c"/>')
    ('tool_io', 'joints')
    """
    plugin = re.match(r"\s*<plugin>\s*([^<]*)", text)
    if plugin and (found := _as_name(plugin[1].partition("/")[0])):
        return found
    tops: list[tuple[str, str]] = []
    depth = 0
    for tag in _TAG.finditer(text):
        if not tag[1]:
            depth -= 1
            continue
        if not depth:
            named = _NAME.search(tag[2])
            tops.append((tag[1], _as_name(named[1]) if named else ""))
        depth += not tag[3]
    if not tops:
        return "text"
    first, name = tops[0]
    if len(tops) == 1:
        return name or first
    return f"{first}s" if all(tag == first for tag, _ in tops) else f"{name or first}_and_more"


def _as_name(text: str) -> str:
    return re.sub(r"\W+", "_", re.sub(r"\$\{[^}]*\}", "", text), flags=re.ASCII).strip("_")
