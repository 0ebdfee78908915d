"""Elements for Gazebo and ros2_control: sensors and drives as text, and elements of a URDF compared by meaning.

White space, comments, the order of different names and defaults of SDF mean nothing, but within a plug-in. Gazebo joins
all ``<gazebo>`` of a link or a joint (``gazebosim/sdformat@sdf14:src/parser_urdf.cc``).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from markupsafe import escape

from rosorin_compile.model import Pose
from rosorin_compile.model.simulation import CLASSIC, MOTOR, POSITION, VELOCITY, GazeboSensor, SdfElement
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Source
from rosorin_compile.source.numbers import NumberFormat
from rosorin_compile.source.wording import plural, quote
from rosorin_compile.source.xml.elements import canonical, tree_of
from rosorin_compile.source.xml.markup import MarkupError, parse

from .format import Unsupported
from .templating import attributes

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from rosorin_compile.model import Output, Robot

DISTRIBUTIONS = GazeboSensor.FRAME_ELEMENTS

# The defaults of SDF, by the last two elements of a path
# (sdformat@sdf14:sdf/1.11/{sensor,lidar,camera,noise}.sdf).
SDF_DEFAULTS = {
    "sensor": {"always_on": "false", "visualize": "false", "update_rate": "0", "pose": "0 0 0 0 0 0"},
    "horizontal": {"resolution": "1"},
    "vertical": {"resolution": "1"},
    "range": {"resolution": "0"},
    "camera": {"horizontal_fov": "1.047"},
    "image": {"width": "320", "height": "240"},
    "clip": {"near": "0.1", "far": "100"},
    "imu": {"enable_orientation": "true"},
    "noise": {"mean": "0", "bias_mean": "0", "bias_stddev": "0"},
}
SDF_FLAGS = ("always_on", "visualize", "enable_orientation", "enable_metrics")
SDF_TRUTH = {"1": "true", "0": "false", "True": "true", "False": "false"}


def distribution(asked: object) -> str:
    """Return which Gazebo an output asks for: ``true`` is Harmonic; empty for none."""
    return "harmonic" if asked is True else str(asked or "")


def sensor_lines(
    one: GazeboSensor, frame_id: str, number: NumberFormat, indent: str, pose: str, collisions: Sequence[str] = ()
) -> Iterator[str]:
    """Yield the lines of a sensor; ``frame_id`` is the element that names its frame, ``pose`` its <pose>, if any."""
    inner = indent + "  "
    yield f"{indent}<sensor{attributes(name=one.name, type=one.type)}>"
    if pose:
        yield f"{inner}{pose}"
    said = {element.name for element in one.elements} | one.without
    if one.stamp and frame_id and not said & {*DISTRIBUTIONS.values(), frame_id}:
        yield f"{inner}<{frame_id}>{escape(one.stamp)}</{frame_id}>"
    shapes = [SdfElement("collision", name) for name in collisions]
    for element in one.elements:
        yield from _lines(element, inner, number, shapes if element.name == "contact" else ())
    if collisions and "contact" not in said:
        yield from _lines(SdfElement("contact"), inner, number, shapes)
    yield f"{indent}</sensor>"


def _lines(element: SdfElement, indent: str, number: NumberFormat, more: Sequence[SdfElement] = ()) -> Iterator[str]:

    def word(value: float | str | bool) -> str:
        text = number(value) if isinstance(value, float) else str(value)
        return text.lower() if isinstance(value, bool) else text

    name = escape(element.name)
    start = f"{indent}<{name}{attributes(**{key: word(value) for key, value in element.attributes.items()})}"
    if element.value is not None:
        yield f"{start}>{escape(word(element.value))}</{name}>"
    elif not element.elements and not more:
        yield f"{start}/>"
    else:
        yield f"{start}>"
        for inner in (*more, *element.elements):
            yield from _lines(inner, indent + "  ", number)
        yield f"{indent}</{name}>"


# The plug-ins for actuators: gz-sim@gz-sim8:src/systems/{joint_position_controller,joint_controller,apply_joint_force}
_PLUGINS = {
    POSITION: ("joint-position-controller", "JointPositionController"),
    VELOCITY: ("joint-controller", "JointController"),
    MOTOR: ("apply-joint-force", "ApplyJointForce"),
}
_OTHER_TARGETS = ("body", "crank_site", "joint_in_parent", "reference_site", "site", "slider_site", "tendon")


def unsupported_drives(output: Output, quiet: bool = False) -> Mapping[str, Unsupported]:
    """Return which keys of actuators an output does not carry; ``quiet`` if it needs none without Gazebo."""
    places = ("actuators.*", "joints.*.actuator")
    if distribution(output.options.get("gazebo")) in ("", CLASSIC):
        return dict.fromkeys(places, Unsupported("no drives; newer versions of Gazebo have plug-ins for them", quiet))
    bound = Unsupported("Gazebo bounds commands by the limits of the joint, and names topics after it", quiet=True)
    found = {f"{place}.{key}": bound for place in places for key in ("name", "range", "unlimited", "mjcf")}
    found |= {f"{place}.{key}": Unsupported("no such gain") for place in places for key in ("gear", "damping_ratio")}
    return found | {f"actuators.*.{key}": Unsupported("drives of joints alone") for key in _OTHER_TARGETS}


def drive_blocks(
    robot: Robot, joints: Mapping[str, str], rule: str, gazebo: str, number: NumberFormat, others: Iterable[str]
) -> tuple[list[str], list[Diagnostic]]:
    """Return a ``<gazebo>`` for each drive of a joint that no ``others`` drive, and a warning without a plug-in."""
    # An actuator with gains becomes a controller with the same law: kp * (command - position) - kv * speed or
    # kv * (command - speed). Hardware blocks of ros2_control and plug-ins among ``others`` have precedence.
    blocks, without, taken = list[str](), list[str](), set[str]()
    if gazebo in ("", CLASSIC):
        return [], []
    for root in (tree_of(f"<all>{text}</all>") for text in others if "<ros2_control" in text or "<plugin" in text):
        taken |= {joint.get("name", "") for block in root.iter("ros2_control") for joint in block.iter("joint")}
        # JointStatePublisher names joints, too.
        plugins = [plugin for plugin in root.iter("plugin") if "state" not in plugin.get("name", "").lower()]
        inner = (element for plugin in plugins for element in plugin.iter())
        taken |= {(element.text or "").strip() for element in inner if "joint" in element.tag.lower()}
    program, namespace = ("ignition-gazebo", "ignition::gazebo") if gazebo == "fortress" else ("gz-sim", "gz::sim")
    pairs = [(joint.actuator, joint) for joint in robot.joints if joint.actuator]
    pairs += [(one, robot.joint[name]) for one in robot.actuators if (name := one.targets.get("joint", ""))]
    without += [one.name for one in robot.actuators if "joint" not in one.targets]
    for actuator, joint in pairs:
        kind, name = actuator.type, joints.get(joint.name, "")
        is_braked = actuator.damping and kind != POSITION  # a controller brakes only what it positions
        if name in taken:
            continue
        if not name or not joint.moves or kind not in _PLUGINS or is_braked:
            without.append(actuator.name or joint.name)
            continue
        # The damping of a servo, which MuJoCo has at the joint, acts like kv; kv and kp are 1 by default in MuJoCo.
        gains = {"p_gain": actuator.kv or 1.0} if kind == VELOCITY else {}
        if kind == POSITION:
            gains = {"p_gain": 1.0 if actuator.kp is None else actuator.kp, "d_gain": actuator.kv + actuator.damping}
        effort = joint.limit.known_value("effort") if joint.limit else None
        force = actuator.force or ((-effort, effort) if effort else None)
        gains |= {"cmd_min": force[0], "cmd_max": force[1]} if force is not None and kind != MOTOR else {}
        values = {"joint_name": escape(name), **({"use_force_commands": "true"} if kind == VELOCITY else {})}
        values |= {tag: number(value) for tag, value in gains.items()}
        lines = [f"    <{tag}>{text}</{tag}>" for tag, text in values.items()]
        file, word = _PLUGINS[kind]
        start = f'  <plugin filename="{program}-{file}-system" name="{namespace}::systems::{word}">'
        blocks.append("\n".join(["<gazebo>", start, *lines, "  </plugin>", "</gazebo>"]))
    message = f"Gazebo {gazebo} has no plug-in for {plural('actuator', len(without))} {quote(without, 3)}"
    help = "drive the joint by position, velocity or motor, or by ros2_control"
    return blocks, [Diagnostic(rule, WARNING, message, help=help)] if without else []


_OF_NOISE = ("mean", "stddev", "bias_mean", "bias_stddev")
_MEASURED = {"rate": "angular_velocity", "accel": "linear_acceleration"}


def with_noise(text: str) -> str:
    """Move the noise of an IMU to each axis, for the text of a ``<sensor>`` from Gazebo classic."""
    # Up to version 1.4 of SDF <imu> has one <noise> with <rate> and <accel>, which readers of later versions ignore
    # (gazebosim/sdformat@sdf12:sdf/1.4/imu.sdf).
    try:
        root = parse(Source("", text)).root if "<imu" in text and "<noise" in text else None
    except MarkupError:  # more than one element: the rules found them well formed
        root = None
    if root is None:
        return text
    pairs = [(noise, imu) for imu in root.iter() if imu.tag == "imu" for noise in imu.children if noise.tag == "noise"]
    for noise, imu in reversed(pairs):
        if not any(child.tag in _MEASURED for child in noise.children):
            continue
        kind = next((child.text for child in noise.children if child.tag == "type"), noise.get("type")) or "gaussian"
        lines: list[str] = []
        for child in noise.children:
            what = _MEASURED.get(child.tag, "")
            if what and all(sibling.tag != what for sibling in imu.children):
                inner = (one for one in child.children if one.tag in _OF_NOISE)
                numbers = "".join(f"<{one.tag}>{escape(one.text)}</{one.tag}>" for one in inner)
                noisy = f'<noise type="{escape(kind)}">{numbers}</noise>'
                lines += [f"<{what}>", *(f"  <{axis}>{noisy}</{axis}>" for axis in "xyz"), f"</{what}>"]
        before = text[: noise.start]
        indent = before.rpartition("\n")[2]
        is_alone = "\n" in before and not indent.strip()
        made = f"\n{indent}".join(lines) if is_alone else "".join(map(str.strip, lines))
        text = f"{before}{made}{text[noise.end :]}"
    return text


_SIGNIFICANT = 9  # of numbers that are compared as texts: ``number_format: short`` is off by 1e-12
_DIGITS = 10  # of metres and entries of a rotation, behind the point
Key = tuple[str, ...]


def meanings(texts: Iterable[str], followers: Set[str] = frozenset()) -> Counter[Key]:
    """Return the contents of some texts of elements, each with its count; ``followers`` are joints that mimic."""
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
                    form = _form(child, followers) if child.tag == "sensor" else canonical(child)
                    found["gazebo", element.get("reference", ""), repr(of), child.tag, form] += 1
            else:
                found[element.tag, canonical(element)] += 1
    return found


def _form(element: Element, followers: Set[str], above: str = "", lidar: bool = False) -> str:
    if element.tag == "plugin":
        return ElementTree.canonicalize(ElementTree.tostring(element), strip_text=True)
    lidar = element.get("type") in ("gpu_lidar", "lidar") if element.tag == "sensor" else lidar
    # A lidar has two names in the newer Gazebo, in the classic one only the first.
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
    """Return a pose in one spelling: its place and its rotation, which has several triples of angles."""
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
    """Return the joints that follow another, which elements for distributions after Humble need not say."""
    return frozenset(joint.name for joint in robot.joints if joint.mimic is not None and not humble)


def element_differences(one: Iterable[str], other: Iterable[str], followers: Set[str] = frozenset()) -> list[str]:
    """Return what only one of two lists of elements of a URDF says, in words."""
    first, second = meanings(one, followers), meanings(other, followers)
    return [f"{words(key)} is lost" for key in (first - second)] + [f"{words(key)} is new" for key in (second - first)]


def spelt(key: Key) -> str:
    """Return something that elements say as an element."""
    return f'<gazebo reference="{key[1]}">{key[-1]}' if key[0] == "gazebo" and len(key) > 3 and key[1] else key[-1]


def words(key: Key) -> str:
    """Return what something that elements say is called in a message."""
    if key[0] == "gazebo" and len(key) > 3:
        return f'<{key[3]}> of <gazebo reference="{key[1]}">' if key[1] else f"<{key[3]}> of <gazebo>"
    return f'<{key[0]} name="{key[1]}">' if len(key) > 2 else key[1][:80]
