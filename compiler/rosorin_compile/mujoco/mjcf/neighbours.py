"""Links that may touch or not: what the file says, and what MuJoCo does with neighbours by itself.

An MJCF of ours says of its own accord who does not touch (``contacts``). Where that is what the file says too, only the
rest of it is in the tree; everywhere else the tree has all that the file says, and asks for no more: ``contacts:
described``.

Both are held against each other by the bodies and geoms of the compiled model, so that classes, includes and replicas
have had their say.
"""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.markup import Element

from .contacts import Contacts, contacts
from .entries import add_pairs
from .reading import Reading, put

_EXCLUDED = "excluded from contact in the MJCF"
_FILTERED = "MuJoCo keeps neighbours apart; here links without mass are between them"


def add_contacts(reading: Reading) -> None:
    """Add the pairs of links that do not touch in the file, and the contact pairs that it has."""
    from rosorin_compile.language.lower import lower

    touching = {geom["body"] for geom in reading.facts["geoms"] if geom["contype"] or geom["conaffinity"]}
    robot = lower(reading.tree).robot if touching or reading.facts["excludes"] else None
    ours = contacts(robot) if robot else Contacts([], [], [])
    said = {frozenset(names) for names, _ in _excludes(reading)}
    named = {frozenset((one.solid.shape.name, other.solid.shape.name)) for one, other in ours.pairs}
    paired = {
        frozenset(reading.called("geom", node["attributes"][word]) for word in ("geom1", "geom2"))
        for node in reading.facts["elements"]["pairs"]
    }
    implied = set(map(frozenset, ours.excluded))
    reading.implied_contacts = implied <= said and named <= paired
    if not reading.implied_contacts:
        implied, named = set(), set()
    pairs = Seq(reading.markup.root.span)
    for names, element in _excludes(reading):
        if frozenset(names) not in implied:
            pairs.put(_pair(names, element, _EXCLUDED), element.span)
    if touching:
        for names, element in _filtered(reading, touching, said | implied):
            pairs.put(_pair(names, element, _FILTERED), element.span)
    if pairs:
        put(reading.tree, "disabled_contacts", pairs)
    add_pairs(reading, named)


def _excludes(reading: Reading) -> Iterator[tuple[list[str], Element]]:
    """Yield the links that the file excludes from contact with each other."""
    written = {frozenset((e.get("body1"), e.get("body2"))): e for e in reading.markup.listed("contact", "exclude")}
    for signature in reading.facts["excludes"]:
        bodies = (signature >> 16, signature & 0xFFFF)  # mjModel.exclude_signature, which MuJoCo has sorted
        names = [reading.link_of.get(index, "") for index in bodies]
        called = [reading.facts["bodies"][index]["name"] for index in bodies]
        element = written.get(frozenset(called), reading.markup.root)
        if all(names):
            yield names, element
        elif element not in reading.told:
            reading.told.add(element)
            what = "a contact with the world that is excluded: the scene is no part of the robot"
            reading.ignored(what, element.span)


def _filtered(reading: Reading, touching: set[int], said: set[frozenset[str]]) -> Iterator[tuple[list[str], Element]]:
    """Yield the links that are neighbours in the file and not here, since several joints move one of them.

    MuJoCo lets nothing that is welded to a body touch what is welded to the body that it moves in, unless that is the
    world. Where several joints move a body it hangs here on links without mass, which are its neighbours instead.
    """
    if reading.facts["elements"]["options"].get("flag filterparent") == "disable":
        return
    top: dict[int, int] = {}  # the topmost body of those that are welded together
    for index, body in enumerate(reading.facts["bodies"]):
        top[index] = index if not index or reading.joints_in.get(index) else top[body["parent"]]
    groups: dict[int, list[int]] = {}
    for index, one in top.items():
        groups.setdefault(one, []).append(index)
    for index, below in groups.items():
        above = top[reading.facts["bodies"][index]["parent"]] if index else 0
        if above == 0 or (len(reading.joints_in.get(index, ())) < 2 and index not in reading.balls_on):
            continue
        upper, lower = ([reading.link_of[at] for at in side if at in touching] for side in (groups[above], below))
        for names in ([one, other] for one in upper for other in lower):
            if frozenset(names) not in said:
                yield names, reading.places.body(index)


def _pair(names: list[str], element: Element, reason: str) -> Map:
    """Return the entry for a pair of links, named in the order of the file."""
    entry, links = Map(element.span), Seq(element.span)
    spans = {attribute.value: attribute.span for attribute in element.attributes.values()}
    for name in sorted(names, key=lambda name: name != element.get("body1")) if reason == _EXCLUDED else names:
        links.put(name, spans.get(name, element.span))
    put(entry, "links", links)
    put(entry, "reason", reason)
    return entry
