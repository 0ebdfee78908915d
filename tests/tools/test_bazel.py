"""The rule of bazel/ and its page: by a Starlark that is not Bazel's, and in a real Bazel.

The rule itself says which words and which files an action has: an interpreter of Starlark runs it with what Bazel
would give it (``data/bazel/stubs.star``).
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import starlark

from rosorin_compile.cli.main import main
from rosorin_compile.source.project import data_folder
from support.pages import MARK, blocks
from support.paths import DATA, DOCS

PAGE = DOCS / "builds.md"
RULE = data_folder("bazel") / "rosorin_robot.bzl"
GLOBALS = starlark.Globals.extended_by([starlark.LibraryExtension.StructType])
BAZEL = shutil.which("bazel")


def page_files(folder: Path) -> dict[str, str]:
    found = {}
    for block in blocks(PAGE.read_text("utf-8")):
        if block.mark[0] == "file":
            path = folder / block.mark[1]
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("".join(f"{line}\n" for line in block.lines), "utf-8")
            found[block.mark[1]] = path.read_text("utf-8")
    return found


def evaluated(text: str, **given: Any) -> Any:
    module = starlark.Module()
    for name, value in given.items():
        module.add_callable(name, value) if callable(value) else module.__setitem__(name, value)
    return starlark.eval(module, starlark.parse("rule.bzl", text, starlark.Dialect.extended()), GLOBALS)


def action(target: dict[str, Any]) -> dict[str, Any]:
    rule = RULE.read_text("utf-8")
    assert rule.startswith('"""')  # a text in the midst of a module is an expression, and Starlark takes it
    driver = "\nrosorin_robot.implementation(context(TARGET['name'], rosorin_robot.attrs, TARGET))\nACTIONS\n"
    made = evaluated((DATA / "bazel/stubs.star").read_text("utf-8") + rule + driver, TARGET=target)
    assert len(made) == 1
    return dict(made[0])


def targets(build: str, folder: Path) -> list[dict[str, Any]]:
    """Return the targets of a BUILD file, by its own Starlark: labels of files as paths."""
    found: list[dict[str, Any]] = []

    def rosorin_robot(**said: Any) -> None:
        found.append({**said, "tool": said["tool"].strip("/").replace(":", "/")})

    def glob(patterns: list[str], exclude: list[str] | None = None) -> list[str]:
        files = {path for pattern in patterns for path in folder.glob(f"{pattern}/*" if "**" in pattern else pattern)}
        return sorted({str(path.relative_to(folder)) for path in files if path.is_file()} - set(exclude or ()))

    text = re.sub(r"^load\(.*\)$", "", build, flags=re.MULTILINE)
    evaluated(text, rosorin_robot=rosorin_robot, glob=glob, filegroup=lambda **_: None)
    return found


@pytest.fixture
def lamp(tmp_path: Path) -> Path:
    folder = tmp_path / "sources"
    page_files(folder)
    return folder


def test_the_targets_of_the_page_are_actions(lamp: Path) -> None:
    whole, measured = map(action, targets((lamp / "BUILD.bazel").read_text("utf-8"), lamp))
    assert whole["inputs"] == ["descriptions/lamp/robot.yaml", "descriptions/lamp/shade.yaml"]
    assert whole["outputs"] == ["bazel-out/bin/lamp"]
    folder = ["-o", "bazel-out/bin/lamp_0007", "-q", "--only", "urdf", "-a", "prefix=left_"]
    assert measured["argv"] == [
        *("tools/rosorin-compile", "all", "descriptions/lamp/robot.yaml", *folder),
        *("--args", "calibration/0007.yaml"),
    ]
    assert measured["outputs"] == ["bazel-out/bin/lamp_0007/lamp.urdf"]
    assert measured["env"]["ROSORIN_COMPILE_CACHE"] == "off"


def test_the_folder_of_a_package_is_that_of_its_package_xml() -> None:
    target = {"name": "lamp", "description": "robot.yaml", "tool": "tools/rosorin-compile"}
    files = ["ros/arm/urdf/arm.urdf", "ros/arm/package.xml"]
    made = action({**target, "packages": {"arm": files}, "trust": True})
    assert made["argv"][-3:] == ["--package", "arm=ros/arm", "--trust"]
    assert made["inputs"] == ["robot.yaml", *files]
    with pytest.raises(starlark.StarlarkError, match=r"has no package\.xml"):
        action({**target, "packages": {"arm": files[:1]}})
    with pytest.raises(starlark.StarlarkError, match="has no description"):
        action({"name": "lamp", "tool": "tools/rosorin-compile"})


def test_the_command_says_where_the_rule_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bazel-dir"]) == 0
    folder = Path(capsys.readouterr().out.rstrip("\n"))
    assert (folder / "rosorin_robot.bzl").is_file()
    assert (folder / "BUILD.bazel").read_text("utf-8") == 'exports_files(["rosorin_robot.bzl"])\n'
    assert {name for kind, name in MARK.findall(PAGE.read_text("utf-8")) if kind == "file"} >= {"BUILD.bazel"}


def build(workspace: Path, *words: str) -> tuple[int, str]:
    """Build in a real Bazel, without a server that would stay; return its exit code and what it prints."""
    home = workspace.parent / "bazel"
    command = [str(BAZEL), f"--output_user_root={home}", "--batch", "build", "--color=no", "--curses=no", *words]
    done = subprocess.run(
        command, cwd=workspace, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )
    return done.returncode, done.stdout


def bazel_workspace(folder: Path) -> Path:
    page_files(folder)
    (folder / "WORKSPACE").touch()
    tools = folder / "tools"
    (tools / "rosorin_compile").mkdir(parents=True)
    for name in ("rosorin_robot.bzl", "BUILD.bazel"):
        shutil.copy(data_folder("bazel") / name, tools / "rosorin_compile" / name)
    shutil.copy(DATA / "bazel/program.bzl", tools / "program.bzl")
    shutil.copy(DATA / "bazel/tools.BUILD", tools / "BUILD.bazel")
    script = tools / "rosorin-compile.sh"
    script.write_text(f'#!/bin/sh\nexec {sys.executable} -m rosorin_compile "$@"\n', "utf-8")
    script.chmod(0o755)
    return folder


@pytest.mark.tier("outside")
@pytest.mark.slow
@pytest.mark.skipif(BAZEL is None, reason="no bazel (apt: bazel-bootstrap)")
def test_in_bazel(tmp_path: Path) -> None:
    command = re.search(r"^bazel build (.+)$", PAGE.read_text("utf-8"), re.MULTILINE)
    assert command
    first = bazel_workspace(tmp_path / "one" / "workspace")
    code, said = build(first, *command[1].split())
    assert code == 0, said
    made = first / "bazel-bin"
    assert sorted(path.name for path in (made / "lamp").iterdir()) == ["lamp.urdf", "lamp.xml"]
    assert b'xyz="0 0 0.3015"' in (made / "lamp_0007/lamp.urdf").read_bytes()
    assert "1 process: 1 internal" in build(first, *command[1].split())[1]  # nothing to do
    # Another machine: the same bytes, which is what a cache goes by.
    other = bazel_workspace(tmp_path / "two" / "somewhere_else")
    assert build(other, "//:lamp")[0] == 0
    for name in ("lamp.urdf", "lamp.xml"):
        assert (other / "bazel-bin/lamp" / name).read_bytes() == (made / "lamp" / name).read_bytes()
    # What is not declared is not there, though it stands in the workspace.
    text = (first / "BUILD.bazel").read_text("utf-8")
    (first / "BUILD.bazel").write_text(text.replace('    srcs = ["descriptions/lamp/shade.yaml"],\n', ""), "utf-8")
    code, said = build(first, "//:lamp_0007")
    assert code != 0
    assert "cannot read descriptions/lamp/shade.yaml" in said
