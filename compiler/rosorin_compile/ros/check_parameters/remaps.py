"""Remaps: which topic a node really publishes on, by the command line and by launch files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span, error

from ..launch_files import LaunchError, nodes_of
from ..ports import full_topic

TF = "tf"
# Nodes that run others in their process: what they are told holds for all of them.
_HOSTS = ("controller_manager", "ros2_control_node")
_FLAGS = ("-r", "--remap")


class Remap(NamedTuple):
    """One rule: names as they are written. ``node`` is the name of the node that it is for; empty for all."""

    node: str
    name: str
    to: str


def of_word(word: str) -> Remap | None:
    """Return what a text such as NODE:FROM:=TO says; None if it is no remap."""
    left, mark, to = word.partition(":=")
    node, colon, name = left.rpartition(":")
    if not mark or not name or not to or (colon and not node):
        return None
    return Remap(node.strip("/").rsplit("/", 1)[-1], name, to)


def topic(name: str, namespace: str, node: str, remaps: Iterable[Remap]) -> str:
    """Return the topic that a node publishes on under ``name``: the first rule that fits is followed."""
    full = full_topic(name, namespace, node)
    for remap in remaps:
        if remap.node in ("", node) and full_topic(remap.name, namespace, node) == full:
            return full_topic(remap.to, namespace, node)
    return full


def is_tf(topic: str, namespace: str) -> bool:
    """Return True if a topic is the one that tf2 listens to: /tf, or that of the namespace."""
    return topic in (f"/{TF}", full_topic(TF, namespace, ""))


def of_launch(path: Path) -> tuple[list[Remap], list[Diagnostic]]:
    """Return the remaps of a launch file, and diagnostics about those that only a run of it knows."""
    from rosorin_compile.source.load import LoadError, read_utf8

    remaps: list[Remap] = []
    diagnostics: list[Diagnostic] = []
    try:
        for node in nodes_of(read_utf8(path, str(path))):
            name = "" if node.name in _HOSTS else node.name
            if node.remaps is None:
                diagnostics.append(_unknown("which remaps this node has is", "them", node.span))
            for remap in node.remaps or ():
                if "$(" in remap.name + remap.to:
                    diagnostics.append(_unknown("which topic is remapped is", "it", remap.span))
                else:
                    remaps.append(Remap(name, remap.name, remap.to))
            remaps += _of_arguments([word or "" for word in node.arguments or ()], name)
    except LoadError as problem:
        return [], [problem.diagnostic]
    except LaunchError as problem:
        return [], [error("parameters-launch", f"{path} is no launch file: {problem}", None, "name a launch file")]
    return remaps, diagnostics


def _unknown(what: str, these: str, span: Span) -> Diagnostic:
    message, help = f"{what} known only when the launch file runs", f"say {these}: --remap NODE:FROM:=TO"
    return Diagnostic("parameters-launch", WARNING, message, span, help=help)


def _of_arguments(words: Sequence[str], node: str) -> Iterator[Remap]:
    for flag, word in pairwise(words):
        if flag in _FLAGS and (remap := of_word(word)) is not None:
            yield remap if remap.node else remap._replace(node=node)
        elif flag == "--controller-ros-args":
            spawned = next((one for one in words if not one.startswith("-")), "")
            yield from _of_arguments(word.split(), spawned)
