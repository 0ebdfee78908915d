"""Who publishes each frame: proved by the rules, and counted by a search that knows nothing of them."""

import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.artifacts import agreement
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.frames import frames_by_publishing
from rosorin_compile.formats.static_tf import condition, in_frontends, in_python
from rosorin_compile.language.lower import lower
from rosorin_compile.model import Link, Robot
from rosorin_compile.rules.publishers import combinations, holds
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import parse_yaml
from rosorin_compile.viewer.frames import frame_trees
from support import launch
from support.launch import Context, Failed, Started, command_line, parsed, performed, run
from support.paths import data_text
from support.robots import found, rules

MODES = ("m", "n")
WHENS = ["", "m", "not m", "n", "m and n", "m and not n", "not (m or n)", "m or n", "m == n", "True"]
NOBODY = {"none": "why"}
OUTPUTS = {"urdf": {"file": "a.urdf"}, "static_tf": {"file": "a.launch.py"}}


def is_on(when: str, states: dict[str, bool]) -> bool:
    return not when or eval(when, {}, dict(states))  # noqa: S307


def every_state() -> list[dict[str, bool]]:
    return [dict(zip(MODES, states, strict=True)) for states in itertools.product((False, True), repeat=2)]


# Conditions that take turns, so that robots come out which are right; any others come too.
IN_TURN = st.sampled_from(
    [["m", "not m"], ["n", "not n"], ["m and n", "not (m and n)"], ["m", "n and not m", "not (m or n)"]]
)
ANY_WHENS = st.one_of(IN_TURN, IN_TURN, IN_TURN, st.lists(st.sampled_from(WHENS), min_size=1, max_size=3))


@st.composite
def owned(draw: Any) -> dict[str, Any]:
    """Make a robot that is one tree; its joints and a few edges are published by anybody, always or in turns."""
    count = draw(st.integers(2, 4))
    taking_turns = st.sampled_from(["static", "static", "a", "b", "b", "nobody", "urdf"])
    kinds = st.sampled_from(["urdf", "urdf", "static", "a", "nobody"])
    names = itertools.count()

    def publisher(kind: str) -> Any:
        special = {"urdf": "robot_state_publisher", "static": {"static_transform_publisher": f"tf{next(names)}"}}
        return {**special, "nobody": NOBODY}.get(kind, kind)

    joints: dict[str, Any] = {}
    for n in range(1, count):
        joint = {"type": "fixed", "parent": f"l{draw(st.integers(0, n - 1))}", "child": f"l{n}"}
        said = publisher(draw(kinds))
        if draw(st.booleans()):
            whens = draw(ANY_WHENS)
            said = [{"by": publisher(draw(taking_turns)), **({"when": when} if when else {})} for when in whens]
        joints[f"j{n}"] = {**joint, "publisher": said}
    links = [f"l{n}" for n in range(count)]
    silent = [joint["child"] for joint in joints.values() if joint["publisher"] == NOBODY]
    edges: list[dict[str, Any]] = []
    for _ in range(draw(st.integers(0, 2))):
        child = draw(st.sampled_from(["l0", *silent, *silent, *silent, *links, "odom"]))
        for when in draw(ANY_WHENS):
            parent = draw(st.sampled_from([*links, "odom", "odom", "map"]))
            who = draw(st.sampled_from("ab"))
            edges.append({"parent": parent, "child": child, "publisher": who, **({"when": when} if when else {})})
    return {
        "robot": "made",
        "modes": dict.fromkeys(MODES),
        "publishers": {"a": None, "b": None},
        "links": {link: {} for link in links},
        "joints": joints,
        "edges": edges,
        "outputs": OUTPUTS,
    }


def running(description: dict[str, Any], states: dict[str, bool]) -> list[tuple[str, str, str]]:
    """Return parent, child and owner of all that is published when modes are so; the owner nobody is told too."""
    made = []
    for joint in description["joints"].values():
        said = joint["publisher"]
        turns = said if isinstance(said, list) else [{"by": said}]
        if any(turn["by"] == "robot_state_publisher" for turn in turns):
            made.append((joint["parent"], joint["child"], "urdf"))
        for turn in turns:
            if turn["by"] != "robot_state_publisher" and is_on(turn.get("when", ""), states):
                silent = turn["by"] == NOBODY and isinstance(said, list)
                if turn["by"] != NOBODY or silent:
                    made.append((joint["parent"], joint["child"], "nobody" if silent else str(turn["by"])))
    for edge in description["edges"]:
        if is_on(edge.get("when", ""), states):
            made.append((edge["parent"], edge["child"], edge["publisher"]))
    return made


def goes_round(pairs: list[tuple[str, str]]) -> bool:
    return any(start in reached(pairs, start) for start, _ in pairs)


def reached(pairs: list[tuple[str, str]], start: str) -> set[str]:
    seen: set[str] = set()
    for _ in pairs:
        seen |= {child for parent, child in pairs if parent == start or parent in seen}
    return seen


def doubled(description: dict[str, Any], states: dict[str, bool]) -> bool:
    """Say whether a frame has two owners at once, or one that a turn of the same joint says nobody is."""
    now = running(description, states)
    children = [child for _, child, owner in now if owner != "nobody"]
    if len(set(children)) < len(children):
        return True
    silent = {child for _, child, owner in now if owner == "nobody"}
    edges = {edge["child"] for edge in description["edges"] if is_on(edge.get("when", ""), states)}
    return bool(silent & set(children) - edges)


@given(owned())
@settings(max_examples=300, deadline=None)
def test_rules_agree_with_a_search_through_all_modes(description):
    said = set(rules(description))
    assert ("two-publishers" in said) == any(doubled(description, states) for states in every_state())
    pairs = [
        [(parent, child) for parent, child, owner in running(description, states) if owner != "nobody"]
        for states in every_state()
    ]
    assert ("edge-cycle" in said) == any(map(goes_round, pairs))


@given(owned())
@settings(max_examples=300, deadline=None)
def test_gaps_are_those_of_the_search(description):
    """Where nothing is an error, the frames with a gap are those that the search finds, and the proof names them."""
    diagnostics = found(description)
    if any(d.severity == "error" for d in diagnostics):
        return
    runs = [{child for _, child, _ in running(description, states)} for states in every_state()]
    gaps = {child for child in set().union(*runs) if not all(child in run for run in runs)}
    told = {
        child for child in gaps for d in diagnostics if d.rule == "unpublished-edge" and f'-> "{child}"' in d.message
    }
    assert told == gaps
    assert sum(d.rule == "unpublished-edge" for d in diagnostics) == len(gaps)
    proof = frames_by_publishing(model(description))
    published = [
        {child for _, child, owner in running(description, states) if owner != "nobody"} for states in every_state()
    ]
    always = set.intersection(*published)
    assert set(proof["published"]) == always
    assert set(proof["gaps"]) == set().union(*published) - always
    assert proof["wrong"] == proof["unchecked"] == []


def model(description: dict[str, Any]) -> Robot:
    robot = lower(parse_yaml(Source("robot.yaml", yaml.safe_dump(description, sort_keys=False)))).robot
    assert robot is not None
    return robot


@given(owned())
@settings(max_examples=200, deadline=None)
def test_pictures_and_launch_files_have_the_edges_of_the_search(description):
    if any(d.severity == "error" for d in found(description)):
        return
    robot = model(description)
    for states in every_state():
        shown = frame_trees(robot, states)[0]
        drawn = {(row.parent, row.child) for row in shown.rows if row.is_published}
        now = {(parent, child) for parent, child, owner in running(description, states) if owner != "nobody"}
        assert drawn == now


TURNS = data_text("robots/ownership_turns.yaml")


def made(folder: Path, text: str = TURNS) -> dict[str, str]:
    path = folder / "robot.yaml"
    path.write_text(text, "utf-8")
    result = compile_robot(path)
    assert [d for d in result.diagnostics if d.severity != "note"] == []
    return {artifact.output: artifact.text for artifact in result.artifacts}


def started(artifacts: dict[str, str], folder: Path, **modes: str) -> list[Started]:
    (folder / "turner.urdf").write_text(artifacts["urdf"], "utf-8")
    return [n for n in run(artifacts["static_tf"], folder / "turner.launch.py", **modes) if n.package == "tf2_ros"]


@pytest.mark.parametrize(
    ("modes", "names"),
    [
        ({}, ["tf_laser", "tf_camera", "tf_camera_optical"]),
        ({"simulated": "False"}, ["tf_laser", "tf_camera", "tf_camera_optical"]),
        ({"simulated": "true"}, []),
        ({"simulated": "True", "mode_urdf_file": "true"}, ["tf_laser_too"]),
    ],
)
def test_launch_file_starts_the_publishers_of_a_mode(tmp_path, modes, names):
    nodes = started(made(tmp_path), tmp_path, **modes)
    assert [node.name for node in nodes] == names
    for node in nodes:
        parent, child, pose = command_line(node.arguments)
        assert (parent, child) in {
            ("base_link", "laser"),
            ("base_link", "camera_link"),
            ("camera_link", "camera_link_optical"),
        }
        assert pose.xyz == ((0.1, 0.0, 0.0) if child == "laser" else (0.0, 0.0, 0.0))


@pytest.mark.parametrize("state", ["maybe", "1", "on", ""])
def test_launch_file_refuses_what_is_no_state(tmp_path, state):
    with pytest.raises(Failed, match=f"Argument 'simulated' provided value '{state}' is not valid"):
        started(made(tmp_path), tmp_path, simulated=state)


def test_artifacts_agree_and_a_wrong_one_does_not(tmp_path):
    path = tmp_path / "robot.yaml"
    path.write_text(TURNS, "utf-8")
    result = compile_robot(path)
    assert result.robot is not None
    assert agreement(result.robot, result.artifacts) == []
    for output, old, new in (
        ("frames", "| 0.1 ", "| 0.2 "),
        ("frames", "| not simulated ", "| simulated "),
        ("static_tf", "'laser']", "'lasre']"),
        ("static_tf_json", '"0.1"', '"0.3"'),
    ):
        texts = [replace(a, text=a.text.replace(old, new)) if a.output == output else a for a in result.artifacts]
        assert texts != list(result.artifacts), output
        assert agreement(result.robot, texts) != [], (output, old)


def in_launch(when: str, modes: tuple[str, ...], states: dict[str, bool]) -> set[str]:
    names = {mode: f"mode_{mode}" for mode in modes}
    read = condition(Robot("r", (Link("l"),), (), modes=modes), when)
    context = Context({}, {names[mode]: str(state).lower() for mode, state in states.items()})
    known = {name: vars(launch)[name] for name in vars(launch) if name.endswith(("Substitution", "Configuration"))}
    value = eval(in_python(read, names, 60), known)  # noqa: S307
    return {performed(value, context), performed(parsed(in_frontends(read, names)), context)}


@pytest.mark.parametrize(
    "when",
    [w for w in WHENS if w not in ("", "True")]
    + ["(m) and(not n)", "m if n else not m", "not not m", "n in [m]", "m or True", "m and False", "m != n"],
)
def test_conditions_mean_the_same_in_launch(when):
    for states in combinations(["m", "n"]):
        assert in_launch(when, ("m", "n", "and"), dict(states)) == {str(holds(when, states)).lower()}


SOME = ("a", "b", "c", "d")
CONDITIONS = st.recursive(
    st.sampled_from(SOME),
    lambda inner: st.one_of(
        inner.map(lambda one: f"not ({one})"),
        st.lists(inner, min_size=2, max_size=4).map(lambda some: " and ".join(f"({one})" for one in some)),
        st.lists(inner, min_size=2, max_size=4).map(lambda some: " or ".join(f"({one})" for one in some)),
        st.tuples(inner, inner).map(lambda two: f"({two[0]}) == ({two[1]})"),
        st.tuples(inner, inner, inner).map(lambda three: f"({three[0]}) if ({three[1]}) else ({three[2]})"),
    ),
    max_leaves=8,
)


@given(CONDITIONS)
@settings(max_examples=150, deadline=None)
def test_any_condition_has_the_truth_table_of_its_launch(when):
    for states in combinations(list(SOME)):
        assert in_launch(when, SOME, dict(states)) == {str(holds(when, states)).lower()}
