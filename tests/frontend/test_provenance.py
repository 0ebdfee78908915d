"""Every "included here" and "used here" begins in the file that contains it, and leads to the file before it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from hypothesis import example, given, settings
from hypothesis import strategies as st

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.source.diagnostics import Diagnostic

MISTAKES = (
    "disabled_contacts: [7]",
    "links: {l%d: 5}",
    "joints: {j%d: {type: fixed, parent: nowhere, child: base_link}}",
    "links: {k%d: {colour: red}}",
    'links: {m%d: {collision: [{sphere: {radius: "${missing}"}}]}}',
    "let: {v%d: \"${1 / 0}\"}\nlinks: {o%d: {gravity_compensation: '${v%d}'}}",
    "use: {u%d: {part: ball, parent: base_link, with: {radius: text}}}",
    "use: {w%d: {part: ball, parent: base_link, xyz: [1]}}",
    'use: {x%d: {part: ball, parent: base_link, for: {i: [1, 2]}, prefix: "x${i}_", with: {radius: -1}}}',
    "poses: {p%d: {positions: {nothing: 1}}}",
    "modes: {q%d: 3}",
    "edges: [{parent: base_link}]",
)
BALL = (
    "parts: {ball: {params: {radius: 10 mm}, joints: {at: {type: fixed, parent: mount, child: it}}, "
    'links: {it: {collision: [{sphere: {radius: "${radius}"}}]}}}}'
)


@st.composite
def projects(draw: Any) -> dict[str, str]:
    """Return the files of a project by name: each but the first is included by one before it, or by several."""
    count = draw(st.integers(2, 5))
    names = ["robot.yaml", *(f"f{index}.yaml" for index in range(1, count))]
    parents = [draw(st.integers(0, index - 1)) for index in range(1, count)]
    files = {}
    for index, name in enumerate(names):
        inner = [names[child] for child, parent in enumerate(parents, 1) if parent == index]
        lines = [f"include: [{', '.join(inner)}]"] if inner else []
        lines += ["robot: r", "links: {base_link: {}}"] if index == 0 else []
        lines += [BALL] if index == count - 1 else []
        taken = {line.partition(":")[0] for line in lines}
        for mistake in draw(st.lists(st.sampled_from(MISTAKES), unique=True, max_size=4)):
            text = mistake % ((index,) * mistake.count("%d"))
            keys = {line.partition(":")[0] for line in text.splitlines()}
            if not keys & taken:
                taken |= keys
                lines.append(text)
        files[name] = "\n".join(lines or ["let: {}"]) + "\n"
    return files


def check(one: Diagnostic, folder: Path) -> None:
    """Follow the places of a diagnostic from the file that it is in to the first file."""
    assert one.span is not None
    here = one.span.source.path
    for related in one.related:
        if related.span is None:
            continue
        place, part = related.span, re.fullmatch(r'part ".*" used here as "(\w+)"', related.message)
        text = place.source.line(place.line)[place.column - 1 :]
        assert (folder / Path(place.source.path).name).read_text("utf-8") == place.source.text
        if related.message == "included here":
            assert text.startswith(Path(here).name), one
            here = place.source.path
        elif part:
            assert text.startswith(part[1].rstrip("_12")), one
            here = place.source.path


WITH_PART = """\
disabled_contacts: [7]
links: {l1: 5}
use: {u1: {part: ball, parent: base_link, with: {radius: text}}}
"""


@example({"robot.yaml": "include: [f1.yaml]\nrobot: r\nlinks: {base_link: {}}\n", "f1.yaml": f"{BALL}\n{WITH_PART}"})
@given(projects())
@settings(max_examples=60, deadline=None)
def test_each_step_begins_in_the_file_that_contains_it(tmp_path_factory: Any, files: dict[str, str]) -> None:
    folder = tmp_path_factory.mktemp("project")
    for name, text in files.items():
        (folder / name).write_text(text, "utf-8")
    for one in compile_robot(folder / "robot.yaml").diagnostics:
        if one.span is not None:
            check(one, folder)
            includes = [related for related in one.related if related.message == "included here"]
            named = [related for related in one.related if "used here as" in related.message]
            at = Path((named[-1].span or one.span).source.path if named else one.span.source.path)
            assert at.name == "robot.yaml" or includes, one  # of what is in an included file it is said who includes it
