"""Artifacts as they were and as they are: their leaves under the names of the robot.

A new name of a link or a joint hides nothing else that changed: old leaves get the new names. Of the links that only
one of two artifacts has, those are the same that the joint of one name places, that the same frame is attached to, or
that are in the same place. A joint has a new name where it places the same link.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from rosorin_compile.formats import FORMATS, Artifact, Format
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Pose, Robot

from .precision import Precision, printed, rounded
from .walk import Leaves, leaves

Names = Mapping[str, str]


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
        old = under_names(format, output, leaves(format.read(committed)))
    except (ValueError, TypeError, OverflowError, RecursionError) as problem:
        raise ValueError(str(problem)) from None
    before = _at_least(printed(committed), rounded(*format.rounding))
    if format.view is not None and not format.partial:
        return Pair(output, old, contents(robot, output), (before, rounded(*format.rounding)))
    new = under_names(format, output, leaves(format.read(artifact.text)))
    return Pair(output, old, new, (before, printed(artifact.text)))


def _at_least(precision: Precision, least: Precision) -> Precision:
    return lambda key, *values: max(least(key, *values), precision(key, *values))


def contents(robot: Robot, output: Output, templates: Templates | None = None) -> Leaves:
    """Return the leaves that an output of a robot is meant to contain, under the names of the robot.

    ``templates`` are those of the description. Raises TemplateProblem if one is missing.
    """
    format = FORMATS[output.backend]
    if format.view is not None and not format.partial:
        value = format.view(robot, output)
    else:
        value = format.read(format.written(robot, output, templates or Templates())[0])  # type: ignore[misc]
    return under_names(format, output, leaves(value))


def under_names(format: Format, output: Output, found: Leaves) -> Leaves:
    """Return leaves under the names that the robot has for links, where an artifact has others."""
    names = format.proving.names(output) if format.proving.names is not None else {}
    return _renamed(found, names, ("frame", "link", "height map"), {}) if names else found


def with_new_names(pairs: Sequence[Pair]) -> list[Pair]:
    """Return artifacts with the new names of links and joints in what was."""
    links: dict[str, str] = {}
    for pair in pairs:
        links |= new_link_names(pair.old, pair.new)
    return [_joints_renamed(_links_renamed(pair, links)) for pair in pairs]


def links_of(found: Leaves) -> set[str]:
    """Return the names of all links and frames in leaves, without rows of publishers that take turns."""
    names = {name for kind, name in found if kind in ("frame", "link")}
    return names | {str(of["parent"]) for (kind, _), of in found.items() if kind == "frame" and "parent" in of}


def new_link_names(old: Leaves, new: Leaves) -> dict[str, str]:
    """Return the links with new names, from the root on."""
    before, after = links_of(old), links_of(new)
    gone, fresh = before - after, after - before
    if not gone or not fresh:
        return {}
    signs = [sorted(_signs(side, links), key=repr) for side, links in ((old, gone), (new, fresh))]
    found: dict[str, str] = {}
    again = True
    while again:
        again = False
        for sign in ("joint", "child", "place"):
            was, now = (_by_sign(some, sign, found) for some in signs)
            made = {link: now[key] for key, link in was.items() if key in now and link not in found}
            made = {link: name for link, name in made.items() if name not in found.values()}
            if made:
                found |= made
                again = True
                break
    return found


Sign = tuple[str, str, tuple[Any, ...]]


def _signs(side: Leaves, links: set[str]) -> Iterator[Sign]:
    """Yield what links are known by: their joint, what is attached to them, and where they are."""
    for (kind, name), of in side.items():
        if kind == "joint" and of.get("child") in links:
            yield "joint", of["child"], (name,)
        if kind == "frame" and of.get("parent") in links:
            yield "child", of["parent"], (name,)
        origin = of.get("origin")
        if kind == "frame" and name in links and isinstance(origin, Pose):
            yield "place", name, (of.get("parent", ""), *(round(x, 9) for x in (*origin.xyz, *origin.rpy)))


def _by_sign(signs: Sequence[Sign], kind: str, known: Names) -> dict[tuple[Any, ...], str]:
    """Return links by what they are known by, under the names that are known; what two share is no sign."""
    found: dict[tuple[Any, ...], str] = {}
    twice = set()
    for sign, link, value in signs:
        if sign == kind:
            key = (known.get(value[0], value[0]), *value[1:])
            twice |= {key} if found.setdefault(key, link) != link else set()
    return {key: link for key, link in found.items() if key not in twice}


def _links_renamed(pair: Pair, links: Names) -> Pair:
    before, after = links_of(pair.old), links_of(pair.new)
    known = {
        old: new
        for old, new in links.items()
        if old in before and new in after and old not in after and new not in before
    }
    if not known:
        return pair
    old = _renamed(pair.old, known, ("frame", "link", "height map"), pair.new)
    return replace(pair, old=old, renamed={"link": known})


def _joints_renamed(pair: Pair) -> Pair:
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
        name = _name(name, names) if kind in kinds or (kind, name) not in new else name
        now = new.get((kind, name), {})
        made[kind, name] = {
            _quantity(kind, quantity, names, now): _value(kind, quantity, value, names, kinds, now.get(quantity))
            for quantity, value in entry.items()
        }
    return made


def _name(name: str, names: Names) -> str:
    """Return a name, or the row of a publisher that takes turns, under a new name."""
    plain, space, rest = name.partition(" ")
    return f"{names[plain]}{space}{rest}" if plain in names else names.get(name, name)


def _quantity(kind: str, quantity: str, names: Names, now: Mapping[str, Any]) -> str:
    if kind in ("frame", "joint") or quantity in now:
        return quantity
    words = [names.get(word, word) for word in quantity.split(" ")]
    other = " ".join(words)
    return other if other in now else quantity


def _value(kind: str, quantity: str, value: Any, names: Names, kinds: Sequence[str], now: Any) -> Any:
    if isinstance(value, frozenset):
        return frozenset(" - ".join(sorted(names.get(word, word) for word in one.split(" - "))) for one in value)
    if not isinstance(value, str):
        return value
    if "link" in kinds and quantity in ("parent", "child") and kind in ("frame", "joint"):
        return names.get(value, value)
    return now if isinstance(now, str) and names.get(value) == now else value
