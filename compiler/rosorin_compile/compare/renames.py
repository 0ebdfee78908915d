"""Renames: committed artifacts under the names of now, so that a new name hides nothing else that changed.

Of the links that are in one of two artifacts alone those are one that the joint of one name places, that the same
frame hangs on, or that sit in the same place. A joint has a new name where the same link hangs on it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rosorin_compile.formats import Fact, Value
from rosorin_compile.formats.facts import AXES

from .entities import Pair, joints_by_child
from .view import View

_OF_LINKS = ("frame", "link", "height map")
Names = Mapping[str, str]  # of now, by those of before


def under_new_names(pairs: Sequence[Pair]) -> list[Pair]:
    """Return artifacts with what was under the names of now; each knows which names are new."""
    links: dict[str, str] = {}
    for pair in pairs:
        links |= _links(pair)
    return [_joints_renamed(_links_renamed(pair, links)) for pair in pairs]


def _links(pair: Pair) -> dict[str, str]:
    """Return the links of an artifact with new names, from the root on."""
    gone, fresh = pair.old.names - pair.new.names, pair.new.names - pair.old.names
    signs = _signs(pair.old, gone), _signs(pair.new, fresh)
    found: dict[str, str] = {}
    again = bool(gone and fresh)
    while again:
        again = False
        for sign in ("joint", "child", "place"):
            was, now = (_by_sign(some, sign, found) for some in signs)
            made = {old: now[key] for key, old in was.items() if key in now and old not in found}
            made = {old: new for old, new in made.items() if new not in found.values()}
            if made:
                found |= made
                again = True
                break
    return found


Sign = tuple[object, ...]


def _signs(view: View, links: frozenset[str]) -> list[tuple[str, str, Sign]]:
    """Return what links are known by: their joint, what hangs on them, and where they sit."""
    joints = joints_by_child(view)
    found: list[tuple[str, str, Sign]] = [("joint", link, (joints[link],)) for link in links if joints.get(link)]
    found += [("child", parent, (child,)) for child, parent in view.parents().items() if parent in links]
    for link in links:
        turn = view.turns.get(link)
        xyz = [view.plain.get(Fact("frame", link, f"origin {axis}")) for axis in AXES]
        if view.parent(link) and None not in xyz:
            place = (*(value.value for value in xyz if value is not None), *(turn.rpy if turn else ()))
            found.append(("place", link, (view.parent(link), place)))
    return sorted(found, key=repr)


def _by_sign(signs: Sequence[tuple[str, str, Sign]], kind: str, known: Names) -> dict[Sign, str]:
    """Return links by what they are known by, under the names that are known; what two share is no sign."""
    found: dict[Sign, str] = {}
    twice = set()
    for sign, link, value in signs:
        if sign == kind:
            key = (known.get(str(value[0]), value[0]), *value[1:])
            twice |= {key} if found.setdefault(key, link) != link else set()
    return {key: link for key, link in found.items() if key not in twice}


def _links_renamed(pair: Pair, links: Names) -> Pair:
    known = {
        old: new
        for old, new in links.items()
        if old in pair.old.names and new in pair.new.names and not (old in pair.new.names or new in pair.old.names)
    }
    return pair._replace(old=_renamed(pair, known, _OF_LINKS), renamed={"link": known}) if known else pair


def _joints_renamed(pair: Pair) -> Pair:
    now = joints_by_child(pair.new)
    known = {old: now[child] for child, old in joints_by_child(pair.old).items() if now.get(child, old) != old}
    if not known:
        return pair
    return pair._replace(old=_renamed(pair, known, ("joint",)), renamed={**pair.renamed, "joint": known})


def _renamed(pair: Pair, names: Names, kinds: Sequence[str]) -> View:
    """Return what an artifact said, under new names of some kinds of things; what else names them follows."""
    old, new = pair.old, pair.new
    plain: dict[Fact, Value] = {}
    for fact, value in old.plain.items():
        made = _fact(fact, names, kinds, new)
        now = new.plain.get(made)
        follows = now is not None and isinstance(value.value, str) and names.get(value.value) == now.value
        if "link" in kinds and fact.quantity in ("parent", "child"):
            value = value._replace(value=names.get(str(value.value), value.value))
        plain[made] = now if follows and now is not None else value
    if "joint" in kinds:
        return old._replace(plain=plain)
    return View(
        plain,
        {_name(frame, names): turn for frame, turn in old.turns.items()},
        {(names.get(link, link), purpose): solids for (link, purpose), solids in old.shapes.items()},
        {names.get(frame, frame): cells for frame, cells in old.heights.items()},
        frozenset(_name(name, names) for name in old.names),
    )


def _fact(fact: Fact, names: Names, kinds: Sequence[str], new: View) -> Fact:
    """Return a fact under new names; of another kind of thing only where it stands so in the new artifact."""
    made = fact._replace(name=_name(fact.name, names)) if fact.kind in kinds else fact
    start, _, last = made.quantity.rpartition(" ")
    if last in names:
        other = made._replace(quantity=f"{start} {names[last]}".strip())
        made = other if other in new.plain else made
    if fact.kind not in kinds and fact.name in names:
        other = made._replace(name=names[fact.name])
        made = other if other in new.plain and made not in new.plain else made
    return made


def _name(name: str, names: Names) -> str:
    """Return a name, or the row of a publisher that takes turns, under a new name."""
    plain, space, row = name.partition(" ")
    return f"{names[plain]}{space}{row}" if plain in names else names.get(name, name)
