"""Situations: the trees of frames that the modes of a robot make."""

from __future__ import annotations

import re
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats.templating import Templates
from rosorin_compile.language.expression import evaluate
from rosorin_compile.model import Edge, Link, Publisher, Robot
from rosorin_compile.model.joint import NODE
from rosorin_compile.viewer import frames_picture
from rosorin_compile.viewer.frame_trees import TooMany, frame_trees
from support.pictures import output

CONDITIONS = ("", "a", "not a", "a and b", "a or b", "not (a and c)", "a and not b or c", "b")


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from(CONDITIONS), max_size=4), st.dictionaries(st.sampled_from("abc"), st.booleans()))
def test_situations_share_out_all_combinations_of_modes(whens: list[str], fixed: dict[str, bool]) -> None:
    edges = tuple(Edge("base", f"frame {at}", Publisher(NODE, "node"), False, when) for at, when in enumerate(whens))
    robot = Robot("modes", (Link("base"),), (), edges=edges, modes=("a", "b", "c"))
    found = frame_trees(robot, fixed)
    for states in product((False, True), repeat=3):
        combination = dict(zip("abc", states, strict=True))
        if any(combination[mode] != state for mode, state in fixed.items()):
            continue
        here = [one for one in found if any(modes.items() <= combination.items() for modes in one.modes)]
        assert len(here) == 1
        meant = [edge.child for edge in edges if not edge.when or evaluate(edge.when, combination.__getitem__)]
        assert [row.child for row in here[0].edges] == meant
    assert len({one.edges for one in found}) == len(found) == len({one.label for one in found})
    assert len({one.short for one in found}) == len(found)


def labels(whens: tuple[str, ...], modes: tuple[str, ...] = ("a", "b", "c")) -> list[tuple[str, str]]:
    edges = tuple(Edge("base", f"frame {at}", Publisher(NODE, "n"), False, when) for at, when in enumerate(whens))
    return [
        (one.label, one.short) for one in frame_trees(Robot("r", (Link("base"),), (), edges=edges, modes=modes), {})
    ]


def test_situations_are_said_in_few_words() -> None:
    assert labels(()) == [("", "")]
    assert labels(("a",)) == [("a is on", "a_on"), ("a is off", "a_off")]
    assert labels(("a and not b",)) == [("b is on, or a is off", "b_on"), ("a is on and b is off", "a_on_b_off")]


def test_modes_whose_names_run_together_get_files_of_their_own() -> None:
    shorts = [short for _, short in labels(("a and b", "a_on_b", "A"), ("a", "b", "a_on_b", "A"))]
    assert len({short.casefold() for short in shorts}) == len(shorts)


def test_too_many_trees_are_refused() -> None:
    modes = tuple("abcdef")
    edges = tuple(Edge("base", f"f{mode}", Publisher(NODE, "n"), False, mode) for mode in modes)
    robot = Robot("r", (Link("base"),), (), edges=edges, modes=modes)
    message = "the tree of frames differs in 64 combinations of modes: too many to show"
    with pytest.raises(TooMany, match=re.escape(message)):
        frame_trees(robot, {})
    text, (problem,) = frames_picture.write(robot, output("frames.svg"), Templates())
    assert (text, problem.rule, problem.severity, problem.message) == ("", "too-many-pictures", "error", message)
    assert problem.help == "say which modes are on, one picture each: modes: [NAME, ...]"
    assert len(frame_trees(robot, {"a": True})) == 32
    many = tuple(f"m{at}" for at in range(12))
    edges = tuple(Edge("base", f"f{mode}", Publisher(NODE, "n"), False, mode) for mode in many)
    robot = Robot("r", (Link("base"),), (), edges=edges, modes=many)
    with pytest.raises(TooMany, match="the frames depend on 12 modes together"):
        frame_trees(robot, {})
    (one,) = frame_trees(robot, dict.fromkeys(many, True))
    assert one.label.startswith("m0 is on and m1 is on and ")
