"""Generate the ``<gazebo>`` blocks of a URDF for sensors, actuators and springs, and compare URDF elements.

Gazebo converts a URDF to SDF with libsdformat, which drops links without mass, merges links that are connected by fixed
joints (sensors move along, and references to a merged link stay valid), names collisions after the merged link, and
combines all ``<gazebo>`` blocks of a link or joint (``gazebosim/sdformat@sdf14:src/parser_urdf.cc``; tested with 12). A
comparison ignores white space, comments, order and SDF defaults, except in a plug-in.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from itertools import product, starmap
from typing import TYPE_CHECKING
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from markupsafe import escape

from rosorin_compile.model import Output, Pose, Robot, Sensor
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.model.simulation import CLASSIC, MOTOR, POSITION, VELOCITY, GazeboSensor, SdfElement
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic
from rosorin_compile.source.numbers import NumberFormat, number_format, vector
from rosorin_compile.source.wording import plural, quote
from rosorin_compile.source.xml.elements import canonical, tree_of

from .format import Unsupported
from .templating import attributes

if TYPE_CHECKING:
    from .urdf.write import Content

DISTRIBUTIONS = GazeboSensor.FRAME_ELEMENTS

# Default values in SDF, by the tag of the parent and the tag of the element
# (sdformat@sdf14:sdf/1.11/{sensor,lidar,camera,noise}.sdf).
SDF_DEFAULTS = {
    "sensor": {"always_on": "false", "visualize": "false", "update_rate": "0", "pose": "0 0 0 0 0 0"},
    **{key: {"resolution": "1"} for key in ("horizontal", "vertical")},
    "range": {"resolution": "0"},
    "camera": {"horizontal_fov": "1.047"},
    "image": {"width": "320", "height": "240"},
    "clip": {"near": "0.1", "far": "100"},
    "imu": {"enable_orientation": "true"},
    "noise": {"mean": "0", "bias_mean": "0", "bias_stddev": "0"},
}
SPRING = ("springStiffness", "springReference")
SDF_FLAGS = ("always_on", "visualize", "enable_orientation", "enable_metrics")
SDF_TRUTH = {"1": "true", "0": "false", "True": "true", "False": "false"}


def distribution(asked: object) -> str:
    """Return the Gazebo release that an option ``gazebo`` selects: "harmonic" for True, or "" for no Gazebo."""
    return "harmonic" if asked is True else str(asked or "")


def sensor_lines(
    one: GazeboSensor, frame_id: str, number: NumberFormat, indent: str, pose: str, collisions: Sequence[str] = ()
) -> Iterator[str]:
    """Yield the lines of a <sensor>; ``frame_id`` is the tag for its frame name, ``pose`` a <pose> element or ""."""
    names = {element.name for element in one.elements} | one.without
    is_stamped = one.stamp and frame_id and not names & {*DISTRIBUTIONS.values(), frame_id}
    shapes = tuple(SdfElement("collision", name) for name in collisions)
    own = (*one.elements, SdfElement("contact")) if shapes and "contact" not in names else one.elements
    own = tuple(replace(e, elements=(*shapes, *e.elements)) if e.name == "contact" else e for e in own)
    own = (SdfElement(frame_id, one.stamp), *own) if is_stamped else own
    return _lines(SdfElement("sensor", None, {"name": one.name, "type": one.type}, own), indent, number, pose)


def _lines(element: SdfElement, indent: str, number: NumberFormat, first: str = "") -> Iterator[str]:
    def word(value: float | str | bool) -> str:
        text = number(value) if isinstance(value, float) else str(value)
        return text.lower() if isinstance(value, bool) else text

    name = escape(element.name)
    start = f"{indent}<{name}{attributes(**{key: word(value) for key, value in element.attributes.items()})}"
    if element.value is not None:
        yield f"{start}>{escape(word(element.value))}</{name}>"
    elif not element.elements and not first:
        yield f"{start}/>"
    else:
        yield f"{start}>"
        yield from [f"{indent}  {first}"] if first else []
        for inner in element.elements:
            yield from _lines(inner, indent + "  ", number)
        yield f"{indent}</{name}>"


# Plug-ins for actuators: gz-sim@gz-sim8:src/systems/{joint_position_controller,joint_controller,apply_joint_force}
_PLUGINS = {
    POSITION: ("joint-position-controller", "JointPositionController"),
    VELOCITY: ("joint-controller", "JointController"),
    MOTOR: ("apply-joint-force", "ApplyJointForce"),
}
_OTHER_TARGETS = ("body", "crank_site", "joint_in_parent", "reference_site", "site", "slider_site", "tendon")


def unsupported_drives(output: Output, quiet: bool = False) -> Mapping[str, Unsupported]:
    """Map unsupported actuator keys to reasons; with ``quiet``, a URDF that is not for Gazebo gives no notes."""
    places = ("actuators.*", "joints.*.actuator")
    if distribution(output.options.get("gazebo")) in ("", CLASSIC):
        return dict.fromkeys(places, Unsupported("no drives; newer versions of Gazebo have plug-ins for them", quiet))
    bound = Unsupported("Gazebo bounds commands by the limits of the joint, and names topics after it", quiet=True)
    found = {f"{place}.{key}": bound for place in places for key in ("name", "range", "unlimited", "mjcf")}
    found |= {f"{place}.{key}": Unsupported("no such gain") for place in places for key in ("gear", "damping_ratio")}
    return found | {f"actuators.*.{key}": Unsupported("only drives of joints") for key in _OTHER_TARGETS}


def drive_blocks(
    robot: Robot, joints: Mapping[str, str], rule: str, gazebo: str, number: NumberFormat, others: Iterable[str]
) -> tuple[list[str], list[Diagnostic]]:
    """Return a ``<gazebo>`` block for each actuator of a joint, and a warning for actuators without a plug-in."""
    # An actuator with gains becomes a controller with the same control law: kp * (command - position) - kv * speed or
    # kv * (command - speed). Joints that the XML snippets in ``others`` already control are skipped.
    blocks, without, unbounded, taken = list[str](), list[str](), list[str](), set[str]()
    if gazebo in ("", CLASSIC):
        return [], []
    for root in (tree_of(f"<all>{text}</all>") for text in others if "<ros2_control" in text or "<plugin" in text):
        taken |= {joint.get("name", "") for block in root.iter("ros2_control") for joint in block.iter("joint")}
        # Plug-ins such as JointStatePublisher list joints that they do not drive.
        plugins = [plugin for plugin in root.iter("plugin") if "state" not in plugin.get("name", "").lower()]
        inner = (element for plugin in plugins for element in plugin.iter())
        taken |= {(element.text or "").strip() for element in inner if "joint" in element.tag.lower()}
    program, namespace = ("ignition-gazebo", "ignition::gazebo") if gazebo == "fortress" else ("gz-sim", "gz::sim")
    pairs = [(joint.actuator, joint) for joint in robot.joints if joint.actuator]
    pairs += [(one, robot.joint[name]) for one in robot.actuators if (name := one.targets.get("joint", ""))]
    without += [one.name for one in robot.actuators if "joint" not in one.targets]
    for actuator, joint in pairs:
        kind, name = actuator.type, joints.get(joint.name, "")
        is_braked = actuator.damping and kind != POSITION  # only position controllers have damping
        if name in taken:
            continue
        if not name or not joint.moves or kind not in _PLUGINS or is_braked:
            without.append(actuator.name or joint.name)
            continue
        # MuJoCo applies the damping of an actuator at the joint, so it acts like kv. kp and kv default to 1.
        gains = {"p_gain": actuator.kv or 1.0} if kind == VELOCITY else {}
        if kind == POSITION:
            gains = {"p_gain": 1.0 if actuator.kp is None else actuator.kp, "d_gain": actuator.kv + actuator.damping}
        effort = joint.limit.known_value("effort") if joint.limit else None
        force = actuator.force or ((-effort, effort) if effort else None)
        gains |= {"cmd_min": force[0], "cmd_max": force[1]} if force is not None and kind != MOTOR else {}
        is_bounded = kind == POSITION or (actuator.range is None and (kind != MOTOR or actuator.force is None))
        unbounded += [] if is_bounded else [actuator.name or joint.name]
        values = {"joint_name": name, **({"use_force_commands": True} if kind == VELOCITY else {}), **gains}
        file, word = _PLUGINS[kind]
        names = {"filename": f"{program}-{file}-system", "name": f"{namespace}::systems::{word}"}
        plugin = SdfElement("plugin", None, names, tuple(starmap(SdfElement, values.items())))
        blocks.append("\n".join(_lines(SdfElement("gazebo", elements=(plugin,)), "", number)))
    message = f"Gazebo {gazebo} has no plug-in for {plural('actuator', len(without))} {quote(without, 3)}"
    help = "drive the joint by position, velocity or motor, or by ros2_control"
    lost = [Diagnostic(rule, WARNING, message, help=help)] if without else []
    message = f"Gazebo does not apply the force or range of {plural('actuator', len(unbounded))} {quote(unbounded, 3)}"
    note = Diagnostic(rule, NOTE, message, help="bound the commands in the controller")
    return blocks, [*lost, note] if unbounded else lost


_KEEPING = ("preserveFixedJoint", "disableFixedJointLumping")


def gazebo_blocks(content: "Content") -> tuple[list[str], list[Diagnostic]]:
    """Return the <gazebo> blocks of a URDF, and warnings about values that its Gazebo release ignores."""
    robot, number = content.robot, number_format(content.output.options)
    name, mounting = distribution(content.output.options["gazebo"]), _Mounting(content)
    blocks: list[str] = []
    unseen: dict[tuple[str, str], list[str]] = {}  # {(reason, help): names of sensors}
    for sensor, one in [(each, one) for each in robot.sensors for one in each.gazebo]:
        link, pose, collisions, reason = mounting.place(sensor, one)
        if reason[0]:
            names = unseen.setdefault(reason, [])
            names += [] if sensor.name in names else [sensor.name]
            continue
        lines = [f"  <gazebo{attributes(reference=link)}>"]
        if one.at_joint and robot.joint[one.link].is_fixed and one.link not in mounting.kept:
            lines.append("    <preserveFixedJoint>true</preserveFixedJoint>")
        numbers = f"{vector(pose.xyz, number)} {vector(pose.rpy, number)}"
        place = "" if pose == IDENTITY else f"<pose>{numbers}</pose>"
        written = one.in_classic() if name == CLASSIC else one
        lines += sensor_lines(written, DISTRIBUTIONS[name], number, "    ", place, collisions)
        blocks.append("\n".join([*lines, "  </gazebo>"]))
    lost = []
    for (why, way), names in unseen.items():
        message = f"Gazebo ignores {plural('sensor', len(names))} {quote(names, 3)}: {why}"
        help = f'{way}, or write "gazebo: []" in the sensor to omit it in Gazebo'
        lost.append(Diagnostic("gazebo-cannot-see", WARNING, message, help=help))
    physics, lost_physics = _physics(content)
    return [*blocks, *physics], [*lost, *lost_physics]


def blocks_in(elements: Iterable[str], *tags: str) -> Iterator[Element]:
    """Yield the elements with one of the tags, by default "gazebo", in strings of XML."""
    for text, tag in product(elements, tags or ("gazebo",)):
        if f"<{tag}" in text:
            yield from tree_of(f"<all>{text}</all>").iter(tag)


def _physics(content: "Content") -> tuple[list[str], list[Diagnostic]]:
    """Return the <gazebo> blocks for joint springs and for friction; Gazebo reads only one coefficient per link."""
    robot, number = content.robot, number_format(content.output.options)
    own = {(block.get("reference", ""), inner.tag) for block in blocks_in(robot.urdf_elements) for inner in block}
    values: dict[str, dict[str, float]] = {}
    lost, mixed, balls = list[tuple[str, str]](), list[str](), list[str]()
    for link in robot.links:
        shapes = content.collisions(link.name) if link.name in content.carried else ()
        coefficients = {shape.contact.sliding_friction if shape.contact else None for shape in shapes}
        known = [one for one in coefficients if one is not None]
        if known and not {(link.name, "mu1"), (link.name, "mu2")} & own:
            values[link.name] = {"mu1": min(known), "mu2": min(known)}
            mixed += [link.name] if len(coefficients) > 1 else []
    for joint in content.joints if "dynamics" in content.elements else ():
        spring = joint.dynamics
        if spring is not None and spring.stiffness and not joint.moves:
            balls.append(joint.name)
        elif spring is not None and spring.stiffness and (joint.name, "springStiffness") not in own:
            values[joint.name] = {"springReference": spring.spring_reference, "springStiffness": spring.stiffness}
    blocks = []
    for name, numbers in values.items():
        block = SdfElement("gazebo", None, {"reference": name}, tuple(starmap(SdfElement, numbers.items())))
        blocks.append("\n".join(_lines(block, "  ", number)))
    if balls:
        message = f"Gazebo reads no springs of joints that move in several directions: {quote(balls, 3)}"
        lost.append((message, "make each of them several joints, one for each axis"))
    name, followers = distribution(content.output.options["gazebo"]), [one.name for one in content.joints if one.mimic]
    if followers and name in ("fortress", CLASSIC):
        message = f"Gazebo {name} reads no mimic: nothing couples {plural('joint', len(followers))}"
        message += f" {quote(followers, 3)}"
        lost.append((message, "use Gazebo harmonic"))
    if mixed:
        message = f"shapes of {quote(mixed, 3)} differ in friction, and Gazebo reads one a link from a URDF: the least"
        lost.append((message, "give each shape a link of its own, or use the SDF"))
    return blocks, [Diagnostic("urdf-cannot-say", WARNING, message, help=help) for message, help in lost]


class _Mounting:
    """Computes the link of each sensor after Gazebo has merged the links that are connected by fixed joints."""

    def __init__(self, content: "Content") -> None:
        self.content, self.above = content, {joint.child: joint for joint in content.joints}
        robot = content.robot
        elements = robot.urdf_elements if "urdf_elements" in content.elements else ()
        blocks = blocks_in(text for text in elements if any(word in text for word in _KEEPING))
        kept = [one for one in blocks if any(one.findtext(word, "").strip() in ("true", "1") for word in _KEEPING)]
        self.kept = {one.get("reference", "") for one in kept}  # fixed joints whose links are not merged
        # Keep the links of a fixed joint with a sensor, unless Gazebo would then drop the child link for lack of mass.
        joints = {joint.name for joint in content.joints}
        at_joints = {one.link for sensor in robot.sensors for one in sensor.gazebo if one.at_joint} & joints
        self.measured: set[str] = set()
        for name in sorted(at_joints):
            self._merge({*self.kept, name})
            self.measured |= set() if self._dropped_with(robot.joint[name].child) else {name}
        self._merge(self.kept | self.measured)

    def _merge(self, kept: set[str]) -> None:
        joints = self.content.joints
        self.merging = {joint.child for joint in joints if joint.is_fixed and joint.name not in kept}
        self.below: dict[str, list[str]] = {}
        for joint in sorted(joints, key=lambda joint: joint.name):  # urdfdom sorts joints by name
            if joint.child in self.merging:
                self.below.setdefault(joint.parent, []).append(joint.child)

    def _top(self, link: str) -> str:
        while link in self.merging:
            link = self.above[link].parent
        return link

    def _pieces(self, top: str) -> Iterator[str]:
        """Yield the links that Gazebo merges into a link, in the order of their collisions."""
        yield top
        for child in self.below.get(top, ()):
            yield from self._pieces(child)

    def _dropped_with(self, link: str) -> str:
        """Return the massless link above that makes Gazebo drop ``link``, or "" if Gazebo keeps it."""
        masses, link = self.content.masses, self._top(link)
        while any(piece in masses and masses[piece].mass > 0 for piece in self._pieces(link)):
            if link not in self.above:
                return ""
            link = self.above[link].parent  # a massless link is dropped with its moving children even if it is merged
        return link

    def _collisions(self, link: str) -> list[str]:
        """Return the names of the collisions of a link in Gazebo, which numbers those of merged links together."""
        top = self._top(link)
        shapes = [(piece, shape) for piece in self._pieces(top) for shape in self.content.collisions(piece)]
        found = []
        for index, (piece, base) in enumerate((piece, shape.name or piece) for piece, shape in shapes):
            # Gazebo adds no prefix to a name that starts with the name of the merged link.
            name = base if base.startswith(top) else f"{top}_fixed_joint_lump__{base}"
            found += [f"{name}_collision{f'_{index}' if index else ''}"] if piece == link else []
        return found

    def place(self, sensor: Sensor, one: GazeboSensor) -> tuple[str, Pose, list[str], tuple[str, str]]:
        """Return the link, pose and collisions of a sensor, and (reason, help) if Gazebo drops the sensor."""
        carried, link, pose, names = self.content.carried, one.link, IDENTITY, list[str]()
        if one.at_joint:
            lost = "" if one.link in self.measured else sensor.frame
        else:
            frame, pose = (one.feels, IDENTITY) if one.feels else (one.link, one.pose)
            link, transform = frame, pose.transform()
            while link not in carried:
                above = self.content.robot.joint_to.get(link)
                if above is None or not above.is_fixed:
                    link = ""
                    break
                transform = above.origin.transform().then(transform)
                link, pose = above.parent, pose_of(transform)
            lost = frame if not link or (one.feels and link != frame) else self._dropped_with(link)
            names = self._collisions(link) if one.feels and not lost else []
        reason = ("", "")
        if lost and lost not in carried:
            reason = f'the URDF has no link "{lost}"', "let robot_state_publisher publish it"
        elif lost and "inertial" not in self.content.elements:
            reason = "no link in this URDF has a mass", 'add "inertial" to "elements" of the output'
        elif lost:
            way = 'add "inertial" to the link, or to a link that is fixed to it'
            reason = f'it drops link "{lost}", which has no mass in this URDF', way
        elif one.feels and not names:
            reason = f'link "{link}" has no collision shape in this URDF', 'add "collision" to the link'
        return link, pose, names, reason


_OF_NOISE = ("mean", "stddev", "bias_mean", "bias_stddev")
_MEASURED = {"rate": "angular_velocity", "accel": "linear_acceleration"}


def with_noise(text: str) -> str:
    """Convert the <noise> of an IMU in a Gazebo classic <sensor> to a <noise> for each axis."""
    # Up to SDF 1.4, <imu> has one <noise> with <rate> and <accel>, which readers of later versions ignore
    # (gazebosim/sdformat@sdf12:sdf/1.4/imu.sdf).
    try:
        root = tree_of(text if "<imu" in text and "<noise" in text else "<none/>")
    except ValueError:  # several elements, or not XML
        return text
    pairs = [(imu, noise) for imu in root.iter("imu") for noise in imu.findall("noise")]
    pairs = [(imu, noise) for imu, noise in pairs if any(child.tag in _MEASURED for child in noise)]
    for imu, noise in pairs:
        kind = noise.findtext("type") or noise.get("type") or "gaussian"
        for child in noise:
            if child.tag in _MEASURED and imu.find(_MEASURED[child.tag]) is None:
                measured = ElementTree.SubElement(imu, _MEASURED[child.tag])
                measured.tail = noise.tail
                for axis in "xyz":
                    noisy = ElementTree.SubElement(ElementTree.SubElement(measured, axis), "noise", type=kind)
                    for tag in (tag for tag in _OF_NOISE if child.find(tag) is not None):
                        ElementTree.SubElement(noisy, tag).text = child.findtext(tag, "").strip()
        imu.remove(noise)
    return ElementTree.tostring(root, "unicode") if pairs else text


_SIGNIFICANT = 9  # significant digits to compare, fewer than ``number_format: short`` prints
_DIGITS = 10  # decimals of a pose to compare (m, entries of a rotation matrix)
Key = tuple[str, ...]


def meanings(texts: Iterable[str], followers: Set[str] = frozenset()) -> Counter[Key]:
    """Convert the elements in XML snippets to canonical keys, and count equal keys; ``followers`` are mimic joints."""
    found: Counter[Key] = Counter()
    for text in texts:
        try:
            root = tree_of(with_noise(f"<all>{text}</all>"))
        except ValueError:
            found["text", " ".join(text.split())] += 1
            continue
        for element in root:
            if element.tag == "ros2_control":
                found["ros2_control", element.get("name", ""), _form(element, followers)] += 1
            elif element.tag == "gazebo" and not (element.text or "").strip():
                of = {key: value for key, value in sorted(element.attrib.items()) if key != "reference"}
                for child in element:
                    form = _form(child, followers) if child.tag in ("sensor", *SPRING) else canonical(child)
                    if form != "<springReference>0</>":  # the default
                        found["gazebo", element.get("reference", ""), repr(of), child.tag, form] += 1
            else:
                found[element.tag, canonical(element)] += 1
    return found


def _form(element: Element, followers: Set[str], above: str = "", lidar: bool = False) -> str:
    if element.tag == "plugin":
        return ElementTree.canonicalize(ElementTree.tostring(element), strip_text=True)
    lidar = element.get("type") in ("gpu_lidar", "lidar") if element.tag == "sensor" else lidar
    # <ray> and <lidar> are the same element in Gazebo; Gazebo classic supports only <ray>.
    tag = "lidar" if element.tag == "ray" and lidar and above == "sensor" else element.tag
    values = dict(element.attrib)
    if tag == "joint" and values.get("name") in followers:
        values.setdefault("mimic", "true")
    start = tag + "".join(f" {name}={_numbers(value)}" for name, value in sorted(values.items()))
    text = _numbers(element.text or "")
    text = SDF_TRUTH.get(text, text) if tag in SDF_FLAGS else text
    text = _pose(text) if tag == "pose" and not values else text
    if not len(element):
        default = SDF_DEFAULTS.get(above, {}).get(tag) if not values else None
        is_default = default is not None and text == (_pose(default) if tag == "pose" else _numbers(default))
        return "" if is_default else f"<{start}>{text}</>"

    def order(child: Element) -> tuple[str, str]:
        return "lidar" if child.tag == "ray" else child.tag, child.get("name", "") if child.tag == "param" else ""

    inner = "".join(_form(child, followers, tag, lidar) for child in sorted(element, key=order))
    return f"<{start}>{text}{inner}</>" if inner or values or text or tag not in ("imu", "clip") else ""


def _pose(text: str) -> str:
    """Convert the angles of a pose to a rotation matrix, because several angles describe the same rotation."""
    try:
        x, y, z, roll, pitch, yaw = map(float, text.split())
    except ValueError:
        return text
    transform = Pose((x, y, z), (roll, pitch, yaw)).transform()
    numbers = (*transform.xyz, *(entry for row in transform.rows for entry in row))
    return " ".join(f"{round(number, _DIGITS) + 0.0!r}" for number in numbers)


def _numbers(text: str) -> str:
    def spelling(word: str) -> str:
        try:
            return word if "_" in word else f"{float(word) + 0.0:.{_SIGNIFICANT}g}"
        except ValueError:
            return word

    return " ".join(map(spelling, text.split()))


def followers_of(robot: Robot, humble: bool) -> frozenset[str]:
    """Return the mimic joints that <ros2_control> need not repeat: none if ``humble`` (ROS 2 Humble), else all."""
    return frozenset(joint.name for joint in robot.joints if joint.mimic is not None and not humble)


def element_differences(one: Iterable[str], other: Iterable[str], followers: Set[str] = frozenset()) -> list[str]:
    """Return a sentence for each difference between two lists of URDF elements."""
    first, second = meanings(one, followers), meanings(other, followers)
    return [f"{words(key)} is lost" for key in (first - second)] + [f"{words(key)} is new" for key in (second - first)]


def spelt(key: Key) -> str:
    """Format a key of ``meanings`` as an XML element."""
    return f'<gazebo reference="{key[1]}">{key[-1]}' if key[0] == "gazebo" and len(key) > 3 and key[1] else key[-1]


def words(key: Key) -> str:
    """Format a key of ``meanings`` for a message, such as <sensor> of <gazebo>."""
    if key[0] == "gazebo" and len(key) > 3:
        return f'<{key[3]}> of <gazebo reference="{key[1]}">' if key[1] else f"<{key[3]}> of <gazebo>"
    return f'<{key[0]} name="{key[1]}">' if len(key) > 2 else key[1][:80]
