"""Compare committed artifacts with those just compiled, explained by meaning first.

Each committed artifact is read back by its format, and compared with what it is meant to contain. What differs is told
once, with the outputs that show it. Shapes and masses may differ because something else does: an artifact that does not
carry every frame gives the shapes of a frame that it leaves out to a link that it carries. That there is no more to it
is shown by undoing the other changes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from rosorin_compile.formats import FORMATS, Artifact, Format
from rosorin_compile.formats.templating import TemplateProblem, Templates
from rosorin_compile.model import Robot
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import printable

from .change import MOVING, Change, Describer, attached, joint_of, order_of, sort_key
from .pairs import Pair, contents, links_of, pair_of, with_new_names
from .precision import NOISE, POSE_NOISE, Precision, exact
from .sentences import NEW, REMOVED, Sentence, brief, renamed
from .shape_sentences import NO_WORD, shapes_change
from .solids import Solid, delta, same_set
from .text_report import CHANGED, EXTRA, MISSING, NOT_TEXT, TextDifference, differing_values, report_lines, unified
from .undo import undo
from .walk import Address, Difference, Leaves, Shapes, compare_leaves

_MISSING = "missing; rosorin-compile all writes it"
_EXTRA = "no artifact of this robot; remove it, or run rosorin-compile all --prune"
_NOT_TEXT = "the committed file is no UTF-8 text; rosorin-compile all writes it anew"
_SAME_MEANING = "same meaning, different text"
_NOTHING_COMPARED = "different text; nothing that is compared by meaning differs"
_LARGEST_PICTURE = 200_000  # letters of a text that is not for people; the lines of a larger one are not shown at all
SHAPES = ("collision", "visual")
INERTIAL = ("mass", "centre of mass", "inertia")
# With more changes than these, each is taken for a cause of shapes that differ for another reason.
_MANY_CAUSES = 30


class Comparison(NamedTuple):
    """How committed artifacts differ from compiled ones: by meaning, and file by file; ``same`` if nothing differs.

    ``pairs`` are the artifacts that differ and can be read, as they were and as they are.
    """

    changes: tuple[Change, ...]
    texts: tuple[TextDifference, ...]
    same: bool
    pairs: tuple[Pair, ...] = ()

    def brief(self) -> str:
        """Return what changed, each once and without its numbers; of many the first ones."""
        return brief(change.text for change in self.changes)


def compare(
    robot: Robot, artifacts: Sequence[Artifact], committed: Mapping[str, bytes], templates: Templates | None = None
) -> Comparison:
    """Return how the committed files (bytes by name, see ``output.read_set``) differ from what was just compiled.

    ``templates`` are those of the description: without them, changes of outputs with some are not explained.
    """
    arranged = sorted(artifacts, key=lambda artifact: (FORMATS[artifact.backend].rank, artifact.output))
    texts: list[tuple[TextDifference, Artifact | None, str]] = []
    pairs: list[Pair] = []
    for number, artifact in enumerate(arranged):
        Progress.step(f"comparing {artifact.file},", number, len(arranged))
        old = _decoded(committed.get(artifact.file))
        if old is None:
            is_missing = artifact.file not in committed
            kind, remark = (MISSING, _MISSING) if is_missing else (NOT_TEXT, _NOT_TEXT)
            texts.append((TextDifference(artifact.file, kind, remark), None, ""))
        elif old != artifact.text:
            remark = ""
            try:
                pair = pair_of(robot, artifact, old)
                pairs += [pair] if pair is not None else []
            except ValueError as problem:
                remark = f"the committed file is damaged and compared as text alone ({printable(str(problem))})"
                remark = _with_values(remark, old, artifact.text)
            texts.append((_changed(artifact, old, remark), artifact, old))
    pairs = with_new_names(pairs)
    extra = sorted(committed.keys() - {artifact.file for artifact in artifacts})
    texts += [(TextDifference(file, EXTRA, _EXTRA), None, "") for file in extra]
    changes = tuple(_Changes(robot, pairs, templates).found()) if pairs else ()
    told = {output for change in changes for output in change.artifacts}
    remarked = sorted(_remarked(text, artifact, old, told) for text, artifact, old in texts)
    return Comparison(changes, tuple(remarked), not remarked, tuple(pairs))


def lines(comparison: Comparison, full: bool = False) -> list[str]:
    """Return a comparison as lines of plain text; diffs are shortened unless ``full``."""
    return report_lines(comparison.changes, comparison.texts, full)


def _decoded(data: bytes | None) -> str | None:
    """Return committed bytes as text; None if there are none, or if they are no UTF-8."""
    try:
        return None if data is None else data.decode("utf-8")
    except UnicodeDecodeError:
        return None


def _changed(artifact: Artifact, old: str, remark: str) -> TextDifference:
    shown = FORMATS[artifact.backend].shown
    large = not shown and max(len(old), len(artifact.text)) > _LARGEST_PICTURE
    return TextDifference(
        artifact.file, CHANGED, remark, () if large else unified(artifact.file, old, artifact.text), shown
    )


def _remarked(text: TextDifference, artifact: Artifact | None, old: str, told: set[str]) -> TextDifference:
    """Return a text difference with the remark that no change of meaning goes with it, where that is so."""
    if artifact is None or text.remark or artifact.output in told:
        return text
    format = FORMATS[artifact.backend]
    differ = format.differ(old, artifact.text) if format.differ is not None else ""
    if not differ and format.read is None:
        return text
    if not differ:
        same = same_syntax(format, old, artifact.text)
        differ = _SAME_MEANING if same else _with_values(_NOTHING_COMPARED, old, artifact.text)
    return text._replace(remark=differ)


def _with_values(remark: str, old: str, new: str) -> str:
    values = differing_values(old, new)
    return f"{remark}: {values}" if values else remark


def same_syntax(format: Format, old: str, new: str) -> bool:
    """Return True if two texts of a format differ in white space, comments and the spelling of numbers alone."""
    if format.syntax is None:
        return False
    try:
        return bool(format.syntax(old) == format.syntax(new))
    except (ValueError, SyntaxError):
        return False


@dataclass
class _Own:
    """What is found of one pair: its differences that are told of their leaf, and those of shapes and masses."""

    pair: Pair
    told: list[Difference] = field(default_factory=list)
    derived: dict[tuple[str, str], list[Difference]] = field(default_factory=dict)


class _Changes:
    """Finds the changes of all pairs, each once, with the outputs that show it."""

    def __init__(self, robot: Robot, pairs: Sequence[Pair], templates: Templates | None) -> None:
        self.robot = robot
        self.templates = templates
        self.pairs = pairs
        self.changes: list[Change] = []
        self.order = {pair.name: index for index, pair in enumerate(pairs)}

    def found(self) -> list[Change]:
        """Return the changes, sorted: by link from the root on, then servos, poses and the rest."""
        owned = [self._own(pair) for pair in self.pairs]
        for kind, old, new in dict.fromkeys(
            (kind, old, new)
            for pair in self.pairs
            for kind, names in pair.renamed.items()
            for old, new in names.items()
        ):
            outputs = tuple(pair.name for pair in self.pairs if old in pair.renamed.get(kind, {}))
            self.changes.append(Change(kind, new, "", *renamed(kind, old, new), outputs))
        self._told(owned)
        self._derived(owned)
        place = order_of(self.robot)
        made = [
            change._replace(artifacts=tuple(sorted(dict.fromkeys(change.artifacts), key=self.order.__getitem__)))
            for change in self.changes
        ]
        return sorted(made, key=lambda change: sort_key(self.robot, place, change))

    def _own(self, pair: Pair) -> _Own:
        own = _Own(pair)
        for one in _without_hidden(pair, compare_leaves(pair.old, pair.new, pair.precisions)):
            kind, name, quantity = one.address
            if kind == "link" and quantity in SHAPES:
                own.derived[name, quantity] = [one]
            elif kind == "link" and quantity in INERTIAL and None not in (one.old, one.new):
                own.derived.setdefault((name, "mass"), []).append(one)
            else:
                own.told.append(one)
        return own

    def _told(self, owned: Sequence[_Own]) -> None:
        """Add the changes of leaves, those that mean the same in several artifacts once."""
        clusters: dict[Address, list[list[tuple[Pair, Difference, Sentence]]]] = {}
        for own in owned:
            describer = Describer(self.robot, (own.pair.old, own.pair.new), own.pair.precisions)
            for one, sentence in describer.describe(own.told):
                groups = clusters.setdefault(one.address, [])
                for group in groups:
                    if _same_change(group[0][0], group[0][1], own.pair, one):
                        group.append((own.pair, one, sentence))
                        break
                else:
                    groups.append([(own.pair, one, sentence)])
        for groups in clusters.values():
            for group in groups:
                _, one, sentence = group[0]
                outputs = tuple(pair.name for pair, _, _ in group)
                kind, name, quantity = one.address
                if not quantity and kind in ("frame", "link"):
                    word = NEW if one.old is None else REMOVED
                    every = [pair.new if word == NEW else pair.old for pair in self.pairs]
                    sentence = attached(self.robot, name, word, every)
                found = tuple(difference for _, difference, _ in group)
                self.changes.append(Change(kind, name, quantity, *sentence, outputs, (), found))

    def _derived(self, owned: Sequence[_Own]) -> None:
        """Add the changes of shapes and masses, those that follow from others under these."""
        if not any(own.derived for own in owned):
            return
        undone = undo_all(self.robot, [own.pair for own in owned], [own.told for own in owned])
        # An artifact that has every frame tells of each link alone.
        for own in sorted(owned, key=lambda own: -len(links_of(own.pair.new))):
            before = self._contents(undone, own.pair)
            for (link, quantity), differences in own.derived.items():
                if before is None or not self._follows(own.pair, link, differences, before):
                    undone = self._add(own.pair, link, quantity, differences, before, undone)
                    before = self._contents(undone, own.pair)
                else:
                    self._attach(own.pair, link, quantity)

    def _contents(self, robot: Robot, pair: Pair) -> Leaves | None:
        try:
            return contents(robot, pair.output, self.templates)
        except (ValueError, KeyError, TypeError, StopIteration, TemplateProblem):  # what is undone may be no robot
            return None

    def _follows(self, pair: Pair, link: str, differences: Sequence[Difference], before: Leaves) -> bool:
        """Return True if the old leaves are what the artifact is meant to contain with the other changes undone."""
        entry = before.get(("link", link), {})
        first: Leaves = {("link", link): {one.address.quantity: one.old for one in differences if one.old is not None}}
        meant = {one.address.quantity: entry.get(one.address.quantity) for one in differences}
        second: Leaves = {("link", link): {key: value for key, value in meant.items() if value is not None}}
        return not compare_leaves(first, second, pair.precisions, POSE_NOISE)

    def _add(
        self,
        pair: Pair,
        link: str,
        quantity: str,
        differences: Sequence[Difference],
        before: Leaves | None,
        undone: Robot,
    ) -> Robot:
        """Add what changed of a link itself, and return the robot with it undone."""
        if quantity == "mass":
            describer = Describer(self.robot, (pair.old, pair.new), pair.precisions)
            for one, sentence in describer.describe(differences):
                self._merge(Change("link", link, one.address.quantity, *sentence, (pair.name,), (), (one,)))
            return undo(undone, [(one, pair.old) for one in differences])
        (one,) = differences
        meant = one.new if before is None else before.get(("link", link), {}).get(quantity)
        old, now = (_solids(s, p) for s, p in zip((one.old, one.new), pair.precisions, strict=True))
        expected = _solids(meant, pair.precisions[1])
        if _size(old, expected) >= _size(old, now):
            meant, expected = one.new, now
        elif not same_set(expected, now):
            self._attach(pair, link, quantity)
        told = shapes_change(link, quantity, (len(old), len(expected)), delta(old, expected))
        for sentence in (*told.numbers, *told.words):
            self._merge(Change("link", link, f"{quantity} shapes", *sentence, (pair.name,), (), (one,)))
        return undo(undone, [(Difference(one.address, one.old, meant), pair.old)])

    def _merge(self, change: Change) -> None:
        """Add a change, or its artifact to the same change; an artifact may have had no word before."""
        for at, other in enumerate(self.changes):
            same = other[:3] == change[:3] and other.row.after == change.row.after
            before = {other.row.before, change.row.before}
            if (
                same
                and (len(before) == 1 or NO_WORD in before)
                and other.text.partition(":")[0] == change.text.partition(":")[0]
            ):
                self.changes[at] = other._replace(artifacts=(*other.artifacts, *change.artifacts))
                return
        self.changes.append(change)

    def _attach(self, pair: Pair, link: str, quantity: str) -> None:
        """List an artifact with the changes that its shapes or its mass of a link follow from."""
        key = ("link", link)
        causes = [
            at
            for at, change in enumerate(self.changes)
            if change.differences and self._is_cause(change, pair, key, quantity)
        ]
        for at in causes:
            change = self.changes[at]
            own = change[:2] == key or quantity == "mass"
            therefore = change.therefore if own else (*change.therefore, link)
            self.changes[at] = change._replace(
                artifacts=(*change.artifacts, pair.name), therefore=tuple(dict.fromkeys(therefore))
            )

    def _is_cause(self, change: Change, pair: Pair, key: tuple[str, str], quantity: str) -> bool:
        if len(self.changes) > _MANY_CAUSES:
            return change.kind == "frame" or change[:2] == key
        own = self._sides(change)
        undone = self._contents(undo(self.robot, own), pair)
        words = INERTIAL if quantity == "mass" else (quantity,)
        if undone is None:
            return False
        sides = ({key: {w: e[w] for w in words if w in (e := side.get(key, {}))}} for side in (undone, pair.new))
        first, second = sides
        return bool(compare_leaves(first, second, (exact, pair.precisions[1]), POSE_NOISE))

    def _sides(self, change: Change) -> list[tuple[Difference, Leaves]]:
        old = {pair.name: pair.old for pair in self.pairs}
        return [(one, old[name]) for one, name in zip(change.differences, change.artifacts, strict=False)]


def _size(old: Sequence[Solid], new: Sequence[Solid]) -> tuple[int, int]:
    """Return in how many solids two sets differ, without looks and names, and with them."""
    bare = delta([one.bare for one in old], [one.bare for one in new])
    whole = delta(old, new)
    return len(bare.removed) + len(bare.added), len(whole.removed) + len(whole.added)


def _solids(side: Any, precision: Precision) -> list[Solid]:
    return side.solids(precision) if isinstance(side, Shapes) else []


def _same_change(pair: Pair, one: Difference, other_pair: Pair, other: Difference) -> bool:
    """Return True if two artifacts mean the same by a difference at one address."""
    if not one.address.quantity and not isinstance(one.old or one.new, frozenset):
        return (one.old is None) == (other.old is None)
    for side in (0, 1):
        values = (one[1 + side], other[1 + side])
        entries = [{} if value is None else {one.address.quantity: value} for value in values]
        thing = one.address[:2]
        known = (pair.precisions[side], other_pair.precisions[side])
        if compare_leaves({thing: entries[0]}, {thing: entries[1]}, known, NOISE):
            return False
    return True


def _without_hidden(pair: Pair, differences: Sequence[Difference]) -> Iterator[Difference]:
    """Yield the differences that are no consequence of things that are new or gone, or move now and did not."""
    before, after = links_of(pair.old), links_of(pair.new)
    changed = {one.address.name: one for one in differences if one.address.kind == "frame" and not one.address.quantity}
    came = {name for name in before ^ after if " " not in name} | set(changed)
    joints = {joint_of(side, name) for side in (pair.old, pair.new) for name in came} - {""}
    retyped = set()
    for one in differences:
        kind, name, quantity = one.address
        if kind == "joint" and (not quantity or quantity == "type"):
            types = [
                side.get("type") if isinstance(side, dict) else side if quantity else "fixed"
                for side in (one.old, one.new)
            ]
            if (types[0] in MOVING) != (types[1] in MOVING) and name not in joints:
                retyped.add(name)
                yield Difference(Address(kind, name, "type"), types[0] or "fixed", types[1] or "fixed")
    for one in differences:
        kind, name, quantity = one.address
        if kind == "frame" and name in changed and quantity:
            continue
        if kind == "joint" and (name in joints or name in retyped or not quantity):
            continue
        if kind in ("link", "height map") and (name in changed or (name in came and quantity)):
            continue
        if kind == "link" and not quantity and name in (before & after):
            yield from _entries(one)
            continue
        if kind == "pose" and (quantity in joints or quantity in retyped):
            continue
        if isinstance(one.old, frozenset) or isinstance(one.new, frozenset):
            sets = [frozenset(m for m in side or () if came.isdisjoint(_members(m))) for side in (one.old, one.new)]
            if sets[0] != sets[1]:
                yield Difference(one.address, *sets)
            continue
        yield one


def _entries(one: Difference) -> Iterator[Difference]:
    """Yield the leaves of a link that says something now, and did not, or the other way round."""
    kind, name, _ = one.address
    for quantity, value in (one.old or one.new).items():
        yield Difference(Address(kind, name, quantity), *((value, None) if one.new is None else (None, value)))


def _members(text: str) -> set[str]:
    return set(text.partition(" (")[0].split(" - "))


def undo_all(robot: Robot, pairs: Sequence[Pair], told: Sequence[Sequence[Difference]] = ()) -> Robot:
    """Return the robot that artifacts tell of, as they were; with ``told``, with these differences undone alone.

    What is new in an artifact, and was in another one before, is not new.
    """
    known = {name for pair in pairs for name in links_of(pair.old)}
    found: list[tuple[Difference, Leaves]] = []
    for at in sorted(range(len(pairs)), key=lambda at: -len(pairs[at].old)):
        pair = pairs[at]
        differences = told[at] if told else compare_leaves(pair.old, pair.new, pair.precisions)
        for one in differences:
            kind, name, quantity = one.address
            fresh = one.old is None and not quantity and kind in ("frame", "link")
            if not fresh or name not in known:
                found.append((one, pair.old))
    return undo(robot, found)
