"""The page of rules, made from what each module declares, so that it cannot fall behind.

    python docs/make/rules_reference.py > docs/rules.md

``python tests/renew.py docs`` does that too. What is said of all rules, or of a topic, stands in
``docs/_rules_head.md``, with the mark ``<!-- rules -->`` under each heading where the table of that topic goes.
"""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterator
from pathlib import Path

from rosorin_compile.source.rule_registry import Rule, find

HEAD = Path(__file__).parents[1] / "_rules_head.md"
MARK = "<!-- rules -->"
_COLUMNS = ("rule", "problem", "fix", "accepted for")


def page(head: str, rules: Collection[Rule]) -> str:
    """Return the page of rules: ``head`` with a table in place of each mark. Raises ValueError for a lost topic."""
    lines: list[str] = []
    shown: set[str] = set()
    topic = ""
    for line in head.splitlines():
        if line.startswith("#"):
            topic = line.lstrip("# ")
        if line == MARK:
            own = sorted((rule for rule in rules if rule.topic == topic), key=lambda rule: rule.id)
            shown |= {rule.id for rule in own}
            lines += _table(own)
        else:
            lines.append(line)
    lost = sorted({rule.topic for rule in rules if rule.id not in shown})
    if lost:
        raise ValueError(f"the page of rules has no heading with a mark for {', '.join(lost)}")
    return "\n".join(lines) + "\n"


def _table(rules: Collection[Rule]) -> Iterator[str]:
    """Yield the table of the rules of a topic, each with an anchor; the last column only where one can be accepted."""
    columns = _COLUMNS if any(rule.accept for rule in rules) else _COLUMNS[:-1]
    yield f"| {' | '.join(columns)} |"
    yield f"|{'---|' * len(columns)}"
    for rule in rules:
        name = f'<a id="{rule.id}"></a>`{rule.id}`'
        cells = (name, *(cell.replace("|", "\\|") for cell in (rule.what, rule.help, rule.accept)))
        yield "|" + "".join(f" {cell} |" if cell else " |" for cell in cells[: len(columns)])


def text() -> str:
    """Return the page as it is committed."""
    return page(HEAD.read_text("utf-8"), tuple(find().values()))


if __name__ == "__main__":
    sys.stdout.write(text())
