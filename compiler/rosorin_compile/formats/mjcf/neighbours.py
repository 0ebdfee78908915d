"""Links that may touch or not: what the file says, and what MuJoCo does with neighbours, against what ours will."""

from __future__ import annotations

from ...diagnostics.wording import first_of
from ...frontend.tree import Map, Seq
from ...xml.markup import Element
from .contacts import Contacts, contacts
from .reading import Reading, put

_EXCLUDED = "excluded from contact in the MJCF"
_FILTERED = "MuJoCo keeps what is fixed to neighbours apart"
_GEOMS = {"geom1", "geom2"}


def add_contacts(reading: Reading) -> None:
    """Add the pairs of links that do not touch in the file; not those that no MJCF of this robot lets touch.

    They are the excluded ones, and those that are fixed to the two sides of a joint where both sides move.
    """
    from ...frontend.lower import lower

    touching = {geom["body"] for geom in reading.facts["geoms"] if geom["contype"] or geom["conaffinity"]}
    robot = lower(reading.tree).robot if touching or reading.facts["excludes"] else None
    ours = contacts(robot) if robot else Contacts([], [])
    pairs = _excluded(reading, ours)
    _pairs(reading, ours, pairs)
    if pairs:
        put(reading.tree, "disabled_contacts", pairs)
    _tell(reading, ours, touching)


def _excluded(reading: Reading, ours: Contacts) -> Seq:
    """Return the pairs of links that the file excludes, and ours would not."""
    implied = set(map(frozenset, ours.excluded))
    written = {frozenset((e.get("body1"), e.get("body2"))): e for e in reading.markup.listed("contact", "exclude")}
    pairs = Seq(reading.markup.root.span)
    for signature in reading.facts["excludes"]:
        bodies = (signature >> 16, signature & 0xFFFF)  # mjModel.exclude_signature, which MuJoCo has sorted
        names = [reading.link_of.get(index, "") for index in bodies]
        called = [reading.facts["bodies"][index]["name"] for index in bodies]
        element = written.get(frozenset(called), reading.markup.root)
        if not all(names):
            what = "a contact with the world that is excluded: the scene is no part of the robot"
            reading.ignored(what, element.span)
        elif frozenset(names) not in implied:
            pairs.put(_pair(names, element, _EXCLUDED), element.span)
    return pairs


def _pairs(reading: Reading, ours: Contacts, pairs: Seq) -> None:
    """Add the links that ours lets touch and MuJoCo does not, unless the file has pairs of their geoms as well."""
    links = list(dict.fromkeys((one.link, other.link) for one, other in ours.pairs))
    index_of = {name: index for index, name in reading.link_of.items()}
    named = _named_pairs(reading)
    known = {frozenset(entry["links"]) for entry in pairs}
    held = _held(reading)
    flags = [flag for option in reading.markup.sections("option") for flag in reading.markup.children(option)]
    filters = not any(flag.get("filterparent") == "disable" for flag in flags)
    for one, other in links:
        bodies = frozenset((index_of[one], index_of[other]))
        if bodies in named:
            reading.pairs.update(element for element in named[bodies] if set(element.attributes) <= _GEOMS)
        elif filters and not bodies & held and frozenset((one, other)) not in known:
            element = reading.places.body(index_of[other])
            pairs.put(_pair([one, other], element, _FILTERED), element.span)


def _named_pairs(reading: Reading) -> dict[frozenset[int], list[Element]]:
    """Return the pairs of geoms that the file has, by their bodies."""
    bodies = {geom["name"]: geom["body"] for geom in reading.facts["geoms"] if geom["name"]}
    named: dict[frozenset[int], list[Element]] = {}
    for element in reading.markup.listed("contact", "pair"):
        both = frozenset(bodies.get(element.get(word) or "", 0) for word in ("geom1", "geom2"))
        named.setdefault(both, []).append(element)
    return named


def _held(reading: Reading) -> set[int]:
    """Return the bodies that no joint moves against the world."""
    held = {0}
    for index, body in enumerate(reading.facts["bodies"]):
        if index and body["parent"] in held and not reading.joints_in.get(index):
            held.add(index)
    return held


def _tell(reading: Reading, ours: Contacts, touching: set[int]) -> None:
    """Say which links that a joint connects may touch in the file: MuJoCo lets those of a base in the world do so."""
    index_of = {name: index for index, name in reading.link_of.items()}
    excluded = {frozenset((one >> 16, one & 0xFFFF)) for one in reading.facts["excludes"]}
    held = _held(reading)
    free = []
    for pair in ours.excluded:
        one, other = (index_of.get(name) for name in pair)
        if one is None or other is None or not {one, other} <= touching or frozenset((one, other)) in excluded:
            continue
        if one in held or other in held:
            free.append(pair)
    if free:
        which = first_of([f"{one} and {other}" for one, other in free], 3)
        message = f"neighbours that may touch in the MJCF do not in ours: {which}"
        reading.changed(message, reading.places.body(index_of[free[0][0]]).span)


def _pair(names: list[str], element: Element, reason: str) -> Map:
    """Return the entry of two links, in the order in which the file names them."""
    entry, links = Map(element.span), Seq(element.span)
    spans = {attribute.value: attribute.span for attribute in element.attributes.values()}
    for name in sorted(names, key=lambda name: name != element.get("body1")) if reason == _EXCLUDED else names:
        links.put(name, spans.get(name, element.span))
    put(entry, "links", links)
    put(entry, "reason", reason)
    return entry
