"""``--depfile``: every file that was read, in the words of Make and Ninja, which then do no more than they have to."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rosorin_compile.cli.depfile import escaped
from rosorin_compile.cli.main import main
from rosorin_compile.output import OutputError
from support.commands import Shown, ask, edit, write_files
from support.paths import ROOT
from support.projects import foreign, meshes, packaged, rosorin_alone, stl, ur5e

PROGRAM = f"{sys.executable} -m rosorin_compile"
# Notes each file that is opened for reading, in every process of Python that is started.
HOOK = """\
import os, sys
_log = os.open(os.environ["OPENED"], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
def _note(event, given):
    if event == "open" and isinstance(given[0], (str, bytes)):
        if not (given[2] or 0) & (os.O_WRONLY | os.O_RDWR | os.O_DIRECTORY):
            os.write(_log, os.fsencode(os.path.realpath(given[0])) + b"\\n")
sys.addaudithook(_note)
"""


def names_in(depfile: Path) -> list[str]:
    """Return the names in a depfile without anything to escape; the target is the first."""
    target, _, rest = depfile.read_text("utf-8").partition(":")
    return [target, *rest.replace("\\\n", " ").split()]


def opened_by(folder: Path, *words: str) -> set[str]:
    hook = folder / "hook"
    hook.mkdir()
    (hook / "sitecustomize.py").write_text(HOOK)
    log = hook / "opened"
    environment = {"OPENED": str(log), "PYTHONPATH": str(hook), "PYTHONDONTWRITEBYTECODE": "1"}
    environment |= {"ROSORIN_COMPILE_CACHE": "off"}
    command = [sys.executable, "-m", "rosorin_compile", *words]
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    here = Path.cwd().resolve()
    opened = {Path(os.fsdecode(line)) for line in log.read_bytes().splitlines()}
    return {str(path.relative_to(here)) for path in opened if path.is_relative_to(here) and path.is_file()}


CASES = {
    "reference": (rosorin_alone, ["all"]),
    "reference-one": (rosorin_alone, ["print", "mjcf", "-o", "made.xml"]),
    "example": (ur5e, ["all", "--only", "urdf"]),
    "xacro-in-a-package": (packaged, ["all", "r", "-q"]),
    "foreign": (foreign, ["all"]),
    "meshes": (meshes, ["all", "--args", "cal.yaml", "--package", "p=p"]),
    "meshes-print": (meshes, ["print", "r", "mjcf", "--args", "cal.yaml", "--package", "p=p", "-o", "a.xml"]),
    "a-page": (meshes, ["print", "r", "page", "--package", "p=p", "-o", "a.html"]),
    "a-template": (meshes, ["print", "r", "note", "-o", "a.txt"]),
    "a-xacro-alone": (meshes, ["print", "descriptions/r/x/v.xacro", "urdf", "-o", "a.urdf"]),
}
# A package.xml says what a package is called: where a name leads decides, and not what else stands in the file.
OUTPUTS = "outputs: {urdf: {file: r.urdf}}\n"
NAMING = "package.xml"


@pytest.mark.parametrize("case", CASES)
def test_every_file_that_was_opened_stands_in_the_depfile(
    case: str, home: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    make, words = CASES[case]
    make()
    opened = opened_by(tmp_path_factory.mktemp("hook"), *words, "--depfile", "made.d")
    target, *inputs = names_in(home / "made.d")
    assert Path(target).is_file()
    listed = {os.path.relpath(os.path.realpath(name), home.resolve()) for name in inputs}
    assert len(opened) > 1 or "alone" in case
    written = {name for name in opened if name.startswith("outputs/")}
    assert {name for name in opened - written if Path(name).name != NAMING} - listed == set()
    assert all(Path(name).exists() for name in inputs)


@pytest.mark.parametrize("name", [" a  b", "$HOME", "a # b", "x\\ y", "x\\\\ y", "é", "c:\\d", "[1]"])
def test_a_name_is_escaped_as_ninja_and_make_take_it(name: str, home: Path) -> None:
    """Both read the name back: a file that is there is one that they can stat, and its absence is told by its name."""
    (home / name).write_text("")
    (home / "made.d").write_text(f"made: {escaped(name)}\n")
    (home / "build.ninja").write_text(
        "rule r\n  command = cp made.d made2.d; touch made\n  depfile = made2.d\nbuild made: r\n"
    )
    run("ninja")
    assert "no work to do" in run("ninja")
    touched(home / name)
    assert "no work to do" not in run("ninja")
    assert "no work to do" in run("ninja")
    (home / "Makefile").write_text("made:\n\ttouch made\ninclude made.d\n")
    assert "'made' is up to date" in run("make", "made")
    touched(home / name)
    assert "touch made" in run("make", "made")


@pytest.mark.parametrize("name", ["a b", "$HOME", "#1", "x\\ y", "a:b"])
def test_a_target_is_escaped_as_ninja_takes_it(name: str, home: Path) -> None:
    (home / "read").write_text("")
    (home / "made.d").write_text(f"{escaped(name)}: read\n")
    target = re.sub("[$: ]", r"$\g<0>", name)
    rule = "rule r\n  command = cp made.d made2.d; touch $out\n  depfile = made2.d\n  deps = gcc\n"
    (home / "build.ninja").write_text(f"{rule}build {target}: r\n")
    run("ninja")
    assert "no work to do" in run("ninja")
    touched(home / "read")
    assert "no work to do" not in run("ninja")
    assert "no work to do" in run("ninja")


def test_a_name_that_no_depfile_can_hold() -> None:
    with pytest.raises(OutputError, match="has a line break"):
        escaped("a\nb")


def run(*words: str, code: int = 0) -> str:
    program = shutil.which(words[0], path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    if program is None:
        pytest.skip(f"{words[0]} is not installed")
    done = subprocess.run([program, *words[1:]], capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout


def touched(path: Path) -> None:
    time.sleep(0.02)
    os.utime(path)
    time.sleep(0.02)


RULE = """\
rule print
  command = {program} print $robot urdf -o $out --depfile $out.d
  depfile = $out.d
  {deps}
build left.urdf: print
  robot = left.yaml
build sub/right.urdf: print
  robot = right.yaml
"""
SHARED = {
    "left.yaml": "robot: left\ninclude: [common.yaml, own.yaml]\n",
    "right.yaml": """\
robot: right
include: [common.yaml]
let: {r: '${load("r.yaml").r}'}
links: {x: {visual: [{sphere: {radius: "${r}"}}]}}
joints: {j: {type: fixed, parent: base, child: x}}
""",
    "common.yaml": "links: {base: {}}\n",
    "own.yaml": "links: {tip: {}}\njoints: {j: {type: fixed, parent: base, child: tip}}\n",
    "r.yaml": "r: 1\n",
}


@pytest.mark.slow
@pytest.mark.landing("builds", "deps = gcc")
@pytest.mark.parametrize("deps", ["", "deps = gcc"])
def test_ninja_runs_what_depends_on_a_file_and_then_nothing(home: Path, deps: str) -> None:
    write_files(home, {**SHARED, "build.ninja": RULE.format(program=PROGRAM, deps=deps)})
    assert "[2/2]" in run("ninja")
    assert "no work to do" in run("ninja")
    both, left, right = "[2/2]", "left.yaml", "right.yaml"
    for name, runs in (("common.yaml", both), ("own.yaml", left), ("r.yaml", right), (left, left), (right, right)):
        touched(home / name)
        said = run("ninja", "-v")
        assert runs in said
        assert runs == both or "[1/1]" in said
        assert "no work to do" in run("ninja")
    (home / "r.yaml").write_text("r: 2\n")
    run("ninja")
    assert '<sphere radius="2"/>' in (home / "sub" / "right.urdf").read_text()
    (home / "r.yaml").write_text("r: 1 kg\n")
    assert "error[wrong-unit]" in run("ninja", code=1)
    assert '<sphere radius="2"/>' in (home / "sub" / "right.urdf").read_text()
    (home / "r.yaml").write_text("r: 3\n")
    run("ninja")
    assert '<sphere radius="3"/>' in (home / "sub" / "right.urdf").read_text()


# What is written when, and what does not go together


def test_the_target_is_what_the_caller_calls_it(home: Path, capsys: Shown) -> None:
    outputs = "outputs: {urdf: {file: r.urdf}, frames: {file: frames.md}}\n"
    write_files(home, {"descriptions/r/robot.yaml": f"robot: r\nlinks: {{base: {{}}}}\n{outputs}"})

    def target(*words: str) -> str:
        ask(capsys, *words, "--depfile", "d/made.d")
        return names_in(home / "d" / "made.d")[0]

    assert target("all", "-q") == "outputs/r/frames.md"
    assert target("all", "-q", "-o", "./out/r") == "out/r/frames.md"
    assert target("all", "-q", "-o", str(home / "out/r")) == f"{home}/out/r/frames.md"
    assert target("all", "-q", "--only", "urdf") == "outputs/r/r.urdf"
    assert target("all", "-q", "--depfile-target", "mine") == "mine"
    assert target("print", "urdf", "-o", "./x/r.urdf") == "./x/r.urdf"
    assert target("print", "urdf", "-o", "x/r.urdf", "--depfile-target", "mine") == "mine"
    assert target("print", "urdf", "--depfile-target", "mine") == "mine"


def test_a_depfile_goes_over_nothing_that_it_tells_of(home: Path, capsys: Shown) -> None:
    (home / "r.yaml").write_text("robot: r\nlinks: {a: {}}\n")
    for words in (
        ["print", "r.yaml", "urdf", "-o", "r.urdf", "--depfile", "r.urdf"],
        ["print", "r.yaml", "urdf", "-o", "r.urdf", "--depfile", "./r.yaml"],
        ["all", "r.yaml", "--only", "urdf", "--depfile", "r.yaml"],
        ["all", "r.yaml", "--only", "urdf", "--depfile", "outputs/r/r.urdf"],
    ):
        main(words)
        assert "is an input or an artifact in the depfile" in capsys.readouterr().err
    assert (home / "r.yaml").read_text().startswith("robot: r")
    assert (home / "r.urdf").read_text().startswith("<?xml")


def test_an_error_leaves_no_depfile(rosorin: Path) -> None:
    (rosorin / "descriptions/rosorin/arm.yaml").write_text("links: {a: {}\n")
    for words in (["all", "--depfile", "made.d"], ["print", "urdf", "-o", "r.urdf", "--depfile", "made.d"]):
        assert main(words) == 1
        assert not (rosorin / "made.d").exists()


# --only


def test_only_some_outputs_are_written_and_the_others_stay(rosorin: Path, capsys: Shown) -> None:
    said = ask(capsys, "all", "--only", "urdf", "--only", "mjcf")
    assert said == "rosorin: 2 artifacts in outputs/rosorin, written: rosorin.urdf, rosorin.xml\n"
    folder = rosorin / "outputs" / "rosorin"
    for name in ("rosorin.urdf", "rosorin.xml"):
        assert (folder / name).read_bytes() == (ROOT / "outputs" / "rosorin" / name).read_bytes()
    ask(capsys, "all")
    (folder / "static_tf.json").write_text("{}")
    (folder / "frames.md").unlink()
    assert main(["all", "--only", "static_tf_json"]) == 0
    shown = capsys.readouterr()
    assert shown.out == "rosorin: 1 artifact in outputs/rosorin, written: static_tf.json\n"
    assert "not-an-artifact" not in shown.err
    assert not (folder / "frames.md").exists()
    assert "written: frames.md" in ask(capsys, "all")
    assert len(list(folder.iterdir())) == 10


def test_only_may_be_a_format_that_is_not_listed(rosorin: Path, capsys: Shown) -> None:
    said = ask(capsys, "all", "--only", "frames_picture", "-o", "out/rosorin")
    assert said == "rosorin: 1 artifact in out/rosorin, written: frames.svg\n"
    assert 'rosorin has no output "frame"' in ask(capsys, "all", "--only", "frame", code=2)
    assert [path.name for path in (rosorin / "out" / "rosorin").iterdir()] == ["frames.svg"]


def test_the_meshes_of_an_output_go_along_and_those_of_others_do_not(home: Path, capsys: Shown) -> None:
    (home / "m.stl").write_bytes(stl())
    outputs = "{urdf: {file: r.urdf}, a: {backend: mjcf, file: a/r.xml}, b: {backend: mjcf, file: b/r.xml}}"
    (home / "r.yaml").write_text(
        f"robot: r\nlinks: {{base: {{collision: [{{mesh: {{file: m.stl}}}}]}}}}\noutputs: {outputs}\n"
    )
    ask(capsys, "all", "r.yaml", "--only", "a", "-o", "out/r")
    ask(capsys, "all", "r.yaml", "--only", "urdf", "-o", "plain/r")
    ask(capsys, "all", "r.yaml", "-o", "whole/r")
    made = {path.relative_to(home / "out").as_posix() for path in (home / "out").rglob("*") if path.is_file()}
    whole = {path.relative_to(home / "whole").as_posix() for path in (home / "whole").rglob("*") if path.is_file()}
    assert made == {name for name in whole if name.startswith("r/a/")}
    assert [path.name for path in (home / "plain" / "r").iterdir()] == ["r.urdf"]
    for name in made:
        assert (home / "out" / name).read_bytes() == (home / "whole" / name).read_bytes()


def test_a_mesh_that_another_output_lacks_is_no_matter(home: Path, capsys: Shown) -> None:
    outputs = "{urdf: {file: r.urdf}, mjcf: {file: r.xml}}"
    (home / "r.yaml").write_text(
        f"robot: r\nlinks: {{base: {{collision: [{{mesh: {{file: none.stl}}}}]}}}}\noutputs: {outputs}\n"
    )
    assert "error[mesh-not-found]" in ask(capsys, "all", "r.yaml", code=1)
    assert "error[mesh-not-found]" in ask(capsys, "print", "r.yaml", "mjcf", code=1)
    assert 'filename="none.stl"' in ask(capsys, "print", "r.yaml", "urdf")


def test_what_was_read_is_told_with_the_artifacts_too(rosorin: Path, capsys: Shown) -> None:
    for _ in range(2):  # compiled, and found unchanged
        assert main(["all", "-v"]) == 0
        err = capsys.readouterr().err
        assert sum(line.startswith("read descriptions/rosorin/") for line in err.splitlines()) == 10
    assert main(["all", "-v", "-q"]) == 2
    assert "not allowed with argument" in capsys.readouterr().err
    assert rosorin


# What was looked for and not found


def test_a_folder_stands_for_a_file_that_was_not_found(home: Path) -> None:
    mesh = "visual: [{mesh: {file: meshes/a.stl}}]"
    write_files(home / "descriptions" / "r", {"robot.yaml": f"robot: r\nlinks: {{a: {{{mesh}}}}}\n{OUTPUTS}"})
    (home / "descriptions/r/meshes").mkdir()
    assert main(["all", "--depfile", "made.d"]) == 0
    assert names_in(home / "made.d")[1:] == ["descriptions/r/robot.yaml", "descriptions/r/meshes"]
    (home / "descriptions/r/meshes/a.stl").write_bytes(stl())
    assert main(["all", "--depfile", "made.d"]) == 0
    assert names_in(home / "made.d")[1:] == ["descriptions/r/robot.yaml", "descriptions/r/meshes/a.stl"]


# check --depfile: a build learns what was compiled, and what it was compared with.


PROJECT = {
    "descriptions/lamp/robot.yaml": "robot: lamp\ninclude: [more.yaml]\noutputs: {urdf: {file: lamp.urdf}}\n",
    "descriptions/lamp/more.yaml": "links: {base_link: {}}\n",
    "descriptions/other/robot.yaml": "robot: other\nlinks: {base_link: {}}\noutputs: {urdf: {file: o.urdf}}\n",
}
CHECK = ("check", "lamp", "--depfile", "lamp.d", "--depfile-target", "stamp")


def test_what_was_read_and_compared(project: Path) -> None:
    assert main(["all", "lamp"]) == 0
    assert main(list(CHECK)) == 0
    names = ["descriptions/lamp/robot.yaml", "descriptions/lamp/more.yaml", "outputs/lamp/lamp.urdf"]
    assert (project / "lamp.d").read_text() == " \\\n  ".join(["stamp:", *names]) + "\n"


def test_what_differs_is_not_done(project: Path) -> None:
    assert main(["all", "lamp"]) == 0
    edit(project / "descriptions/lamp/more.yaml", "base_link", "base")
    assert main(list(CHECK)) == 1
    assert not (project / "lamp.d").exists()
