"""Descriptions with something wrong at one place, and what must hold for each.

``python -m support.fuzzing`` compiles descriptions in processes that may use a limited amount of time and memory.
"""

import json
import os
import random
import re
import resource
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import yaml

from rosorin_compile.cli.report_formats import FORMATS
from rosorin_compile.formats.compilation import CompileResult, compile_robot
from rosorin_compile.source.diagnostics import Diagnostic, has_errors
from support.paths import data_text

VALUES = yaml.compose(data_text("cases/values_anywhere.yaml"), yaml.BaseLoader).value
KEYS = "for if value part with use prefix mirror parent xyz help default args file links joints ${name} ${ ${legs} <<"
# Errors that no file has: an argument of the command line, and a description that cannot be read.
PLACELESS = {"unknown-argument", "file-unreadable"}
OF_PYTHON = ("Traceback", "object has no attribute", "<locals>", "NoneType", "not subscriptable", "expected str")


def with_a_mistake(text: str, chance: random.Random, step: int) -> Iterator[str]:
    """Yield a YAML text with another value, or another key, at each ``step``-th of its places."""
    root = yaml.compose(text, yaml.BaseLoader)
    for number, (parent, index) in enumerate(_places(root)):
        if number % step:
            continue
        item, value = parent.value[index], chance.choice(VALUES)
        if isinstance(parent, yaml.MappingNode):
            key = yaml.ScalarNode(yaml.BaseLoader.DEFAULT_SCALAR_TAG, chance.choice(KEYS.split()))
            value = (key, item[1]) if chance.random() < 0.2 else (item[0], value)
        parent.value[index] = value
        yield yaml.serialize(root, Dumper=yaml.BaseDumper)
        parent.value[index] = item


def _places(node: yaml.Node) -> Iterator[tuple[yaml.CollectionNode, int]]:
    for index, item in enumerate(node.value if isinstance(node, yaml.CollectionNode) else ()):
        yield node, index
        yield from _places(item[1] if isinstance(item, tuple) else item)


def held(path: Path) -> CompileResult:
    """Compile a description and check what holds for every description."""
    made = compile_robot(path, {})
    for diagnostic in made.diagnostics:
        check_diagnostic(diagnostic)
    for form in FORMATS.values():
        form(made.diagnostics).encode("utf-8")
    assert made.robot is not None or has_errors(made.diagnostics), "no robot and no error"
    assert not made.artifacts or not has_errors(made.diagnostics), "artifacts in spite of errors"
    for artifact in made.artifacts:
        artifact.text.encode("utf-8")
    return made


def check_diagnostic(diagnostic: Diagnostic) -> None:
    assert re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", diagnostic.rule), diagnostic
    assert diagnostic.message.strip(), diagnostic
    assert len(diagnostic.message) + len(diagnostic.help) < 20_000, f"{diagnostic.rule}: {diagnostic.message[:200]}..."
    assert not any(word in diagnostic.message for word in OF_PYTHON), diagnostic.message
    assert diagnostic.span is not None or diagnostic.rule in PLACELESS, diagnostic
    for span in (diagnostic.span, *(related.span for related in diagnostic.related)):
        if span is not None:
            forms = ("\n", "\r\n|[\n\r\x85\u2028\u2029]")  # a file that is not YAML has line feeds alone
            lines = ([*re.split(form, span.source.text), "", ""] for form in forms)
            assert any(span.line < len(one) and 1 <= span.column <= len(one[span.line - 1]) + 2 for one in lines)
            assert span.length >= 1, span[1:]


def main() -> None:
    """For each line "FOLDER SECONDS MEGABYTES": compile FOLDER/robot.yaml in a fork with these limits.

    The fork writes the rules of the diagnostics to ``told.json`` and an exception to ``stderr``, both in the folder.
    Its exit code is printed.
    """
    for line in sys.stdin:
        folder, seconds, megabytes = line.rstrip("\n").rsplit(" ", 2)
        process = os.fork()
        if process == 0:
            os.chdir(folder)
            os.dup2(os.open("stderr", os.O_WRONLY | os.O_CREAT), sys.stderr.fileno())
            resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds)))
            resource.setrlimit(resource.RLIMIT_AS, (int(megabytes) << 20, int(megabytes) << 20))
            signal.alarm(10 * int(seconds))
            made = held(Path("robot.yaml"))
            Path("told.json").write_text(json.dumps([diagnostic.rule for diagnostic in made.diagnostics]))
            os._exit(0)
        print(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), flush=True)


if __name__ == "__main__":
    main()
