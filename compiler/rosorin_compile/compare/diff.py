"""Compare the meaning of two robots, which can be in different formats, and report the differences.

Links and joints of B first get the names of their counterparts in A (``bodies``). Then frames, masses, shapes and other
values are compared. Shapes are compared as sets of solids, one set for all links that are connected by fixed joints.
Values that a format does not support are reported as not compared, not as differences.
"""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import lacks
from rosorin_compile.formats.urdf.write import carriers, inertials_at
from rosorin_compile.model import Box, Capsule, Ellipsoid, HeightMap, Inertial, Mesh, Shape, Transform
from rosorin_compile.model.colours import is_default, shows_collision
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.model.link import together
from rosorin_compile.model.shape import GROUNDED, ROWS, Rgba, plain
from rosorin_compile.source.progress import Progress

from .bodies import Bodies, BodyPairs, compare_frames, compare_names, pair
from .describe import Describer, shapes_change
from .difference import DEFAULT_TOLERANCE, KINDS, MASS, SHAPE, VISUAL, YAML, Difference, Item, Report, Side
from .precision import Precision, join_errors
from .sections import compare_sections, has_one_box
from .sentences import colour_change, row, several
from .solids import Solid, largest_step, match, same_colour, same_space, solid_of
from .walk import Difference as Leaf
from .walk import compare_leaves, inertial_leaves, renamed_robot


def compare_robots(a: Side, b: Side, tolerance: float = DEFAULT_TOLERANCE, prefix: str | None = None) -> Difference:
    """Compare the meaning of two robots and return the differences.

    Differences up to ``tolerance`` (m, rad; for other numbers, relative) plus the rounding of the numbers are ignored.
    ``prefix`` is the prefix of all names in ``b``, "" for none, or None to detect it.
    """
    if all(side.format is YAML and side.robot.without_plugin_entries().is_tree for side in (a, b)):
        # Ignore what sections of plug-ins add to the robot, so that their differences are reported only once.
        a, b = (side._replace(robot=side.robot.without_plugin_entries()) for side in (a, b))
    pairing = pair_sides(a, b, tolerance, prefix)
    missing, not_compared = not_carried(pairing, a, b)
    report = Report([], [], not_compared)
    if pairing.prefixed:
        names = (b if pairing.prefixed == "B" else a).robot.link
        cut = sum(name.startswith(pairing.prefix) for name in names)
        some = "" if cut == len(names) else f"{cut} of {len(names)} of "
        report.notes.append(f'{some}the names of {pairing.prefixed} begin with "{pairing.prefix}"')
    origins, flipped = compare_frames(pairing, report)
    topics = compare_sections(pairing, (a, b), flipped, report)
    if "mass" not in topics:
        _compare_masses(pairing, origins, report)
    for purpose in [purpose for purpose in ("collision", "visual") if purpose not in topics]:
        compare_shapes(pairing, (a, b), origins, purpose, report)
    report.items.extend(compare_names(pairing, missing, "fixed joint name" not in topics))
    if a.robot.name != b.robot.name and a.format.names_robot and b.format.names_robot:
        report.notes.append(f"the robot is called {a.robot.name} in A, {b.robot.name} in B")
    order = {name: index for index, name in enumerate({**pairing.a.top, **pairing.b.top})}
    for joint in (*pairing.a.robot.joints, *pairing.b.robot.joints):
        order.setdefault(joint.name, order[joint.child])
    items = sorted(report.items, key=lambda item: (KINDS.index(item.kind), order.get(item.name, len(order))))
    return Difference(a, b, tuple(items), tuple(report.notes), tuple(report.not_compared), tolerance)


def pair_sides(a: Side, b: Side, tolerance: float, prefix: str | None) -> BodyPairs:
    """Match the links and joints of two robots, after removing differences that only come from their formats."""
    a, b = _without_made_visuals(a, b), _without_made_visuals(b, a)
    for at, side, other in ((1, a, b), (0, b, a)):
        output = other.format.output(side.robot)
        if other.format.names is not None and output is not None:  # an option of the output can rename links
            free = {new: old for new, old in other.format.names(output).items() if old not in other.robot.link}
            other = other._replace(robot=renamed_robot(other.robot, free, {}))
            pairing = pair(a, other, tolerance, prefix) if at else pair(other, b, tolerance, prefix)
            pairing.steps[at].insert(0, (free, {}))
            return pairing
    return pair(_carrying(a, b), _carrying(b, a), tolerance, prefix)


def _without_made_visuals(side: Side, other: Side) -> Side:
    """Remove visuals that were generated from collision shapes if the link has no visual in the other robot."""
    bare = {link.name for link in other.robot.links if not link.visual}
    made = {link.name for link in side.robot.links if link.name in bare and shows_collision(link)}
    links = tuple(replace(link, visual=()) if link.name in made else link for link in side.robot.links)
    return side._replace(robot=replace(side.robot, links=links)) if made else side


def _carrying(side: Side, other: Side) -> Side:
    """Merge the masses of links that the other robot's format omits into the remaining links of a description.

    Only links below moving joints matter here: links that fixed joints connect are compared as a single body anyway.
    """
    robot, leaves_out = side.robot, other.format.leaves_out
    carried = frozenset(robot.link.keys() & other.robot.link.keys())
    if side.format is not YAML or leaves_out is None or not carried or len(carried) == len(robot.links):
        return side
    gone = {name for name, (carrier, _) in carriers(robot, carried).items() if robot.moves_between(name, carrier)}
    if gone and all(leaves_out(robot, name) for name in gone):
        with suppress(ValueError):
            masses = inertials_at(robot, robot.link.keys() - gone)
            links = tuple(replace(link, inertial=masses.get(link.name)) for link in robot.links)
            return side._replace(robot=replace(robot, links=links))
    return side


def not_carried(pairing: BodyPairs, a: Side, b: Side) -> tuple[frozenset[str], list[str]]:
    """Return the names of links that a robot lacks because of its format, and notes about these links."""
    names: set[str] = set()
    lines: list[str] = []
    for robot, other, side, its in ((pairing.a.robot, pairing.b.robot, a, b), (pairing.b.robot, pairing.a.robot, b, a)):
        format, left = its.format, [link.name for link in robot.walk() if link.name not in other.link]
        name = ""
        if side.format is YAML and format.links is not None and len(its.robot.links) != len(robot.links):
            # The other file may be an artifact of the description that omits links on purpose.
            outputs = [one for one in robot.outputs if one.backend == format.name and format.is_withheld(one)]
            name = next((one.name for one in outputs if set(format.links(robot, one)) == set(its.robot.link)), "")
        if not name and format is YAML:
            left = [link for link in left if side.format.adds is not None and side.format.adds(robot, link, its.robot)]
        elif not name:
            left = [link for link in left if format.leaves_out is not None and format.leaves_out(robot, link)]
        names.update(left)
        if left:
            why = (its if side.format is YAML or its.format is not YAML else side).format.why
            why = f"its output {name} has no such links" if name else why
            lines.append(f"{several(left)} of {side.label}: {why}")
    return frozenset(names), lines


def _compare_masses(pairing: BodyPairs, origins: Mapping[str, str], report: Report) -> None:
    """Report differences in mass and inertia, unless only their distribution within a rigid body differs."""
    precisions = pairing.a.precision, pairing.b.precision

    def differences(name: str, *sides: tuple[Inertial | None, Precision]) -> Sequence[Leaf]:
        old, new = ({("link", name): inertial_leaves(inertial)} for inertial, _ in sides)
        return compare_leaves(old, new, (sides[0][1], sides[1][1]), pairing.tolerance)

    robots, found = (pairing.a.robot, pairing.b.robot), dict[str, Sequence[Leaf]]()
    for name in pairing.shared_links:
        inertials = [(robot.link[name].inertial, known) for robot, known in zip(robots, precisions, strict=True)]
        found[name] = differences(name, *inertials)
    for top, goal in pairing.bodies.items():
        members = pairing.a.members[top], pairing.b.members[goal]
        differing = {name for name in members[0] if found.get(name)}
        for robot, names, others in zip(robots, members, members[::-1], strict=True):
            differing |= {name for name in names if name not in others and robot.link[name].inertial is not None}
        if len(differing) > 1 or differing - found.keys():
            wholes = (_whole(side, names, origins[top]) for side, names in zip(pairing[:2], members, strict=True))
            if not differences(top, *wholes):
                links = several(sorted(differing, key=lambda name: (name not in found, name)))
                text = f"the mass of the body of {top} is shared out otherwise ({links}); as a whole it is the same"
                report.notes.append(text)
                found |= dict.fromkeys(differing, ())
    describer = Describer(pairing.a.robot, ({}, {}), precisions, pairing.tolerance)
    units = {"mass": "kg", "inertia": "kg*m^2", "centre of mass": "m"}
    for name in pairing.shared_links:
        for ((_, _, quantity), old, new), text in describer.describe(found[name]):
            before, after = (old, new) if quantity == "mass" else (row(old), row(new))
            distance = math.dist(old, new) if quantity == "centre of mass" else None
            report.items.append(Item(MASS, name, quantity, text, before, after, units[quantity], distance))


def _whole(bodies: Bodies, names: Sequence[str], frame: str) -> tuple[Inertial | None, Precision]:
    """Return the total inertial of some links of a body in the frame of link ``frame``, and its precision."""
    links = [(inertial, name) for name in names if (inertial := bodies.robot.link[name].inertial) is not None]
    parts = [(inertial, bodies.relative(frame, name)) for inertial, name in links]
    if not any(inertial.mass for inertial, _ in parts):
        return None, bodies.precision
    whole = together([(inertial, place.transform) for inertial, place in parts])
    centres = [place.transform.apply(inertial.pose.xyz) for inertial, place in parts]
    reach = max(math.dist(centre, whole.pose.xyz) for centre in centres)
    length = max(place.length + bodies.precision("xyz", *one.pose.xyz) for one, place in parts)
    masses = math.fsum(bodies.precision("mass", one.mass) for one, _ in parts)
    xyz, ixx = reach * masses / abs(whole.mass or 1.0), masses * reach**2 + 4 * abs(whole.mass) * reach * length
    spread = {"xyz": length + xyz, "ixx": ixx}
    return whole, lambda key, *values: len(parts) * bodies.precision(key, *values) + spread.get(key, 0.0)


class Piece(NamedTuple):
    """A solid in the frame of its link, and the shape of the robot that it is a part of."""

    link: str
    shape: Shape
    solid: Solid


Pieces = list[Piece]


def pieces_of(
    link: str,
    shapes: Sequence[Shape],
    precision: Precision,
    capsules: bool = True,
    form: str = ROWS,
    words: bool = False,
) -> Pieces:
    """Divide the shapes of a link into solids without colours. A mesh is a solid with the name of its file.

    Without ``capsules``, capsules become cylinders, as in URDF 1.0. ``form`` is the way to divide height maps into
    boxes (see ``HeightMap.boxes``). With ``words``, solids include names and values for simulation, such as friction.
    """
    found: Pieces = []
    for whole in shapes:
        for shape in whole.solids(form):
            solid = solid_of(shape if capsules else replace(shape, geometry=plain(shape.geometry)), precision, 1.0)
            kept = [word for word in solid.words if words and not word.startswith("file ")]
            if isinstance(shape.geometry, Mesh):
                kept.append(f"file {shape.geometry.file.replace(chr(92), '/').rsplit('/', 1)[-1]}")
            found.append(Piece(link, whole, solid._replace(rgba=None, words=tuple(kept))))
    return found


def compare_shapes(
    pairing: BodyPairs, sides: tuple[Side, Side], origins: Mapping[str, str], purpose: str, report: Report
) -> None:
    """Report differences in "visual" or "collision" shapes; ``origins`` is the first result of ``compare_frames``."""
    work = _Comparison(pairing, sides, purpose, report)
    done = set()
    for number, (top, goal) in enumerate(pairing.bodies.items()):
        Progress.step("comparing shapes", number, len(pairing.bodies))
        work.body(pairing.a.members[top], pairing.b.members[goal], origins[top])
        done |= {name for name in pairing.a.members[top] if pairing.b.top.get(name) == goal}
    for name in pairing.shared_links:
        if name not in done:
            work.body([name], [name], "")
    if work.meshes:
        report.notes.append(f"mesh files are named otherwise: {several(sorted(work.meshes))}")
    for why, names in work.not_comparable.items():
        report.not_compared.append(f"the collision of {several(names)}: {why}")


class _Comparison:
    def __init__(self, pairing: BodyPairs, sides: tuple[Side, Side], purpose: str, report: Report) -> None:
        self.sides, self.purpose, self.tolerance = sides, purpose, pairing.tolerance
        self.bodies = pairing.a, pairing.b
        formats = [side.format for side in sides]
        self.words = formats[0] is formats[1]
        # A visual without a colour differs from a coloured visual, unless a format has a default colour, such as MJCF.
        self.says_no_colour = self.words or all(one is FORMATS.published_format() or not one.load for one in formats)
        self.one_box = next((one for one in formats if has_one_box(one)), None)
        no_capsules = [one for one in formats if one is not YAML and lacks(one, "links.collision.capsule")]
        cylinders = next((one for one in no_capsules if not has_one_box(one)), None)
        self.capsules = cylinders is None
        self.report = report
        self.not_comparable: dict[str, list[str]] = {}
        self.meshes: set[str] = set()
        shapes = (one for side in self.bodies for link in side.robot.links for one in getattr(link, purpose))
        if cylinders is not None and any(isinstance(one.geometry, (Capsule, Ellipsoid)) for one in shapes):
            text = f"the round ends of capsules: {cylinders.article_name} has cylinders of the same full length"
            report.not_compared.append(text)

    def body(self, mine: Sequence[str], theirs: Sequence[str], origin: str) -> None:
        old, new = self._pieces(mine, theirs, origin)
        counts = {name: sum(piece.link == name for piece in old) for name in mine}
        shared = [name for name in mine if name in theirs]
        groups: list[tuple[Collection[str], str]] = [([name], "") for name in shared]
        groups += [({*mine, *theirs}, origin)] if origin else []
        pairs: list[tuple[Piece, Piece]] = []
        for names, frame in groups if self.one_box is None else groups[: len(shared)]:
            some = [[piece for piece in pieces if piece.link in names] for pieces in (old, new)]
            rest = match(self._seen(0, some[0], frame), self._seen(1, some[1], frame), self.tolerance)
            equal = [(some[0][one], some[1][other]) for one, other in rest.pairs]
            _remove(old, [one for one, _ in equal])
            _remove(new, [other for _, other in equal])
            pairs += equal
        for names, frame in groups:
            self._take_same_space(old, new, names, frame)
        self._named_otherwise(pairs)
        moved = sorted({f"{one.link} -> {other.link}" for one, other in pairs if one.link != other.link})
        if moved:
            self.report.notes.append(f"{self.purpose} shapes are on another link of the same body: {several(moved)}")
        for name in shared:
            left = [[piece for piece in some if piece.link == name] for some in (old, new)]
            if left[0] or left[1]:
                self._differ(name, (counts[name], counts[name] - len(left[0]) + len(left[1])), *left)

    def _pieces(self, mine: Sequence[str], theirs: Sequence[str], origin: str) -> tuple[Pieces, Pieces]:
        """Return the solids of a body in A and in B, except height maps that both have."""
        kept: tuple[dict[str, Sequence[Shape]], dict[str, Sequence[Shape]]] = ({}, {})
        for name in dict.fromkeys([*mine, *theirs]):
            pairs = zip(self.bodies, (mine, theirs), strict=True)
            shapes = [getattr(side.robot.link[name], self.purpose) if name in names else () for side, names in pairs]
            rest = [[one for one in some if not isinstance(one.geometry, HeightMap)] for some in shapes]
            has_map = [len(some) < len(all_of) for some, all_of in zip(rest, shapes, strict=True)]
            if self.one_box is not None and name in mine and name in theirs:
                placed = [[(type(one.in_link.geometry), one.in_link.pose) for one in some] for some in rest]
                why = "a height map on one side, boxes on the other" if has_map[0] != has_map[1] else ""
                if any(some not in ([], [(Box, IDENTITY)]) for some in placed):
                    why = f"{self.one_box.article_name} has one box along the axes of a link"
                if why:
                    self.not_comparable.setdefault(why, []).append(name)
                    continue
            for at, some in enumerate(rest if all(has_map) else shapes):
                kept[at][name] = some

        def cut(at: int, form: str) -> Pieces:
            options = self.bodies[at].precision, self.capsules, form, self.words
            return [piece for name, some in kept[at].items() for piece in pieces_of(name, some, *options)]

        rows = cut(0, ROWS), cut(1, ROWS)
        for at in (0, 1):
            # Extend the boxes down to z = 0 if an output does so, and if more boxes then match the other robot.
            maps = [name for name, some in kept[at].items() if any(isinstance(s.geometry, HeightMap) for s in some)]
            if maps and any(one.options.get("height_maps") == GROUNDED for one in self.sides[at].robot.outputs):
                low, other = cut(at, GROUNDED), self._seen(1 - at, rows[1 - at], origin)
                fits = [len(match(self._seen(at, some, origin), other).pairs) for some in (rows[at], low)]
                if fits[1] > fits[0]:
                    rows[at][:] = low
                    note = f"the boxes of the height map of {maps[0]} reach down to z = 0 on one side"
                    self.report.notes.append(note)
        return rows

    def _seen(self, at: int, pieces: Iterable[Piece], frame: str) -> list[Solid]:
        side = self.bodies[at]
        return [one.solid.seen_from(side.relative(frame, one.link)) if frame else one.solid for one in pieces]

    def _take_same_space(self, old: Pieces, new: Pieces, names: Collection[str], frame: str) -> None:
        """Drop boxes that fill the same space in both robots: a height map can be divided in several ways."""
        boxes: list[list[tuple[Piece, Solid]]] = []
        for at, pieces in enumerate((old, new)):
            some = [piece for piece in pieces if piece.link in names]
            boxes.append([both for both in zip(some, self._seen(at, some, frame), strict=True) if both[1].box])
        words = [{word for _, solid in some for word in solid.words if not word.startswith("name ")} for some in boxes]
        first, second = ([solid for _, solid in some] for some in boxes)
        if all(boxes) and words[0] == words[1] and same_space(first, second, self.tolerance):
            links = several(sorted({piece.link for some in boxes for piece, _ in some}))
            self.report.notes.append(f"{self.purpose} boxes are cut otherwise, and fill the same space: {links}")
            _remove(old, [piece for piece, _ in boxes[0]])
            _remove(new, [piece for piece, _ in boxes[1]])

    def _differ(self, name: str, counts: tuple[int, int], old: Pieces, new: Pieces) -> None:
        kind = SHAPE if self.purpose == "collision" else VISUAL
        of = {id(piece.solid): piece for piece in (*old, *new)}
        for change in shapes_change(name, self.purpose, counts, *([p.solid for p in some] for some in (old, new))):
            largest = largest_step(zip(change.old, change.new, strict=False))
            before, after = ("; ".join(map(_words, some)) for some in (change.old, change.new))
            self.report.items.append(Item(kind, name, self.purpose, change.text, before, after, "m", largest))
            if len(change.old) == len(change.new) == 1:
                self._named_otherwise([(of[id(change.old[0])], of[id(change.new[0])])])

    def _named_otherwise(self, pairs: Iterable[tuple[Piece, Piece]]) -> None:
        colours: dict[tuple[str, Rgba | None, Rgba | None], None] = {}
        for one, other in pairs:
            files = [getattr(piece.shape.geometry, "file", "") for piece in (one, other)]
            if files[0] != files[1] and one.solid.words == other.solid.words:
                self.meshes.add(f"{files[0]} -> {files[1]}")
            if self.purpose == "visual" and (found := self._colours(one.shape, other.shape)):
                colours.setdefault((one.link, *found))
        for link, *both in colours:
            before, after = (row(rgba) if rgba else "none" for rgba in both)
            text = colour_change(f"{link} visual", *both)
            self.report.items.append(Item(VISUAL, link, "colour", text, before, after))

    def _colours(self, one: Shape, other: Shape) -> tuple[Rgba | None, Rgba | None] | None:
        old, new = (side.robot.colour(shape) for side, shape in zip(self.bodies, (one, other), strict=True))
        if any(side.format is not YAML for side in self.sides):
            old, new = (None if colour is None or is_default(colour) else colour for colour in (old, new))
        if old is None or new is None:
            return None if old is new or not self.says_no_colour else (old, new)
        known = join_errors(self.bodies[0].precision("rgba", *old), self.bodies[1].precision("rgba", *new))
        return None if same_colour(old, new, known + self.tolerance) else (old, new)


def _remove(pieces: Pieces, gone: Iterable[Piece]) -> None:
    taken = set(map(id, gone))
    pieces[:] = [piece for piece in pieces if id(piece) not in taken]


def _words(solid: Solid) -> str:
    rpy, files = pose_of(Transform(solid.rows)).rpy, [word for word in solid.words if word.startswith("file ")]
    turned = ["rpy", row(rpy)] if any(rpy) else []
    return " ".join([solid.kind, *files, row(solid.sizes), "at", row(solid.centre), *turned])
