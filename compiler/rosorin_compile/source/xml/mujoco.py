"""Names in elements of MJCF: those that they define, and those that they use.

An element is in a body of MuJoCo (``top`` is false), or is a section of the file, such as ``<tendon>``; its tags begin
there.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Callable, Iterator, Mapping

from .elements import Found
from .references import Reference, renamed

BODY, JOINT, SITE, GEOM, CAMERA, LIGHT = "body", "joint", "site", "geom", "camera", "light"
TENDON, ACTUATOR, SENSOR, EQUALITY, KEY = "tendon", "actuator", "sensor", "equality", "key"
CLASS, MATERIAL, TEXTURE, MESH, HEIGHTS = "class", "material", "texture", "mesh", "hfield"

SECTIONS = (
    *("actuator", "asset", "contact", "custom", "default", "deformable", "equality", "extension", "keyframe"),
    *("option", "sensor", "size", "statistic", "tendon", "visual", "worldbody"),
)
"""The sections of a file that elements may be; ``<compiler>`` would apply to the whole file."""

# Attributes that name something, whatever the element; with several names in some.
_ATTRIBUTES: Mapping[str, str] = {
    **dict.fromkeys(("joint", "joint1", "joint2", "jointinparent"), JOINT),
    **dict.fromkeys(("body", "body1", "body2", "target", "subtree1", "subtree2", "node"), BODY),
    **dict.fromkeys(("site", "site1", "site2", "sidesite", "refsite", "slidersite", "cranksite"), SITE),
    **dict.fromkeys(("geom", "geom1", "geom2"), GEOM),
    **dict.fromkeys(("tendon", "tendon1", "tendon2"), TENDON),
    **dict.fromkeys(("class", "childclass"), CLASS),
    **{kind: kind for kind in (CAMERA, ACTUATOR, MATERIAL, TEXTURE, MESH, HEIGHTS, "flex", "instance")},
}
# Sections of numbers, some of which are called as what elsewhere names something: <scale camera="0.1">.
_OF_SETTINGS = ("option", "size", "statistic", "visual")
_OF_MANY = ("flex", "flexcomp")  # elements whose attributes name several things, space between
_KINDS = {"xbody": BODY, "mesh": MESH, "hfield": HEIGHTS, "numeric": "numeric", "text": "text", "tuple": "tuple"}
# What the elements of a section are, where it is not said by their tag.
_OF_SECTION = {"actuator": ACTUATOR, "sensor": SENSOR, "equality": EQUALITY, "tendon": TENDON}


def kind_of(found: Found, top: bool) -> str:
    """Return the kind of the name of an element; empty for an element without a name."""
    tag, *around = reversed(found.tags)
    if tag == "default":
        return CLASS
    if found.tags[0] == "default" and top:  # the elements of a class have no names
        return ""
    if not top or found.tags[0] == "worldbody":
        return {"flexcomp": "flex", "freejoint": JOINT}.get(tag, tag)
    if len(around) == 1:
        return _OF_SECTION.get(around[0], tag)
    return tag if tag == "instance" else ""


def given(found: Found, top: bool) -> Iterator[Reference]:
    """Yield the name that an element defines; with a file and no name it is that of the file, as in MuJoCo."""
    kind = kind_of(found, top)
    attribute = "class" if kind == CLASS else "name"
    name = found.attributes.get(attribute, "").strip()
    if kind and name:
        yield Reference(name, kind, attribute, f"the {attribute} of <{found.tags[-1]}>")
    elif kind in (MESH, HEIGHTS, TEXTURE) and found.attributes.get("file"):
        stem = posixpath.splitext(posixpath.basename(found.attributes["file"]))[0]
        yield Reference(stem, kind, "", f"the file of <{found.tags[-1]}>")


def used(found: Found, top: bool) -> Iterator[Reference]:
    """Yield the names in an element that refer to others."""
    tag, attributes = found.tags[-1], found.attributes
    if top and found.tags[0] in _OF_SETTINGS:
        return
    inside = f" in <{found.tags[0]}>" if len(found.tags) > 1 else ""
    for attribute, value in attributes.items():
        kind = _kind_of_name(attribute, attributes)
        if not kind or (attribute == "class" and kind_of(found, top) == CLASS) or tag in ("attach", "config"):
            continue
        for name in value.split() if tag in _OF_MANY else [value.strip()]:
            if name:
                yield Reference(name, kind, attribute, f"the {attribute} of <{tag}>{inside}")


def _kind_of_name(attribute: str, attributes: Mapping[str, str]) -> str:
    if attribute in ("objname", "refname"):
        kind = attributes.get(f"{attribute[:3]}type", "")
        return _KINDS.get(kind, kind)
    return _ATTRIBUTES.get(attribute, "")


_FILE = re.compile(r"""(\sfile\w*\s*=\s*)("[^"<]*"|'[^'<]*')""")


def files_in(text: str) -> list[str]:
    """Return the files that some elements name: meshes, textures, height fields, skins."""
    return [quoted[1:-1] for _, quoted in _FILE.findall(text) if quoted[1:-1].strip()]


def with_files(text: str, rename: Callable[[str], str]) -> str:
    """Return elements in which each file is replaced by ``rename`` of it."""

    def one(found: re.Match[str]) -> str:
        name, quote = found[2][1:-1], found[2][0]
        return f"{found[1]}{quote}{rename(name) if name.strip() else name}{quote}"

    return _FILE.sub(one, text)


def with_names(text: str, top: bool, rename: Callable[[str], str]) -> str:
    """Return elements in which each name, defined or used, is replaced by ``rename`` of it."""

    def all_names(tags: tuple[str, ...], attributes: Mapping[str, str], _: str) -> Iterator[Reference]:
        found = Found(tags, dict(attributes), "", 0)
        yield from (one for one in given(found, top) if one.attribute)
        yield from used(found, top)

    return renamed(text, rename, all_names)
