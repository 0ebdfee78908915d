"""Program: a xacro with all files that it includes, as a program: its arguments, properties and macros.

What is taken down here is what stands at the top of files, under conditions too; what is in macros is looked at where
they are called. Files of other packages are found as xacro finds them.
"""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Mapping
from pathlib import Path

from ....diagnostics import Span
from ....frontend.packages import Packages
from ....xml.files import read_source
from ....xml.markup import Document, Element, MarkupError, Remark, parse
from .pieces import Body, File, Macro, When, Whens
from .scopes import ARGUMENT, FREE, GLOBAL, Scope, Value, Variable
from .texts import EXTENSION, TEXT, Unsupported, parameters, tokens

_FIND = re.compile(r"\$\(find\s+([^)\s]+)\)")


class Definition:
    """One ``xacro:property`` at the top of a file."""

    def __init__(self, value: Value, when: Whens, default: bool) -> None:
        self.value = value
        self.when = when
        self.default = default


class Program:
    """A xacro and all that it includes."""

    def __init__(self, path: Path, document: Document, packages: Mapping[str, Path], given: Mapping[str, str]) -> None:
        self.scope = Scope()
        self.packages = Packages(packages, os.environ, path)
        self.given = given
        self.files: dict[str, File] = {}
        self.macros: dict[str, Macro] = {}
        self.again: set[str] = set()
        self.arguments: dict[str, Variable] = {}
        self.argument_files: dict[str, File] = {}
        self.properties: dict[str, list[Definition]] = {}
        self.property_files: dict[str, File] = {}
        self.property_comments: dict[str, tuple[str, ...]] = {}
        self.missing: list[tuple[str, Span]] = []
        self.tops: dict[int, list[tuple[File, Whens]]] = {}
        self.root = self._file(path, document, root=True)
        self._collect(self.root.document.root, self.root, (), ())
        self._name_properties()

    def _file(self, path: Path, document: Document, root: bool = False) -> File:
        key = os.path.abspath(path)
        if key in self.files:
            return self.files[key]
        file = File(key, document, "robot.yaml" if root else self._free_name(path))
        file.body = Body(file, None, self.scope)
        self.files[key] = file
        return file

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
                condition = When(Value(child.get("value"), self.scope, "condition", child.span), tag == "xacro:if")
                self._collect(child, file, (*when, condition), within)
            elif tag == "xacro:include":
                self._include(child, file, when, within)
            elif tag == "xacro:macro":
                self._macro(child, file, comments)
            elif tag == "xacro:arg":
                self._argument(child, file)
            elif tag == "xacro:property":
                self._property(child, file, when, comments)

    def _include(self, element: Element, file: File, when: Whens, within: tuple[str, ...]) -> None:
        if element.get("ns"):
            raise Unsupported("an include with ns", element.span)
        target = self.resolve(element.get("filename"), file, element.span)
        if re.search(r"[*?[]", str(target)):
            for one in sorted(glob.glob(str(target))):
                self._include_one(Path(one), element, when, within)
            return
        self._include_one(target, element, when, within)

    def _include_one(self, target: Path, element: Element, when: Whens, within: tuple[str, ...]) -> None:
        key = os.path.abspath(target)
        if key in within or len(within) > 40:
            raise Unsupported(f"{Path(key).name} includes itself", element.span)
        try:
            known = self.files.get(key)
            included = known or self._file(target, parse(read_source(target)))
        except (MarkupError, OSError):
            self.missing.append((str(target), element.span))
            return
        self.tops.setdefault(id(element), []).append((included, ()))
        self._collect(included.document.root, included, when, (*within, key))

    def resolve(self, name: str, file: File, span: Span) -> Path:
        """Return the file that a text names. Raises Unsupported where it depends on an argument."""
        made = []
        for kind, text in tokens(name):
            if kind == TEXT:
                made.append(text)
            elif kind == EXTENSION and text.split()[:1] == ["find"]:
                folder = self.packages.find(text.split()[1])
                made.append(str(folder) if folder else f"/no-package/{text.split()[1]}")
            else:
                raise Unsupported(f'the file "{name}" is chosen by an expression', span)
        path = "".join(made)
        for scheme in ("package://", "file://"):
            if path.startswith(scheme):
                return self.packages.resolve(path, Path()) or Path("/no-package")
        return Path(os.path.normpath(Path(file.path).parent / path))

    def _macro(self, element: Element, file: File, comments: tuple[str, ...]) -> None:
        name = element.get("name").removeprefix("xacro:")
        known = self.macros.get(name)
        if known is not None:
            if known.element is not element and known.element.verbatim != element.verbatim:
                self.again.add(name)
            return
        self.macros[name] = Macro(name, element, file, parameters(element.get("params")), comments)
        for inner in element.iter():  # macros within macros are known once those are called
            if inner.tag == "xacro:macro" and inner is not element:
                self._macro(inner, file, ())
            elif inner.tag == "xacro:include" and id(inner) not in self.tops:
                self._include(inner, file, (), ())

    def _argument(self, element: Element, file: File) -> None:
        name = element.get("name")
        if name in self.arguments:
            return
        made = Variable(name, ARGUMENT, span=element.span)
        if "default" in element.attributes:
            made.values.append(Value(element.get("default"), self.scope, FREE, element.span))
        self.arguments[name] = made
        self.argument_files[name] = file
        self.scope.names[f"arg {name}"] = made

    def _property(self, element: Element, file: File, when: Whens, comments: tuple[str, ...]) -> None:
        name = element.get("name")
        if element.get("remove") in ("true", "True", "1"):
            raise Unsupported("a property that is removed", element.span)
        if "value" not in element.attributes and "default" not in element.attributes:
            self.scope.blocks[name] = (element, self.scope)
            return
        default = "default" in element.attributes
        value = Value(element.get("default" if default else "value"), self.scope, FREE, element.span)
        known = self.properties.setdefault(name, [])
        if default and any(not one.when for one in known):
            return
        if any(one.value.text == value.text and one.when == when for one in known):
            return
        known.append(Definition(value, when, default))
        self.property_files.setdefault(name, file)
        if comments:
            self.property_comments.setdefault(name, comments)

    def _name_properties(self) -> None:
        """Give each property a variable; one that is an argument and nothing else is that argument."""
        from .expressions import usable
        from .scopes import sole_name

        taken = {variable.ours for variable in self.arguments.values()}
        for name, variable in self.arguments.items():
            variable.ours = usable(name, lambda _: False)
        for name, definitions in self.properties.items():
            only = definitions[0] if len(definitions) == 1 and not definitions[0].when else None
            target = sole_name(tokens(only.value.text)) if only else None
            if target and target.startswith("arg ") and target[4:] in self.arguments:
                self.scope.names[name] = self.arguments[target[4:]]
                continue
            made = Variable(name, GLOBAL, usable(name, lambda one: one in taken), span=definitions[0].value.span)
            taken.add(made.ours)
            made.values += [definition.value for definition in definitions]
            self.scope.names[name] = made


def with_comments(element: Element) -> list[tuple[Element, tuple[str, ...]]]:
    """Return the elements in an element, each with the comments right above it."""
    found: list[tuple[Element, tuple[str, ...]]] = []
    waiting: list[str] = []
    for item in element.content:
        if isinstance(item, Element):
            found.append((item, tuple(waiting)))
            waiting = []
        elif isinstance(item, Remark) and item.kind == "comment":
            waiting.append(item.text)
    return found
