"""Read what a picture of frames shows, in the terms of the list of frames."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from rosorin_compile.model.frame_tree import NO_TOPIC, NOBODY, Row
from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.xml.elements import tree_of

# Patterns are made by those who need them: an SVG has none of nodes and edges.
_NODE = r'n(\d+) ?\[(?:label=)?"(.*)"\];?'
_EDGE = r'n(\d+) (?:->|==>|-->|-\.->) ?(?:\|"(.*)"\| )?n(\d+)(?: \[label="(.*?)(?<!\\)", color=.*)?;?'
_JOINT = r"(.+) \((\w+)\)"
_CODE = r"#(\d+);"
_BACKSLASH = r"\\(.)"


class Shown(NamedTuple):
    """One situation as a picture shows it: its label, the frames, and the edges; only an SVG shows their joints."""

    label: str
    frames: tuple[str, ...]
    edges: tuple[Row, ...]


def read(text: str) -> Sequence[Shown]:
    """Return what a picture of any kind shows. Raises ValueError if it is damaged."""
    return read_svg(text) if text.lstrip().startswith("<") else read_graph(text)


def read_svg(text: str) -> list[Shown]:
    """Return what an SVG shows. Raises ValueError if it is damaged, or its letters are not what its data says."""
    panels = []
    for panel in tree_of(text).iter("g"):
        if panel.get("class") != "panel":
            continue
        frames: dict[str, None] = {}
        edges = []
        for line in panel.iter("g"):
            if line.get("class") != "line":
                continue
            letters = {part.get("class", ""): part.text or "" for part in line.iter("text")}
            data = {key.removeprefix("data-"): value for key, value in line.items()}
            frames[data.get("frame", "")] = None
            if "child" in data:
                edges.append(_row_of(data, letters))
            _same(letters.get("name", "").removesuffix(" (again)"), data.get("frame", "").removesuffix(" (again)"))
        panels.append(Shown(panel.get("data-when", ""), tuple(frames), tuple(edges)))
    if not panels:
        raise ValueError("there is no tree of frames")
    return panels


def _row_of(data: dict[str, str], letters: dict[str, str]) -> Row:
    """Return the edge of a line; what stands beside it has to be the same. Raises ValueError."""
    missing = [key for key in ("frame", "parent", "publisher", "topic") if key not in data]
    if missing:
        raise ValueError(f"a line has no {missing[0]}")
    why, topic = data.get("why", ""), data["topic"]
    beside = letters.get("publisher", "")
    _same(re.sub(r" \(\d+\)$", "", beside) if why else beside, data["publisher"])
    _same(letters.get("topic", NO_TOPIC), topic)
    if data["frame"] not in (data["parent"], data["child"]):
        raise ValueError(f"the line of {data['frame']} says another frame")
    first = data.get("first", "") or data["parent"]
    joint = re.fullmatch(_JOINT, letters.get("joint", ""))
    named = (joint[1], joint[2]) if joint else ("", "")
    return Row(data["parent"], data["child"], data["publisher"], why, topic, data.get("when", ""), first, *named)


def _same(letters: str, data: str) -> None:
    if letters != data:
        raise ValueError(f'a line shows "{letters}" and says "{data}"')


def read_graph(text: str) -> list[Shown]:
    """Return what a graph for Graphviz or Mermaid shows. Raises ValueError if it is damaged."""
    panels: list[Shown] = []
    names: dict[str, str] = {}
    texts: list[str] = []
    for line in map(str.strip, text.splitlines()):
        comment = re.fullmatch(r"(?://|%%) (situation|edge) (\[.*\])", line)
        if comment:
            texts = _texts(comment[2])
            if comment[1] == "situation":
                panels.append(Shown(texts[0], (), ()))
                names = {}
            continue
        node, edge = re.fullmatch(_NODE, line), re.fullmatch(_EDGE, line)
        if edge and panels:
            row = _edge(edge, names, texts)
            panels[-1] = panels[-1]._replace(edges=(*panels[-1].edges, row))
        elif node and panels:
            names[node[1]] = _plain(node[2], line.endswith(";"))
            panels[-1] = panels[-1]._replace(frames=tuple(names.values()))
    if not panels:
        raise ValueError("there is no tree of frames")
    return panels


def _texts(text: str) -> list[str]:
    texts = json_of(text)
    if not isinstance(texts, list) or not texts or not all(isinstance(one, str) for one in texts):
        raise ValueError("a comment is no list of texts")
    return texts


def _edge(match: re.Match[str], names: dict[str, str], texts: list[str]) -> Row:
    """Return an edge: ends and publisher as the arrow shows them, the rest as its comment says. Raises ValueError."""
    if match[1] not in names or match[3] not in names or len(texts) != 4:
        raise ValueError("an edge leads to no frame, or nothing is said of it")
    topic, why, when, first = texts
    parent, child = names[match[1]], names[match[3]]
    mermaid = match[2] is not None
    label = match[2] if mermaid else match[4] or ""
    publisher, _, shown = label.rpartition("<br>" if mermaid else "\\n")
    if topic == NO_TOPIC:
        publisher, shown = NOBODY, NO_TOPIC if label == NOBODY else label
    if shown != topic:
        raise ValueError(f'an edge shows "{shown}" and says "{topic}"')
    return Row(parent, child, _plain(publisher, not mermaid), why, topic, when, first or parent)


def _plain(text: str, dot: bool) -> str:
    """Return the text of a label."""
    if dot:
        return re.sub(_BACKSLASH, r"\1", text)
    return re.sub(_CODE, lambda code: chr(int(code[1])), text)
