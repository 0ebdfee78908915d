"""Parts that come to the same are evaluated once, and nobody can tell.

The tree, its places and all messages are those of each part by itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile import compile as compile_robot
from rosorin_compile.frontend.expand import expand
from rosorin_compile.frontend.expand import scope as scope_module
from rosorin_compile.frontend.expand.parts import Parts
from rosorin_compile.frontend.tree import Map, Place, Seq, locate
from support.paths import ROOT

ROBOTS = sorted(
    [
        *(path for path in (ROOT / "tests" / "bad").glob("*.yaml") if "use:" in path.read_text("utf-8")),
        *ROOT.glob("examples/*/robot.yaml"),
        *ROOT.glob("descriptions/*/robot.yaml"),
    ]
)

CHAIN = """\
robot: chain
parts:
  segment:
    params: {length: 100 mm, limit: 90 deg, density: 2700 kg/m^3}
    let: {mass: "${density*length*0.04**2*m**2}", middle: "${length/2}"}
    links:
      link:
        inertial:
          mass: "${mass}"
          xyz: [0, 0, "${middle}"]
          inertia: {ixx: 0.005, iyy: "${mass*length**2}", izz: 0.004}
        collision: [{box: {size: [4 cm, 4 cm, "${length}"]}, xyz: [0, 0, "${middle}"]}]
    joints:
      joint:
        type: revolute
        parent: mount
        child: link
        axis: [0, 1, 0]
        limit: {lower: "${-limit}", upper: "${limit}", effort: 10, velocity: 2}
links: {base_link: {}}
use:
  "s${i}":
    for: {i: "${range(%d)}"}
    part: segment
    parent: ${'base_link' if i == 0 else 's' + str(i - 1) + '_link'}
    with: {length: "${(100 if i %% 3 else 120) * mm}"}
    xyz: [0, 0, 100 mm]
outputs: {urdf: {file: chain.urdf}}
"""


def each_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Parts, "_key", lambda *_: None)


def places(tree: Map) -> Iterator[tuple[tuple[Any, ...], Any, Any, Any, Any]]:
    """Yield all that a tree says, and where and by what each value came to be."""
    waiting: list[tuple[Any, ...]] = [()]
    while waiting:
        path = waiting.pop()
        node: Any = tree
        for step in path:
            node = node[step]
        at, key = locate(tree, path), locate(tree, path, key=True)
        yield path, type(node), None if isinstance(node, (Map, Seq)) else repr(node), shown(at), shown(key)
        if isinstance(node, (Map, Seq)):
            waiting += [(*path, step) for step in (node if isinstance(node, Map) else range(len(node)))]


def shown(place: Place) -> tuple[Any, ...]:
    return (place.span.source.path, *place.span[1:], place.stack())


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_a_robot_is_what_it_is_with_each_part_by_itself(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    together = compile_robot(path)
    tree = expand(path, {}, None).tree
    each_by_itself(monkeypatch)
    apart = compile_robot(path)
    assert together.diagnostics == apart.diagnostics
    assert together.artifacts == apart.artifacts
    if tree is not None:
        other = expand(path, {}, None).tree
        assert other is not None
        assert list(places(tree)) == list(places(other))


@pytest.mark.parametrize(
    "change",
    [
        ("90 deg", "200 deg"),  # a limit that looks wrong, in each of them
        ("0.04**2", "40**2"),  # a mass that no body of this size has
        ("ixx: 0.005", "ixx: -1"),
        ("[4 cm, 4 cm,", "[4 cm, 0,"),
        ("effort: 10", "effort: 10 m"),
        ("axis: [0, 1, 0]", "axis: [0, 1, 0.5]"),
        ("[4 cm, 4 cm,", '["${len(name)*cm}", 4 cm,'),
        ("part: segment\n", "part: segment\n    prefix: \"${'x_' if i == 2 else 'a' + str(i)}\"\n"),
        ("${middle}", "${middle if i == 0 else 0}"),
        ('{length: "${(100 if', '{limit: "${(i > 1)*-1.5}", length: "${(100 if'),
    ],
    ids=lambda change: change[1][:20],
)
def test_what_is_said_of_parts_that_are_alike_is_said_of_each(
    change: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "robot.yaml"
    text = (CHAIN % 7).replace(*change)
    assert text != CHAIN % 7
    path.write_text(text, "utf-8")
    together = compile_robot(path)
    each_by_itself(monkeypatch)
    apart = compile_robot(path)
    assert together.diagnostics == apart.diagnostics
    assert together.artifacts == apart.artifacts


def test_the_expressions_of_a_part_are_evaluated_once_for_all_that_are_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counts = []
    evaluated: list[str] = []
    evaluate = scope_module.evaluate
    monkeypatch.setattr(scope_module, "evaluate", lambda text, lookup: evaluated.append(text) or evaluate(text, lookup))
    for number in (10, 100):
        path = tmp_path / f"{number}.yaml"
        path.write_text(CHAIN % number, "utf-8")
        evaluated.clear()
        assert compile_robot(path).robot is not None
        counts.append(sum("i" not in text.replace("middle", "").replace("limit", "") for text in evaluated))
    assert counts[0] == counts[1] > 0
