"""The odometry that nodes listen to: somebody publishes it, as far as the files say who publishes what."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from ...diagnostics import NOTE, WARNING, Diagnostic, Related
from ...diagnostics.registry import PARAMETERS, Rule
from ...formats.controllers.topics import is_of_nobody, odometry_of
from ...formats.controllers.types import full
from ...startup.records import NamedTuple
from .nodes import Node, Setting
from .remaps import Remap, full_name, topic

RULES = (
    Rule(
        "parameters-odometry",
        "A warning: a node listens to an odometry below the name of a controller that publishes another one. A note: "
        "it listens to `odom`, and in the files the odometry of the drive is elsewhere.",
        "Name the topic that is published; or say by `--remap` or `--launch` which remap there is.",
        PARAMETERS,
    ),
)

_FILTER, _FILTERED = "ekf", "odometry/filtered"
_INPUT = re.compile(r"odom\d+")
_KEY, _USUAL = "odom_topic", "odom"


class Source(NamedTuple):
    """A controller of a drive: its node, and the topic of its odometry after remaps."""

    node: Node
    topic: str


def check(nodes: Sequence[Node], remaps: Sequence[Remap]) -> Iterator[Diagnostic]:
    """Yield the odometry that nodes listen to and nobody publishes; nothing where no controller drives."""
    sources = [
        Source(node, topic(odometry, node.namespace, node.name, remaps))
        for node in nodes
        if (odometry := odometry_of(full(node.type)))
    ]
    filters = [node for node in nodes if node.kind is not None and node.kind.name == _FILTER]
    published = {source.topic for source in sources}
    published |= {topic(_FILTERED, node.namespace, node.name, remaps) for node in filters}
    for node in nodes if sources else ():
        for key, setting in _heard(node):
            heard = topic(str(setting.value), node.namespace, node.name, remaps)
            if heard not in published:
                yield from _nobody(node, key, setting, heard, sources)


def _heard(node: Node) -> Iterator[tuple[str, Setting]]:
    """Yield the keys of a node that say which odometry it listens to."""
    keys = [key for key in node.parameters if _INPUT.fullmatch(key)]
    if node.kind is not None and _KEY in node.kind.keys:
        keys.append(_KEY)
    for key in keys:
        setting = node.setting(key)
        if isinstance(setting.value, str) and setting.value:
            yield key, setting


def _nobody(node: Node, key: str, setting: Setting, heard: str, sources: Sequence[Source]) -> Iterator[Diagnostic]:
    meant = is_of_nobody(heard, {source.node.full.strip("/"): source.topic for source in sources})
    if not meant and heard not in (full_name(_USUAL, node.namespace, ""), f"/{_USUAL}"):
        return  # of somebody else, such as a camera
    source = next((one for one in sources if one.topic == meant), sources[0])
    message = f'{node.shown} listens to the odometry {heard} ("{key}"{setting.how}), and nobody in the files publishes '
    message += f"that: {source.node.shown} publishes {source.topic}"
    help = f"{key}: {source.topic.strip('/')}" + ("" if meant else "; or say the remap: --remap NODE:FROM:=TO")
    related = (Related(f"{source.node.shown} is here", source.node.span),)
    yield Diagnostic("parameters-odometry", WARNING if meant else NOTE, message, setting.span, related, help)
