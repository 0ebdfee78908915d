"""Artifacts as they were and as they are: their leaves, under the names of the robot.

A new name of a link or a joint hides nothing else that changed: old leaves get the new names. Of the links that only
one of two artifacts has, those are the same that the joint of one name places, that the same frame is attached to, or
that are in the same place. A joint has a new name where it places the same link.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from rosorin_compile.formats import FORMATS, Artifact, Format
from rosorin_compile.model import Output, Pose, Robot

from .precision import Precision, printed, rounded
from .walk import Leaves, leaves

Names = Mapping[str, str]
_LINKS = ("frame", "link", "height map")


@dataclass(frozen=True)
class Pair:
    """One artifact: its output, and the leaves of the committed and of the compiled text.

    ``renamed`` are the new names by those of before, by the kind of thing ("link", "joint"): ``old`` has the new ones.
    """

    output: Output
    old: Leaves
    new: Leaves
    precisions: tuple[Precision, Precision]
    renamed: Mapping[str, Names] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The name of the output."""
        return self.output.name


def output_of(robot: Robot, artifact: Artifact) -> Output:
    """Return the output of a robot that an artifact was written for."""
    unnamed = Output(artifact.output, artifact.backend, artifact.file)
    return next((output for output in robot.outputs if output.name == artifact.output), unnamed)


def pair_of(robot: Robot, artifact: Artifact, committed: str) -> Pair | None:
    """Return an artifact as it was and as it is; None if its format does not read it back.

    Raises ValueError if the committed text is damaged.
    """
    format, output = FORMATS[artifact.backend], output_of(robot, artifact)
    if format.read is None:
        return None
    try:
        old = leaves(format.read(committed))
    except (ValueError, TypeError, OverflowError, RecursionError) as problem:
        raise ValueError(str(problem)) from None
    before, least = printed(committed), rounded(*format.rounding)
    known = lambda key, *values: max(least(key, *values), before(key, *values))  # noqa: E731
    if format.view is not None and not format.partial:
        new, precision = leaves(format.view(robot, output)), least
    else:
        new, precision = leaves(format.read(artifact.text)), printed(artifact.text)
    return Pair(output, *(under_names(format, output, side) for side in (old, new)), (known, precision))


def under_names(format: Format, output: Output, found: Leaves) -> Leaves:
    """Return leaves under the names that the robot has for links, where an artifact has others."""
    names = format.names(output) if format.names is not None else {}
    return _renamed(found, names, _LINKS, {}) if names else found


def with_new_names(pairs: Sequence[Pair]) -> list[Pair]:
    """Return artifacts with the new names of links and joints in what was."""
    links: dict[str, str] = {}
    for pair in pairs:
        links |= _new_link_names(pair.old, pair.new)
    return [_with_new_joints(_with_new_links(pair, links)) for pair in pairs]


def links_of(found: Leaves) -> set[str]:
    """Return the names of all links and frames in leaves, without rows of publishers that take turns."""
    names = {name for kind, name in found if kind in ("frame", "link")}
    return names | {str(of["parent"]) for (kind, _), of in found.items() if kind == "frame" and "parent" in of}


def _new_link_names(old: Leaves, new: Leaves) -> dict[str, str]:
    """Return the links with new names, from the root on."""
    before, after = links_of(old), links_of(new)
    gone, fresh = before - after, after - before
    found: dict[str, str] = {}
    again = bool(gone and fresh)
    while again:
        again = False
        for sign in ("joint", "child", "place"):
            was, now = _signs(old, gone, sign, found), _signs(new, fresh, sign, found)
            made = {link: now[key] for key, link in was.items() if key in now and link not in found}
            made = {link: name for link, name in made.items() if name not in found.values()}
            if made:
                found |= made
                again = True
                break
    return found


def _signs(side: Leaves, links: set[str], sign: str, renamed: Names) -> dict[tuple[Any, ...], str]:
    """Return links by what they are recognised by; what two of them share is left out."""
    found: dict[tuple[Any, ...], str] = {}
    shared = set()
    for link, value in _all_signs(side, links, sign):
        key = (renamed.get(value[0], value[0]), *value[1:])
        if found.setdefault(key, link) != link:
            shared.add(key)
    return {key: link for key, link in found.items() if key not in shared}


def _all_signs(side: Leaves, links: set[str], sign: str) -> Iterator[tuple[str, tuple[Any, ...]]]:
    for (kind, name), of in side.items():
        origin = of.get("origin")
        if sign == "joint" and kind == "joint" and of.get("child") in links:
            yield of["child"], (name,)
        elif sign == "child" and kind == "frame" and of.get("parent") in links:
            yield of["parent"], (name,)
        elif sign == "place" and kind == "frame" and name in links and isinstance(origin, Pose):
            yield name, (of.get("parent", ""), *(round(x, 9) for x in (*origin.xyz, *origin.rpy)))


def _with_new_links(pair: Pair, links: Names) -> Pair:
    gone, fresh = links_of(pair.old) - links_of(pair.new), links_of(pair.new) - links_of(pair.old)
    known = {old: new for old, new in links.items() if old in gone and new in fresh}
    if not known:
        return pair
    return replace(pair, old=_renamed(pair.old, known, _LINKS, pair.new), renamed={"link": known})


def _with_new_joints(pair: Pair) -> Pair:
    before, after = (
        {of["child"]: name for (kind, name), of in side.items() if kind == "joint" and "child" in of}
        for side in (pair.old, pair.new)
    )
    known = {name: after[child] for child, name in before.items() if after.get(child, name) != name}
    if not known:
        return pair
    old = _renamed(pair.old, known, ("joint",), pair.new)
    return replace(pair, old=old, renamed={**pair.renamed, "joint": known})


def _renamed(found: Leaves, names: Names, kinds: Sequence[str], new: Leaves) -> Leaves:
    """Return leaves under other names of some kinds of things.

    What else names them follows: a value where the new artifact has the new name, and a quantity with it.
    """
    made: Leaves = {}
    for (kind, name), entry in found.items():
        plain, space, rest = name.partition(" ")  # the row of a publisher that takes turns has more words
        if kind in kinds or (kind, name) not in new:
            name = f"{names[plain]}{space}{rest}" if plain in names else names.get(name, name)
        now = new.get((kind, name), {})
        own = made[kind, name] = {}
        for quantity, value in entry.items():
            words = " ".join(names.get(word, word) for word in quantity.split(" "))
            is_fixed = kind in ("frame", "joint") or quantity in now or words not in now
            own[quantity if is_fixed else words] = _value(kind, quantity, value, names, kinds, now.get(quantity))
    return made


def _value(kind: str, quantity: str, value: Any, names: Names, kinds: Sequence[str], now: Any) -> Any:
    if isinstance(value, frozenset):
        return frozenset(" - ".join(sorted(names.get(word, word) for word in one.split(" - "))) for one in value)
    if not isinstance(value, str):
        return value
    if "link" in kinds and quantity in ("parent", "child") and kind in ("frame", "joint"):
        return names.get(value, value)
    return now if isinstance(now, str) and names.get(value) == now else value
