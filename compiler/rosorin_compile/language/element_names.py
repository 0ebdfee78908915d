"""Find and replace names in XML elements: links and joints in URDF and SRDF, and all objects in MJCF.

In functions for MJCF, ``top`` is True for children of ``<mujoco>``, such as ``<tendon>``, and False for children of a
``<body>``.
"""

import posixpath
import re
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import NamedTuple

from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.xml.elements import FlatElement, found_in
from rosorin_compile.source.xml.markup import MarkupError, parse

LINK, JOINT, EITHER, FRAME = "link", "joint", "link or joint", "frame"

# Elements of SRDF and ros2_control in which <link name="..."> and <joint name="..."> refer to the robot.
REFERRING = (
    *("chain", "disable_collisions", "disable_collision", "disable_default_collisions", "enable_collisions"),
    *("end_effector", "group", "group_state", "passive_joint", "ros2_control", "transmission"),
)
# Attributes that refer to a link or a joint in any element.
_ATTRIBUTES = dict.fromkeys(("link", "link1", "link2", "base_link", "tip_link", "parent_link", "child_link"), LINK)
_ATTRIBUTES |= dict.fromkeys(("joint", "joint1", "joint2"), JOINT)
# Patterns of tags in <plugin> elements whose text is probably the name of a link, joint or frame.
_TEXTS = (
    (r"(.*_)?joint|joint_?[nN]ame|.+Joint", JOINT),
    (r"(.*_)?link|(link|body)_?[nN]ame|.+Link", LINK),
    (r"(.*_)?frame(_id|_name)?|frame(Id|Name)|.+Frame(Id|Name)?", FRAME),
)


class Reference(NamedTuple):
    """A name in an XML attribute or, if ``attribute`` is empty, in the text of an element.

    ``where`` describes the position for messages. If ``sure`` is False, the text may be something other than a name.
    """

    name: str
    kind: str
    attribute: str
    where: str
    sure: bool = True


def references(tags: tuple[str, ...], attributes: Mapping[str, str], text: str) -> Iterator[Reference]:
    """Yield the link and joint names that a URDF or SRDF element refers to.

    ``tags`` has the tags of all ancestors, outermost first, and of the element; ``text`` is the text of the element.
    """
    tag, top = tags[-1], tags[0]
    named = [(_ATTRIBUTES[attribute], attribute) for attribute in attributes if attribute in _ATTRIBUTES]
    if top in REFERRING and tag in ("link", "joint", "passive_joint"):
        named.insert(0, (LINK if tag == "link" else JOINT, "name"))
    if tags == ("gazebo",):
        named.insert(0, (EITHER, "reference"))
    for kind, attribute in named:
        name = attributes.get(attribute, "").strip()
        if _is_name(name):
            inside = f" in <{top}>" if len(tags) > 1 else ""
            yield Reference(name, kind, attribute, f"the {attribute} of <{tag}>{inside}", top != "mujoco")
    if tag == "param" and attributes.get("name") == "mimic" and top == "ros2_control":
        if _is_name(text):
            yield Reference(text, JOINT, "", 'the param "mimic" in <ros2_control>')
        return
    if text and (kind := _kind_of_text(tag)) and _is_name(text):
        yield Reference(text, kind, "", f"the text of <{tag}> in <{top}>", sure=False)


Finder = Callable[[tuple[str, ...], Mapping[str, str], str], Iterator[Reference]]


def named_in(text: str) -> Iterator[Reference]:
    """Yield the link and joint names in a string of URDF or SRDF elements, or nothing if it is not valid XML."""
    for element in found_in(text):
        yield from references(element.tags, element.attributes, element.text)


@lru_cache(maxsize=2_000)
def _kind_of_text(tag: str) -> str:
    return next((kind for form, kind in _TEXTS if re.fullmatch(form, tag)), "")


def _is_name(text: str) -> bool:
    number = r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?|true|false|nan|inf(inity)?"
    return bool(re.fullmatch(r"[\w./-]+", text)) and not re.fullmatch(number, text, re.IGNORECASE)


def rename_references(text: str, rename: Callable[[str], str], references: Finder = references) -> str:
    """Apply ``rename`` to each name that ``references`` finds in a string of XML elements; return the new string."""
    before, after = "<robot>", "</robot>"
    try:
        document = parse(Source("", f"{before}{text}{after}"))
    except MarkupError:  # a rule reports invalid XML
        return text
    made = document.source.text
    places: set[tuple[int, str, str]] = set()
    for element in [*document.root.iter()][1:]:
        tags = (*(outer.tag for outer in [*element.ancestors()][-2::-1]), element.tag)
        plain = {name: one.value for name, one in element.attributes.items() if one.raw == one.value}
        inner = element.texts[0] if len(element.content) == len(element.texts) == 1 else None
        for found in references(tags, plain, inner.text.strip() if inner else ""):
            name = rename(found.name)
            start = element.attributes[found.attribute].start if found.attribute else inner.start if inner else -1
            form = rf"(?<![^\s\"'>]){re.escape(found.name)}(?![^\s\"'<])"
            if name != found.name and start >= 0 and (there := re.compile(form).search(made, start)):
                places.add((there.start(), found.name, name))
    for start, old, new in sorted(places, reverse=True):
        made = made[:start] + new + made[start + len(old) :]
    return made[len(before) : -len(after)]


BODY, SITE, GEOM, CAMERA, LIGHT = "body", "site", "geom", "camera", "light"
TENDON, ACTUATOR, SENSOR, EQUALITY, KEY = "tendon", "actuator", "sensor", "equality", "key"
CLASS, MATERIAL, TEXTURE, MESH, HEIGHTS = "class", "material", "texture", "mesh", "hfield"

SECTIONS = (
    *("actuator", "asset", "contact", "custom", "default", "deformable", "equality", "extension", "keyframe"),
    *("option", "sensor", "size", "statistic", "tendon", "visual", "worldbody"),
)
"""The MJCF sections that a description may contain; not ``<compiler>``, which would apply to the entire file."""

# MJCF attributes that are references in every element, with the kind of the object that they refer to.
_OF_MJCF: Mapping[str, str] = {
    **dict.fromkeys(("joint", "joint1", "joint2", "jointinparent"), JOINT),
    **dict.fromkeys(("body", "body1", "body2", "target", "subtree1", "subtree2", "node"), BODY),
    **dict.fromkeys(("site", "site1", "site2", "sidesite", "refsite", "slidersite", "cranksite"), SITE),
    **dict.fromkeys(("geom", "geom1", "geom2"), GEOM),
    **dict.fromkeys(("tendon", "tendon1", "tendon2"), TENDON),
    **dict.fromkeys(("class", "childclass"), CLASS),
    **{kind: kind for kind in (CAMERA, ACTUATOR, MATERIAL, TEXTURE, MESH, HEIGHTS, "flex", "instance")},
}
# Sections without references to objects: "camera" in <scale camera="0.1"> is a number, not the name of a camera.
_OF_SETTINGS = ("option", "size", "statistic", "visual")
_OF_MANY = ("flex", "flexcomp")  # elements whose attributes contain lists of names, separated by spaces
_KINDS = {"xbody": BODY, "mesh": MESH, "hfield": HEIGHTS, "numeric": "numeric", "text": "text", "tuple": "tuple"}
# MJCF sections in which all elements define objects of the same kind, whatever the tag.
_OF_SECTION = {"actuator": ACTUATOR, "sensor": SENSOR, "equality": EQUALITY, "tendon": TENDON}


def kind_of(found: FlatElement, top: bool) -> str:
    """Return the kind of object that an MJCF element defines, such as "geom", or "" if it defines no object."""
    *outer, tag = found.tags
    if tag == "default":
        return CLASS
    if found.tags[0] == "default" and top:  # elements in a default class have no names
        return ""
    if not top or found.tags[0] == "worldbody":
        return {"flexcomp": "flex", "freejoint": JOINT}.get(tag, tag)
    return _OF_SECTION.get(outer[0], tag) if len(outer) == 1 else tag if tag == "instance" else ""


def defined_names(found: FlatElement, top: bool) -> Iterator[Reference]:
    """Yield the name that an MJCF element defines; as in MuJoCo, an asset without a name has the name of its file."""
    kind = kind_of(found, top)
    attribute = "class" if kind == CLASS else "name"
    name = found.attributes.get(attribute, "").strip()
    if kind and name:
        yield Reference(name, kind, attribute, f"the {attribute} of <{found.tags[-1]}>")
    elif kind in (MESH, HEIGHTS, TEXTURE) and found.attributes.get("file"):
        stem = posixpath.splitext(posixpath.basename(found.attributes["file"]))[0]
        yield Reference(stem, kind, "", f"the file of <{found.tags[-1]}>")


def used_names(found: FlatElement, top: bool) -> Iterator[Reference]:
    """Yield the names of objects that an MJCF element refers to."""
    tag, attributes = found.tags[-1], found.attributes
    if top and found.tags[0] in _OF_SETTINGS:
        return
    inside = f" in <{found.tags[0]}>" if len(found.tags) > 1 else ""
    for attribute, value in attributes.items():
        kind = kind_of_name(attribute, attributes)
        if not kind or (attribute == "class" and kind_of(found, top) == CLASS) or tag in ("attach", "config"):
            continue
        for name in value.split() if tag in _OF_MANY else [value.strip()]:
            if name:
                yield Reference(name, kind, attribute, f"the {attribute} of <{tag}>{inside}")


def kind_of_name(attribute: str, attributes: Mapping[str, str]) -> str:
    """Return the kind of object that an MJCF attribute refers to, or "" if the attribute is not a reference."""
    if attribute in ("objname", "refname"):
        kind = attributes.get(f"{attribute[:3]}type", "")
        return _KINDS.get(kind, kind)
    return _OF_MJCF.get(attribute, "")


_FILE = r"""(\sfile\w*\s*=\s*)("[^"<]*"|'[^'<]*')"""


def files_in(text: str) -> list[str]:
    """Return the file names in a string of XML elements: meshes, textures, height fields and skins."""
    return [quoted[1:-1] for _, quoted in re.findall(_FILE, text) if quoted[1:-1].strip()]


def with_files(text: str, rename: Callable[[str], str]) -> str:
    """Apply ``rename`` to each file name in a string of XML elements; return the new string."""

    def one(found: re.Match[str]) -> str:
        name, quote = found[2][1:-1], found[2][0]
        return f"{found[1]}{quote}{rename(name)}{quote}" if name.strip() else found[0]

    return re.sub(_FILE, one, text)


def with_names(text: str, top: bool, rename: Callable[[str], str]) -> str:
    """Apply ``rename`` to each name that MJCF elements in a string define or refer to; return the new string."""

    def all_names(tags: tuple[str, ...], attributes: Mapping[str, str], _: str) -> Iterator[Reference]:
        found = FlatElement(tags, dict(attributes), "", 0)
        yield from (one for one in defined_names(found, top) if one.attribute)
        yield from used_names(found, top)

    return rename_references(text, rename, all_names)
