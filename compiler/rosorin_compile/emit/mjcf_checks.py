"""What MuJoCo does not load and what MJCF has no word for, told before the artifact is."""

from __future__ import annotations

from collections.abc import Iterator

from ..diagnostic import ERROR, NOTE, WARNING, Diagnostic
from ..model import SENSOR_ELEMENT, Joint, Mesh, Robot, Simulated

_MESH_FORMATS = (".stl", ".obj", ".msh")


def mesh_path(mesh: Mesh) -> str:
    """Return the file of a mesh as MuJoCo opens it; empty if MuJoCo cannot."""
    if mesh.file.startswith("package://") or not mesh.file.lower().endswith(_MESH_FORMATS):
        return ""
    return mesh.file.removeprefix("file://")


def position_range(joint: Joint) -> tuple[float, float] | None:
    """Return the limits of the position of a joint (rad or m); None where it has none."""
    limit = joint.limit
    if joint.type == "continuous" or limit is None or limit.lower is None or limit.upper is None:
        return None
    return (limit.lower, limit.upper)


def weld_groups(robot: Robot) -> dict[str, list[str]]:
    """Return the links that no joint moves against each other, in the order of the tree, by the topmost of them."""
    top: dict[str, str] = {}
    groups: dict[str, list[str]] = {}
    for link in robot.walk():
        joint = robot.joint_to.get(link.name)
        top[link.name] = link.name if joint is None or joint.moves else top[joint.parent]
        groups.setdefault(top[link.name], []).append(link.name)
    return groups


def refused(robot: Robot, free: bool) -> Iterator[Diagnostic]:
    """Yield an error for each thing that MuJoCo does not load."""
    for top, names in weld_groups(robot).items():
        joint = robot.joint_to.get(top)
        if (joint is None and not free) or any(robot.link[name].inertial for name in names):
            continue
        what = f'joint "{joint.name}" moves link "{top}"' if joint else f'"base: free" lets link "{top}" move'
        message = f"{what}, but neither it nor a link fixed to it has a mass: MuJoCo does not load that"
        way_out = "make the joint fixed" if joint else 'say "base: fixed"'
        yield Diagnostic("mjcf-needs-mass", ERROR, message, help=f'give "{top}" an inertial, or {way_out}')
    if "world" in robot.link:
        message = 'MuJoCo keeps the name "world" for its own root body: link "world" cannot be told in MJCF'
        yield Diagnostic("mjcf-reserved-name", ERROR, message, help='call the link something else, such as "base"')
    for sensor in robot.sensors:
        for part in sensor.simulated:
            site = _site_name(part)
            if site in robot.link:
                message = (
                    f'sensor "{sensor.name}" brings a site called "{site}", but in MJCF that is the site of the link'
                )
                yield Diagnostic("mjcf-reserved-name", ERROR, message, help="name the element of its type: name: WORD")


def _site_name(part: Simulated) -> str:
    """Return the name of the site that an element of a sensor brings; empty if it brings none, or many."""
    if part.replicas is not None:
        return ""
    if part.kind == SENSOR_ELEMENT:
        return "" if part.pose is None else part.site
    return part.name if part.element == "site" else ""


def unsaid(robot: Robot, joints: list[Joint]) -> Iterator[Diagnostic]:
    """Yield what joints and meshes have that MJCF has no word for."""
    for joint in joints:
        ends = position_range(joint)
        if ends and ends[0] == ends[1]:
            message = f'joint "{joint.name}" is held at {ends[0]:g}: MuJoCo takes a range of no width for no limit'
            yield Diagnostic("mjcf-cannot-say", WARNING, message, help="make the joint fixed, or its range wider")
        if joint.limit and joint.limit.effort == 0:
            message = f'joint "{joint.name}" has an effort of 0: MuJoCo takes a force range of no width for no limit'
            yield Diagnostic("mjcf-cannot-say", WARNING, message, help="give the effort that the joint really has")
    fast = sum(joint.limit is not None and joint.limit.velocity is not None for joint in joints)
    if fast:
        message = f"MJCF has no velocity limit: that of {fast} joint{'' if fast == 1 else 's'} is left out"
        yield Diagnostic("mjcf-cannot-say", NOTE, message)
    yield from _unreadable(robot)


def _unreadable(robot: Robot) -> Iterator[Diagnostic]:
    """Yield a warning for each shape that is left out because MuJoCo cannot open its mesh."""
    for link in robot.walk():
        for shape in (*link.collision, *link.visual):
            if isinstance(shape.geometry, Mesh) and not mesh_path(shape.geometry):
                message = f'mesh {shape.geometry.file} of link "{link.name}" is left out of the MJCF: MuJoCo opens'
                message += " STL, OBJ and MSH files by their path, no package:// address and no other format"
                yield Diagnostic("mjcf-cannot-say", WARNING, message, help="give a path relative to the artifact")
