"""Compare the values in committed, compiled and expected artifacts, and group the differences into changes.

The values in an artifact are stored in a dict, see ``walk.leaves``. ``agreement`` compares the values that an artifact
should contain with those read back from its text; ``find_changes`` compares committed with compiled artifacts. Each
change is reported once, with all outputs that contain it. Some differences follow from another change: an artifact that
omits a link merges its shapes into another link, which then differs, too. Such a difference is added to the change that
causes it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.formats import FORMATS, Artifact, Format
from rosorin_compile.formats.urdf.write import carriers
from rosorin_compile.language.annotations import misfits
from rosorin_compile.model import Box, Output, Robot, Shape
from rosorin_compile.source.diagnostics import Diagnostic, error
from rosorin_compile.source.load import json_of
from rosorin_compile.source.progress import Progress

from . import walk
from .describe import MOVING, Describer, describe_attachment, joint_of, shapes_change, solids_left
from .precision import NOISE, POSE_NOISE, Precisions, exact, printed_precision, rounding_precision
from .sentences import NEW, REMOVED, with_remark
from .solids import match
from .walk import Address, Difference, Leaves, Names, Shapes, compare_leaves, leaves, links_of

_HELP = "a template or a format is at fault, not the description: please report it"


class Pair(NamedTuple):
    """The values in the committed and in the compiled text of an artifact."""

    output: Output
    old: Leaves  # values in the committed text; renamed links and joints have their new names
    new: Leaves  # values in the compiled text
    precisions: Precisions
    renamed: Mapping[str, Names] = {}  # {"link" or "joint": {old name: new name}}


def output_of(robot: Robot, artifact: Artifact) -> Output:
    """Return the output of the robot that an artifact names, or a new ``Output`` without options if there is none."""
    unnamed = Output(artifact.output, artifact.backend, artifact.file)
    return next((output for output in robot.outputs if output.name == artifact.output), unnamed)


def pair_of(robot: Robot, artifact: Artifact, committed: str) -> Pair | None:
    """Parse an artifact's committed and compiled text; return None if its format has no parser. Raises ValueError."""
    format, output = FORMATS[artifact.backend], output_of(robot, artifact)
    if format.read is None:
        return None
    try:
        old = leaves(format.read(committed))
    except (ValueError, TypeError, OverflowError, RecursionError) as problem:
        raise ValueError(str(problem)) from None
    before, least = printed_precision(committed), rounding_precision(*format.rounding)
    known = lambda key, *values: max(least(key, *values), before(key, *values))  # noqa: E731
    if format.view is not None and not format.partial:
        new, precision = leaves(format.view(robot, output)), least
    else:
        new, precision = leaves(format.read(artifact.text)), printed_precision(artifact.text)
    old, new = under_names(format, output, old), under_names(format, output, new)
    return Pair(output, old, new, (known, precision))


def under_names(format: Format, output: Output, found: Leaves) -> Leaves:
    """Restore the robot's link names in the values of an artifact, if an option of the output renames links."""
    return walk.with_names(found, format.names(output) if format.names is not None else {}, "link", {})


def with_new_names(pairs: Sequence[Pair]) -> list[Pair]:
    """Find renamed links and joints, and use their new names in the committed values of all artifacts."""
    links: dict[str, str] = {}
    for pair in pairs:
        links |= walk.new_link_names(pair.old, pair.new)
    made = []
    for pair in pairs:
        before, after = links_of(pair.old), links_of(pair.new)
        known = {old: new for old, new in links.items() if old in before - after and new in after - before}
        found = walk.with_names(pair.old, known, "link", pair.new)
        joints = walk.new_joint_names(found, pair.new)
        found = walk.with_names(found, joints, "joint", pair.new)
        made.append(pair._replace(old=found, renamed={"link": known, "joint": joints}))
    return made


def agreement(robot: Robot, artifacts: Sequence[Artifact]) -> list[Diagnostic]:
    """Read compiled artifacts back and return an error for each value that differs from the robot."""
    found: list[str] = []
    for number, artifact in enumerate(artifacts):
        Progress.step(f"proving {artifact.file},", number, len(artifacts))
        found += disagreements(robot, artifact)
    return [error("artifacts-disagree", text, None, _HELP) for text in found]


def disagreements(robot: Robot, artifact: Artifact) -> Iterator[str]:
    """Read an artifact back and yield a sentence for each value that differs from the robot."""
    format = FORMATS[artifact.backend]
    if format.read is None and not format.schema:
        return
    try:
        if format.schema:
            for problem in misfits(format.schema, (format.data or json_of)(artifact.text)):
                yield f"{artifact.file} does not fit schemas/{format.schema}.schema.json: {problem}"
        found = leaves(format.read(artifact.text)) if format.read is not None else {}
    except (ValueError, TypeError) as problem:
        yield f"{artifact.file} cannot be read back: {problem}"
        return
    if format.read is None or format.view is None:
        return
    output = output_of(robot, artifact)
    meant = leaves(format.view(robot, output))
    if format.partial:
        found = {thing: _part(found[thing], entry) for thing, entry in meant.items() if thing in found}
    precisions = exact, exact
    if output.options.get("number_format") != "exact":
        precisions = rounding_precision(*format.rounding), printed_precision(artifact.text)
    sides = meant, found
    differences = compare_leaves(*sides, precisions, POSE_NOISE if format.partial else NOISE)
    for _, text in Describer(robot, sides, precisions).describe(differences):
        yield f"{artifact.file} differs from what it has to contain: {text}"


def _part(found: Mapping[str, Any], meant: Mapping[str, Any]) -> dict[str, Any]:
    part = {quantity: value for quantity, value in found.items() if quantity in meant}
    for quantity, value in part.items():
        if isinstance(value, Shapes):
            part[quantity] = Shapes(tuple(Shape(shape.geometry, shape.pose) for shape in value.shapes))
    return part


SHAPES = ("collision", "visual")
INERTIAL = ("mass", "centre of mass", "inertia")
# Quantities in the order in which the changes of a link or joint are listed.
_QUANTITIES = (
    *("", "parent", "publisher", "topic", "type", "child", "origin", "axis", "limit lower", "limit upper", "limit"),
    *("damping", "friction"),
    *("armature", "mimic", "kp", "kv", "ctrl", "heights", "cell", "base", "mass", "centre", "inertia", "collision"),
    *("visual", "site", "contact"),
)
_KINDS = {"frame": 0, "joint": 0, "link": 0, "height map": 0, "servo": 1, "pose": 2}


class Change(NamedTuple):
    """A change between committed and compiled artifacts, such as a moved frame."""

    kind: str
    name: str
    quantity: str  # such as "origin", or "" if the link, joint or other entry itself is new or removed
    text: str  # the sentence that describes the change
    artifacts: tuple[str, ...] = ()  # names of the outputs that contain the change
    therefore: tuple[str, ...] = ()  # links whose shapes differ as a consequence of the change
    differences: tuple[Difference, ...] = ()  # all differing values that the change explains

    def words(self) -> str:
        """Return the text of the change, and the links whose shapes differ as a consequence."""
        links = ", ".join(self.therefore)
        return with_remark(self.text, f"and therefore the shapes of {links}" if links else "")

    def line(self) -> str:
        """Return the text of the change, and the outputs that contain it."""
        return f"{self.words()}: {', '.join(self.artifacts)}"


def find_changes(robot: Robot, pairs: Sequence[Pair]) -> list[Change]:
    """Return each change with all outputs that contain it: links and joints from the root down, then other entries."""
    changes: list[Change] = []
    for pair in pairs:
        for kind, names in pair.renamed.items():
            for old, new in names.items():
                _merge(changes, Change(kind, new, "", f"{kind} {old} renamed to {new}", (pair.output.name,)))
    # Group equal differences in several artifacts, because they are one change.
    groups: dict[Address, list[list[tuple[Pair, Difference, str]]]] = {}
    bodies: list[tuple[Pair, Difference]] = []
    for pair in pairs:
        found = list(_without_hidden(pair, compare_leaves(pair.old, pair.new, pair.precisions)))
        own = [one for one in found if not _is_of_body(one)]
        bodies += [(pair, one) for one in found if _is_of_body(one)]
        for one, text in Describer(robot, (pair.old, pair.new), pair.precisions).describe(own):
            some = groups.setdefault(one.address, [])
            group = next((group for group in some if _same_change(group[0][:2], (pair, one))), None)
            if group is None:
                some.append(group := [])
            group.append((pair, one, text))
    for address, some in groups.items():
        for group in some:
            _, first, text = group[0]
            if not address.quantity and address.kind in ("frame", "link"):
                word = NEW if first.old is None else REMOVED
                text = describe_attachment(robot, address.name, word, [p.new if word == NEW else p.old for p in pairs])
            outputs, differences = tuple(each[0].output.name for each in group), tuple(each[1] for each in group)
            changes.append(Change(*address, text, outputs, (), differences))
    # Start with the artifacts that have the most links, because the others merge the shapes of several links.
    for pair, one in sorted(bodies, key=lambda found: -len(links_of(found[0].new))):
        _add_body(robot, changes, pair, one)
    order = {pair.output.name: index for index, pair in enumerate(pairs)}
    place = {link.name: index for index, link in enumerate(robot.walk())}

    def sort_key(change: Change) -> tuple[object, ...]:
        link = robot.joint[change.name].child if change.kind == "joint" and change.name in robot.joint else change.name
        word = change.quantity if change.quantity in _QUANTITIES else change.quantity.split(" ")[0]
        quantity = _QUANTITIES.index(word) if word in _QUANTITIES else len(_QUANTITIES)
        where = place.get(link.split(" ")[0], len(place))
        return (_KINDS.get(change.kind, 3), where, link, quantity, change.quantity, change.text, change.artifacts)

    changes = [one._replace(artifacts=tuple(sorted({*one.artifacts}, key=order.__getitem__))) for one in changes]
    return sorted(changes, key=sort_key)


def _is_of_body(one: Difference) -> bool:
    _, _, quantity = one.address
    return one.address.kind == "link" and (quantity in SHAPES or (quantity in INERTIAL and None not in one[1:]))


def _same_change(one: tuple[Pair, Difference], other: tuple[Pair, Difference]) -> bool:
    (address, *values), others = one[1], other[1][1:]
    if not address.quantity and not isinstance(values[0] or values[1], frozenset):
        return (values[0] is None) == (others[0] is None)
    for side in (0, 1):
        leaves = ({} if some[side] is None else {address.quantity: some[side]} for some in (values, others))
        first, second = ({address[:2]: entry} for entry in leaves)
        if compare_leaves(first, second, (one[0].precisions[side], other[0].precisions[side]), NOISE):
            return False
    return True


def _add_body(robot: Robot, changes: list[Change], pair: Pair, one: Difference) -> None:
    """Add a difference in shapes or mass of a link to the changes that cause it, or as a new change."""
    _, link, quantity = one.address
    causes = [at for at, change in enumerate(changes) if _is_cause(robot, change, pair, one)]
    causes = [at for at in causes if pair.output.name in changes[at].artifacts] or causes
    for at in causes:
        change = changes[at]
        own = change[:2] == ("link", link) or quantity in INERTIAL
        therefore = change.therefore if own else tuple(dict.fromkeys((*change.therefore, link)))
        changes[at] = change._replace(artifacts=(*change.artifacts, pair.output.name), therefore=therefore)
    rest = _unexplained({changes[at].kind for at in causes}, one)
    if quantity in INERTIAL:
        for _, text in Describer(robot, (pair.old, pair.new), pair.precisions).describe(rest):
            _merge(changes, Change("link", link, quantity, text, (pair.output.name,), (), (one,)))
        return
    is_known = any(changes[at][:3] == ("link", link, f"{quantity} shapes") for at in causes)
    for difference in [one] if is_known else rest:
        for found in shapes_change(link, quantity, *solids_left(difference, pair.precisions)):
            # The same solids may already be reported for an artifact without names or colours.
            if found.looks or not is_known:
                what = f"{quantity} {'looks' if found.looks else 'shapes'}"
                _merge(changes, Change("link", link, what, found.text, (pair.output.name,), (), (one,)))


def _unexplained(causes: set[str], one: Difference) -> list[Difference]:
    if not causes:
        return [one]
    if causes - {"height map", "material"}:
        return []
    sides = []
    for side in one[1:]:
        shapes = side.shapes if isinstance(side, Shapes) else ()
        if "height map" in causes:
            shapes = tuple(shape for shape in shapes if not isinstance(shape.geometry, Box))
        if "material" in causes:
            shapes = tuple(replace(shape, rgba=None, texture="", material="") for shape in shapes)
        sides.append(Shapes(shapes))
    return [Difference(one.address, *sides)]


def _merge(changes: list[Change], change: Change) -> None:
    for at, other in enumerate(changes):
        texts = [each.text.replace(" capsule ", " cylinder ") for each in (other, change)]
        if other[:3] == change[:3] and texts[0] == texts[1]:
            changes[at] = other._replace(artifacts=(*other.artifacts, *change.artifacts))
            return
    changes.append(change)


def _is_cause(robot: Robot, change: Change, pair: Pair, one: Difference) -> bool:
    (kind, name, what), (_, link, quantity) = change[:3], one.address
    if not change.differences:
        return False
    # All links of the robot whose shapes are merged into this link, in the old or in the new artifact.
    carried = {link}
    for links in (frozenset(links_of(side) & robot.link.keys()) for side in (pair.old, pair.new)):
        owners = carriers(robot, links).items() if link in links else ()
        carried |= {other for other, (carrier, _) in owners if carrier == link}
    carried &= robot.link.keys()
    # For links without visuals, writers generate visuals from the collision shapes.
    is_made = quantity == "visual" and not any(robot.link[other].visual for other in carried)
    purpose = "collision" if is_made else quantity
    if kind == "material":
        shapes = [shape for other in carried for shape in robot.link[other].visual]
        return quantity == "visual" and any(shape.material == name for shape in shapes)
    if kind == "height map":
        return purpose == "collision" and name in carried
    if kind == "link" and name == link:
        return what == f"{purpose} shapes" and (is_made or _same_solids(change, pair, one))
    if kind == "link":
        same = what in INERTIAL if quantity in INERTIAL else what == f"{purpose} shapes"
        return name in carried and (same or not what)
    if kind == "frame" and not what:
        return (change.differences[0].old or change.differences[0].new).get("parent") in carried and name != link
    joint = robot.joint.get(name) if kind == "joint" else robot.joint_to.get(name)
    moves = what in (("type", "axis") if kind == "joint" else ("parent", "origin"))
    return kind in ("joint", "frame") and moves and joint is not None and {joint.parent, joint.child} <= carried


def _same_solids(change: Change, pair: Pair, one: Difference) -> bool:
    """Return True if a change and a difference concern the same solids; capsules are compared as cylinders."""
    sides = []
    for difference in (change.differences[0], one):
        moved = [one for one in shapes_change("", "", *solids_left(difference, pair.precisions)) if not one.looks]
        both = [solid for each in moved for solid in each.old], [solid for each in moved for solid in each.new]
        sides.append([[solid.as_cylinder._replace(words=(), rgba=None) for solid in some] for some in both])
    pairs = zip(*sides, strict=True)
    return all(some and len(some) == len(others) and not match(some, others).old for some, others in pairs)


def _without_hidden(pair: Pair, differences: Sequence[Difference]) -> Iterator[Difference]:
    """Yield the differences that are not a consequence of new or removed frames, or of new joint types."""
    before, after = links_of(pair.old), links_of(pair.new)
    changed = {one.address.name for one in differences if one.address.kind == "frame" and not one.address.quantity}
    came = {name for name in before ^ after if " " not in name} | changed
    joints = {joint_of(side, name) for side in (pair.old, pair.new) for name in came} - {""}
    retyped = set()
    for one in differences:
        kind, name, quantity = one.address
        if kind == "joint" and (not quantity or quantity == "type") and name not in joints:
            types = [side.get("type") if isinstance(side, dict) else side if quantity else "fixed" for side in one[1:]]
            if (types[0] in MOVING) != (types[1] in MOVING):
                retyped.add(name)
                yield Difference(Address(kind, name, "type"), types[0] or "fixed", types[1] or "fixed")
    for one in differences:
        kind, name, quantity = one.address
        if kind == "joint" and (name in joints or name in retyped or not quantity):
            continue
        if (kind == "frame" and name in changed and quantity) or (kind == "pose" and quantity in joints | retyped):
            continue
        if kind in ("link", "height map") and (name in changed or (name in came and quantity)):
            continue
        if kind == "link" and not quantity and name in before & after:  # only one side has values for it
            for word, value in (one.old or one.new).items():
                yield Difference(Address(kind, name, word), *((value, None) if one.new is None else (None, value)))
        elif isinstance(one.old, frozenset) or isinstance(one.new, frozenset):
            members = [{m: m.partition(" (")[0].split(" - ") for m in side or ()} for side in one[1:]]
            sets = [frozenset(m for m, names in side.items() if came.isdisjoint(names)) for side in members]
            if sets[0] != sets[1]:
                yield Difference(one.address, *sets)
        else:
            yield one
