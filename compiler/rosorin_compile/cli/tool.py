"""rosorin-compile rule, schema, completion, help, cmake-dir and bazel-dir: print information about the tool."""

import json
import re
import textwrap
from collections.abc import Sequence

import click
from click.shell_completion import get_completion_class

from rosorin_compile import api
from rosorin_compile.formats import schema_names, schema_text
from rosorin_compile.language.suppressions import STAYS
from rosorin_compile.source.diagnostics import RequestError, has_errors
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.rule_registry import PLUGINS, Rule

from .command import argument, command, flag, words_argument
from .console import FINE, PROBLEMS, give, table
from .run import Run

_LINK = re.compile(r"\[([^\]]*)\]\(([^)\s]+)\)")
_WIDTH = 100
_IMPORTED = {"always": "import writes that entry by itself.", "lenient": "import --lenient writes that entry.", "": ""}


@command("rule", exits="0 printed, 1 a plug-in is broken")
@words_argument("[ID ...]", "id of a message, such as axis-zero; default: list all rules", offers=("rule",))
def run_rule(run: Run) -> int:
    """Print the reference entries of rules."""
    found = api.explain_rules(run.words)
    entries = ["\n".join(entry(rule)) for rule in found.rules]
    run.give(found.rules, lambda: "\n\n".join(entries) if run.words else _list(found.rules))
    run.console.show(found.diagnostics)
    return PROBLEMS if has_errors(found.diagnostics) else FINE


def entry(rule: Rule) -> list[str]:
    """Return the entry of a rule in docs/rules.md as lines for a terminal."""
    paragraphs = [rule.what, f"What to do: {rule.help}" if rule.help else ""]
    if rule.accept:
        of = "" if rule.accept == "robot" else ", of: [NAME]"
        paragraphs.append(f"A {rule.accept} may break it: accept: [{{rule: {rule.id}{of}, reason: WHY}}]")
        paragraphs.append(_IMPORTED[rule.imported])
    elif rule.mild and rule.id not in STAYS:
        paragraphs.append(f"To end it: accept: [{{rule: {rule.id}, reason: WHY}}]")
    lines = [rule.id]
    for paragraph in paragraphs:  # links are relative to the folder of the project
        text = _LINK.sub(lambda link: f"{link[1]} ({'' if '://' in link[2] else 'docs/'}{link[2]})", paragraph)
        lines += textwrap.wrap(text, _WIDTH, initial_indent="  ", subsequent_indent="  ", break_on_hyphens=False)
    return lines


def _list(rules: Sequence[Rule]) -> str:
    topics: dict[str, list[Rule]] = {}
    for rule in rules:
        topics.setdefault(rule.topic or PLUGINS, []).append(rule)
    width = max(len(rule.id) for rule in rules)
    lines: list[str] = []
    for topic in sorted(topics):
        lines += ["", f"{topic}:"]
        for rule in topics[topic]:
            what = textwrap.shorten(_LINK.sub(r"\1", rule.what), _WIDTH, placeholder=" ...")
            lines.append(f"  {rule.id:<{width}}  {what}")
    return "\n".join(lines[1:])


@command("schema", exits="0 printed", sections=lambda: {"Schemas": [*schema_names().items()]})
@argument(
    "name", default="authoring", metavar="[NAME]", help="a schema, see below; default: authoring", offers=("schema",)
)
@flag("--list", help="list the schemas")
@flag("--macros", help="add the macros of the xacro files that robots of this project include, and their parameters")
def run_schema(run: Run) -> int:
    """Print a schema, or list all schemas."""
    if run.list:
        names = schema_names()
        rows = [{"name": name, "what": what} for name, what in names.items()]
        return run.give(rows, lambda: "\n".join(table(list(names.items()))))
    if run.format != "text":
        raise RequestError("--format goes with --list: a schema is printed as it is")
    found = api.schema(run.name, run.macros)
    give(json.dumps(found, indent=1, ensure_ascii=False) + "\n" if run.macros else schema_text(run.name))
    return FINE


@command("completion", exits="0 printed, 1 the shell is too old")
@argument("shell", type=click.Choice(("bash", "zsh", "fish")), metavar="SHELL", help="bash, zsh or fish")
def run_completion(run: Run) -> int:
    """Print the completion script of a shell, for commands, options, robots and frames."""
    from .main import COMPLETE, PROGRAM, program

    shell = get_completion_class(run.shell)
    assert shell is not None  # noqa: S101 - click supports all shells that the argument allows
    try:
        script = shell(program(), {}, PROGRAM, COMPLETE).source()
    except RuntimeError as problem:
        return run.console.fail(str(problem), PROBLEMS)
    return run.give({"shell": run.shell, "script": script}, lambda: script)


@command("help", exits="0 shown")
@argument("names", nargs=-1, metavar="[COMMAND ...]", help="a command; default: all commands", offers=("commands",))
def run_help(run: Run) -> int:
    """Print the help of a command, or the list of commands."""
    from .main import PROGRAM, program

    with program().make_context(PROGRAM, [*run.names, "--help"]) as context:  # --help prints and exits
        return int(context.command.invoke(context))


def _print_folder(run: Run) -> int:
    folder = str(data_folder(run.called.removesuffix("-dir")))
    return run.give(folder, lambda: folder)


_CMAKE = "Pass it to find_package(rosorin_compile) as rosorin_compile_DIR."
run_cmake_dir = command("cmake-dir", exits="0 printed", epilog=_CMAKE)(_print_folder)
_BAZEL = "rosorin_robot.bzl defines the rule; see docs/builds.md."
run_bazel_dir = command("bazel-dir", exits="0 printed", epilog=_BAZEL)(_print_folder)
