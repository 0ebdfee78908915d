"""Program: a xacro with all files that it includes, as a program: its arguments, properties and macros.

What is taken down here is what stands at the top of files, under conditions too; what is in macros is looked at where
they are called. Files of other packages are found as xacro finds them.
"""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterator, Mapping
from fnmatch import fnmatchcase
from pathlib import Path

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.xml.files import read_source
from rosorin_compile.source.xml.markup import Document, Element, MarkupError, Remark

from .pieces import Body, File, Macro, When, Whens
from .scopes import ARGUMENT, CONDITION, FREE, GLOBAL, Bound, Scope, Space, Unsaid, Value, Variable
from .texts import EXPRESSION, EXTENSION, TEXT, Token, Unsupported, parameters, tokens

MAX_CHOICES = 20
_ENVIRONMENT = re.compile(r"\$\((optenv|env)\s+(\w+)(?=[\s)])\s*([^)]*)\)")
_FIND = re.compile(r"\$\(find\s+([^)\s]+)\)")


class Definition:
    """One ``xacro:property`` at the top of a file."""

    def __init__(self, value: Value, when: Whens, default: bool) -> None:
        self.value = value
        self.when = when
        self.default = default


class Fixed(Exception):
    """An argument that no description can have, because it names files that are not known: it keeps its value.

    ``element`` is the include.
    """

    def __init__(self, name: str, text: str, element: Element) -> None:
        super().__init__(name)
        self.name = name
        self.text = text
        self.element = element


class Program:
    """A xacro and all that it includes.

    What it takes from the environment (``$(optenv NAME 1)``) are arguments here, ``environment`` has their texts.
    """

    def __init__(
        self,
        path: Path,
        packages: Mapping[str, Path],
        given: Mapping[str, str],
        unsaid: Mapping[str, str] | None = None,
        fixed: Mapping[str, str] | None = None,
        changing: frozenset[str] = frozenset(),
    ) -> None:
        self.scope = Scope()
        self.changing = changing  # properties that are what they were set to last, wherever they are read
        self.unsaid = unsaid or {}
        self.fixed = fixed or {}
        self.packages = Packages(packages, os.environ, path)
        self.given = given
        self.environment: dict[str, str] = {}
        self.spaces: dict[int, str] = {}
        self.others: dict[str, Macro] = {}
        self.files: dict[str, File] = {}
        self.macros: dict[str, Macro] = {}
        self.by_element: dict[int, Macro] = {}
        self.arguments: dict[str, Variable] = {}
        self.argument_files: dict[str, File] = {}
        self.properties: dict[str, list[Definition]] = {}
        self.property_files: dict[str, File] = {}
        self.property_comments: dict[str, tuple[str, ...]] = {}
        self.conditions: list[Value] = []
        self.unclear: dict[int, Unsupported] = {}
        self.guards: dict[int, list[tuple[str, list[str]]]] = {}
        self.missing: list[tuple[str, Span]] = []
        self.tops: dict[int, list[tuple[File, Whens]]] = {}
        self.root = self._file(path, root=True)
        self._collect(self.root.document.root, self.root, (), ())
        self._take_given()
        self._name_properties()

    def _file(self, path: Path, root: bool = False, space: str = "") -> File:
        """Return a file, read. Raises MarkupError, OSError."""
        key = os.path.abspath(path)
        if key in self.files:
            return self.files[key]
        source = read_source(path)
        document = Document.parse(type(source)(source.path, _ENVIRONMENT.sub(self._of_environment, source.text)))
        file = File(key, document, "robot.yaml" if root else self._free_name(path), space)
        file.body = Body(file, None, Space(self.scope, space) if space else self.scope)
        self.spaces[id(document)] = space
        self.files[key] = file
        for name, text in self.environment.items():
            self._declare(name, text, document.root.span, file)
        return file

    def _of_environment(self, match: re.Match[str]) -> str:
        """Return the argument that stands for a variable of the environment, as long as what it stands for."""
        name, text = match[2], os.environ.get(match[2], match[3].strip())
        if self.environment.setdefault(name, text) != text:
            raise Unsupported(f"$({match[1]} {name}) has several defaults")
        return f"$(arg {name})".replace(")", " " * (len(match[0]) - len(name) - 7) + ")")

    def _free_name(self, path: Path) -> str:
        """Return the name of the file here: that of the xacro, in the folders that it is in beside the first."""
        first = Path(next(iter(self.files)))
        here = Path(os.path.abspath(path))
        stem = re.sub(r"(\.urdf)?\.xacro$|\.urdf$|\.xml$", "", here.name)
        stem = re.sub(r"[^\w.-]+", "_", stem).strip(".") or "part"
        folder = ""
        if here.is_relative_to(first.parent) and here.parent != first.parent:
            folder = f"{here.parent.relative_to(first.parent).as_posix()}/"
        taken = {file.name for file in self.files.values()}
        name, number = f"{folder}{stem}.yaml", 1
        if name == "robot.yaml":
            name = "robot_parts.yaml"
        while name in taken:
            number += 1
            name = f"{folder}{stem}_{number}.yaml"
        return name

    def _collect(self, element: Element, file: File, when: Whens, within: tuple[str, ...]) -> None:
        """Take down what an element defines."""
        for child, comments in with_comments(element):
            tag = child.tag
            if tag in ("xacro:if", "xacro:unless"):
                condition = When(Value(child.get("value"), file.body.scope, "condition", child.span), tag == "xacro:if")
                self._collect(child, file, (*when, condition), within)
            elif tag == "xacro:include":
                self._include(child, file, when, within)
            elif tag == "xacro:macro":
                self._macro(child, file, comments)
            elif tag == "xacro:arg":
                self._argument(child, file, comments)
            elif tag == "xacro:property":
                self._property(child, file, when, comments)

    def _include(self, element: Element, file: File, when: Whens, within: tuple[str, ...]) -> None:
        chosen = self.chosen(element, file)
        if chosen is not None:
            for target, conditions in chosen:
                self._include_one(target, element, (*when, *conditions), within, conditions)
            return
        target = self.resolve(element.get("filename"), file, element.span)
        if re.search(r"[*?[]", str(target)):
            for one in _fitting(str(target)):
                self._include_one(Path(one), element, when, within)
            return
        self._include_one(target, element, when, within)

    def _include_one(
        self, target: Path, element: Element, when: Whens, within: tuple[str, ...], own: Whens = ()
    ) -> None:
        key = os.path.abspath(target)
        if key in within or len(within) > 40:
            raise Unsupported(f"{Path(key).name} includes itself", element.span)
        try:
            known = self.files.get(key)
            included = known or self._file(target, space=self._space(element))
            if known and known.space != self._space(element):
                self._also(known, self._space(element))
        except (MarkupError, OSError):
            self.missing.append((str(target), element.span))
            return
        self.tops.setdefault(id(element), []).append((included, own))
        self._collect(included.document.root, included, when, (*within, key))

    def add(self, name: str, element: Element) -> list[str]:
        """Take down a file whose name is known by now; return the properties that are new."""
        if id(element) not in self.tops:
            here = Path(element.document.source.path).parent
            path = self.packages.resolve(name, Path()) if "://" in name else Path(os.path.normpath(here / name))
            self._include_one(path or Path("/no-package"), element, (), ())
        return self._name_properties()

    def file_of(self, element: Element) -> File | None:
        """Return the file that an element stands in."""
        return next((one for one in self.files.values() if one.document is element.document), None)

    def add_chosen(self, pieces: list[Token], element: Element, file: File) -> list[str]:
        """Take down the files that arguments in a macro choose by their names; return the properties that are new."""
        if id(element) not in self.tops:
            for target, conditions in self.choices(pieces, element, file) or ():
                self._include_one(target, element, conditions, (), conditions)
        return self._name_properties()

    def _space(self, element: Element) -> str:
        """Return the space of the names of a file that is included: its own, or that of the file it is included in."""
        around = self.spaces.get(id(element.document), "")
        return f"{around}.{element.get('ns')}".strip(".") if element.get("ns") else around

    def _also(self, file: File, space: str) -> None:
        """Take down that the macros of a file have names in another space, too."""
        for macro in [one for one in self.macros.values() if one.file is file]:
            name = macro.element.get("name").removeprefix("xacro:")
            self.others[f"{space}.{name}".strip(".")] = macro

    def macro(self, called: str, element: Element) -> Macro | None:
        """Return the macro that an element calls by a name: of the space that it stands in, or of all."""
        space = self.spaces.get(id(element.document), "")
        for name in (f"{space}.{called}", called) if space else (called,):
            found = self.macros.get(name) or self.others.get(name)
            if found is not None:
                return found
        return None

    def chosen(self, element: Element, file: File) -> list[tuple[Path, Whens]] | None:
        """Return the files that an include may mean whose name has arguments in it, each with its conditions.

        None for a name without arguments; nothing where no file is called so.
        """
        return self.choices(self.spelt(element.get("filename"), 0), element, file)

    def choices(self, pieces: list[Token], element: Element, file: File) -> list[tuple[Path, Whens]] | None:
        """Return the files that have the name which some pieces make: of plain text, packages and arguments."""
        pattern, form = "", ""
        names: dict[str, list[str]] = {}
        for kind, text in pieces:
            if kind != EXTENSION or text.split()[:1] == ["find"]:
                plain = text if kind == TEXT else str(self.packages.find(self._package(text)) or "/no-package")
                pattern, form = pattern + glob.escape(plain), form + re.escape(plain)
                continue
            name = text.split()[1]
            form += f"(?P={name})" if name in names else f"(?P<{name}>[^/]*)"
            pattern, names[name] = pattern + "*", []
        if not names:
            return None
        base = "" if pattern.startswith("/") else f"{glob.escape(str(Path(file.path).parent))}/"
        fitting = _fitting(base + pattern) if re.search(r"\w", pattern) else []
        several = len(names) > 1
        if not re.search(r"\w", pattern) or (several and not 0 < len(fitting) <= MAX_CHOICES):
            raise self._fixed(next(iter(names)), element)
        found: list[tuple[Path, Whens]] = []
        for one in fitting[:MAX_CHOICES]:
            match = re.fullmatch((re.escape(f"{Path(file.path).parent}/") if base else "") + form, one)
            if match and all(match.groupdict().values()) and files.is_file(one):
                found.append((Path(one), tuple(self._is(name, match[name], element) for name in names)))
                for name, known in names.items():
                    known += [match[name]] if match[name] not in known else []
        self.guards[id(element)] = list(names.items())
        return found

    def _is(self, name: str, text: str, element: Element) -> When:
        """Return the condition that an argument is a text."""
        value = Value(f"${{'$(arg {name})' == '{text}'}}", self.scope, CONDITION, element.span)
        self.conditions.append(value)
        return When(value, True)

    def _fixed(self, name: str, element: Element) -> Fixed:
        variable = self.arguments.get(name)
        text = self.given.get(name, variable.values[0].text if variable and variable.values else None)
        if text is None:
            raise Unsupported(f'the file "{element.get("filename")}" is chosen by an argument', element.span)
        return Fixed(name, text, element)

    def spelt(self, text: str, depth: int) -> list[Token]:
        """Return the pieces of a text, those of properties that are one text in their place."""
        made: list[Token] = []
        for piece in tokens(text):
            name = piece.text.strip() if piece.kind == EXPRESSION else ""
            known = self.properties.get(name, [])
            argument = piece.text.split()[1:] if piece.kind == EXTENSION and piece.text.split()[:1] == ["arg"] else []
            if name and len(known) == 1 and not known[0].when and depth < 10:
                made += self.spelt(known[0].value.text, depth + 1)
            elif argument and argument[0] in self.fixed and depth < 10:
                made += self.spelt(self.fixed[argument[0]], depth + 1)
            elif piece.kind == EXPRESSION or (
                piece.kind == EXTENSION and piece.text.split()[:1] not in (["find"], ["arg"])
            ):
                raise Unsupported(f'the file "{text}" is chosen by an expression')
            else:
                made.append(piece)
        return made

    def resolve(self, name: str, file: File, span: Span) -> Path:
        """Return the file that a text names. Raises Unsupported where it depends on an argument."""
        made = []
        for kind, text in self.spelt(name, 0):
            if kind == TEXT:
                made.append(text)
            elif kind == EXTENSION and text.split()[:1] == ["find"]:
                folder = self.packages.find(self._package(text))
                made.append(str(folder) if folder else f"/no-package/{self._package(text)}")
            else:
                raise Unsupported(f'the file "{name}" is chosen by an expression', span)
        path = "".join(made)
        for scheme in ("package://", "file://"):
            if path.startswith(scheme):
                return self.packages.resolve(path, Path()) or Path("/no-package")
        return Path(os.path.normpath(Path(file.path).parent / path))

    def _package(self, text: str) -> str:
        """Return the package that a ``find`` names, perhaps by a property."""
        return "".join(piece.text for piece in self.spelt(text.strip().partition(" ")[2].strip(), 0))

    def _macro(self, element: Element, file: File, comments: tuple[str, ...]) -> None:
        called = name = f"{file.space}.{element.get('name').removeprefix('xacro:')}".strip(".")
        if id(element) in self.by_element:
            return
        number = 1
        while name in self.macros:
            if self.macros[name].element.verbatim == element.verbatim:
                self.by_element[id(element)] = self.macros[name]
                return
            number += 1
            name = f"{called}_{number}"
        self.macros[name] = Macro(name, element, file, parameters(element.get("params")), comments)
        self.by_element[id(element)] = self.macros[name]
        for inner in element.iter():  # macros within macros are known once those are called
            if inner.tag == "xacro:macro" and inner is not element:
                self._macro(inner, file, ())
            elif inner.tag == "xacro:arg":
                self._argument(inner, file)
            elif inner.tag == "xacro:include" and id(inner) not in self.tops:
                try:
                    self._include(inner, file, (), ())
                except Unsupported as problem:  # told where the macro is called
                    self.unclear[id(inner)] = problem

    def called(self) -> set[str]:
        """Return the macros that are called by what stands outside of macros, or by a macro that is."""
        waiting = [file.document.root for file in self.files.values()]
        found: set[str] = set()
        while waiting:
            names = set(_calls(waiting.pop()))
            for name, macro in self.macros.items():
                if name not in found and (macro.called or self._meant(macro, names)):
                    found.add(name)
                    waiting.append(macro.element)
        return found

    def _meant(self, macro: Macro, names: set[str]) -> bool:
        """Say whether calls may mean a macro; of several of one name those that a walk has met."""
        name = macro.element.get("name")
        same = [one for one in self.macros.values() if one.element.get("name") == name and one is not macro]
        short = name.removeprefix("xacro:")
        called = not names.isdisjoint((short, f"{macro.file.space}.{short}")) or any("$" in one for one in names)
        return called and not any(one.called for one in same)

    def _take_given(self) -> None:
        """Take what is given and declared nowhere for an argument: the source takes it, and refuses to go without."""
        for name, text in self.given.items():
            if name not in self.arguments:
                self._declare(name, text, self.root.document.root.span, self.root)

    def _argument(self, element: Element, file: File, comments: tuple[str, ...] = ()) -> None:
        text = element.get("default") if "default" in element.attributes else None
        if element.get("name") in self.environment:
            raise Unsupported(f'the argument "{element.get("name")}" is called like a variable of the environment')
        self._declare(element.get("name"), text, element.span, file)
        variable = self.arguments.get(element.get("name"))
        if variable is not None and not variable.comments:
            variable.comments = comments

    def _declare(self, name: str, default: str | None, span: Span, file: File) -> None:
        if name in self.fixed:
            self.scope.names[f"arg {name}"] = Bound(self.fixed[name], self.scope)
        if name in self.arguments or name in self.fixed:
            return
        made = Variable(name, ARGUMENT, span=span)
        if default is not None:
            made.values.append(Value(default, self.scope, FREE, span))
        self.arguments[name] = made
        self.argument_files[name] = file
        self.scope.names[f"arg {name}"] = made

    def _property(self, element: Element, file: File, when: Whens, comments: tuple[str, ...]) -> None:
        name = f"{file.space}.{element.get('name')}".strip(".")
        if element.get("remove") in ("true", "True", "1"):
            raise Unsupported("a property that is removed", element.span)
        if "value" not in element.attributes and "default" not in element.attributes:
            self.scope.blocks[name] = (element, file.body.scope)
            return
        default = "default" in element.attributes
        value = Value(element.get("default" if default else "value"), file.body.scope, FREE, element.span)
        known = self.properties.setdefault(name, [])
        if default and any(not one.when for one in known):
            return
        if any(one.value.text == value.text and one.when == when for one in known):
            return
        known.append(Definition(value, when, default))
        self.property_files.setdefault(name, file)
        if comments:
            self.property_comments.setdefault(name, comments)

    def changed(self) -> frozenset[str]:
        """Return the properties that are set to another value later on, on no condition."""
        return frozenset(
            name
            for name, known in self.properties.items()
            if len({one.value.text for one in known if not one.when}) > 1
        )

    def _name_properties(self) -> list[str]:
        """Give each property a variable; one that is an argument and nothing else is that argument.

        Return the names of those that had none.
        """
        from .expressions import usable
        from .scopes import sole_name

        taken = {variable.ours for variable in self.arguments.values()}
        for name, variable in self.arguments.items():
            variable.ours = usable(name, lambda _: False)
        taken |= {one.ours for one in self.scope.names.values() if isinstance(one, Variable)}
        fresh = [name for name in self.properties if name not in self.scope.names]
        for name in fresh:
            definitions = self.properties[name]
            if name in self.changing:
                continue
            if name in self.unsaid:
                self.scope.names[name] = Unsaid(self.unsaid[name])
                continue
            only = definitions[0] if len(definitions) == 1 and not definitions[0].when else None
            target = sole_name(tokens(only.value.text)) if only else None
            if target and target.startswith("arg ") and target[4:] in self.arguments:
                self.scope.names[name] = self.arguments[target[4:]]
                continue
            made = Variable(name, GLOBAL, usable(name, lambda one: one in taken), span=definitions[0].value.span)
            taken.add(made.ours)
            made.values += [definition.value for definition in definitions]
            self.scope.names[name] = made
        return fresh


def _calls(element: Element) -> Iterator[str]:
    """Yield the names that an element calls; macros that are defined in it call for themselves."""
    for child in element.children:
        if child.tag == "xacro:call":
            yield child.get("macro")
        elif child.tag.startswith("xacro:"):
            yield child.tag.removeprefix("xacro:")
        if child.tag != "xacro:macro":
            yield from _calls(child)


def _fitting(pattern: str) -> list[str]:
    """Return the files that fit a pattern, as xacro finds them, in their order."""
    *folders, last = pattern.split("/")
    found = [""]
    for part in folders:
        found = [f"{one}{name}/" for one in found for name in _named(one, part, True)]
    return sorted(f"{one}{name}" for one in found for name in _named(one, last, False))


def _named(folder: str, part: str, only_folders: bool) -> list[str]:
    """Return what matches a part of a pattern in a folder, as ``glob`` finds it."""
    if not glob.has_magic(part):  # the spelling counts: ".." and "." stay
        return [part] if only_folders or os.path.lexists(f"{folder}{part}") else []
    try:
        inside = files.list_folder(folder or ".")
    except OSError:
        return []
    shown = part.startswith(".")
    return [
        path.name
        for path in inside
        if fnmatchcase(path.name, part)
        and (shown or not path.name.startswith("."))
        and (not only_folders or files.is_folder(path))
    ]


def with_comments(element: Element) -> list[tuple[Element, tuple[str, ...]]]:
    """Return the elements in an element, each with the comments right above it."""
    found: list[tuple[Element, tuple[str, ...]]] = []
    waiting: list[str] = []
    text = element.document.source.text
    for index, item in enumerate(element.content):
        before = element.content[index - 1] if index else None
        is_comment = isinstance(item, Remark) and item.is_comment
        if is_comment and isinstance(before, Element) and "\n" not in text[before.end : item.start]:
            found[-1] = (found[-1][0], (*found[-1][1], item.text))
            continue  # it stands behind what it speaks of
        if isinstance(item, Element):
            found.append((item, tuple(waiting)))
            waiting = []
        elif isinstance(item, Remark) and item.is_comment:
            waiting.append(item.text)
    return found


def comments_within(element: Element) -> list[str]:
    """Return the comments in a link or a joint that nothing in it has a place for: those above visuals have one."""
    found: list[str] = []
    for one in element.iter():
        kept: set[str] = set()
        for child, comments in with_comments(one):
            kept.update(comments if one is element and child.tag in ("visual", "collision") else ())
        remarks = [item.text for item in one.content if isinstance(item, Remark) and item.is_comment]
        found += [text for text in remarks if text not in kept]
    return found
