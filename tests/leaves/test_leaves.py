"""Nothing is lost silently: another value of any leaf changes each artifact, or the format gives a reason.

The reason is a note that names the key and the format, or an entry in ``unsupported`` or ``covers`` of the format. The
descriptions are those of ``every_word`` and of this folder. The daily run tries a tenth of the keys.
"""

from __future__ import annotations

import json
import random
import shutil
from collections import defaultdict
from collections.abc import Callable, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml

import rosorin_compile
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import reason
from rosorin_compile.language.schema import of_parts
from support.leaves import Leaf, all_keys, changed, leaves, names_by_kind

HERE = Path(__file__).parent
EVERY_WORD = HERE.parent / "judges" / "goldens" / "every_word"
SEED = 57
SHARE = 10
MOST_PLACES, MOST_VALID, MOST_TRIED = 3, 3, 25
# Schemas that are shared have keys which no description may set there.
NOWHERE = (
    *("joints.actuator.mjcf.cranklength", "joints.actuator.mjcf.gain", "links.inertial.of.mesh.file"),
    *("links.inertial.of.mesh.inertia", "links.inertial.of.mesh.mjcf.content_type", "links.inertial.of.mjcf.fitscale"),
    *("links.inertial.of.mesh.mjcf.maxhullvert", "links.inertial.of.mesh.mjcf.smoothnormal"),
    *("links.inertial.of.mesh.scale", "links.inertial.of.mjcf.material"),
)
KEYS = sorted(key for key in all_keys() if key not in NOWHERE)
SENSOR_TYPES = ["imu", "camera", "lidar_2d", "range_finder", "gnss"]  # some of the library
EXPANDED = ("args", "let", "include")

# The kinds of drives, with the type of the controller of each, for wheels.yaml.
_LEFT, _RIGHT, _ROLLING = (
    ["left_joint", "left_2_joint"],
    ["right_joint", "right_2_joint"],
    ["left_joint", "right_joint"],
)
_STEERING, _DRIVEN = ["fork_joint", "fork_2_joint"], ["front_joint", "front_2_joint"]
DRIVES: dict[str, dict[str, Any]] = {
    "differential": {"drive": {"differential": {"left": _LEFT, "right": _RIGHT}}},
    "tricycle": {
        "drive": {"tricycle": {"steering": "fork_joint", "driven": ["front_joint"], "rolling": _ROLLING}},
        "controllers": {"wheels": {"type": "tricycle"}},
    },
    "ackermann": {
        "drive": {"ackermann": {"steering": _STEERING, "driven": _DRIVEN, "rolling": _ROLLING}},
        "controllers": {"wheels": {"type": "ackermann_steering"}},
    },
}

Description = dict[str, Any]
Form = Callable[[Description], dict[str, Description]]


class Result(NamedTuple):
    """The texts of each format that has an output, and the rules and messages of warnings and notes."""

    outputs: tuple[Any, ...]
    texts: dict[str, tuple[str, ...]]
    remarks: frozenset[tuple[str, str]]


class Case:
    """A description in one form, with the leaves that it sets, and what it compiles to."""

    def __init__(self, description: Description, form: Form, folder: Path) -> None:
        self.description, self.form, self.folder = description, form, folder
        self.names = {**names_by_kind(description), "sensor type": SENSOR_TYPES}
        self.places = defaultdict[str, list[Leaf]](list)
        for leaf in leaves(description):
            self.places[leaf.key].append(leaf)

    @cached_property
    def base(self) -> Result:
        """What the description compiles to as it is."""
        shutil.copytree(EVERY_WORD, self.folder)
        template = self.folder / "marks.xml.jinja"
        template.with_name(f"{template.name}_x").write_text('<framequat objtype="xbody" objname="base_link"/>')
        base = self.compile(self.description)
        assert isinstance(base, Result), base
        return base

    def compile(self, description: Description, outputs: Sequence[str] = ()) -> Result | str:
        """Compile a description in its form to all outputs or some; return the first error if there is one."""
        for name, content in self.form(description).items():
            (self.folder / name).write_text(json.dumps(_escaped(content)), encoding="utf-8")
        compiled = rosorin_compile.compile(self.folder / "robot.yaml", outputs=outputs)
        errors = [str(one) for one in compiled.diagnostics if one.severity == "error"]
        if errors:
            return errors[0]
        assert compiled.robot is not None
        texts = defaultdict[str, tuple[str, ...]](tuple)
        for artifact in compiled.artifacts:
            texts[artifact.backend] += (artifact.text,)
        remarks = frozenset((one.rule, one.message) for one in compiled.diagnostics)
        return Result(compiled.robot.outputs, dict(texts), remarks)

    def unexplained(self, key: str) -> set[str]:
        """Return the formats that give no reason for not carrying a key, and no note."""
        steps = key.split(".")
        is_stale = any(rule == "collisions-stale" for rule, _ in self.base.remarks)
        if is_stale and {"collision_matrix", "collisions"} & {*steps}:
            return set()  # a mirrored robot is another one
        listed = [f"{'.'.join(steps[: count + 1])} (" for count in range(len(steps))]
        if any(
            rule == "ignored-key" and f"its {step} has no effect" in text
            for rule, text in self.base.remarks
            for step in steps
        ):
            return set()
        found = set()
        for name in self.base.texts:
            reasons = [reason(FORMATS[name], output, key) for output in self.base.outputs if output.backend == name]
            quiet = all(why is not None and why.quiet for why in reasons)
            start = f"{FORMATS[name].word} cannot express "
            notes = [text for rule, text in self.base.remarks if rule == "not-in-format" and text.startswith(start)]
            if not quiet and not any(one in text for text in notes for one in listed):
                found.add(name)
        return found

    def carrying(self, key: str, formats: set[str]) -> tuple[set[str], bool]:
        """Return the formats that carry other values of a leaf or remark on them; False without a valid value."""
        carrying: set[str] = set()
        is_valid = False
        for leaf in self.places[key][:MOST_PLACES]:
            valid = 0
            for number, description in enumerate(changed(self.description, leaf, self.names)):
                left = formats - carrying
                if not left or valid == MOST_VALID or number == MOST_TRIED:
                    break
                result = self.compile(description, [one.name for one in self.base.outputs if one.backend in left])
                if isinstance(result, Result):
                    valid += 1
                    is_valid = True
                    carrying |= {name for name in left if result.texts[name] != self.base.texts[name]}
                    rules = {rule for rule, _ in self.base.remarks ^ result.remarks}
                    carrying |= {
                        name for name in left if any(rule.startswith(name.replace("_", "-")) for rule in rules)
                    }
        return carrying, is_valid


def _escaped(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _escaped(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_escaped(item) for item in value]
    return value.replace("${", "$${") if isinstance(value, str) else value


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    kinds = (bool, int, float, str)
    return next((kind(value) for kind in kinds if isinstance(value, kind)), None)


def direct(description: Description) -> dict[str, Description]:
    """Return the files of a description as it is."""
    return {"robot.yaml": description}


def mirrored(description: Description) -> dict[str, Description]:
    """Return the files of a description that is a mirrored part, but for the root link, which it is mounted on."""
    sections = {key: value for key, value in description.items() if key in of_parts()}
    rest = {key: value for key, value in description.items() if key not in of_parts()}
    root = (sections["links"].keys() - {joint["child"] for joint in sections["joints"].values()}).pop()
    links = {name: link for name, link in sections["links"].items() if name != root}
    part = json.loads(json.dumps({**sections, "links": links}).replace(json.dumps(root), '"mount"'))
    use = {"half": {"part": "half", "prefix": "", "parent": root, "mirror": "y"}}
    return {"robot.yaml": {**rest, "links": {root: sections["links"][root]}, "parts": {"half": part}, "use": use}}


def included(description: Description) -> dict[str, Description]:
    """Return the files of a description that includes another one with all its sections."""
    own = ("robot", "rosorin_compile", "outputs", "source")
    inner = {key: value for key, value in description.items() if key not in own}
    return {
        "robot.yaml": {**{key: description[key] for key in own if key in description}, "include": ["inner.yaml"]},
        "inner.yaml": inner,
    }


FORMS = {form.__name__: form for form in (direct, mirrored, included)}


@cache
def descriptions() -> dict[str, Description]:
    """Return the descriptions by name; those of ``every_word`` are expanded."""
    found = {}
    for path in sorted(EVERY_WORD.glob("*.yaml")):
        if "robot" in yaml.safe_load(path.read_text("utf-8")):
            expanded = _plain(rosorin_compile.read(path).tree)
            found[path.stem] = {key: value for key, value in expanded.items() if key not in EXPANDED}
    # The types of sensors are gone with the expansion.
    found["robot"]["sensors"]["cliff"]["type"] = "range_finder"
    found["robot"]["outputs"] |= {"robot_model": {"file": "model.json"}, "frames_picture": {"file": "frames.svg"}}
    found |= {f"{path.stem}_leaves": yaml.safe_load(path.read_text("utf-8")) for path in sorted(HERE.glob("*.yaml"))}
    wheels = found.pop("wheels_leaves")
    return found | {f"wheels_{kind}": {**wheels, **changes} for kind, changes in DRIVES.items()}


def cases(form: Form, folder: Path) -> list[Case]:
    """Return the descriptions in a form, the small ones first."""
    small = sorted(descriptions().items(), key=lambda item: len(str(item[1])))
    return [Case(description, form, folder / name) for name, description in small]


def lost(cases: list[Case], key: str) -> list[str]:
    """Return the formats that lose a leaf without a word, each with the key; or why nobody knows."""
    missing, carrying = set[str](), set[str]()
    tried = False
    for case in cases:
        if case.places[key]:
            formats = case.unexplained(key) - carrying
            more, is_valid = case.carrying(key, formats)
            tried |= is_valid or not formats
            missing |= formats
            carrying |= more
    if not tried:
        return [f"{key}: no other value is valid"]
    return [f"{key}: {name}" for name in sorted(missing - carrying)]


def test_every_leaf_is_set() -> None:
    made = [Case(description, direct, Path()) for description in descriptions().values()]
    assert sorted(key for key in KEYS if not any(case.places[key] for case in made)) == []


@pytest.mark.parametrize("number", range(len(FORMS)), ids=FORMS)
def test_some_leaves_reach_every_format(number: int, tmp_path: Path) -> None:
    some = random.Random(SEED).sample(KEYS, len(KEYS) // SHARE)  # noqa: S311
    every = cases([*FORMS.values()][number], tmp_path)
    assert [one for key in some[number :: len(FORMS)] for one in lost(every, key)] == []


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
def test_every_leaf_reaches_every_format(form: str, tmp_path: Path) -> None:
    every = cases(FORMS[form], tmp_path)
    assert [one for key in KEYS for one in lost(every, key)] == []
