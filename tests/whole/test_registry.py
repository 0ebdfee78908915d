"""Rules declare themselves: each id once, where it is raised; the command and SARIF say what the page says."""

from __future__ import annotations

import ast
import json
import re
from collections import Counter
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

from rosorin_compile.cli import main
from rosorin_compile.diagnostics import ERROR, Diagnostic, registry, report
from rosorin_compile.diagnostics.registry import NUMBERS, Rule, checks_of, declared_in, every_rule, rule
from rosorin_compile.diagnostics.report import FORMATS
from rosorin_compile.rules import acceptable, checks, is_id
from support.paths import COMPILER, PACKAGES

# What the id of a rule looks like in the source, and the functions that take one as their first argument.
RULE = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
MAKERS = {"error", "Diagnostic", "OutputError", "ShapeProblem", "problem", "report", "fail"}
MAKERS |= {"_error", "_make", "_problem"}

# The order in which the modules of rules are asked: the later ones look away from what the earlier ones tell.
ORDER = "kinematics frames joints mimic drive inertia bodies sizes lacking ranges servos signs conditions publishers"
ORDER += " tf_tree stamps poses outputs control controllers moveit values materials xml_elements simulated_names"
ORDER += " actuators tendons constraints sensors numbers"
ORDER += " simulated_values mjcf_elements simulated_marks two_words stand_ins names sight"


def rule_ids(source: str) -> tuple[set[str], list[str]]:
    """Return the rule ids that a source raises, and patterns of those that are put together when it runs."""
    ids: set[str] = set()
    patterns: list[str] = []
    for node in ast.walk(ast.parse(source)):
        for value in rule_values(node):
            if isinstance(value, ast.JoinedStr):
                parts = [part.value if isinstance(part, ast.Constant) else "[a-z]+" for part in value.values]
                patterns.append("".join(parts))
            elif isinstance(value, ast.Constant) and isinstance(value.value, str):
                ids.add(value.value)
    return {rule for rule in ids if RULE.fullmatch(rule)}, [pattern for pattern in patterns if " " not in pattern]


def rule_values(node: ast.AST) -> list[ast.expr]:
    """Return what a piece of source says is the id of a rule: the first argument of a maker, a value of ``rule``."""
    if isinstance(node, ast.Call) and node.args:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        return node.args[:1] if name in MAKERS else []
    if isinstance(node, ast.Assign):
        target, value = node.targets[0], node.value
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) and len(target.elts) == len(value.elts):
            named = zip(target.elts, value.elts, strict=True)
            return [v for t, v in named if isinstance(t, ast.Name) and t.id == "rule"]
        if isinstance(target, ast.Name) and target.id in ("rule", "_RULE"):
            return [value.body, value.orelse] if isinstance(value, ast.IfExp) else [value]
    return []


SOURCES = [path for package in PACKAGES for path in sorted(package.rglob("*.py"))]
# Those that may declare some: all are looked at only when a test asks, for each worker collects.
DECLARING = [path for path in SOURCES if re.search(r"\b[Rr]ule\(\s*\"[a-z]", path.read_text("utf-8"))]


@cache
def declared(path: Path) -> list[Rule]:
    """Return the rules that a source declares; one without such a call is not parsed."""
    text = path.read_text("utf-8")
    return declared_in(text) if re.search(r"\b[Rr]ule\(", text) else []


@cache
def raised_in(path: Path) -> tuple[set[str], list[str]]:
    """Return what ``rule_ids`` finds in a source."""
    return rule_ids(path.read_text("utf-8"))


def test_every_id_that_is_raised_is_declared_once():
    counts = Counter(rule.id for path in SOURCES for rule in declared(path))
    assert [id for id, count in counts.items() if count > 1] == []
    raised = {id for path in SOURCES for id in raised_in(path)[0]}
    assert raised - counts.keys() == set()
    patterns = [pattern for path in SOURCES for pattern in raised_in(path)[1]]
    never = [id for id in counts.keys() - raised if not any(re.fullmatch(pattern, id) for pattern in patterns)]
    texts = "".join(path.read_text("utf-8") for path in SOURCES)
    assert [id for id in never if texts.count(f'"{id}"') == 1] == []


def test_there_are_sources() -> None:
    assert sum(len(declared(path)) for path in DECLARING) > 400
    assert [path for path in SOURCES if declared(path)] == DECLARING


@pytest.mark.parametrize("path", DECLARING, ids=lambda path: path.stem)
def test_an_id_is_declared_where_it_is_raised(path: Path):
    """In the same module, in one beside it, or in a folder below."""
    text = path.read_text("utf-8")
    beside = [other for other in SOURCES if other != path and other.is_relative_to(path.parent)]
    texts = "".join(other.read_text("utf-8") for other in beside)
    ids, patterns = raised_in(path)
    for one in declared(path):
        known = one.id in ids or any(re.fullmatch(pattern, one.id) for pattern in patterns)
        assert known or text.count(f'"{one.id}"') > 1 or f'"{one.id}"' in texts, one.id


@pytest.mark.parametrize("path", DECLARING, ids=lambda path: path.stem)
def test_what_is_read_from_the_source_is_what_the_module_has(path: Path):
    if "rosorin_compile_verify" in path.parts:
        pytest.importorskip("numpy")
    name = ".".join(path.relative_to(COMPILER).with_suffix("").parts).removesuffix(".__init__")
    module = import_module(name)
    made = list(getattr(module, "RULES", ()))
    made += [rule for check in checks_of(module) for rule in check.rules]
    assert {rule.id: rule for rule in made} == {rule.id: rule for rule in declared(path)}
    assert len(made) == len(declared(path))


def test_an_id_that_is_declared_twice_overrides_nothing(monkeypatch: pytest.MonkeyPatch):
    twice = [(Path(name), b'RULES = (Rule("axis-zero", "What.", "Help."),)') for name in ("one.py", "other.py")]
    monkeypatch.setattr(registry, "_declaring", lambda: iter(twice))
    with pytest.raises(ValueError, match=r"the rule axis-zero is declared twice, the second time in other\.py"):
        every_rule()


def test_every_rule_says_what_it_means():
    for one in every_rule().values():
        assert is_id(one.id)
        assert one.what.endswith(".")
        assert bool(one.accept) == bool(one.imported), one.id


@pytest.mark.parametrize("text", ["", "Axis", "axis_zero", "axis--zero", "-axis", "axis zero", "größe"])
def test_what_is_no_id(text: str):
    assert not is_id(text)


def test_the_modules_of_rules_are_asked_in_their_order():
    found = (check.function.__module__.removesuffix(".rules").rsplit(".", 1)[1] for check in checks())
    modules = dict.fromkeys(found)
    assert list(modules) == ORDER.split()


def test_decorators_of_one_check_add_up():
    @rule("one", "One.", "Do.", NUMBERS)
    @rule("two", "Two.", accept="link", imported="always")
    def look(case):
        return iter((case,))

    assert [one.id for one in look.rules] == ["one", "two"]
    assert look.rules[0] == Rule("one", "One.", "Do.", "Numbers")
    assert look.rules[1].accept == "link"
    assert list(look("here")) == ["here"]


def test_rule_prints_an_entry(capsys):
    assert main(["rule", "axis-not-unit", "bad-name"]) == 0
    assert capsys.readouterr().out == (
        "axis-not-unit\n"
        "  An axis is not of unit length; readers differ in what they make of it.\n"
        "  What to do: The message gives the same direction with length 1.\n"
        "  A joint may break it: accept: [{rule: axis-not-unit, of: [NAME], reason: WHY}]\n"
        "  import writes that entry by itself.\n"
        "\n"
        "bad-name\n"
        "  A name has a form that it may not have, such as `<` or a quote, or a space at its end.\n"
        "  What to do: Letters, digits and `_` are safe. Spaces within and `/` are allowed; names of values\n"
        "  and arguments are plain words.\n"
    )


def test_rule_says_where_a_link_leads(capsys):
    assert main(["rule", "expression", "limit-swapped"]) == 0
    printed = capsys.readouterr().out
    assert "what is allowed (docs/language.md#expressions)" in printed
    assert "import --lenient writes that entry." in printed


def test_rule_lists_all(capsys):
    assert main(["rule"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert sorted(line.split()[0] for line in lines if line.startswith("  ")) == sorted(every_rule())
    assert {rule.topic + ":" for rule in every_rule().values()} == {line for line in lines if line[:1].strip()}


def test_rule_prints_json(capsys):
    assert main(["rule", "axis-zero", "--format", "json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["result"]
    assert found == {
        "id": "axis-zero",
        "what": "An axis is zero: no direction.",
        "help": "Name one, such as `[0, 0, 1]`.",
        "topic": "Links and joints",
        "accept": "",
        "imported": "",
        "asked": "",
    }


def test_rule_without_such_an_id(capsys):
    assert main(["rule", "axis-zer"]) == 2
    assert capsys.readouterr().err == 'rosorin-compile: there is no rule "axis-zer"; did you mean "axis-zero"?\n'


def test_sarif_says_what_the_rule_means():
    log = json.loads(FORMATS["sarif"]([Diagnostic("axis-zero", ERROR, "zero"), Diagnostic("nobodys", ERROR, "x")]))
    known, other = log["runs"][0]["tool"]["driver"]["rules"]
    assert known == {
        "id": "axis-zero",
        "shortDescription": {"text": "An axis is zero: no direction."},
        "help": {"text": "Name one, such as `[0, 0, 1]`.", "markdown": "Name one, such as `[0, 0, 1]`."},
    }
    assert other == {"id": "nobodys", "shortDescription": {"text": "nobodys"}}


def test_sarif_leads_to_where_the_project_is(monkeypatch):
    monkeypatch.setattr(report, "HOME", "https://example.org/tree/")
    log = json.loads(FORMATS["sarif"]([Diagnostic("axis-zero", ERROR, "zero"), Diagnostic("nobodys", ERROR, "x")]))
    driver = log["runs"][0]["tool"]["driver"]
    assert driver["informationUri"] == "https://example.org/tree/"
    assert [rule.get("helpUri") for rule in driver["rules"]] == [
        "https://example.org/tree/docs/rules.md#axis-zero",
        None,
    ]


def test_what_may_be_accepted_says_of_what():
    assert {rule.accept for rule in acceptable().values()} == {"link", "joint", "link or joint"}
    assert {rule.imported for rule in acceptable().values()} == {"always", "lenient"}
