"""The registry of rules, the command rule, and rules in SARIF."""

import json

from rosorin_compile.cli import report_formats
from rosorin_compile.cli.main import main
from rosorin_compile.cli.report_formats import FORMATS
from rosorin_compile.source.diagnostics import ERROR, Diagnostic


def test_rule_says_where_a_link_leads(capsys):
    assert main(["rule", "expression", "limit-swapped"]) == 0
    printed = capsys.readouterr().out
    assert "expressions (docs/language.md#expressions)" in printed
    assert "import --lenient writes that entry." in printed


def test_rule_without_such_an_id(capsys):
    assert main(["rule", "axis-zer"]) == 2
    assert capsys.readouterr().err == 'rosorin-compile: there is no rule "axis-zer"; did you mean "axis-zero"?\n'


def test_sarif_leads_to_where_the_project_is(monkeypatch):
    monkeypatch.setattr(report_formats, "HOME", "https://example.org/tree/")
    log = json.loads(FORMATS["sarif"]([Diagnostic("axis-zero", ERROR, "zero"), Diagnostic("nobodys", ERROR, "x")]))
    driver = log["runs"][0]["tool"]["driver"]
    assert driver["informationUri"] == "https://example.org/tree/"
    assert [rule.get("helpUri") for rule in driver["rules"]] == [
        "https://example.org/tree/docs/rules.md#axis-zero",
        None,
    ]
