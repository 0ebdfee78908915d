"""Left out: every element and attribute of the text that the tree does not carry is listed; nothing is lost unsaid.

The list works from the other end: it knows what is carried, and tells of all the rest, grouped by what it is. An
attribute that is 0 says nothing and is not told of.

What makes a file no robot for us is told by ``before`` (seen in the text) and ``refusal`` (said by MuJoCo), with a
place.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path

from ...diagnostics import Diagnostic, Span, error
from ...diagnostics.registry import READING, Rule
from ...diagnostics.wording import plural
from ...xml.markup import Attribute, Element
from . import SETTINGS
from .process import Answer
from .reading import Reading
from .source import Markup

RULES = (
    Rule(
        "mjcf-refused",
        "MuJoCo does not load the file; the message is MuJoCo's.",
        "Correct it until MuJoCo loads it.",
        READING,
    ),
    Rule(
        "mjcf-too-large",
        "The replicas of an MJCF are more elements than any robot has.",
        "Repeat less often.",
        READING,
    ),
)


_PLACE = "pos quat axisangle xyaxes zaxis euler"
_COMMON = f"name class {_PLACE}"

# What is carried, calculated with, or only about names and order, by element.
_CARRIED: dict[str, frozenset[str]] = {
    tag: frozenset(words.split())
    for tag, words in {
        "body": f"{_COMMON} childclass",
        "frame": f"{_COMMON} childclass scale",
        "replicate": "count offset euler sep childclass",
        "attach": "model body prefix frame",
        "inertial": f"{_PLACE} mass diaginertia fullinertia",
        "joint": f"name class type group {_PLACE} axis range limited ref armature damping frictionloss"
        " actuatorfrcrange actuatorfrclimited springref",
        "freejoint": "name group align",
        "geom": f"{_COMMON} type contype conaffinity group size fromto mass density rgba material mesh fitscale"
        " shellinertia hfield",
        "site": f"{_COMMON} fromto",
        "camera": f"{_COMMON} mode target",
        "mesh": "name class file scale refpos refquat content_type inertia smoothnormal maxhullvert vertex normal"
        " texcoord face builtin params material octree_maxdepth needsdf",
        "material": "name class texture rgba",
        "exclude": "name class body1 body2",
        "key": "name qpos ctrl",
        "option": " ".join(SETTINGS),
    }.items()
}

# Words for attributes that are told of together, by element.
_TOPICS: dict[str, dict[str, str]] = {
    "joint": {
        "stiffness springdamper": "springs",
        "solreflimit solimplimit solreffriction solimpfriction margin": "the tuning of limits and friction",
        "actuatorgravcomp": "compensation of gravity",
    },
    "geom": {
        "condim priority friction solmix solref solimp margin gap": "friction and the tuning of contacts",
        "fluidshape fluidcoef": "the drag of fluids",
    },
    "body": {"gravcomp": "compensation of gravity", "mocap": "motion capture", "sleep": "the sleep policy"},
    "material": {
        "texrepeat texuniform emission specular shininess reflectance metallic roughness": "shine and texture mapping"
    },
    "camera": {
        "fovy ipd resolution output focal focalpixel principal principalpixel sensorsize projection": "the optics"
    },
    "key": {"time qvel act mpos mquat": "time, speeds and activations"},
}

# Sections and elements that are about the simulation or its scene, and say nothing of the robot.
_SCENE = {
    "size": "settings of the simulation",
    "visual": "settings of the viewer",
    "statistic": "settings of the viewer",
    "light": "lights",
    "custom": "numbers and texts for other programs",
}

# What is handled where the compiled model is read.
_READ_ELSEWHERE = ("equality", "actuator", "compiler")

_LOST = {
    "pair": "contact pairs",
    "sensor": "sensors",
    "tendon": "tendons",
    "deformable": "flexible bodies",
    "flexcomp": "flexible bodies",
    "skin": "skins",
    "extension": "plugins",
    "plugin": "plugins",
}
_SINGULAR = ("the ", "compensation", "motion", '"')
_ON_LOOKS_OF_SITES = "size type rgba group material user"


def tell(reading: Reading) -> None:
    """List what the tree does not carry of the text of an MJCF."""
    groups: dict[tuple[str, str], list[Span]] = {}
    for element in _elements(reading):
        tag = element.tag
        if element in reading.pairs:
            continue
        if tag in _LOST:
            groups.setdefault(("lost", _LOST[tag]), []).append(_first(element))
        elif tag in _SCENE:
            groups.setdefault(("scene", _SCENE[tag]), []).append(element.span)
        else:
            for name, span in _unsaid(element):
                kind = "looks" if tag == "site" and name in _ON_LOOKS_OF_SITES.split() else "lost"
                words = "how sites look" if kind == "looks" else f"{_topic(tag, name)} of {plural(tag, 2)}"
                groups.setdefault((kind, words), []).append(span)
    for (kind, words), spans in groups.items():
        if kind == "lost":
            places = f" ({len(spans)} places)" if len(spans) > 1 else ""
            reading.lost(f"{words}{places}", spans[0], "", not words.startswith(_SINGULAR), spans[1:])
        else:
            reading.ignored(f"{words}: no part of the robot", spans[0])
    _masks(reading)


def _elements(reading: Reading) -> Iterator[Element]:
    """Yield the elements to look at; of what is told of as a whole only the outermost."""
    waiting = list(reading.markup.children(reading.markup.root))[::-1]
    while waiting:
        element = waiting.pop()
        if element.tag in _READ_ELSEWHERE:
            continue
        yield element
        if element.tag not in _LOST and element.tag not in _SCENE:
            waiting += list(reading.markup.children(element))[::-1]


def _first(element: Element) -> Span:
    """Return the place of the first thing in a section, or of the section."""
    return next((child.span for child in element.children), element.span)


def _unsaid(element: Element) -> Iterator[tuple[str, Span]]:
    """Yield the attributes of an element that are not carried and say something."""
    carried = _CARRIED.get(element.tag)
    if carried is None or _in_scene(element):
        return
    for name, attribute in element.attributes.items():
        if name not in carried and not _says_nothing(attribute.value):
            yield name, attribute.name_span


def _in_scene(element: Element) -> bool:
    """Say whether an element stands in the world itself, not in a body."""
    above = element.parent
    return above is not None and above.tag == "worldbody" and element.tag not in ("body", "frame")


def _says_nothing(value: str) -> bool:
    return all(_is_zero(word) for word in value.split()) or value in ("auto", "false", "none")


def _is_zero(word: str) -> bool:
    try:
        return float(word) == 0
    except ValueError:
        return False


def _topic(tag: str, name: str) -> str:
    for names, words in _TOPICS.get(tag, {}).items():
        if name in names.split():
            return words
    return f'"{name}"'


def _masks(reading: Reading) -> None:
    """Say that only whether a geom collides is carried, where the masks say more."""
    masks = [(geom["contype"], geom["conaffinity"]) for geom in reading.facts["geoms"]]
    special = [index for index, mask in enumerate(masks) if mask not in ((0, 0), (1, 1))]
    in_robot = _first_in(reading, special)
    if in_robot is not None:
        span = reading.places.of("geoms", in_robot).span
        reading.lost("which geoms collide with which others (contype and conaffinity)", span)


def _first_in(reading: Reading, geoms: Iterable[int]) -> int | None:
    return next((index for index in geoms if reading.facts["geoms"][index]["body"] in reading.link_of), None)


MAX_ELEMENTS = 500_000

_LINE = re.compile(r"\bline (\d+)")
_TAG = re.compile(r"Element '([^']+)'")
_QUOTED = re.compile(r"'([^']+)'")
_NOT_FINITE = re.compile(r"(?i)[-+]?(nan|inf|infinity)")
_FILE_HELP = "put the file where the MJCF looks for it: MuJoCo wants to see every mesh and texture"
_WORDS = ("name", "class", "childclass", "file", "model", "prefix", "material", "mesh", "texture", "group")


def before(markup: Markup) -> Iterator[Diagnostic]:
    """Yield what MuJoCo is not asked about: numbers that are none, replicas without end, files without an end."""
    yield from _no_files(markup)
    for element in markup.everything():
        for attribute in element.attributes.values():
            if attribute.name in _WORDS:
                continue
            for word in attribute.words():
                if _NOT_FINITE.fullmatch(word.text):
                    message = f"{attribute.name} of <{element.tag}> is {word.text}, which is no number"
                    yield error("not-finite", message, word.span, "give a number")
    most, where = _replicas(markup, markup.root)
    if most > MAX_ELEMENTS:
        message = f"the replicas of this file are {most:,} elements, more than {MAX_ELEMENTS:,}"
        yield error("mjcf-too-large", message, (where or markup.root).span, "repeat less often")


def _no_files(markup: Markup) -> Iterator[Diagnostic]:
    """Yield an error for each mesh, texture or height field that is a pipe or a device: reading one may never end."""
    words = ("meshdir", "texturedir", "assetdir")
    inner = [
        "",
        *(e.get(word).replace("\\", "/") for e in markup.sections("compiler") for word in words if e.get(word)),
    ]
    folders = [folder / name for folder in dict.fromkeys(file.parent for file in markup.files) for name in inner]
    for element in markup.everything():
        for attribute in element.attributes.values():
            if not attribute.name.startswith("file") or not attribute.value or element.tag in ("include", "model"):
                continue
            for path in (folder / attribute.value.replace("\\", "/") for folder in folders):
                if _is_odd(path):
                    message = f"{attribute.value} is no regular file"
                    yield error("file-unreadable", message, attribute.span, "name a file")
                    break


def _is_odd(path: Path) -> bool:
    """Say whether there is something that is neither a file nor a folder."""
    try:
        return path.exists() and not (path.is_file() or path.is_dir())
    except (OSError, ValueError):
        return False


def _replicas(markup: Markup, element: Element) -> tuple[int, Element | None]:
    """Return how many elements an element holds when all is repeated, and the replicate that makes the most of them."""
    total, most, where = 1, 0, None
    for child in markup.children(element):
        count, inner = _replicas(markup, child)
        total += count
        if inner is not None and count > most:
            most, where = count, inner
    written = element.get("count")
    if element.tag == "replicate" and written.isdecimal():
        return total * int(written), where or element
    return total, where


def refusal(markup: Markup, answer: Answer) -> Diagnostic:
    """Return the error about a file that MuJoCo does not load, in MuJoCo's words."""
    words = " ".join(answer.refusal.split())
    for prefix in ("XML Error: ", "Error: "):
        words = words.removeprefix(prefix)
    if answer.missing:
        return error("extra-missing", words, markup.root.span, answer.help)
    help = _FILE_HELP if words.startswith("Error opening file") else answer.help
    message = words if answer.own else f"MuJoCo refuses the file: {words}"
    return error("mjcf-refused", message, place(markup, words), help)


def place(markup: Markup, message: str) -> Span:
    """Return the place that a message of MuJoCo speaks of.

    MuJoCo gives the line in the main file, 0 in others, and quotes the names of elements and attributes and the values
    that it does not like: the element that has the most of them is meant.
    """
    line, tag = _LINE.search(message), _TAG.search(message)
    quoted = set(_QUOTED.findall(message)) - {tag[1] if tag else ""}
    best, likely = 0, markup.root.span
    for element in markup.everything():
        attribute = _quoted(element, quoted)
        here = line is not None and element.document is markup.root.document and element.span.line == int(line[1])
        score = 4 * here + 2 * (tag is not None and element.tag == tag[1]) + 3 * (attribute is not None)
        if score > best:
            best, likely = score, _span(element, attribute, quoted)
    return likely


def _quoted(element: Element, quoted: set[str]) -> Attribute | None:
    return next((a for a in element.attributes.values() if a.name in quoted or _says(a, quoted)), None)


def _says(attribute: Attribute, quoted: Collection[str]) -> bool:
    """Say whether an attribute has a quoted value; MuJoCo quotes a file with the folder that it looked in."""
    value = attribute.value
    return value in quoted or (attribute.name == "file" and any(q.endswith(f"/{value}") for q in quoted if value))


def _span(element: Element, attribute: Attribute | None, quoted: set[str]) -> Span:
    if attribute is None:
        return element.span
    return attribute.name_span if attribute.name in quoted else attribute.span
