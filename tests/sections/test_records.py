"""Records of sections that are none, and sections that make no robot: each is told with what is wrong."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import pytest

from rosorin_compile import Robot
from rosorin_compile.extend import Section, rule
from rosorin_compile.language import lower as lowering
from rosorin_compile.language import schema as sections
from rosorin_compile.language.schema import PluginSections, _marks
from rosorin_compile.model import Joint, Link, Pose
from rosorin_compile.model.sections import Sections
from rosorin_compile.source.diagnostics import Diagnostic, Source
from rosorin_compile.source.load import parse_yaml
from rosorin_compile.source.plugins import Plugin


@dataclass(frozen=True)
class Fan:
    link: str = ""


NAME = {"$ref": "#/$defs/name"}


def schema(entry: Mapping[str, Any], **properties: Any) -> dict[str, Any]:
    said = {"type": "object", "additionalProperties": False, "properties": {"link": NAME, **properties}, **entry}
    return {"type": "object", "additionalProperties": said}


NONE = {
    "a name": lambda: Section.by_name("Fans", Fan, schema({})),
    "no dataclass": lambda: Section.by_name("fans", str, schema({})),
    "another form": lambda: Section.list_of("fans", Fan, schema({})),
    "a word of no draft": lambda: Section.by_name("fans", Fan, schema({"requird": ["link"]})),
    "an annotation": lambda: Section.by_name("fans", Fan, schema({"x-miror": ["pose"]})),
    "a way to mirror": lambda: Section.by_name("fans", Fan, schema({"x-mirror": ["poses"]})),
    "a mirror of nothing": lambda: Section.by_name(
        "fans", Fan, schema({"x-mirror": ["direction"]}, push={"type": "array"})
    ),
    "a key beside it": lambda: Section.by_name(
        "fans", Fan, schema({}, at={**NAME, "x-attached": ["xzy"]}, xyz={"type": "array"})
    ),
    "a unit": lambda: Section.by_name("fans", Fan, schema({}, force={"type": "number", "x-unit": "Newton"})),
    "a rule": lambda: Section.by_name("fans", Fan, schema({}), checks=(rule("Too Hot", "It is.")(lambda _: ()),)),
    "a reference": lambda: Section.by_name("fans", Fan, schema({}, at={"$ref": "#/$defs/xzy"})),
}


@pytest.mark.parametrize("name", NONE)
def test_a_record_that_is_none_is_refused(name: str) -> None:
    with pytest.raises((ValueError, TypeError)):
        _marks(NONE[name]())


def test_a_kind_that_nothing_is_of_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    fans = Section.by_name("fans", Fan, schema({}, at={**NAME, "x-names": "lnik"}))
    monkeypatch.setattr(sections, "load", lambda *_: (((PLUGIN, fans),), ()))
    found = sections.plugin_sections.__wrapped__()
    assert found.sections == ()
    assert 'no kind "lnik"; did you mean "link"?' in found.diagnostics[0].message


PLUGIN = Plugin("toy", "1", "sections", "fans", "toy:FANS")
ROBOT = Robot("r", (Link("a"),), (), sections=Sections({"fans": {}}, {"fans": {}}))


def added(robot: Robot, joint: Joint) -> Robot:
    return replace(robot, links=(*robot.links, Link("b")), joints=(*robot.joints, joint))


@pytest.mark.parametrize(
    ("adds", "message"),
    [
        (lambda *_: None, "what a section adds to is a Robot again, not 'None'"),
        (lambda robot, _: added(robot, Joint("j", "fixed", "nowhere", "b", Pose())), 'joint "j" at link "nowhere"'),
        (lambda robot, _: added(robot, Joint("j", "fxed", "a", "b", Pose())), '"fxed"; did you mean "fixed"?'),
        (lambda *_: 1 / 0, "ZeroDivisionError"),
    ],
)
def test_what_a_section_makes_that_is_no_robot_is_told_of_its_package(
    monkeypatch: pytest.MonkeyPatch, adds: Any, message: str
) -> None:
    fans = Section.by_name("fans", Fan, schema({}), adds=adds)
    monkeypatch.setattr(lowering, "plugin_sections", lambda: PluginSections(((PLUGIN, fans),), ()))
    told: list[tuple[Diagnostic, str]] = []
    tree = parse_yaml(Source("r.yaml", "fans: {}"))
    made = lowering.with_sections(ROBOT, tree, lambda *one: told.append(one), lambda *_: None)
    assert made == ROBOT
    ((problem, section),) = told
    assert section == "fans"
    assert problem.rule == "plugin-broken"
    assert message in problem.message
