"""rosorin-compile rule: say what the id of a message means, and what to do; or list all ids."""

from __future__ import annotations

import argparse
import re
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from rosorin_compile.language.accepting import STAYS
from rosorin_compile.source.diagnostics import Diagnostic, did_you_mean, has_errors
from rosorin_compile.source.rule_registry import OF_PLUGINS, PLUGINS, Rule, every_rule, find

from .answer import answer_of, give_result
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from .parser import Parser


_LINK = re.compile(r"\[([^\]]*)\]\(([^)\s]+)\)")
_WIDTH = 100
_IMPORTED = {"always": "import writes that entry by itself.", "lenient": "import --lenient writes that entry.", "": ""}


def options(command: Parser) -> None:
    """Add what this command takes."""
    what = "id in the brackets of a message, such as axis-zero; default: list all rules"
    command.add_argument("words", nargs="*", metavar="ID", help=what)
    command.add_result_form()


def run(options: argparse.Namespace) -> int:
    """Print the entries of rules."""
    of_plugins, diagnostics = _of_plugins()
    rules = {**of_plugins, **(find(options.words) if options.words else every_rule())}
    for id in options.words:
        if id not in rules:
            raise WrongUsage(f'there is no rule "{id}"; {did_you_mean(id, {**every_rule(), **of_plugins})}')
    chosen = [rules[id] for id in dict.fromkeys(options.words or sorted(rules))]
    give_result(options, [asdict(rule) for rule in chosen], lambda: _text(chosen, bool(options.words)))
    answer_of(options).console().show(diagnostics)
    return PROBLEMS if has_errors(diagnostics) else FINE


def _text(rules: Sequence[Rule], in_full: bool) -> str:
    return "\n\n".join("\n".join(entry(rule)) for rule in rules) if in_full else "\n".join(_listed(rules))


def every() -> dict[str, Rule]:
    """Return all rules by id: those of plug-ins, and the tool's own."""
    return {**_of_plugins()[0], **every_rule()}


def _of_plugins() -> tuple[dict[str, Rule], tuple[Diagnostic, ...]]:
    """Return the rules of plug-ins by id, and what is wrong with plug-ins."""
    from rosorin_compile.formats import plugged_diagnostics
    from rosorin_compile.rules.check import plugged

    diagnostics = (*plugged().diagnostics, *plugged_diagnostics())
    return dict(OF_PLUGINS), diagnostics


def entry(rule: Rule) -> list[str]:
    """Return what the page of rules says of one, as lines for a terminal."""
    lines = [rule.id, *_wrapped(rule.what)]
    if rule.help:
        lines += _wrapped(f"What to do: {rule.help}")
    if rule.accept:
        of = "" if rule.accept == "robot" else ", of: [NAME]"
        lines += _wrapped(f"A {rule.accept} may break it: accept: [{{rule: {rule.id}{of}, reason: WHY}}]")
        lines += _wrapped(_IMPORTED[rule.imported])
    elif rule.mild and rule.id not in STAYS:
        lines += _wrapped(f"To end it: accept: [{{rule: {rule.id}, reason: WHY}}]")
    return lines


def _wrapped(text: str) -> list[str]:
    plain = _LINK.sub(lambda link: f"{link[1]} ({_from_here(link[2])})", text)
    return textwrap.wrap(plain, _WIDTH, initial_indent="  ", subsequent_indent="  ", break_on_hyphens=False)


def _from_here(target: str) -> str:
    """Return the target of a link on the page of rules as seen from the folder of the project."""
    if "://" in target:
        return target
    return f"docs/rules.md{target}" if target.startswith("#") else f"docs/{target}"


def _listed(rules: Iterable[Rule]) -> list[str]:
    """Return rules by topic, a line each."""
    topics: dict[str, list[Rule]] = {}
    for rule in rules:
        topics.setdefault(rule.topic or PLUGINS, []).append(rule)
    width = max(len(rule.id) for own in topics.values() for rule in own)
    lines: list[str] = []
    for topic in sorted(topics):
        lines += ["", f"{topic}:"]
        for rule in topics[topic]:
            what = textwrap.shorten(_LINK.sub(lambda link: link[1], rule.what), _WIDTH, placeholder=" ...")
            lines.append(f"  {rule.id:<{width}}  {what}")
    return lines[1:]
