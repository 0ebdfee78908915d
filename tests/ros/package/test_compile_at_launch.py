"""A package that compiles its description at launch: its launch files are run, and call the real program."""

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from support.launch import Command, Context, Failed, LaunchConfiguration, Started, command_line, parsed, performed, read
from support.packages import FORMS, clean, names_in
from support.paths import DATA, DOCS

ARM = (DATA / "robots/launched_arm.yaml").read_text("utf-8")
FILES = {
    "descriptions/arm/robot.yaml": ARM,
    "descriptions/arm/parts/mast.yaml": "links: {'${prefix}mast': {}, '${prefix}eye': {}, '${prefix}ear': {}}\n",
    "descriptions/arm/note.txt.jinja": "{{ robot.name }}\n",
    "descriptions/arm/numbers.yaml": "offset: 5 mm\n",
    "calibration/eye.yaml": "let: {offset: '${load(\"numbers.yaml\").offset}'}\n",
}
NAME = "arm_description"


def project_of(folder: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = folder / "a project" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
    return folder / "a project"


def packaged(folder: Path, *words: str, files: dict[str, str] = FILES) -> Path:
    project = project_of(folder, files)
    target = folder / "an install" / NAME
    first = next(name for name in files if name.endswith("robot.yaml"))
    command = ["package", str(project / first), "-o", str(target), "--name", NAME, "--compile-at-launch"]
    assert main([*command, *words]) == 0
    return target


def launched(package: Path, form: str, **given: str) -> list[Started]:
    return read(package / f"launch/description.launch.{form}", {package.name: package}, **given).nodes


def compiled(project: Path, **arguments: str) -> tuple[str, dict[str, list[str]]]:
    """Return the URDF of a description as it stands in the project, and its static transforms by node."""
    made = compile_robot(project / "descriptions/arm/robot.yaml", arguments, requested=("full", "static_tf_json"))
    texts = {artifact.output: artifact.text for artifact in made.artifacts}
    return texts["full"], {
        n["name"]: n["arguments"] for n in json.loads(texts["static_tf_json"])["static_transform_publisher"]
    }


def test_what_a_package_carries(tmp_path: Path) -> None:
    package = packaged(tmp_path)
    assert [name for name in names_in(package) if name.startswith(("descriptions", "launch"))] == [
        "descriptions/calibration/eye.yaml",
        "descriptions/descriptions/arm/note.txt.jinja",
        "descriptions/descriptions/arm/numbers.yaml",
        "descriptions/descriptions/arm/parts/mast.yaml",
        "descriptions/descriptions/arm/robot.yaml",
        "launch/description.launch.py",
        "launch/description.launch.xml",
        "launch/description.launch.yaml",
        "launch/static_frames.launch.py",
    ]
    for name, text in FILES.items():
        assert (package / "descriptions" / name).read_text("utf-8") == text
    said = (package / "README.md").read_text("utf-8")
    assert "pip install path/to/rosorin-compile\n" in said
    assert "`rosorin-compile check ROBOT --every-argument`" in said
    assert " descriptions " in f" {(package / 'CMakeLists.txt').read_text('utf-8')}"
    clean(*package.rglob("*.py"))


def test_a_description_alone_stands_below_descriptions(tmp_path: Path) -> None:
    lone = "robot: arm\ninclude: [more.yaml]\nlinks: {base: {}}\noutputs: {urdf: {file: a.urdf}}\n"
    package = packaged(tmp_path, files={"here/robot.yaml": lone, "here/more.yaml": "links: {}\n"})
    carried = [name for name in names_in(package) if name.startswith("descriptions")]
    assert carried == ["descriptions/here/more.yaml", "descriptions/here/robot.yaml"]
    within = {name: text for name, text in FILES.items() if name.startswith("descriptions")}
    within["descriptions/arm/robot.yaml"] = ARM.replace("../../calibration/eye", "eye")
    within["descriptions/arm/eye.yaml"] = "let: {offset: '${load(\"numbers.yaml\").offset}'}\n"
    package = packaged(tmp_path / "other", files=within)
    assert "descriptions/arm/robot.yaml" in names_in(package)


@pytest.mark.landing("outside", "given1", "given3")
@pytest.mark.slow
@pytest.mark.parametrize(
    "given",
    [
        {},
        {"height": "450 mm", "side": "right", "twice": "1 m"},
        {"prefix": "left_", "arg_rviz": "true"},
        {"label": 'two  spaces, it\'s "quoted" \\ and $HOME; $(var height) := `x` #'},
        {"label": ""},
        {"label": "a\nb\t"},
    ],
)
def test_values_arrive_whole_in_all_three_forms(tmp_path: Path, given: dict[str, str]) -> None:
    package = packaged(tmp_path)
    arguments = {name.removeprefix("arg_"): value for name, value in given.items()}
    urdf, statics = compiled(tmp_path / "a project", **arguments)
    for form in FORMS:
        started = launched(package, form, **given)
        publisher = next(node for node in started if node.package == "robot_state_publisher")
        assert publisher.parameters == {"robot_description": urdf, "frame_prefix": "", "use_sim_time": False}
        nodes = [node for node in started if node.package == "tf2_ros"]
        assert {node.name: node.arguments for node in nodes} == {
            name: words for name, words in statics.items() if name != "tf_other_ear"
        }


@pytest.mark.slow
@pytest.mark.landing("outside", "yaml")
@pytest.mark.parametrize("form", FORMS)
def test_namespace_prefix_and_modes_reach_what_is_compiled(tmp_path: Path, form: str) -> None:
    package = packaged(tmp_path)
    nodes = launched(package, form, namespace="left", frame_prefix="left/", slam="true", prefix="my_")
    assert {node.namespace for node in nodes} == {"left"}
    statics = {node.name: command_line(node.arguments)[:2] for node in nodes if node.package == "tf2_ros"}
    assert statics == {"tf_eye": ("left/my_mast", "left/my_eye"), "tf_other_ear": ("left/my_mast", "left/my_ear")}
    publisher = next(node for node in nodes if node.package == "robot_state_publisher")
    assert publisher.parameters["frame_prefix"] == "left/"


@pytest.mark.slow
@pytest.mark.landing("outside", "py")
@pytest.mark.parametrize("form", FORMS)
def test_arguments_have_their_defaults_choices_and_help(tmp_path: Path, form: str) -> None:
    package = packaged(tmp_path)
    arguments = read(package / f"launch/description.launch.{form}", {NAME: package}).arguments
    assert arguments["prefix"] == ("", "before each name", ())
    assert arguments["height"] == ("0.3 m", "of the mast: where the eye is", ())
    assert arguments["side"] == ("left", "the argument side of the description", ("left", "right"))
    assert arguments["twice"].default == "${2 * height}"
    assert arguments["label"].default == 'it\'s "it"'
    assert arguments["arg_rviz"] == ("false", "an argument with a name of ours (rviz of the description)", ())
    assert arguments["rviz"].description == "show the robot in RViz"
    with pytest.raises(Failed, match="'middle' is not valid"):
        launched(package, form, side="middle")


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
def test_what_the_description_refuses_stops_the_launch(tmp_path: Path, form: str) -> None:
    with pytest.raises(Failed, match=r"robot\.yaml:\d+:\d+: error\[") as told:
        launched(packaged(tmp_path), form, height="3 kg")
    assert '"height"' in str(told.value)


REQUIRED = """\
robot: numbered
args: {serial: {type: integer, help: of the arm}}
links: {"base_${serial}": {}}
outputs: {urdf: {file: r.urdf}}
"""


@pytest.mark.slow
@pytest.mark.landing("outside", "xml")
@pytest.mark.parametrize("form", FORMS)
def test_an_argument_without_a_default_has_to_be_given(tmp_path: Path, form: str) -> None:
    package = packaged(tmp_path, "-a", "serial=7", files={"descriptions/numbered/robot.yaml": REQUIRED})
    with pytest.raises(Failed, match="Required launch argument 'serial' was not provided"):
        launched(package, form)
    (publisher,) = launched(package, form, serial="12")
    assert '<link name="base_12"/>' in publisher.parameters["robot_description"]
    assert "| `serial` | required | of the arm |" in (package / "README.md").read_text("utf-8")


@pytest.mark.slow
@pytest.mark.landing("outside", "py")
@pytest.mark.parametrize("form", FORMS)
def test_what_was_given_to_package_is_the_default_at_launch(tmp_path: Path, form: str) -> None:
    (tmp_path / "more.yaml").write_text("prefix: given_\n")
    package = packaged(tmp_path, "-a", "height=0.7 m", "side:=right", "--args", str(tmp_path / "more.yaml"))
    nodes = launched(package, form)
    urdf, _ = compiled(tmp_path / "a project", height="0.7 m", side="right", prefix="given_")
    assert nodes[-1].parameters["robot_description"] == urdf == (package / "urdf/arm.urdf").read_text("utf-8")
    again = launched(package, form, height="0.3 m", side="left", prefix="")
    assert again[-1].parameters["robot_description"] == compiled(tmp_path / "a project")[0]


def test_it_is_remembered_and_taken_back(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    package = packaged(tmp_path)
    first = tmp_path / "a project/descriptions/arm/robot.yaml"
    before = {name: (package / name).read_bytes() for name in names_in(package)}
    capsys.readouterr()
    assert main(["package", str(first), "-o", str(package)]) == 0
    assert capsys.readouterr().out.endswith("unchanged\n")
    assert {name: (package / name).read_bytes() for name in names_in(package)} == before
    assert main(["check", "deployed", str(first), str(package)]) == 0
    assert "deployed-launch" not in capsys.readouterr().err
    assert main(["package", str(first), "-o", str(package), "--no-compile-at-launch"]) == 0
    assert "rosorin-compile print" not in (package / "launch/description.launch.xml").read_text("utf-8")
    assert main(["check", "deployed", str(first), str(package)]) == 0


def test_a_description_that_differs_is_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    package = packaged(tmp_path)
    first = tmp_path / "a project/descriptions/arm/robot.yaml"
    carried = package / "descriptions/descriptions/arm/numbers.yaml"
    carried.write_text("offset: 6 mm\n")
    capsys.readouterr()
    assert main(["check", "deployed", str(first), str(package)]) == 1
    place = "descriptions/descriptions/arm/numbers.yaml"
    assert f"{place}: not as rosorin-compile package writes it\n" in capsys.readouterr().out
    carried.unlink()
    assert main(["check", "deployed", str(first), str(package.parent)]) == 1
    assert f"{NAME}/{place}: it is not there\n" in capsys.readouterr().out


MESHED = """\
robot: arm
links:
  base_link:
    visual:
      - mesh: {file: "FILE"}
outputs: {urdf: {file: urdf/arm.urdf}}
"""


@pytest.mark.slow
def test_a_mesh_named_by_a_path_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    project = project_of(tmp_path, {"descriptions/arm/robot.yaml": MESHED.replace("FILE", "meshes/body.stl")})
    (project / "descriptions/arm/meshes").mkdir()
    (project / "descriptions/arm/meshes/body.stl").write_bytes(b"solid x")
    first, target = project / "descriptions/arm/robot.yaml", tmp_path / "package"
    assert main(["package", str(first), "-o", str(target), "--compile-at-launch"]) == 1
    said = capsys.readouterr().err
    message = "mesh meshes/body.stl is named by a path, and a URDF that is compiled at launch is in no folder"
    assert f"robot.yaml:5:23: error[package-not-carried]: {message}\n" in said
    help = "write package://arm_description/meshes/body.stl in the description; the file is copied into the package"
    assert help in said
    assert not target.exists()
    first.write_text(MESHED.replace("FILE", "package://arm_description/meshes/body.stl"))
    assert main(["package", str(first), "-o", str(target), "--compile-at-launch"]) == 0
    assert (target / "meshes/body.stl").read_bytes() == b"solid x"
    (node,) = launched(target.rename(tmp_path / NAME), "xml")
    assert 'filename="package://arm_description/meshes/body.stl"' in node.parameters["robot_description"]


@pytest.mark.parametrize("what", ["include", "load"])
def test_a_file_named_by_its_whole_path_is_refused(
    tmp_path: Path, what: str, capsys: pytest.CaptureFixture[str]
) -> None:
    there = tmp_path / "a project/descriptions/arm"
    named = (
        f"include: ['{there}/more.yaml']" if what == "include" else f"let: {{x: '${{load(\"{there}/more.yaml\").y}}'}}"
    )
    text = f"robot: arm\n{named}\nlinks: {{base_link: {{}}}}\noutputs: {{urdf: {{file: a.urdf}}}}\n"
    more = "links: {other: {}}\njoints: {j: {type: fixed, parent: base_link, child: other}}\n"
    files = {"descriptions/arm/robot.yaml": text, "descriptions/arm/more.yaml": more if what == "include" else "y: 1\n"}
    project = project_of(tmp_path, files)
    if what == "load":
        text = text.replace("links: {base_link", "links: {'link_${x}'").replace("{base_link", "{")
        (project / "descriptions/arm/robot.yaml").write_text(text)
    target = tmp_path / "package"
    assert main(["package", str(project / "descriptions/arm"), "-o", str(target), "--compile-at-launch"]) == 1
    said = capsys.readouterr().err
    assert "robot.yaml:2:" in said
    assert "error[package-not-carried]: " in said
    assert not target.exists()


@pytest.mark.slow
def test_a_description_of_another_package_is_a_dependency(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    prefix = tmp_path / "opt"
    there = prefix / "share/gripper_description"
    (there / "urdf").mkdir(parents=True)
    (there / "package.xml").write_text("<package format='3'><name>gripper_description</name></package>")
    (there / "urdf/gripper.urdf").write_text('<robot name="g"><link name="palm"/></robot>')
    text = """\
robot: arm
include:
  - {package: gripper_description, file: urdf/gripper.urdf, parent: base_link}
links: {base_link: {}}
outputs: {urdf: {file: a.urdf}}
"""
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(prefix))
    package = packaged(tmp_path, files={"descriptions/arm/robot.yaml": text})
    assert [name for name in names_in(package) if name.startswith("descriptions")] == ["descriptions/arm/robot.yaml"]
    needs = {element.text for element in ET.parse(package / "package.xml").iter("exec_depend")}
    assert "gripper_description" in needs
    (node,) = launched(package, "yaml")
    assert '<link name="palm"/>' in node.parameters["robot_description"]


@pytest.mark.slow
@pytest.mark.landing("outside", "yaml")
@pytest.mark.parametrize("form", FORMS)
def test_the_lines_of_the_page_replace_a_call_of_xacro(tmp_path: Path, form: str) -> None:
    """The table of docs/ros-package.md has the line of each form that compiles a description at launch."""
    text = (DOCS / "ros-package.md").read_text("utf-8")
    description = tmp_path / "robot.yaml"
    description.write_text(
        "robot: mast\nargs: {height: {type: length, default: 0.3 m}}\nlinks: {base_link: {}, mast: {}}\njoints:\n"
        '  mast_joint: {type: fixed, parent: base_link, child: mast, xyz: [0, 0, "${height}"]}\n'
        "outputs: {urdf: {file: mast.urdf}}\n",
        "utf-8",
    )
    made = compile_robot(description, {"height": "50 cm"}, requested=("urdf",))
    row = next(line for line in text.splitlines() if line.startswith("| Python" if form == "py" else "| XML"))
    line = row.split("`")[3]
    context = Context({}, {"height": "50 cm"})
    path = str(description)
    if form == "py":
        known = {"Command": Command, "path": path, "height": LaunchConfiguration("height")}
        assert eval(line, known).perform(context) == made.artifacts[0].text  # noqa: S307
    else:
        assert performed(parsed(line.replace("PATH", path)), context) == made.artifacts[0].text
