"""Report properties of a robot that MJCF cannot express or that MuJoCo rejects."""

import posixpath
import re
from collections.abc import Iterator, Mapping, Sequence

from rosorin_compile.formats.gazebo import SPRING, blocks_in
from rosorin_compile.model import Inertial, Joint, Mesh, Robot
from rosorin_compile.model.link import Inertia, along_link
from rosorin_compile.model.shape import MERGED
from rosorin_compile.model.simulation import SENSOR_ELEMENT
from rosorin_compile.source.cache import of_robot
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, first_of

from .bodies import WORLD, body_name, has_volume, is_free, weld_groups

# Attributes of a pair, a spatial tendon or a sensor that refer to a geom (sensor: objtype="geom" objname="...").
_GEOM = r"""\b(?:geom[12]?|(?:obj|ref)type="geom" (?:obj|ref)name)="([^"]*)\""""

_MESH_FORMATS = (".stl", ".obj", ".msh")
_CONVERTED = (".dae", ".gltf", ".glb")  # meshes that are converted to .obj
MESHES = "meshes"  # folder next to the MJCF for meshes from ROS packages


def mesh_path(file: str) -> str:
    """Convert the file name of a mesh to its path in the MJCF, or return "" for an unsupported format.

    >>> mesh_path("package://arm/visual/base.DAE"), mesh_path("base.stl"), mesh_path("base.step")
    ('meshes/arm/visual/base.DAE.obj', 'base.stl', '')
    """
    ending = posixpath.splitext(file)[1].lower()
    return _path(file, ".obj" * (ending in _CONVERTED)) if ending in (*_CONVERTED, *_MESH_FORMATS) else ""


def texture_path(file: str) -> str:
    """Convert the file name of an image to its path in the MJCF, or return "" if it is not a PNG."""
    return _path(file, "") if file and posixpath.splitext(file)[1].lower() == ".png" else ""


def file_path(file: str) -> str:
    """Convert the file name of a mesh or an image to its path in the MJCF, or return "" for an unsupported format."""
    return mesh_path(file) or texture_path(file)


def _path(file: str, more: str) -> str:
    scheme, mark, rest = file.partition("://")
    if mark and scheme in ("package", "model"):
        rest = rest.lstrip("/")  # package:///NAME/FILE is also valid
        parts = rest.split("/")
        return "" if {"", ".", ".."} & set(parts) or len(parts) < 2 else f"{MESHES}/{rest}{more}"
    if mark or file.startswith("/"):
        return "" if more or scheme not in ("file", file) else file.removeprefix("file://")
    if not more:
        return file
    outside = posixpath.normpath(file)
    inside = re.sub(r"^(\.\./)+", "", outside)  # converted files are in a folder next to the MJCF
    return f"{inside}{more}" if inside == outside else f"{MESHES}/{inside}{more}"


def is_written(robot: Robot, mesh: Mesh) -> bool:
    """Return True if the MJCF contains a mesh, because MuJoCo supports its format and its file was found."""
    return bool(mesh_path(mesh.file)) and mesh.file not in robot.missing_meshes


def is_textured(robot: Robot, texture: str) -> bool:
    """Return True if the MJCF contains an image, because it is a PNG and its file was found."""
    return bool(texture_path(texture)) and texture not in robot.missing_meshes


def check_names(text: str, left_out: Mapping[str, str]) -> Iterator[Diagnostic]:
    """Yield an error for each reference in an MJCF to an omitted geom; ``left_out`` maps omitted geoms to links."""
    if not left_out:
        return
    from html import unescape  # slow to import

    for name in dict.fromkeys(re.findall(_GEOM, text)):
        if (link := left_out.get(unescape(name))) is not None:
            message = f'a shape of link "{link}" is left out of the MJCF, and something names it ({unescape(name)})'
            help = "put the file of its mesh there, or take out what names it"
            yield Diagnostic("mjcf-left-out", ERROR, message, help=help)


def position_range(joint: Joint) -> tuple[float, float] | None:
    """Return the position limits of a joint (rad or m), or None if the joint has no limits or never moves."""
    limit = joint.limit if joint.moves else None
    if joint.type == "continuous" or limit is None:
        return None
    lower, upper = limit.known_value("lower"), limit.known_value("upper")
    return None if lower is None or upper is None else (lower, upper)


def _omitted(message: str, help: str = "", severity: str = WARNING) -> Diagnostic:
    return Diagnostic("mjcf-cannot-say", severity, message, help=help)


def report_omissions(robot: Robot, joints: list[Joint], unpaired: Sequence[tuple[str, str]]) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each property that MJCF cannot express; ``unpaired`` are links without contact pairs."""
    for joint in joints:
        ends, effort = position_range(joint), joint.limit.known_value("effort") if joint.limit else None
        what, empty = f'joint "{joint.name}"', "MuJoCo ignores an empty range"
        if ends and ends[0] >= ends[1]:
            message = f"{what} is limited to {ends[0]:g} to {ends[1]:g}: {empty}"
            yield _omitted(message, "make the joint fixed, or its range wider")
        if joint.moves and effort is not None and effort <= 0:
            yield _omitted(f"{what} has an effort of {effort:g}: {empty} of forces", "give its real effort")
        words = ["limit"] if joint.limit is not None and joint.type == "planar" else []
        words += ["dynamics"] if joint.dynamics is not None and joint.type != "ball" else []
        if words and not joint.moves and not is_free(robot, joint):
            message = f"{what} is {joint.type}, without its {' and '.join(words)} in the MJCF"
            yield _omitted(message, "the URDF carries them")
    files = [shape.texture for link in robot.links for shape in link.visual]
    files += [material.texture for material in robot.materials]
    textures, meshes = [name for name in dict.fromkeys(files) if name and not texture_path(name)], list[str]()
    for link, shape in [(one, shape) for one in robot.walk() for shape in (*one.collision, *one.visual)]:
        if not all(has_volume(solid.geometry) for solid in shape.solids(MERGED)):
            kind = type(shape.geometry).__name__.lower()
            message = f'a {kind} of link "{link.name}" is left out of the MJCF: MuJoCo takes no size of zero'
            yield _omitted(message, "give it sizes above zero")
        elif isinstance(shape.geometry, Mesh) and not mesh_path(shape.geometry.file):
            meshes.append(shape.geometry.file)
    if textures:  # the MJCF has only the colour
        message = f"left out of the MJCF: {first_of(textures, 3)}; MuJoCo opens textures that are PNG files"
        yield _omitted(message, "save it as PNG, and name the new file", NOTE)
    if meshes:
        message = f"left out of the MJCF: {first_of(list(dict.fromkeys(meshes)), 3)}; MuJoCo reads STL,"
        message += " OBJ and MSH meshes; DAE, glTF and GLB are converted"
        yield _omitted(message, "convert the mesh, and use the new file")
    if WORLD in robot.link:
        message = f'MuJoCo has a body "{WORLD}": that of link "{WORLD}" is "{body_name(robot, WORLD)}" in the MJCF'
        yield _omitted(message, severity=NOTE)
    if ignored := list(dict.fromkeys(_of_gazebo(robot))):
        message = f"elements for Gazebo have no effect in the MJCF: {first_of(ignored, 3)}"
        yield _omitted(message, 'also describe them with keys such as "sensors", "contact" or "dynamics"', NOTE)
    if unpaired:
        which = first_of([f'"{one}" and "{other}"' for one, other in unpaired], 3)
        message = f"links with too many shapes collide only if one is fixed to the world: {which}"
        yield _omitted(message, "fewer shapes: a height map of larger cells or steps", NOTE)


# Elements in <gazebo> and <sdf> blocks that do not change the physics.
_HARMLESS = {"plugin", "material", "transparency", "visual", "cast_shadows", "provideFeedback", "implicitSpringDamper"}
_HARMLESS |= {"preserveFixedJoint", "disableFixedJointLumping", "disableJointLumping"}


def _of_gazebo(robot: Robot) -> Iterator[str]:
    holders = [(item.name, item.urdf_elements) for items in (robot.links, robot.joints) for item in items]
    holders += [(link.name, shape.urdf_elements) for link in robot.links for shape in link.collision]
    for name, texts in [("", robot.urdf_elements), *holders]:
        for block in blocks_in(texts, "gazebo", "sdf"):
            of = block.get("reference", name)
            dynamics = robot.joint[of].dynamics if of in robot.joint else None
            left_out = {*_HARMLESS, *(SPRING if dynamics is not None and dynamics.stiffness else ())}
            yield from (f"<{inner.tag}>{of and f' of {of}'}" for inner in block if inner.tag not in left_out)


# Minima of MuJoCo 4.0.0: mass (kg) and moments (kg*m^2) of a moving body, principal moments of a fullinertia.
LEAST = 1e-15
LEAST_EIGENVALUE = 1e-14


def has_mass(inertial: Inertial) -> bool:
    """Return True if the mass or a moment or product of inertia is not zero."""
    return bool(inertial.mass or inertial.ixx or inertial.iyy or inertial.izz) or has_products(inertial)


def has_products(inertial: Inertial) -> bool:
    """Return True if the products of inertia are not all zero."""
    return any((inertial.ixy, inertial.ixz, inertial.iyz))


def along_link_of(inertial: Inertial) -> Inertia:
    """Return the inertia (kg*m^2) along the axes of the link as (xx, yy, zz, xy, xz, yz)."""
    six = (inertial.ixx, inertial.iyy, inertial.izz, inertial.ixy, inertial.ixz, inertial.iyz)
    return along_link(six, inertial.pose.transform())


def _moves(robot: Robot, names: Sequence[str]) -> bool:
    inertials = (robot.link[name].inertial for name in names)
    return any(one and one.mass >= LEAST and one.principal_moments[0] >= LEAST for one in inertials)


@of_robot
def weightless(robot: Robot, free: bool) -> list[str]:
    """Return the massless links between joints. They get a minimal mass, because MuJoCo rejects moving massless bodies.

    The import adds such links to bodies with several joints. The minimal mass does not change the motion of links that
    are some 10^12 times heavier. ``free`` is true if the base has a free joint.
    """
    groups = weld_groups(robot)
    top_of = {name: top for top, names in groups.items() for name in names}
    massive = {top_of[link.name] for link in robot.links if link.inertial is not None and has_mass(link.inertial)}
    heavy, without = set[str](), list[str]()
    for top in reversed(groups):
        joint = robot.joint_to.get(top)
        if top in heavy and top not in massive and (free or top != robot.root):  # the root only moves if it is free
            without.append(top)
        if joint is not None and (top in heavy or _moves(robot, groups[top])):
            heavy.add(top_of[joint.parent])
    return without[::-1]


def check_loadable(robot: Robot, free: bool) -> Iterator[Diagnostic]:
    """Report names and masses that MuJoCo rejects or changes; ``free`` is true if the base has a free joint."""
    for sensor, part in [(one, part) for one in robot.sensors for part in one.simulated]:
        site = part.name if part.element == "site" else ""
        if part.kind == SENSOR_ELEMENT:
            site = "" if part.pose is None else part.site
        if part.replicas is None and site in robot.link:
            message = f'sensor "{sensor.name}" adds a site "{site}", but in MJCF that is the site of the link "{site}"'
            yield Diagnostic("mjcf-reserved-name", ERROR, message, help='add "name: NAME" to this entry of "mjcf"')
    if carried := weightless(robot, free):
        message = f"MuJoCo loads no moving body without mass: {first_of(carried, 3)} with {LEAST:g} kg in the MJCF"
        yield _omitted(f"{message}, whose mass hangs on further joints", severity=NOTE)
    for top, names in weld_groups(robot).items():
        joint = robot.joint_to.get(top)
        if top in carried or (joint is None and not free) or _moves(robot, names):
            continue
        what = f'joint "{joint.name}" moves link "{top}"' if joint else f'"base: free" lets link "{top}" move'
        message = f"{what}, but neither that link nor a link fixed to it has a mass, so MuJoCo refuses the model"
        help = f'add "inertial" to "{top}", or {"make the joint fixed" if joint else "write base: fixed"}'
        yield Diagnostic("mjcf-needs-mass", ERROR, message, help=help)
    for link in robot.links:
        if link.inertial is None or not has_mass(link.inertial):
            continue
        low, middle, high = link.inertial.principal_moments
        products = has_products(link.inertial) and any(along_link_of(link.inertial)[3:])
        if link.inertial.mass < 0 or (low < 0 and not products):
            yield _omitted(f'MuJoCo takes the negative mass or moments of link "{link.name}" for zero', "correct them")
        why = "it has products of inertia, but a zero principal moment" if low < LEAST_EIGENVALUE and products else ""
        if (low if products else max(low, 0.0)) + middle < high:
            why = "the largest principal moment exceeds the sum of the others"
        if why:
            message = f'MuJoCo refuses the inertia of link "{link.name}": {why}'
            yield Diagnostic("mjcf-refused-inertia", ERROR, message, help="correct the inertia, or remove the output")
