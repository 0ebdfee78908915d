"""Mistakes on the command line: ``data/usage.yaml`` has the calls, and what each prints. Nothing is written."""

import shlex
from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile.cli.main import main
from support.commands import write_files
from support.paths import data_text
from support.robots import copy_of_rosorin

GROUPS = yaml.safe_load(data_text("usage.yaml"))


def files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if "cache" not in path.parts)


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group["about"])
def test_a_mistake_is_explained_and_nothing_is_written(
    group: dict[str, Any], home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if group.get("rosorin"):
        copy_of_rosorin(home)
    write_files(home, group.get("files", {}))
    write_files(home, {name: data_text(source) for name, source in group.get("data", {}).items()})
    before = files(home)
    for words, message, *code in group["calls"]:
        assert [main(shlex.split(words))] == (code or [2]), words
        shown = capsys.readouterr()
        assert (shown.out, message in shown.err) == ("", True), (words, shown.err)
        assert "Traceback" not in shown.err
        assert files(home) == before, words
