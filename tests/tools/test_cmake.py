"""rosorin_compile_add_robot in a plain project: what a build does, and what it leaves alone.

Ninja and make, as far as they are here; docs/builds.md is the page.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from rosorin_compile import __version__
from rosorin_compile.cli.main import main
from rosorin_compile.source.project import data_folder
from support.cmake import GENERATORS, PROGRAM, Built, build, configure, plainly, project, ran
from support.commands import Shown, edit, touch

CMAKE = shutil.which("cmake")
pytestmark = pytest.mark.skipif(CMAKE is None or not GENERATORS, reason="cmake is not here")
# Where generators hardly differ: one at each landing, the others by .ci/full builds.
one_of_them = pytest.mark.parametrize(
    "generator", [*GENERATORS[:1], *(pytest.param(name, marks=pytest.mark.tier("builds")) for name in GENERATORS[1:])]
)
BOTH = "rosorin_compile_add_robot(DESCRIPTION arm OUTPUTS urdf mjcf)"


def made(source: Path, name: str = "arm", robot: str = "arm") -> Path:
    return source / "build" / "rosorin_compile" / name / robot


def tree(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def printed(source: Path, output: str, *words: str) -> str:
    call = [str(PROGRAM), "print", "descriptions/arm", output, *words]
    return subprocess.run(call, cwd=source, text=True, capture_output=True, check=True).stdout


def test_cmake_dir_is_where_the_package_is(capsys: Shown) -> None:
    assert main(["cmake-dir"]) == 0
    folder = Path(capsys.readouterr().out.removesuffix("\n"))
    assert (folder / "rosorin_compileConfig.cmake").is_file()
    version = (folder / "rosorin_compileConfigVersion.cmake").read_text("utf-8")
    assert f'set(PACKAGE_VERSION "{__version__}")' in version


@pytest.mark.parametrize(
    ("asked", "found"),
    [*[("", 1), ("0.4.0 EXACT", 1), ("0.3.9", 1), ("0.3...<0.5", 1)], *[("0.5", 0), ("0.4.1", 0), ("0.3...<0.4", 0)]],
)
def test_versions(tmp_path: Path, asked: str, found: int) -> None:
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.20)\nproject(asks NONE)\n"
        f'find_package(rosorin_compile {asked} QUIET)\nmessage(STATUS "found <${{rosorin_compile_FOUND}}>")\n'
    )
    assert f"found <{found}>" in configure(tmp_path)


@pytest.mark.tier("builds")
@pytest.mark.slow
@one_of_them
def test_a_build_runs_what_changed_and_nothing_else(tmp_path: Path, generator: str) -> None:
    source = project(tmp_path, BOTH)
    assert "rosorin-compile: arm: mjcf/arm.xml, urdf/arm.urdf" in configure(source, generator=generator)
    assert ran(build(source)) == ["arm"]
    assert made(source).joinpath("urdf/arm.urdf").read_text() == printed(source, "urdf")
    assert made(source).joinpath("mjcf/arm.xml").read_text() == printed(source, "mjcf")
    assert ran(build(source)) == []
    lower = source / "descriptions/arm/lower.yaml"
    touch(lower)
    assert ran(build(source)) == ["arm"]  # equal, and newer than what was touched
    assert ran(build(source)) == []
    edit(lower, "30 cm", "35 cm")
    assert ran(build(source)) == ["arm"]
    assert made(source).joinpath("urdf/arm.urdf").read_text() == printed(source, "urdf")
    assert ran(build(source)) == []


@pytest.mark.tier("builds")
@pytest.mark.slow
@one_of_them
def test_an_include_that_comes_and_goes(tmp_path: Path, generator: str) -> None:
    source = project(tmp_path, BOTH)
    tool, more = source / "descriptions/arm/tool.yaml", source / "descriptions/arm/more.yaml"
    configure(source, generator=generator)
    build(source)
    tool.write_text("include: [more.yaml]\n" + tool.read_text())
    more.write_text('links: {"${prefix}more": {}}\njoints: {more_joint: {type: fixed, parent: foot, child: more}}\n')
    assert ran(build(source)) == ["arm"]
    assert ran(build(source)) == []
    edit(more, "more_joint", "joint_of_more")  # which CMake never heard of
    assert ran(build(source)) == ["arm"]
    assert '"joint_of_more"' in made(source).joinpath("urdf/arm.urdf").read_text()
    more.unlink()
    with pytest.raises(Built, match=r"tool\.yaml:1:11: error\[file-unreadable\]"):
        build(source)
    edit(tool, "include: [more.yaml]\n", "")
    assert ran(build(source)) == ["arm"]
    assert ran(build(source)) == []


@pytest.mark.tier("builds")
@pytest.mark.slow
@one_of_them
def test_an_output_that_gets_another_name(tmp_path: Path, generator: str) -> None:
    source = project(tmp_path, "rosorin_compile_add_robot(DESCRIPTION arm OUTPUTS urdf INSTALL)")
    robot, outputs = source / "descriptions/arm/robot.yaml", source / "descriptions/arm/outputs.yaml"
    configure(source, f"-DCMAKE_INSTALL_PREFIX={source / 'there'}", generator=generator)
    build(source)
    edit(robot, "urdf/arm.urdf", "urdf/new.urdf")
    assert "rosorin-compile: arm: urdf/new.urdf" in build(source)  # CMake ran
    build(source, "--target", "install")
    assert list(tree(source / "there")) == ["share/plain/urdf/new.urdf"]
    # Where the outputs stand in an included file, CMake cannot know; the build does.
    edit(robot, "tool.yaml]\noutputs:", "tool.yaml, outputs.yaml]\nlet:")
    outputs.write_text("outputs: {urdf: {file: first.urdf}}\n")
    text = robot.read_text()
    robot.write_text(text[: text.index("let:")])
    build(source)
    assert ran(build(source)) == []
    edit(outputs, "first", "second")
    with pytest.raises(Built) as failed:
        build(source)
    assert "The outputs of the robot arm are others than when CMake ran. Build again" in plainly(str(failed.value))
    build(source)
    assert ran(build(source)) == []
    assert [name for name in tree(made(source)) if name.endswith(".urdf")] == ["second.urdf"]


@pytest.mark.tier("builds")
@pytest.mark.slow
@one_of_them
def test_golden_artifacts(tmp_path: Path, generator: str) -> None:
    source = project(tmp_path, "rosorin_compile_add_robot(DESCRIPTION descriptions/arm OUTPUTS urdf GOLDEN)")
    configure(source, generator=generator)
    assert ran(build(source)) == ["arm", "golden arm"]
    assert ran(build(source)) == []
    lower, committed = source / "descriptions/arm/lower.yaml", source / "outputs/arm/mjcf/arm.xml"
    touch(committed)
    assert ran(build(source)) == ["golden arm"]
    assert ran(build(source)) == []
    edit(lower, "30 cm", "35 cm")
    for _ in range(2):  # it stays wrong
        with pytest.raises(Built, match=r"tool moved 50\.0 mm in arm: origin z 0\.3 -> 0\.35 m: urdf, mjcf"):
            build(source)
    assert main(["all", str(lower.parent), "-o", str(source / "outputs/arm")]) == 0
    build(source)
    assert ran(build(source)) == []
    committed.unlink()
    with pytest.raises(Built, match=r"mjcf/arm\.xml: missing"):
        build(source)


ODD = """\
robot: odd
args: {text: {default: none}, other: {default: none}}
links: {base: {}}
outputs: {note: {file: note.txt, template: note.jinja, options: {said: ["${text}", "${other}"]}}}
"""


TEXTS = ["two words", "a;b", 'say "yes"', "it's", "$HOME", "100%", "#1", "-x", "", "a=b", "c:=d", "*", r"\n"]


@pytest.mark.tier("builds")
@pytest.mark.slow
@one_of_them
def test_arguments_arrive_to_the_letter(tmp_path: Path, generator: str) -> None:
    call = "rosorin_compile_add_robot(DESCRIPTION odd NAME odd{} ARGS [==[text:={}]==] other:=last)"
    source = project(tmp_path, "\n".join(call.format(*numbered) for numbered in enumerate(TEXTS)))
    folder = source / "descriptions/odd"
    folder.mkdir()
    (folder / "robot.yaml").write_text(ODD)
    (folder / "note.jinja").write_text("{{ output.options.options.said | join('|') }}")
    configure(source, generator=generator)
    assert len(ran(build(source, "-j2"))) == len(TEXTS)
    said = [text or "none" for text in TEXTS]  # as all has it: what is given empty is not given
    notes = [made(source, f"odd{number}", "odd") / "note.txt" for number in range(len(TEXTS))]
    assert [note.read_text() for note in notes] == [f"{text}|last" for text in said]
    assert ran(build(source)) == []


SIDES = """\
rosorin_compile_add_robot(DESCRIPTION arm OUTPUTS urdf)
foreach(side left right)
  rosorin_compile_add_robot(DESCRIPTION arm NAME ${side}_arm OUTPUTS urdf ARGS prefix:=${side}_
    DESTINATION share/${side})
  list(APPEND all ${ROSORIN_COMPILE_FILES})
endforeach()
message(STATUS "all <${all}>")
"""


@pytest.mark.tier("builds")
@pytest.mark.slow
@one_of_them
def test_one_description_with_several_arguments(tmp_path: Path, generator: str) -> None:
    source = project(tmp_path, SIDES)
    files = [made(source, f"{side}_arm") / "urdf/arm.urdf" for side in ("left", "right")]
    there = f"-DCMAKE_INSTALL_PREFIX={source / 'there'}"
    assert f"all <{';'.join(map(str, files))}>" in configure(source, there, generator=generator)
    assert ran(build(source, "--target", "plain_left_arm")) == ["left_arm"]
    assert ran(build(source, "-j8")) == ["arm", "right_arm"]
    assert [file.read_text() for file in files] == [printed(source, "urdf", f"prefix:={s}_") for s in ("left", "right")]
    build(source, "--target", "install")
    assert list(tree(source / "there")) == ["share/left/urdf/arm.urdf", "share/right/urdf/arm.urdf"]


@pytest.mark.slow
@one_of_them
def test_what_is_installed(tmp_path: Path, generator: str) -> None:
    source = project(tmp_path, "rosorin_compile_add_robot(DESCRIPTION arm OUTPUTS mjcf notes INSTALL)")
    configure(source, f"-DCMAKE_INSTALL_PREFIX={source / 'there'}", generator=generator)
    build(source)
    build(source, "--target", "install")
    golden = {f"share/plain/{name}": data for name, data in tree(source / "outputs/arm").items() if "urdf" not in name}
    assert len(golden) == 3  # with the mesh of the MJCF
    assert tree(source / "there") == golden
    shutil.rmtree(source / "there")
    build(source, "--target", "install")
    assert tree(source / "there") == golden


@pytest.mark.tier("builds")
@pytest.mark.slow
@one_of_them
def test_a_description_with_an_error(tmp_path: Path, generator: str) -> None:
    source = project(tmp_path, BOTH)
    robot, lower = source / "descriptions/arm/robot.yaml", source / "descriptions/arm/lower.yaml"
    edit(lower, "axis: [0, 1, 0]", "axis: [0, 0, 0]")
    with pytest.raises(Built) as failed:
        configure(source, generator=generator)
    assert "lower.yaml:16:11: error[axis-zero]: " in str(failed.value)
    edit(lower, "axis: [0, 0, 0]", "axis: [0, 1, 0]")
    configure(source, generator=generator)
    build(source)
    before = tree(made(source))
    for file, good, bad in ((lower, "axis: [0, 1, 0]", "axis: [0, 0, 0]"), (robot, "robot: arm", "robto: arm")):
        edit(file, good, bad)
        with pytest.raises(Built, match=rf"{file.name}:\d+:\d+: error\["):
            build(source)
        assert tree(made(source)) == before  # of the last time that it was right
        edit(file, bad, good)
        build(source)
        assert ran(build(source)) == []


@pytest.mark.slow
def test_the_program_beside_the_package_is_found(tmp_path: Path) -> None:
    """An installed wheel: its program is taken without a word, though it is not on PATH."""
    source = project(tmp_path, 'message(STATUS "<${ROSORIN_COMPILE_EXECUTABLE}>")')
    prefix = tmp_path / "env"
    package = prefix / "lib/python3.11/site-packages/rosorin_compile/cmake"
    shutil.copytree(data_folder("cmake"), package)
    (prefix / "bin").mkdir()
    shutil.copy(PROGRAM, prefix / "bin")
    said = configure(source, "-UROSORIN_COMPILE_EXECUTABLE", f"-Drosorin_compile_DIR={package}")
    assert Path(re.search(r"<(.*)>", said)[1]).samefile(prefix / "bin/rosorin-compile")


ARM = "DESCRIPTION arm"
WRONG = [
    ("OUTPUTS urdf", "say DESCRIPTION and a folder, a file, or a name in descriptions/"),
    ("DESCRIPTION", "DESCRIPTION lacks its value"),
    ("arm", 'there is no keyword "arm"; there are INSTALL QUIET TRUST DESCRIPTION NAME TARGET DESTINATION OUTPUTS'),
    (f"{ARM} OUTPUT arm.urdf", 'there is no keyword "OUTPUT"; OUTPUTS has names under outputs:'),
    (f"{ARM} ARGS prefix:=x DESTINATON share", 'there is no keyword "DESTINATON"; there are'),
    (f"{ARM} ARGS prefix=x", 'ARGS are NAME:=VALUE, not "prefix=x"'),
    (f"{ARM} ARGS_FILES none.yaml", "/none.yaml of arguments"),
    (f'{ARM} NAME "two words"', '"two words" cannot name a target; say NAME, of letters, digits, _ . + -'),
    (f"{ARM} TARGET taken", "there is a target plain_taken already; say another NAME or TARGET"),
    ("DESCRIPTION leg", "that is no file, no folder with robot.yaml, and no name in descriptions/, seen from /"),
]
WRONG_FOR_THE_PROGRAM = [
    (
        f"{ARM} OUTPUTS urdf sdf",
        'the robot has no output "sdf"; under outputs: of the description are mjcf, notes, urdf',
    ),
    (f"{ARM} ARGS prefx:=x", 'the description has no argument "prefx"'),
    (f"{ARM})\nrosorin_compile_add_robot({ARM}", "there is a robot arm here already; give this one another NAME"),
    (f"{ARM} INSTALL)\nrosorin_compile_add_robot({ARM} NAME b INSTALL", "mjcf/arm.xml is installed by another robot"),
]


@pytest.mark.parametrize(("words", "message"), WRONG)
def test_a_call_that_is_wrong(tmp_path: Path, words: str, message: str) -> None:
    source = project(tmp_path, f"add_custom_target(plain_taken)\nrosorin_compile_add_robot({words})")
    with pytest.raises(Built) as failed:
        configure(source)
    assert message in plainly(str(failed.value))


@pytest.mark.slow
@pytest.mark.parametrize(("words", "message"), WRONG_FOR_THE_PROGRAM)
def test_a_call_that_the_program_knows_is_wrong(tmp_path: Path, words: str, message: str) -> None:
    source = project(tmp_path, f"rosorin_compile_add_robot({words})")
    with pytest.raises(Built) as failed:
        configure(source)
    assert message in plainly(str(failed.value))


@pytest.mark.slow
@pytest.mark.parametrize(("place", "warns"), [("urdf", True), ("share/plain/urdf", False), ("/opt/there", False)])
def test_a_destination_as_xacro_add_files_has_it(tmp_path: Path, place: str, warns: bool) -> None:
    calls = f"function(ament_package)\nendfunction()\nrosorin_compile_add_robot(DESCRIPTION arm DESTINATION {place})"
    said = plainly(configure(project(tmp_path, calls)))
    assert ("Write share/plain/urdf" in said) == warns


@pytest.mark.parametrize("program", ["", "/nowhere/rosorin-compile"])
def test_a_program_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, program: str) -> None:
    source = project(tmp_path, BOTH)
    tools = tmp_path / "bin"  # a PATH without the program
    tools.mkdir()
    for name in ("cmake", "ninja", "make"):
        if shutil.which(name):
            (tools / name).symlink_to(str(shutil.which(name)))
    monkeypatch.setenv("PATH", f"{tools}")
    # Away from its own place: beside that the program may stand.
    package = shutil.copytree(data_folder("cmake"), tmp_path / "cmake")
    with pytest.raises(Built) as failed:
        configure(source, f"-Drosorin_compile_DIR={package}", program=program)
    assert "There is no program rosorin-compile" in str(failed.value)
    assert "pip install path/to/rosorin-compile" in str(failed.value)
