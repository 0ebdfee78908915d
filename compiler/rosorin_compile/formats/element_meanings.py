"""Compare the elements of a URDF other than links and joints by meaning, not by spelling.

White space, comments, the order of what has other names, spare zeros and what SDF takes by default mean nothing.
Within a plug-in, whose words are its own, texts and their order stay as they are. What Gazebo is told of a link or a
joint it joins, however many ``<gazebo>`` say it (``gazebosim/sdformat@sdf14:src/parser_urdf.cc``).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Set
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.formats.gazebo_sensors import SDF_DEFAULTS, SDF_FLAGS, SDF_TRUTH, with_noise
from rosorin_compile.model import Pose
from rosorin_compile.source.xml.elements import canonical, tree_of

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from rosorin_compile.model import Robot

_SIGNIFICANT = 9  # of numbers that are compared as texts: ``number_format: short`` is off by 1e-12
_DIGITS = 10  # of metres and entries of a rotation, behind the point

# A lidar has two names in the newer Gazebo, in the classic one only the first.
ALIASES = {"ray": "lidar"}
_OF_LIDARS = ("gpu_lidar", "lidar")


class Context(NamedTuple):
    """What decides on a meaning beside the element: the joints that follow another, and whether Humble reads it."""

    followers: Set[str] = frozenset()
    humble: bool = False


Key = tuple[str, ...]


def meanings(texts: Iterable[str], context: Context) -> Counter[Key]:
    """Return what some texts of elements say, each thing with how often; a text that is no XML says its words."""
    found: Counter[Key] = Counter()
    for text in texts:
        try:
            root = tree_of(with_noise(f"<all>{text}</all>"))
        except ValueError:
            found["text", " ".join(text.split())] += 1
            continue
        for element in root:
            found.update(_keys(element, context))
    return found


def _keys(element: Element, context: Context) -> Iterator[Key]:
    if element.tag == "ros2_control":
        yield ("ros2_control", element.get("name", ""), _block(element, context))
    elif element.tag == "gazebo" and not (element.text or "").strip():
        of = {key: value for key, value in sorted(element.attrib.items()) if key != "reference"}
        for child in element:
            what = _sensor(child) if child.tag == "sensor" else canonical(child)
            yield ("gazebo", element.get("reference", ""), repr(of), child.tag, what)
    else:
        yield (element.tag, canonical(element))


def _sensor(element: Element) -> str:
    modern = element.get("type") in _OF_LIDARS
    return _form(element, (), modern)


def _form(element: Element, above: tuple[str, ...], modern: bool) -> str:
    """Return an element of SDF in one spelling; empty where it says what is taken by default."""
    if element.tag == "plugin":
        return _exact(element)
    tag = ALIASES.get(element.tag, element.tag) if modern and len(above) == 1 else element.tag
    start = tag + "".join(f" {name}={_number(value)}" for name, value in sorted(element.attrib.items()))
    text = " ".join(map(_number, (element.text or "").split()))
    text = SDF_TRUTH.get(text, text) if tag in SDF_FLAGS else text
    text = _pose(text) if tag == "pose" and not element.attrib else text
    if not len(element):
        default = SDF_DEFAULTS.get((above[-1], tag)) if above and not element.attrib else None
        same = default is not None and text == (_pose(default) if tag == "pose" else _number(default))
        return "" if same else f"<{start}>{text}</>"
    inner = [(child.tag, _form(child, (*above, tag), modern)) for child in element]
    if tag in ("imu", "clip") and not element.attrib and not text and not any(form for _, form in inner):
        return ""
    parts = "".join(form for _, form in sorted(inner, key=lambda item: ALIASES.get(item[0], item[0])))
    return f"<{start}>{text}{parts}</>"


def _pose(text: str) -> str:
    """Return a pose in one spelling: its place and its rotation, which several angles may say."""
    try:
        x, y, z, roll, pitch, yaw = map(float, text.split())
    except ValueError:
        return text
    transform = Pose((x, y, z), (roll, pitch, yaw)).transform()
    numbers = (*transform.xyz, *(entry for row in transform.rows for entry in row))
    return " ".join(f"{round(number, _DIGITS) + 0.0!r}" for number in numbers)


def _number(word: str) -> str:
    try:
        return word if "_" in word else f"{float(word) + 0.0:.{_SIGNIFICANT}g}"
    except ValueError:
        return word


def _exact(element: Element) -> str:
    values = "".join(f" {name}={value!r}" for name, value in sorted(element.attrib.items()))
    inner = "".join(_exact(child) for child in element)
    return f"<{element.tag}{values}>{(element.text or '').strip()}{inner}</>"


def _block(element: Element, context: Context) -> str:
    """Return a hardware block in one spelling: what has one tag keeps its order, parameters have none."""
    return _component(element, context, ("hardware", "joint", "sensor", "gpio", "transmission"))


_NUMBERS = ("min", "max", "initial_value", "multiplier")
_NUMBER_TAGS = ("mechanical_reduction", "offset")


def _component(element: Element, context: Context, order: tuple[str, ...] = ()) -> str:
    attributes = dict(element.attrib)
    follower = element.tag == "joint" and attributes.get("name") in context.followers
    if follower and not context.humble:
        attributes.setdefault("mimic", "true")
    values = "".join(f" {name}={value.strip()!r}" for name, value in sorted(attributes.items()))
    params = sorted(_param(child) for child in element if child.tag == "param")
    others = [child for child in element if child.tag != "param"]
    rank = {tag: place for place, tag in enumerate(order or sorted({child.tag for child in others}))}
    others.sort(key=lambda child: rank.get(child.tag, len(rank)))
    inner = "".join(_component(child, context) for child in others)
    text = (element.text or "").strip()
    text = _number(text) if element.tag in _NUMBER_TAGS else text
    return f"<{element.tag}{values}>{text}{''.join(params)}{inner}</>"


def _param(element: Element) -> str:
    name, text = element.get("name", ""), (element.text or "").strip()
    more = "".join(f" {key}={value}" for key, value in sorted(element.attrib.items()) if key != "name")
    inner = "".join(_exact(child) for child in element)
    return f"<param {name}{more}>{_number(text) if name in _NUMBERS else text}{inner}</>"


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
