"""Past: the robot that committed artifacts tell of, as far as they tell of one.

It is the compiled robot with what they say otherwise put back: where frames sat, how joints moved, which shapes links
had. An artifact is held against what the same writer makes now; so what it rounds, and what it has no word for, is no
difference.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from rosorin_compile.formats import FORMATS, Fact
from rosorin_compile.formats.facts import AXES, Solid
from rosorin_compile.model import Joint, Link, Mesh, Pose, Robot, Shape, Transform, Vector
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.model.joint import MOVING_TYPES, SEVERAL_COORDINATES, Mimic
from rosorin_compile.model.shape import MERGED, ROWS

from .entities import Pair, joints_by_child
from .solids_old import delta, match, shape_of, solid_from
from .tolerance import same_angles, same_value
from .view import View

_TYPES = (*MOVING_TYPES, *SEVERAL_COORDINATES)
_FILE = "file "
_NOISE = 1e-9  # m; what two writers may have calculated differently


def past(robot: Robot, pairs: Sequence[Pair]) -> Robot:
    """Return the robot as it was; ``pairs`` are the artifacts that differ, as they were and as they are."""
    known = sorted(map(_Told, pairs), key=lambda told: not told.carries_links)
    joints = {joint.child: _joint(joint, known) for joint in robot.joints if not _was_root(joint.child, known)}
    links = {link.name: _link(link, known) for link in robot.links}
    for told in known:
        _put_back(told, links, joints)
    if robot.root not in joints:
        _hang(robot.root, known, links, joints)
    gone = {name for name in links if name in robot.link and _is_new(name, known)}
    return _tree(robot, links, joints, gone)


class _Told:
    """One artifact that differs, its joints by the frame that they place."""

    def __init__(self, pair: Pair) -> None:
        self.old, self.new = pair.old, pair.new
        self.carries_links = FORMATS[pair.backend].load is not None
        self.complete = FORMATS[pair.backend].proving.complete
        self.joints = joints_by_child(pair.old), joints_by_child(pair.new)

    def was(self, name: str) -> bool:
        """Say whether the artifact knew a link, or a frame."""
        return name in self.old.names


def _place(view: View, frame: str) -> tuple[str, Pose] | None:
    """Return the parent of a frame and where it sits there; None if the artifact does not say."""
    values = [view.plain.get(Fact("frame", frame, f"origin {axis}")) for axis in AXES]
    parent = view.parent(frame)
    if not parent or not all(value is not None and isinstance(value.value, float) for value in values):
        return None
    x, y, z = (float(value.value) for value in values if value is not None)
    turn = view.turns.get(frame)
    return parent, Pose((x, y, z), turn.rpy if turn else (0.0, 0.0, 0.0))


def _same_place(told: _Told, frame: str) -> bool:
    """Say whether an artifact has a frame where it had it."""
    facts = [Fact("frame", frame, f"origin {axis}") for axis in AXES]
    was, became = told.old.turns.get(frame), told.new.turns.get(frame)
    unturned = was is became or (was is not None and became is not None and same_angles(was, became))
    return unturned and all(same_value(told.old.plain.get(fact), told.new.plain.get(fact)) for fact in facts)


def _joint(joint: Joint, known: Iterable[_Told]) -> Joint:
    """Return a joint as the first artifacts say that it was which say that it was another one."""
    made = joint
    for told in known:
        was, became = _place(told.old, joint.child), _place(told.new, joint.child)
        if was is None:
            continue
        if became is not None and (was[0] != became[0] or not _same_place(told, joint.child)) and _at(made, joint):
            made = replace(made, parent=was[0], origin=was[1])
        made = _moving(made, joint, told)
    return made


def _at(made: Joint, joint: Joint) -> bool:
    """Say whether a joint still is where it was compiled to: no artifact before said that it was elsewhere."""
    return made.origin is joint.origin and made.parent == joint.parent


def _moving(made: Joint, joint: Joint, told: _Told) -> Joint:
    """Return a joint with the type, axis and leader that an artifact said it had, where it says others now."""
    names = [joints.get(joint.child, "") for joints in told.joints]
    types = [view.text("joint", name, "type") for view, name in zip((told.old, told.new), names, strict=True)]
    was, became = (kind if kind in _TYPES else "fixed" for kind in types)
    if was != became and made.type == joint.type:
        made = replace(made, type=was)
    if was == "fixed" or not names[0]:
        return made
    axes = [_axis(view, name) for view, name in zip((told.old, told.new), names, strict=True)]
    if axes[0] is not None and axes[0] != axes[1] and made.axis == joint.axis:
        made = replace(made, axis=axes[0])
    leaders = [_mimic(view, name) for view, name in zip((told.old, told.new), names, strict=True)]
    if leaders[0] != leaders[1] and made.mimic == joint.mimic:
        made = replace(made, mimic=leaders[0])
    return made


def _axis(view: View, joint: str) -> Vector | None:
    values = [view.plain.get(Fact("joint", joint, f"axis {axis}")) for axis in AXES]
    numbers = [value.value for value in values if value is not None]
    if len(numbers) < len(AXES) or not any(numbers):
        return None
    x, y, z = map(float, numbers)
    return (x, y, z)


def _mimic(view: View, joint: str) -> Mimic | None:
    leader = view.text("joint", joint, "mimic joint")
    values = [view.plain.get(Fact("joint", joint, f"mimic {part}")) for part in ("multiplier", "offset")]
    multiplier, offset = (float(one.value) if one else usual for one, usual in zip(values, (1.0, 0.0), strict=True))
    return Mimic(leader, multiplier, offset) if leader else None


def _link(link: Link, known: Sequence[_Told]) -> Link:
    """Return a link with the shapes that it had."""
    collision, visual = (_shapes(link, purpose, known) for purpose in ("collision", "visual"))
    return replace(link, collision=collision, visual=visual, inertial=None)


def _shapes(link: Link, purpose: str, known: Sequence[_Told]) -> tuple[Shape, ...]:
    now: tuple[Shape, ...] = getattr(link, purpose)
    key = (link.name, purpose)
    tellers = [told for told in known if key in told.old.shapes or key in told.new.shapes]
    told = next((one for one in tellers if one.complete), tellers[0] if tellers else None)
    if told is None or not told.was(link.name):
        return now
    change = delta(*(_bare(view.shapes.get(key, ())) for view in (told.old, told.new)))
    added = [*map(_wordless, change.added)]
    tried = []
    for form in (ROWS, MERGED):  # what the artifact has made of height maps
        pieces = [(shape, solid) for shape in now for solid in shape.solids(form)]
        tried.append((pieces, match([_wordless(solid_from(solid)) for _, solid in pieces], added, _NOISE)))
    solids, found = max(tried, key=lambda one: len(one[1].pairs))
    if change.added and change.removed and not found.pairs:
        return now  # shapes of another frame, which tells of itself
    gone = {index for index, _ in found.pairs}
    cut = {id(shape) for index, (shape, _) in enumerate(solids) if index in gone}
    kept = [shape for shape in now if id(shape) not in cut]
    kept += [solid for index, (shape, solid) in enumerate(solids) if id(shape) in cut and index not in gone]
    return (*kept, *filter(None, map(_shape, change.removed)))


def _bare(solids: Sequence[Solid]) -> list[Solid]:
    """Return solids without their names and colours: only of a mesh its file says where it is."""
    return [one._replace(words=tuple(word for word in one.words if word.startswith(_FILE))) for one in solids]


def _wordless(solid: Solid) -> Solid:
    return solid._replace(words=())


def _shape(solid: Solid) -> Shape | None:
    """Return a solid as a shape; None for one of a kind that nobody draws."""
    if solid.kind == "mesh" and len(solid.sizes) == 3:
        file = next((word.removeprefix(_FILE) for word in solid.words), "")
        x, y, z = solid.sizes
        return Shape(Mesh(file, (x, y, z)), pose_of(Transform(solid.rows, solid.centre)))
    return shape_of(solid)


def _put_back(told: _Told, links: dict[str, Link], joints: dict[str, Joint]) -> None:
    """Add the frames that an artifact knew, and knows no more, to what they hung on."""
    gone = [name for name in sorted(told.old.names - told.new.names) if name not in links]
    added = True
    while added:
        added = False
        for name in gone:
            place = _place(told.old, name)
            if name not in links and place is not None and place[0] in links:
                links[name], joints[name] = _added(told, name, place)
                added = True


def _added(told: _Told, name: str, place: tuple[str, Pose]) -> tuple[Link, Joint]:
    """Return a link that is no more, and the joint that it hung by."""
    collision, visual = (
        tuple(filter(None, map(_shape, told.old.shapes.get((name, purpose), ()))))
        for purpose in ("collision", "visual")
    )
    joint = told.joints[0].get(name, "")
    kind = told.old.text("joint", joint, "type")
    axis, leader = _axis(told.old, joint), _mimic(told.old, joint)
    made = Joint(joint or name, kind if kind in _TYPES else "fixed", place[0], name, place[1], mimic=leader)
    return Link(name, collision=collision, visual=visual), replace(made, axis=axis) if axis else made


def _was_root(link: str, known: Iterable[_Told]) -> bool:
    """Say whether a link that hangs on another one now was the root."""
    return any(
        told.carries_links and told.was(link) and _place(told.old, link) is None and _place(told.new, link) is not None
        for told in known
    )


def _hang(root: str, known: Iterable[_Told], links: dict[str, Link], joints: dict[str, Joint]) -> None:
    """Put what the root of now hung on above it."""
    for told in known:
        name = root
        if _place(told.new, root) is not None:
            continue  # its parent is no link, such as a world
        while told.carries_links and (place := _place(told.old, name)) is not None and name not in joints:
            joints[name] = replace(_added(told, name, place)[1])
            if place[0] in links:
                return
            links[place[0]] = Link(place[0])
            name = place[0]
        if name != root:
            _put_back(told, links, joints)
            return


def _is_new(name: str, known: Iterable[_Told]) -> bool:
    """Say whether an artifact has a link that it had not, and none had it."""
    tellers = [told for told in known if told.was(name) or name in told.new.names]
    return bool(tellers) and not any(told.was(name) for told in tellers)


def _tree(robot: Robot, links: Mapping[str, Link], joints: Mapping[str, Joint], gone: set[str]) -> Robot:
    """Return the robot of links and joints, without what is ``gone`` and what hangs on nothing.

    Where artifacts contradict each other so that no tree is left, that is the robot of now.
    """
    standing = {name: link for name, link in links.items() if name not in gone}
    roots = [name for name in standing if name not in joints]
    below: dict[str, list[str]] = {}
    for child, joint in joints.items():
        below.setdefault(joint.parent, []).append(child)
    best: list[str] = []
    for root in roots:
        found, waiting = [root], [root]
        while waiting:
            children = [name for name in below.get(waiting.pop(), ()) if name in standing]
            found += children
            waiting += children
        best = max(best, found, key=len)
    if not best:
        return robot
    kept = set(best)
    return Robot(
        robot.name,
        tuple(link for name, link in standing.items() if name in kept),
        tuple(joint for child, joint in joints.items() if child in kept and joint.parent in kept),
        materials=robot.materials,
    )
