"""Which sections stand in no folder of their own, and where else a section is named: each with its reason."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path

from rosorin_compile.frontend.schema import own_schema
from rosorin_compile.model.sections import own_sections
from support.paths import PACKAGE

OF_THE_CORE = {
    "rosorin_compile": "the version of the language",
    "robot": "what the robot is called",
    "source": "where values come from, of any entry",
    "include": "how files are put together; gone before there is a model",
    "args": "what is given from outside; gone before there is a model",
    "let": "values with names; gone before there is a model",
    "materials": "what visuals of links look like",
    "links": "what a robot is made of",
    "joints": "what a robot is made of",
    "root": "how the root link stands in the world: a field of the robot, as joints have an origin",
    "sensors": "a sensor is frames: the joints that mount it are made, published and checked with all others",
    "urdf_elements": "of links, joints and sensors, too; those of sensors become the robot's, where it says none",
    "modes": "when which transform is published",
    "publishers": "who publishes a transform",
    "edges": "transforms that other nodes own",
    "poses": "positions of joints",
    "accept": "what is wrong and may be",
    "outputs": "what is made of the robot",
}

A_WORD = "a word that is called so, and not the section"
DOOR = "a public name, and where it is"
NAMED = {
    ("commands/init.py", "control"): A_WORD,
    ("commands/transforms/pulses.py", "servos"): "the command that asks servos for pulses",
    ("commands/transforms/states.py", "servos"): "a position on the command line may be a pulse",
    ("commands/transforms/tf.py", "servos"): "a position on the command line may be a pulse",
    ("frontend/expand/declared.py", "drive"): "the edge of the odometry as an example, of a base that drives",
    ("frontend/expand/forms.py", "mjcf_elements"): "also a key of links",
    ("frontend/lower/__init__.py", "mjcf_elements"): "also a key of links",
    ("frontend/lower/entries.py", "servos"): "poses may be written in pulses",
    ("frontend/synonyms.py", "controllers"): "the output that is called so",
    ("meaning/proof/model.py", "mjcf_elements"): "also a key of links",
    ("meaning/simulation.py", "mjcf_elements"): "also a key of links",
    ("meaning/not_compared.py", "drive"): "a topic of formats, with its word",
    ("model/__init__.py", "drive"): DOOR,
    ("model/robot.py", "control"): "an option of outputs that is called so",
    ("model/robot.py", "drive"): "the public property `driving`",
    ("pipeline.py", "mjcf_elements"): "files that elements of links and of the robot name",
    ("rules/kinematics.py", "moveit"): "what is unknown is told of the robot before it is told of planners",
    ("rules/misspelt.py", "servos"): "a joint that a group lists is defined there, for a name that is misspelt",
    ("rules/poses.py", "moveit"): "a pose that is the state of a group says nothing of other joints",
    ("rules/simulated_names.py", "drive"): "a base that drives is free in simulations",
    ("rules/simulated_names.py", "mjcf_elements"): "also a key of links",
    ("rules/simulated_values.py", "moveit"): "a virtual joint places the base that a pose gives",
    ("rules/two_words.py", "tendons"): "words that are said twice, of joints and of tendons",
}


def named() -> Iterator[tuple[str, str]]:
    """Yield the modules that name a section of a folder outside of the folders and formats, each with it."""
    for path in sorted(PACKAGE.rglob("*.py")):
        module = path.relative_to(PACKAGE).as_posix()
        if not module.startswith(("sections/", "formats/", "backend/")):
            yield from ((module, section) for section in sections_in(path))


def sections_in(path: Path) -> set[str]:
    """Return the sections that a module names as text, or of whose folder it imports something."""
    own: Mapping[str, object] = own_sections()
    nodes = list(ast.walk(ast.parse(path.read_text("utf-8"))))
    texts = {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    imports = {f"{node.module}." for node in nodes if isinstance(node, ast.ImportFrom)}
    folders = {
        module.split("sections.", 1)[1].partition(".")[0] for module in imports if module.startswith("sections.")
    }
    return (texts & own.keys()) | (folders - {""})


def test_each_section_stands_in_a_folder_or_is_the_cores_own() -> None:
    assert own_sections().keys().isdisjoint(OF_THE_CORE)
    assert own_schema()["properties"].keys() == own_sections().keys() | OF_THE_CORE.keys()


def test_no_module_but_these_names_a_section_of_a_folder() -> None:
    assert sorted(set(named())) == sorted(NAMED)


def test_a_module_that_names_one_is_found(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text('from ..sections.drive.value import Drive\n\nKEYS = ("servos", "links")\n', "utf-8")
    assert sections_in(tmp_path / "a.py") == {"drive", "servos"}
