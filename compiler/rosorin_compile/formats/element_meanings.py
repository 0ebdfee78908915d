"""Compare the elements of a URDF other than links and joints by meaning, not by spelling.

White space, comments, the order of what has other names, spare zeros and what SDF takes by default mean nothing.
Within a plug-in, whose words are its own, texts and their order stay as they are. What Gazebo is told of a link or a
joint it joins, however many ``<gazebo>`` say it (``gazebosim/sdformat@sdf14:src/parser_urdf.cc``).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Set
from typing import TYPE_CHECKING, NamedTuple
from xml.etree import ElementTree

from rosorin_compile.formats.gazebo_sensors import SDF_DEFAULTS, SDF_FLAGS, SDF_TRUTH, with_noise
from rosorin_compile.model import Pose
from rosorin_compile.source.xml.elements import canonical, tree_of

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from rosorin_compile.model import Robot

_SIGNIFICANT = 9  # of numbers that are compared as texts: ``number_format: short`` is off by 1e-12
_DIGITS = 10  # of metres and entries of a rotation, behind the point

# A lidar has two names in the newer Gazebo, in the classic one only the first.
_ALIASES = {"ray": "lidar"}
_LIDARS = ("gpu_lidar", "lidar")


class Context(NamedTuple):
    """What decides on a meaning beside the element: the joints that follow another, and whether Humble reads it."""

    followers: Set[str] = frozenset()
    humble: bool = False


Key = tuple[str, ...]


def meanings(texts: Iterable[str], context: Context) -> Counter[Key]:
    """Return the contents of some texts of elements, each with its count; of a text that is no XML its words."""
    found: Counter[Key] = Counter()
    for text in texts:
        try:
            root = tree_of(with_noise(f"<all>{text}</all>"))
        except ValueError:
            found["text", " ".join(text.split())] += 1
            continue
        for element in root:
            if element.tag == "ros2_control":
                found["ros2_control", element.get("name", ""), _form(element, context)] += 1
            elif element.tag == "gazebo" and not (element.text or "").strip():
                of = {key: value for key, value in sorted(element.attrib.items()) if key != "reference"}
                for child in element:
                    form = _form(child, context) if child.tag == "sensor" else canonical(child)
                    found["gazebo", element.get("reference", ""), repr(of), child.tag, form] += 1
            else:
                found[element.tag, canonical(element)] += 1
    return found


def _form(element: Element, context: Context, above: tuple[str, ...] = (), lidar: bool = False) -> str:
    """Return an element of SDF or of ros2_control in one spelling; empty if it has the default value.

    Elements with one name keep their order, parameters have none.
    """
    if element.tag == "plugin":
        return ElementTree.canonicalize(ElementTree.tostring(element), strip_text=True)
    lidar = element.get("type") in _LIDARS if element.tag == "sensor" else lidar
    tag = _ALIASES.get(element.tag, element.tag) if lidar and len(above) == 1 else element.tag
    values = dict(element.attrib)
    if tag == "joint" and values.get("name") in context.followers and not context.humble:
        values.setdefault("mimic", "true")
    start = tag + "".join(f" {name}={_numbers(value)}" for name, value in sorted(values.items()))
    text = _numbers(element.text or "")
    text = SDF_TRUTH.get(text, text) if tag in SDF_FLAGS else text
    text = _pose(text) if tag == "pose" and not values else text
    if not len(element):
        default = SDF_DEFAULTS.get((above[-1], tag)) if above and not values else None
        is_default = default is not None and text == (_pose(default) if tag == "pose" else _numbers(default))
        return "" if is_default else f"<{start}>{text}</>"
    children = sorted(
        element, key=lambda child: (_ALIASES.get(child.tag, child.tag), child.tag == "param" and child.get("name", ""))
    )
    inner = "".join(_form(child, context, (*above, tag), lidar) for child in children)
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


def context_of(robot: Robot, humble: bool) -> Context:
    """Return what decides on the meaning of elements of a robot."""
    return Context(frozenset(joint.name for joint in robot.joints if joint.mimic is not None), humble)


def element_differences(one: Iterable[str], other: Iterable[str], context: Context | None = None) -> list[str]:
    """Return what only one of two lists of elements of a URDF says, in words."""
    context = context or Context()
    first, second = meanings(one, context), meanings(other, context)
    return [f"{words(key)} is lost" for key in (first - second)] + [f"{words(key)} is new" for key in (second - first)]


def spelt(key: Key) -> str:
    """Return something that elements say as an element."""
    return f'<gazebo reference="{key[1]}">{key[-1]}' if key[0] == "gazebo" and len(key) > 3 and key[1] else key[-1]


def words(key: Key) -> str:
    """Return what something that elements say is called in a message."""
    if key[0] == "gazebo" and len(key) > 3:
        return f'<{key[3]}> of <gazebo reference="{key[1]}">' if key[1] else f"<{key[3]}> of <gazebo>"
    return f'<{key[0]} name="{key[1]}">' if len(key) > 2 else key[1][:80]
