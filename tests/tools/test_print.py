"""``print``: one artifact on standard output, the same bytes as ``all`` writes, and nothing else anywhere."""

import hashlib
import json
import os
import shutil
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats import FORMATS
from support.commands import Shown, ask
from support.paths import OUTPUTS, ROOT, ROSORIN, ROUND_TRIP, XACRO
from support.projects import foreign, meshes, packaged, ur5e

PROGRAM = [sys.executable, "-m", "rosorin_compile"]
LISTED = {
    "controllers": ("controllers", "controllers.yaml"),
    "frames": ("frames", "frames.md"),
    "frames_amcl": ("frames_picture", "frames_amcl.svg"),
    "frames_slam": ("frames_picture", "frames_slam.svg"),
    "mjcf": ("mjcf", "rosorin.xml"),
    "nav2": ("nav2", "nav2.yaml"),
    "robot_localization": ("robot_localization", "ekf_frames.yaml"),
    "robot_model": ("robot_model", "robot_model.json"),
    "scene": ("scene", "scene.xml"),
    "sdf": ("sdf", "rosorin.sdf"),
    "srdf": ("srdf", "rosorin.srdf"),
    "static_tf": ("static_tf", "static_tf.launch.py"),
    "static_tf_json": ("static_tf_json", "static_tf.json"),
    "urdf": ("urdf", "rosorin.urdf"),
    "urdf_control": ("urdf", "rosorin_control.urdf"),
    "urdf_sim": ("urdf", "rosorin_sim.urdf"),
}
PLAIN = """\
robot: plain
links: {base_link: {}, laser: {}, wheel: {}}
joints:
  laser_joint: {type: fixed, parent: base_link, child: laser, publisher: {static_transform_publisher: laser_tf}}
  wheel_joint: {type: fixed, parent: base_link, child: wheel, publisher: robot_state_publisher}
"""


def run(*words: str, cwd: Path = ROOT, **environment: str) -> subprocess.CompletedProcess[bytes]:
    variables = {**os.environ, "ROSORIN_COMPILE_CACHE": "off", **environment}
    return subprocess.run([*PROGRAM, *words], capture_output=True, cwd=cwd, env=variables, check=False)


def printed(*words: str, cwd: Path = ROOT, **environment: str) -> bytes:
    done = run("print", *words, cwd=cwd, **environment)
    assert (done.returncode, done.stderr) == (0, b"")
    return done.stdout


@pytest.mark.parametrize("name", ["controllers", "frames_slam", "urdf_sim"])
def test_each_output_of_the_reference_robot_is_the_committed_file(name: str, home: Path, capfdbinary: Shown) -> None:
    assert main(["print", str(ROSORIN), name]) == 0
    shown = capfdbinary.readouterr()
    assert shown == ((OUTPUTS / LISTED[name][1]).read_bytes(), b"")
    assert [path for path in home.rglob("*") if path.is_file() and "cache" not in path.parts] == []


def test_what_is_wrong_with_another_output_keeps_nobody_from_this_one(home: Path, capsys: Shown) -> None:
    (home / "robot.yaml").write_text(
        PLAIN + "outputs:\n  urdf: {file: a.urdf}\n  static_tf: {file: a.launch.py}\n"
        "  robot_model: {file: a.json, servos: nobody}\n"
    )
    assert main(["all", "robot.yaml"]) == 1
    assert "error[unknown-servo]" in capsys.readouterr().err
    assert main(["print", "robot.yaml", "robot_model"]) == 1
    assert "error[unknown-servo]" in capsys.readouterr().err
    assert main(["print", "robot.yaml", "urdf"]) == 0
    assert "unknown-servo" not in capsys.readouterr().err
    assert main(["all", "robot.yaml", "--only", "urdf"]) == 0
    assert not (home / "outputs/robot/a.json").exists()


def test_the_list_names_outputs_formats_and_files(capsys: Shown) -> None:
    rows = [{"name": name, "format": format, "file": file} for name, (format, file) in LISTED.items()]
    assert json.loads(ask(capsys, "print", "--list", str(ROSORIN), "--format", "json"))["result"] == rows
    lines = ask(capsys, "print", "--list", str(ROSORIN)).splitlines()
    assert [line.split() for line in lines[1:]] == [list(row.values()) for row in rows]


def test_neither_locale_nor_folder_nor_buffering_changes_a_byte(tmp_path: Path) -> None:
    (tmp_path / "größe.yaml").write_text('robot: "größe"\nlinks: {"bäse": {}}\n', "utf-8")
    plain = printed(str(tmp_path / "größe.yaml"), "urdf")
    assert plain.decode("utf-8").count("größe") == 2
    assert plain.endswith(b"</robot>\n")
    ascii_only = {
        "LC_ALL": "C",
        "LANG": "C",
        "PYTHONIOENCODING": "ascii",
        "PYTHONUTF8": "0",
        "PYTHONCOERCECLOCALE": "0",
    }
    for environment in (ascii_only, {"PYTHONUNBUFFERED": "1"}, {"FORCE_COLOR": "1"}):
        assert printed("größe.yaml", "urdf", cwd=tmp_path, **environment) == plain


def test_a_read_only_install_space_is_enough(tmp_path: Path) -> None:
    share = tmp_path / "share" / "arm_description" / "descriptions" / "rosorin"
    shutil.copytree(ROSORIN.parent, share)
    folders = [share, *share.parents[:3]]
    for path in [*share.iterdir(), *folders]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    (tmp_path / "elsewhere").mkdir()
    try:
        made = printed(str(share / "robot.yaml"), "urdf", cwd=tmp_path / "elsewhere")
    finally:
        for path in folders:
            path.chmod(0o755)
    assert made == (OUTPUTS / "rosorin.urdf").read_bytes()
    assert sorted(path.name for path in share.iterdir()) == sorted(path.name for path in ROSORIN.parent.iterdir())
    assert list((tmp_path / "elsewhere").iterdir()) == []


@pytest.mark.parametrize("name", ["urdf", "static_tf", "robot_model", "frames_picture"])
def test_a_format_that_is_not_listed_has_its_defaults(name: str, home: Path, capsys: Shown) -> None:
    (home / "alone.yaml").write_text(PLAIN)
    alone = ask(capsys, "print", "alone.yaml", name)
    files = {"urdf": "plain.urdf", "static_tf": "a.launch.py"} | {name: FORMATS[name].file.format("plain")}
    every = ", ".join(f"{one}: {{file: {file}}}" for one, file in files.items())
    (home / "listed.yaml").write_text(f"{PLAIN}outputs: {{{every}}}\n")
    listed = ask(capsys, "print", "listed.yaml", name)
    if name == "static_tf":  # which starts what reads the URDF, where there is one
        assert "robot_state_publisher" in listed
        assert "robot_state_publisher" not in alone
    else:
        assert alone == listed
    assert name == "urdf" or "laser" in alone  # a static transform publisher has that


def test_a_name_goes_before_a_format(home: Path, capsys: Shown) -> None:
    text = PLAIN.replace("publisher: {static_transform_publisher: laser_tf}", "")
    outputs = "  main: {backend: urdf, file: plain.urdf, version: 1.2}\n  mjcf: {backend: urdf, file: other.urdf}\n"
    (home / "r.yaml").write_text(f"{text}outputs:\n{outputs}")
    assert '<robot name="plain" version="1.2">' in ask(capsys, "print", "r.yaml", "main")
    assert '<robot name="plain">' in ask(capsys, "print", "r.yaml", "urdf")
    assert '<robot name="plain">' in ask(capsys, "print", "r.yaml", "mjcf")


def test_an_unknown_output_is_met_with_what_there_is(capsys: Shown) -> None:
    said = ask(capsys, "print", str(ROSORIN), "udrf", code=2)
    assert 'error[unknown-output]: rosorin has no output "udrf", and there is no format of that name' in said
    assert 'did you mean "urdf"? (its outputs: urdf_control, ' in said
    assert "; with their defaults: " in said
    assert "frames_picture, page, template)" in said


def test_a_format_that_needs_options_says_which(capsys: Shown) -> None:
    said = ask(capsys, "print", str(ROSORIN), "template", code=1)
    assert 'error[template-not-named]: output "template" names no template' in said
    assert "add template: FILE, a Jinja template" in said
    assert "taken with the defaults of its format; an entry under outputs can say more" in said


def test_an_error_leaves_standard_output_empty(tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text(
        PLAIN.replace("parent: base_link, child: laser", "parent: bas_link, child: laser")
    )
    for words in (["bad.yaml", "urdf"], ["bad.yaml", "mjcf", "-v"], ["bad.yaml", "urdf", "-o", "made.urdf"]):
        done = run("print", *words, cwd=tmp_path)
        assert (done.returncode, done.stdout) == (1, b"")
        assert b'did you mean "base_link"?' in done.stderr
        assert done.stderr.endswith(b"bad: 1 error, nothing printed\n")
    assert not (tmp_path / "made.urdf").exists()


def test_an_argument_and_what_is_wrong_with_one(capsys: Shown) -> None:
    fixed, free = (ask(capsys, "print", str(ROSORIN), "mjcf", f"base:={way}") for way in ("fixed", "free"))
    assert free.encode() == (OUTPUTS / "rosorin.xml").read_bytes()
    assert "<freejoint" in free
    assert "<freejoint" not in fixed
    assert ask(capsys, "print", str(ROSORIN), "mjcf", "-a", "base=fixed") == fixed
    assert 'did you mean "base"?' in ask(capsys, "print", str(ROSORIN), "mjcf", "bas:=free", code=1)


def test_what_cannot_be_printed_in_full_is_a_problem(tmp_path: Path) -> None:
    said = b"rosorin-compile: cannot write to standard output: "
    command = f"exec {' '.join(PROGRAM)} print rosorin urdf"
    for script, why in (
        (f"ulimit -f 4; {command} > {tmp_path / 'cut.urdf'}", b"File too large\n"),
        (f"{command} >&-", b"it is closed\n"),
    ):
        done = subprocess.run(["bash", "-c", script], capture_output=True, cwd=ROOT, check=False)
        assert (done.returncode, done.stderr) == (1, said + why)


@pytest.mark.parametrize("make", [ur5e, packaged, foreign, meshes])
def test_each_output_is_what_all_writes(make: Callable[[], None], home: Path, capfdbinary: Shown) -> None:
    """Also where meshes are found, converted, or missing, and before any of them is copied."""
    make()
    more = ["--package", "p=p", "-a", "x=2"] if make is meshes else []
    listed = json.loads(print_bytes(capfdbinary, "--list", "--format", "json", *more))["result"]
    alone = {entry["file"]: print_bytes(capfdbinary, entry["name"], *more) for entry in listed}
    assert main(["all", "r", "-q", *more]) == 0
    capfdbinary.readouterr()
    folder = home / "outputs" / "r"
    assert alone == {file: (folder / file).read_bytes() for file in alone}
    assert alone == {entry["file"]: print_bytes(capfdbinary, entry["name"], *more) for entry in listed}


def print_bytes(capfdbinary: Shown, *words: str) -> bytes:
    assert main(["print", "r", *words]) == 0
    out, err = capfdbinary.readouterr()
    assert err == b""
    return bytes(out)


# -o FILE


def test_a_file_is_written_at_once_and_an_equal_one_gets_newer(home: Path, capsys: Shown) -> None:
    assert ask(capsys, "print", str(ROSORIN), "urdf", "-o", "new/folder/r.urdf") == ""
    made = home / "new" / "folder" / "r.urdf"
    assert made.read_bytes() == (OUTPUTS / "rosorin.urdf").read_bytes()
    os.utime(made, (1, 1))
    before = made.stat().st_ino
    ask(capsys, "print", str(ROSORIN), "urdf", "-o", str(made))
    assert made.stat().st_ino == before
    assert made.stat().st_mtime > 1_000_000_000
    made.write_text(made.read_text().replace("0.1", "0.2", 1))
    made.chmod(0o640)
    ask(capsys, "print", str(ROSORIN), "urdf", "-o", str(made))
    assert stat.S_IMODE(made.stat().st_mode) == 0o640
    assert [path.name for path in made.parent.iterdir()] == ["r.urdf"]


def test_a_link_stays_and_a_pipe_is_written_into(home: Path, capsys: Shown) -> None:
    (home / "link.urdf").symlink_to("real.urdf")
    ask(capsys, "print", str(ROSORIN), "urdf", "-o", "link.urdf")
    assert (home / "link.urdf").is_symlink()
    assert (home / "real.urdf").read_bytes() == (OUTPUTS / "rosorin.urdf").read_bytes()
    os.mkfifo(home / "pipe")
    with subprocess.Popen(["cat", "pipe"], stdout=subprocess.PIPE) as cat:
        ask(capsys, "print", str(ROSORIN), "urdf", "-o", "pipe")
        assert cat.communicate()[0] == (OUTPUTS / "rosorin.urdf").read_bytes()
    assert stat.S_ISFIFO((home / "pipe").stat().st_mode)


def test_a_place_that_no_file_can_have(home: Path, capsys: Shown) -> None:
    (home / "folder").mkdir()
    (home / "file").write_text("")
    (home / "arm.yaml").write_text(PLAIN)
    digest = hashlib.sha256((home / "arm.yaml").read_bytes()).digest()
    assert "error[output-folder]: folder is a folder" in ask(
        capsys, "print", "arm.yaml", "urdf", "-o", "folder", code=1
    )
    said = ask(capsys, "print", "arm.yaml", "urdf", "-o", "file/x.urdf", code=1)
    assert "error[output-folder]: cannot write file/x.urdf: file" in said
    said = ask(capsys, "print", "arm.yaml", "urdf", "-o", "./arm.yaml", code=1)
    assert "error[output-is-input]: arm.yaml is one of the files that it would be made of" in said
    assert hashlib.sha256((home / "arm.yaml").read_bytes()).digest() == digest


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_not_be_written(home: Path, capsys: Shown) -> None:
    (home / "kept").mkdir(mode=0o555)
    said = ask(capsys, "print", str(ROSORIN), "urdf", "-o", "kept/x.urdf", code=1)
    assert "error[output-read-only]: cannot write kept/x.urdf" in said


# Which robot


def test_which_robot_is_meant(home: Path, capsys: Shown) -> None:
    for name in ("left", "right"):
        (home / "descriptions" / name).mkdir(parents=True)
        (home / "descriptions" / name / "robot.yaml").write_text(PLAIN.replace("robot: plain", f"robot: {name}"))
    said = ask(capsys, "print", "urdf", code=2)
    assert "there are several robots here: left, right; name one: rosorin-compile print ROBOT urdf" in said
    assert "left is a robot: write rosorin-compile print left OUTPUT" in ask(capsys, "print", "left", code=2)
    for word in ("left", "descriptions/left", "descriptions/left/robot.yaml"):
        assert '<robot name="left">' in ask(capsys, "print", word, "urdf")
    assert "print what?" in ask(capsys, "print", code=2)
    said = ask(capsys, "print", "urdf", "left", code=2)
    assert "the robot comes first: rosorin-compile print left urdf" in said
    assert "a name is empty" in ask(capsys, "print", "", "urdf", code=2)
    assert "print takes one ROBOT and one OUTPUT" in ask(capsys, "print", "left", "urdf", "right", code=2)
    shutil.rmtree("descriptions/right")
    assert '<robot name="left">' in ask(capsys, "print", "urdf")
    assert "left lists no outputs; print takes the name of a format: urdf, " in ask(capsys, "print", "--list")


@pytest.mark.usefixtures("rosorin")
def test_without_an_output_those_of_the_robot_are_named(capsys: Shown) -> None:
    said = ask(capsys, "print", code=2)
    assert "rosorin-compile print [ROBOT] OUTPUT; the outputs of rosorin: frames, frames_amcl, " in said


# Robots in other formats


def test_a_urdf_in_the_place_of_a_description(capsys: Shown) -> None:
    source = ROUND_TRIP / "limits.urdf"
    made = ElementTree.fromstring(ask(capsys, "print", str(source), "urdf"))
    meant = ElementTree.parse(source).getroot()
    assert {one.get("name") for one in made.iter("joint")} == {one.get("name") for one in meant.iter("joint")}
    assert ask(capsys, "print", str(source), "frames").startswith("# Frames of limits\n")
    assert [
        entry["name"] for entry in json.loads(ask(capsys, "print", "--list", str(source), "--format", "json"))["result"]
    ][-1] == "urdf"


def test_what_import_refuses_is_not_left_out_in_silence(home: Path, capsys: Shown) -> None:
    (home / "a.urdf").write_text('<robot name="a"><link name="l"><inertial><mass value="1"/></inertial></link></robot>')
    said = ask(capsys, "print", "a.urdf", "urdf", code=1)
    assert 'a.urdf:1:33: error[missing-element]: <inertial> of <link name="l"> lacks <inertia>' in said
    assert "--lenient leaves the inertial out" in said
    assert ElementTree.fromstring(ask(capsys, "print", "a.urdf", "urdf", "--lenient")).find("link/inertial") is None


def test_a_xacro_with_its_arguments_prints_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "a.urdf.xacro").write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="a"><xacro:arg name="prefix" default="x_"/>'
        '<link name="$(arg prefix)base"/></robot>'
    )
    assert b'<link name="left_base"/>' in printed("a.urdf.xacro", "urdf", "prefix:=left_", cwd=tmp_path)
    assert b'<link name="x_base"/>' in printed("a.urdf.xacro", "urdf", cwd=tmp_path)
    told = run("print", "a.urdf.xacro", "urdf", "-v", cwd=tmp_path).stderr
    assert b"warning[xacro-runs-code]" in told
    assert b"read a.urdf.xacro\n" in told


def test_a_description_that_includes_a_xacro_prints_nothing_else(tmp_path: Path) -> None:
    shutil.copy(next(XACRO.glob("05-*")) / "robot.xacro", tmp_path / "v.xacro")
    (tmp_path / "r.yaml").write_text("robot: r\ninclude: [v.xacro]\n")
    assert printed("r.yaml", "urdf", cwd=tmp_path).startswith(b"<?xml")
