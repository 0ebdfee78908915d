"""rosorin-compile rule: say what the id of a message means, and what to do; or list all ids."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Sequence

from rosorin_compile.language.accepting import STAYS
from rosorin_compile.source.diagnostics import has_errors
from rosorin_compile.source.rule_registry import PLUGINS, Rule

from .answer import answer_of, give_result
from .command import Options, command
from .options import words_argument
from .usage import FINE, PROBLEMS

_LINK = re.compile(r"\[([^\]]*)\]\(([^)\s]+)\)")
_WIDTH = 100
_IMPORTED = {"always": "import writes that entry by itself.", "lenient": "import --lenient writes that entry.", "": ""}


@command("rule", exits="0 printed, 1 a plug-in is broken")
@words_argument(
    "[ID ...]",
    "id in the brackets of a message, such as axis-zero; default: list all rules",
    offers=("rule",),
)
def run(options: Options) -> int:
    """Print the entries of rules."""
    from rosorin_compile import api

    found = api.explain_rules(options.words)
    give_result(options, found.rules, lambda: _text(found.rules, bool(options.words)))
    answer_of(options).console().show(found.diagnostics)
    return PROBLEMS if has_errors(found.diagnostics) else FINE


def _text(rules: Sequence[Rule], in_full: bool) -> str:
    return "\n\n".join("\n".join(entry(rule)) for rule in rules) if in_full else "\n".join(_listed(rules))


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
