"""Nothing is lost silently: another value of any leaf changes each artifact, or the format gives a reason.

The reason is a note that names the key and the format, or an entry in ``unsupported`` or ``covers`` of the format. The
descriptions are those of ``every_word`` and of this folder. The daily run tries a tenth of the keys.
"""

from __future__ import annotations

import json
import random
import shutil
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml

import rosorin_compile
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.unsupported import reason
from rosorin_compile.language.annotations import of_parts
from support.leaves import Leaf, all_keys, changed, leaves, names_by_kind

HERE = Path(__file__).parent
EVERY_WORD = HERE.parent / "judges" / "goldens" / "every_word"
SEED = 57
SHARE = 10
# What the section "mjcf" of raw elements replaces, and what only copies MJCF.
WAITING = ("tendons", "constraints", "mjcf_sensors", "contact_layers", "contact_pairs")
MOST_VALID, MOST_TRIED = 3, 25
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

    def __init__(self, name: str, description: Description, form: Form, folder: Path) -> None:
        self.name, self.description, self.form, self.folder = name, description, form, folder
        self.names = names_by_kind(description)
        self.leaves = leaves(description)
        base = self.compile(description)
        assert isinstance(base, Result), f"{name}: {base}"
        self.base = base

    def compile(self, description: Description, formats: Collection[str] = ()) -> Result | str:
        """Compile a description in its form to all formats or some; return the first error if there is one."""
        for name, content in self.form(description).items():
            (self.folder / name).write_text(json.dumps(_escaped(content)), encoding="utf-8")
        names = [output.name for output in self.base.outputs if output.backend in formats] if formats else []
        compiled = rosorin_compile.compile(self.folder / "robot.yaml", outputs=names)
        if compiled.robot is None:
            return next(str(one) for one in compiled.diagnostics if one.severity == "error")
        texts = defaultdict[str, tuple[str, ...]](tuple)
        for artifact in compiled.artifacts:
            texts[artifact.backend] += (artifact.text,)
        return Result(
            compiled.robot.outputs, dict(texts), frozenset((one.rule, one.message) for one in compiled.diagnostics)
        )

    def is_excused(self, name: str, key: str) -> bool:
        """Return True if every output of a format has a reason for not carrying a key that needs no note."""
        outputs = [output for output in self.base.outputs if output.backend == name]
        reasons = [reason(FORMATS[name], output, key) for output in outputs]
        return all(why is not None and why.quiet for why in reasons)

    def results(self, leaf: Leaf, formats: Collection[str]) -> Iterator[Result]:
        """Yield the results of some other values of a leaf that are valid."""
        valid = 0
        for number, description in enumerate(changed(self.description, leaf, self.names)):
            result = self.compile(description, formats)
            if isinstance(result, Result):
                valid += 1
                yield result
            if valid == MOST_VALID or number == MOST_TRIED:
                return


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
    for sensor in part.get("sensors", {}).values():
        sensor.get("optical", {}).pop("rpy", None)  # what the standard asks for is not mirrored
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


def cases(form: Form, folder: Path) -> list[Case]:
    """Return the descriptions in a form, each in a folder with the files of ``every_word``."""
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
    found |= {f"wheels_{kind}": {**wheels, **changes} for kind, changes in DRIVES.items()}
    made = []
    for name, description in found.items():
        shutil.copytree(EVERY_WORD, folder / name)
        made.append(Case(name, description, form, folder / name))
    return made


def lost(cases: list[Case], keys: set[str]) -> dict[str, dict[str, set[str]]]:
    """Return for each key the formats that carry no other value of it, without a word, with the cases."""
    found = {}
    for key in sorted(keys):
        missing: dict[str, set[str]] = {}
        carried: set[str] = set()
        tried = False
        for case in cases:
            places = [leaf for leaf in case.leaves if leaf.key == key][:3]
            formats = {name for name in case.base.texts if not case.is_excused(name, key)} - carried
            for leaf in places:
                if not formats:
                    tried = True
                    break
                for result in case.results(leaf, formats):
                    tried = True
                    carried |= {name for name in formats if _carries(case.base, result, name, key)}
                    formats -= carried
                    if not formats:
                        break
            for name in formats if places else ():
                missing.setdefault(name, set()).add(case.name)
        missing = {name: where for name, where in missing.items() if name not in carried}
        if not tried:
            missing["no valid value"] = set()
        if missing:
            found[key] = missing
    return found


def _carries(base: Result, result: Result, name: str, key: str) -> bool:
    if result.texts.get(name) != base.texts[name]:
        return True
    prefix = name.replace("_", "-")
    steps = key.split(".")
    listed = [f"{'.'.join(steps[: count + 1])} (" for count in range(len(steps))]
    texts = [text for rule, text in base.remarks if rule == "not-in-format" and text.startswith(FORMATS[name].word)]
    noted = any(one in text for one in listed for text in texts)
    ignored = [text for rule, text in base.remarks if rule == "ignored-key"]
    noted |= any(f"its {step} has no effect" in text for step in steps for text in ignored)
    return noted or any(rule.startswith(prefix) for rule, _ in base.remarks ^ result.remarks)
