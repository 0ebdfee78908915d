"""Editing: what a newer source changes, written into a file that somebody has worked on.

The text is edited where the values stand; what is not changed stays to the letter, with its comments, order and layout.
Afterwards it is read again: it has to say what was to come out, and no comment may be lost that the importer did not
write. Otherwise it is not edited at all.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import yaml

from rosorin_compile.diagnostics import Source
from rosorin_compile.extending import LoadError, Path, Scalar, parse_yaml

from .three_way import MISSING, OURS, Change, same

_COMMENT = re.compile(r"(?:^|(?<=\s))#[^\n]*", re.M)


class CannotEdit(Exception):
    """A text cannot be changed safely; the message says why."""


class _Edit(NamedTuple):
    """A piece of a text, from ``start`` to before ``end``, and what stands there instead."""

    start: int
    end: int
    text: str


def edited(base: str, ours: str, theirs: str, changes: Sequence[Change], wanted: Any) -> str:
    """Return our text with some changes of the newer one, after which it says ``wanted``. Raises CannotEdit."""
    plain = ours.replace("\r\n", "\n")
    try:
        editing = _Editing(_Text(base), _Text(plain), _Text(theirs))
        edits = list(editing.all_of(changes))
    except (yaml.YAMLError, LookupError, TypeError, ValueError, AttributeError):
        raise CannotEdit("it is written in a way that cannot be edited safely") from None
    text, end = plain, len(plain) + 1
    edits.reverse()  # of two at one place the first one stands first: from the end on it is made last
    for edit in sorted(edits, key=lambda one: (one.start, one.end), reverse=True):
        if edit.end > end:
            raise CannotEdit("what changes stands on one line with something else that does")
        text, end = text[: edit.start] + edit.text + text[edit.end :], edit.start
    _check(base, plain, text, wanted)
    return text.replace("\n", "\r\n") if "\r\n" in ours else text


def _check(base: str, ours: str, text: str, wanted: Any) -> None:
    """Raise CannotEdit unless a text says what is wanted and has every comment that somebody wrote into ours."""
    try:
        made = parse_yaml(Source("", text))
    except LoadError:
        raise CannotEdit("it is written in a way that cannot be edited safely, such as with anchors") from None
    if not same(made, wanted):
        raise CannotEdit("it is written in a way that cannot be edited safely, such as with anchors")
    left = list(comments(text))
    for comment in comments(ours):
        if comment in left:
            left.remove(comment)
        elif comment not in base:
            raise CannotEdit(f'the comment "{comment}" stands in what the newer source has otherwise')


def comments(text: str) -> Iterator[str]:
    """Yield the comments of a YAML text. Raises yaml.YAMLError."""
    letters = list(text)
    for token in yaml.scan(text, Loader=_LOADER):
        if isinstance(token, yaml.ScalarToken):
            place = range(token.start_mark.index, token.end_mark.index)
            if token.style in ("|", ">"):  # its first line may end in a comment
                place = range(text.find("\n", place.start) % (len(text) + 1), place.stop)
            for index in place:
                letters[index] = "\n" if letters[index] == "\n" else "x"
    for found in _COMMENT.finditer("".join(letters)):
        yield found[0].rstrip()


_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Text:
    """A text, and where in it each value stands."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.root = yaml.compose(text, Loader=_LOADER)

    def holder(self, path: Path) -> yaml.CollectionNode:
        """Return the collection that holds a path."""
        node: Any = self.root
        for step in path[:-1]:
            node = self.entry(node, step)[1]
        if not isinstance(node, yaml.CollectionNode):
            raise LookupError(path)
        return node

    def entry(self, node: Any, step: str | int) -> tuple[Any, Any]:
        """Return the nodes of a key and its value; of an item, twice that of the item."""
        if isinstance(step, int):
            return node.value[step], node.value[step]
        return next(pair for pair in node.value if pair[0].value == step)  # type: ignore[no-any-return]

    def end(self, node: Any) -> int:
        """Return where a value ends; a block ends with its last value, not with what follows it."""
        while isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
            last = node.value[-1]
            node = last[1] if isinstance(last, tuple) else last
        begin, end = int(node.start_mark.index), int(node.end_mark.index)
        return begin + len(self.text[begin:end].rstrip())

    def line_begin(self, place: int) -> int:
        return self.text.rfind("\n", 0, place) + 1

    def line_end(self, place: int) -> int:
        """Return the end of a line; a comment behind the last value belongs to it."""
        end = self.text.find("\n", place)
        return len(self.text) if end < 0 else end

    def column(self, place: int) -> int:
        return place - self.line_begin(place)

    def above(self, place: int) -> int:
        """Return where the comment begins that stands right above a line."""
        begin = self.line_begin(place)
        while begin and self.text[self.line_begin(begin - 1) : begin].lstrip().startswith("#"):
            begin = self.line_begin(begin - 1)
        return begin

    def is_first(self, place: int) -> bool:
        """Say whether nothing stands before a place in its line."""
        return not self.text[self.line_begin(place) : place].strip()


class _Editing:
    """Makes edits of our text from the newer one."""

    def __init__(self, base: _Text, ours: _Text, theirs: _Text) -> None:
        self.base, self.ours, self.theirs = base, ours, theirs
        self.changes: dict[Path, Change] = {}

    def all_of(self, changes: Sequence[Change]) -> Iterator[_Edit]:
        """Yield what changes do to our text; a mapping in brackets that gets or loses an entry is written anew."""
        self.changes = {change.path: change for change in changes}
        anew = {self.bracket(one.path) for one in changes if one.old is MISSING or one.new is MISSING} - {None}
        for path in anew:
            node = _at(self.ours, path or ())
            yield _Edit(node.start_mark.index, self.ours.end(node), self.rewritten(node, path or ()))
        for change in changes:
            if self.bracket(change.path) not in anew:
                yield from self.edits(change)

    def bracket(self, path: Path) -> Path | None:
        """Return the path of the outermost value in brackets that holds what stands at a path; None if none does."""
        node: Any = self.ours.root
        for depth, step in enumerate(path):
            if getattr(node, "flow_style", False):
                return path[:depth]
            if depth < len(path) - 1:
                node = self.ours.entry(node, step)[1]
        return None

    def rewritten(self, node: Any, path: Path) -> str:
        """Return a value in brackets as it is with the changes in it."""
        change = self.changes.get(path)
        if change is not None and change.items is not None:
            return self.woven(path, change.items).text
        if change is not None:
            return _flow(_at(self.theirs, path), self.theirs)
        inside = [one for one in self.changes.values() if one.path[: len(path)] == path]
        if not inside:
            return _slice(self.ours, node, node, 0)
        if isinstance(node, yaml.SequenceNode):
            return f"[{', '.join(self.rewritten(item, (*path, number)) for number, item in enumerate(node.value))}]"
        texts = [
            f"{_flow(key, self.ours)}: {self.rewritten(value, (*path, key.value))}"
            for key, value in node.value
            if self.stays((*path, key.value))
        ]
        for one in inside:
            if one.old is MISSING and len(one.path) == len(path) + 1:
                key, value = self.theirs.entry(self.theirs.holder(one.path), one.path[-1])
                texts.append(f"{_flow(key, self.theirs)}: {_flow(value, self.theirs)}")
        return f"{{{', '.join(texts)}}}"

    def edits(self, change: Change) -> Iterator[_Edit]:
        """Yield what a change does to our text."""
        if change.items is not None:
            yield self.woven(change.path, change.items)
        elif not change.path:
            raise LookupError("a whole file is replaced as one")
        elif change.old is MISSING:
            yield self.added(change.path)
        elif change.new is MISSING:
            yield self.removed(change.path)
        else:
            yield self.replaced(change.path)

    def replaced(self, path: Path) -> _Edit:
        """Return the edit that puts the newer value of an entry in the place of the old one."""
        ours, theirs = self.ours, self.theirs
        holder = ours.holder(path)
        key, old = ours.entry(holder, path[-1])
        new_key, new = theirs.entry(theirs.holder(path), path[-1])
        if holder.flow_style:
            return _Edit(old.start_mark.index, ours.end(old), _flow(new, theirs))
        if isinstance(path[-1], int) or not (_is_block(old) or _is_block(new)):
            begin, shift = old.start_mark.index, key.start_mark.column - new_key.start_mark.column
            if begin == ours.end(old):  # nothing stands there
                return _Edit(ours.end(key) + 1, ours.end(key) + 1, f" {_slice(theirs, new, new, shift)}")
            return _Edit(begin, ours.end(old), _slice(theirs, new, new, shift))
        shift = key.start_mark.column - new_key.start_mark.column
        return _Edit(key.start_mark.index, max(ours.end(old), ours.end(key) + 1), _slice(theirs, new_key, new, shift))

    def removed(self, path: Path) -> _Edit:
        """Return the edit that removes an entry, with the comment above it where the importer wrote that."""
        ours, holder = self.ours, self.ours.holder(path)
        key, value = ours.entry(holder, path[-1])
        number = next(place for place, pair in enumerate(holder.value) if pair[0] is key)
        begin, end = key.start_mark.index, max(ours.end(value), ours.end(key) + 1)
        following = holder.value[number + 1][0].start_mark.index if number + 1 < len(holder.value) else None
        if following is not None and not ours.is_first(begin):  # the first one of an item of a list
            return _Edit(begin, following, "")
        begin, end = self.comment(begin), min(ours.line_end(end) + 1, len(ours.text))
        if ours.text[:begin].endswith("\n\n") and ours.text[end : end + 1] in ("\n", ""):
            begin -= 1  # of the empty lines around it one stays
        return _Edit(begin, end, "")

    def comment(self, place: int) -> int:
        """Return where the comment above a line begins, as far as the importer wrote it."""
        begin, top = self.ours.line_begin(place), self.ours.above(place)
        while begin > top:
            line = self.ours.line_begin(begin - 1)
            if self.ours.text[line:begin].strip() not in self.base.text:
                break
            begin = line
        return begin

    def added(self, path: Path) -> _Edit:
        """Return the edit that adds an entry, behind the one that it stands behind in the newer text."""
        ours, theirs = self.ours, self.theirs
        holder, other = ours.holder(path), theirs.holder(path)
        new_key, new = theirs.entry(other, path[-1])
        names = [pair[0].value for pair in other.value]
        stays = {pair[0].value: pair for pair in holder.value if self.stays((*path[:-1], pair[0].value))}
        before = [name for name in names[: names.index(path[-1])] if name in stays]
        column = holder.value[0][0].start_mark.column
        text = _entry(theirs, new_key, new, column, other.flow_style)
        apart = "\n" * (not other.flow_style and theirs.text[: theirs.above(new_key.start_mark.index)].endswith("\n\n"))
        first = next(iter(stays.values()), None)
        if not before and first and ours.is_first(first[0].start_mark.index):
            place = ours.above(first[0].start_mark.index)
            return _Edit(place, place, f"{text}\n{apart}")
        key, value = stays[before[-1]] if before else holder.value[-1]
        place = ours.line_end(max(ours.end(value), ours.end(key) + 1))
        if place == len(ours.text):
            return _Edit(place, place, f"\n{apart}{text}")
        return _Edit(place + 1, place + 1, f"{apart}{text}\n")

    def stays(self, path: Path) -> bool:
        """Say whether an entry of ours is there in the end."""
        return path not in self.changes or self.changes[path].new is not MISSING

    def woven(self, path: Path, items: Sequence[tuple[str, int]]) -> _Edit:
        """Return the edit that writes a list anew, each of its items as it stands on its side."""
        sides = [self.ours if side == OURS else self.theirs for side, _ in items]
        lists = {id(one): _at(one, path) for one in sides}
        nodes = [lists[id(side)].value[number] for side, (_, number) in zip(sides, items, strict=True)]
        there = _at(self.ours, path)
        if there.flow_style:
            texts = [_flow(node, side) for node, side in zip(nodes, sides, strict=True)]
            return _Edit(there.start_mark.index, self.ours.end(there), f"[{', '.join(texts)}]")
        column = there.start_mark.column
        lines = "\n".join(_item(side, node, column) for side, node in zip(sides, nodes, strict=True))
        begin = self.ours.above(there.start_mark.index)
        return _Edit(begin, self.ours.line_end(self.ours.end(there)), lines)


def _at(text: _Text, path: Path) -> Any:
    return text.entry(text.holder(path), path[-1])[1] if path else text.root


def _is_block(node: Any) -> bool:
    return isinstance(node, yaml.CollectionNode) and not node.flow_style


def _slice(text: _Text, begin: Any, end: Any, shift: int) -> str:
    """Return a piece of a text, its lines but the first moved to the right by ``shift``."""
    return _moved(text.text[begin.start_mark.index : text.end(end)], shift)


def _moved(text: str, shift: int) -> str:
    first, *rest = text.split("\n")
    if shift >= 0:
        return "\n".join([first, *(f"{' ' * shift}{line}" if line.strip() else line for line in rest)])
    return "\n".join([first, *(line[min(-shift, len(line) - len(line.lstrip(" "))) :] for line in rest)])


def _entry(text: _Text, key: Any, value: Any, column: int, in_flow: bool) -> str:
    """Return the lines of an entry of a block, with the comment above it."""
    shift = column - key.start_mark.column
    begin = key.start_mark.index
    said = [] if in_flow else text.text[text.above(begin) : text.line_begin(begin)].splitlines()
    end = text.end(value)
    behind = "" if in_flow else _behind(text, max(end, text.end(key) + 1))
    empty = ":" if end <= text.end(key) else ""
    body = _moved(text.text[begin : max(end, text.end(key))], shift) + empty + behind
    return "\n".join([*(" " * column + line.strip() for line in said), " " * column + body])


def _behind(text: _Text, place: int) -> str:
    """Return the comment that stands behind a value on its line, with the space before it."""
    rest = text.text[place : text.line_end(place)]
    return rest.rstrip() if rest.lstrip().startswith("#") else ""


def _item(text: _Text, node: Any, column: int) -> str:
    """Return the lines of an item of a list in a block, with its comments."""
    begin, end = node.start_mark.index, text.end(node)
    dash = text.text.rfind("-", 0, begin)
    in_block = text.is_first(dash)
    said = text.text[text.above(dash) : text.line_begin(dash)].splitlines() if in_block else []
    behind = _behind(text, end) if in_block else ""
    body = _moved(text.text[begin:end], column + 2 - node.start_mark.column)
    return "\n".join([*(" " * column + line.strip() for line in said), f"{' ' * column}- {body}{behind}"])


def _flow(node: Any, text: _Text) -> str:
    """Return a value as it stands inside brackets, on one line."""
    if isinstance(node, yaml.MappingNode):
        return f"{{{', '.join(f'{_flow(key, text)}: {_flow(value, text)}' for key, value in node.value)}}}"
    if isinstance(node, yaml.SequenceNode):
        return f"[{', '.join(_flow(item, text) for item in node.value)}]"
    written = text.text[node.start_mark.index : text.end(node)]
    if node.style is None:
        return Scalar(node.value).quoted() if re.search(r"[\[\]{},\n]", written) else written or "null"
    return written if node.style in "\"'" and "\n" not in written else Scalar(node.value).quoted()
