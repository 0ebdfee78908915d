"""Elements of a xacro that are the same for every combination of arguments become words, and its macros stay."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.importing.xacro import wording
from rosorin_compile.importing.xacro.values import name_of

pytest.importorskip("xacro")

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
ROBOT = """
<xacro:arg name="sim" default="false"/>
<xacro:macro name="body" params="name"><link name="${name}"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></xacro:macro>
<xacro:body name="base"/><xacro:body name="arm"/>
<joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
"""
BLOCK = """<ros2_control name="NAME" type="system"><hardware><plugin>PLUGIN</plugin></hardware>
<joint name="j"><command_interface name="position"><param name="min">-1</param><param name="max">1</param>
</command_interface><state_interface name="position"/></joint></ros2_control>"""
NAME_OF = '<xacro:property name="name_of" value="system"/>'
SENSOR = """<gazebo reference="arm"><material>Gazebo/Black</material><sensor name="imu" type="imu">
<always_on>true</always_on><update_rate>50</update_rate></sensor></gazebo>"""


def block(name: str, plugin: str = "mock_components/GenericSystem") -> str:
    return BLOCK.replace("NAME", name).replace("PLUGIN", plugin)


def imported(body: str, *more: str) -> str:
    """Return the first file of the description that a xacro in this folder becomes, and compile it."""
    Path("robot.xacro").write_text(f"{HEAD}{ROBOT}{body}</robot>", "utf-8")
    assert main(["import", "robot.xacro", "-o", "made", "--trust", "--force", *more]) == 0
    assert main(["all", "made"]) == 0
    return Path("made/robot.yaml").read_text("utf-8")


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_block_and_a_sensor_become_words(capsys: pytest.CaptureFixture[str]) -> None:
    made = imported(block("one") + SENSOR)
    said = capsys.readouterr()
    assert "control:\n  one:\n    plugin: mock_components/GenericSystem\n    joints:\n      j:\n" in made
    assert "sensors:\n  imu:\n    type: imu\n    frame: arm\n" in made
    assert 'urdf_elements: [<gazebo reference="arm"><material>Gazebo/Black</material></gazebo>]\n' in made
    assert "control: jazzy, gazebo: " in made
    assert "1 hardware block (one), 1 sensor (imu)" in said.out
    assert "kept as they are: gazebo\n" in said.out
    assert "ignored" not in said.err


def test_what_is_there_on_a_condition_is_asked_for_on_that_condition(capsys: pytest.CaptureFixture[str]) -> None:
    """The default has no block: without the condition, each compilation would warn that there is none."""
    made = imported(f'<xacro:if value="$(arg sim)">{block("one")}</xacro:if>')
    assert "control:\n  one:\n    if: ${sim}\n" in made
    assert "control: \"${'jazzy' if sim else none}\"" in made
    assert main(["all", "made", "-a", "sim=true"]) == 0
    assert "<ros2_control" in Path("outputs/made/r.urdf").read_text("utf-8")
    assert "ignored" not in capsys.readouterr().err


def test_two_blocks_of_one_name_on_opposite_conditions(capsys: pytest.CaptureFixture[str]) -> None:
    both = f'<xacro:if value="$(arg sim)">{block("one", "sim/Sim")}</xacro:if>'
    made = imported(f'{both}<xacro:unless value="$(arg sim)">{block("one")}</xacro:unless>')
    assert "control:\n  one:\n    if: ${sim}\n    plugin: sim/Sim\n" in made
    assert "one${''}" in made
    assert "control: jazzy" in made
    assert "ignored" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("body", "more"),
    [
        pytest.param(NAME_OF + block("one").replace('"system"', '"${name_of}"'), (), id="an expression"),
        pytest.param(block("one"), ("--verbatim",), id="asked for"),
    ],
)
def test_what_stays_as_it_stands_is_not_asked_for(
    body: str, more: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    made = imported(body, *more)
    assert '<ros2_control name="one"' in made
    assert "jazzy" not in made
    assert "ignored" not in capsys.readouterr().err


def test_words_that_would_say_something_else_are_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    right = wording.find

    def wrong(plain, evaluated, robots):  # type: ignore[no-untyped-def]
        found = right(plain, evaluated, robots)
        for words in found.spots.values():
            for entry in words.entries:
                if entry.name == "one":
                    entry.value["plugin"] = "other/Plugin"
        return found

    monkeypatch.setattr("rosorin_compile.importing.xacro.translate.find", wrong)
    made = imported(block("one") + SENSOR)
    assert '<ros2_control name="one"' in made
    assert "sensors:\n  imu:" in made
    assert "other/Plugin" not in made


@pytest.mark.parametrize(
    ("conditions", "told"),
    [
        (["a", None], None),
        (["a and b", "a and not b"], "a"),
        (["a", "not a"], None),
        (["a", "a and b"], "a"),
        (["a == 'x' and b", "c"], "a == 'x' and b or c"),
        (["a", "a"], "a"),
    ],
)
def test_one_of_some_conditions(conditions: list[str | None], told: str | None) -> None:
    nodes = [None if one is None else ast.parse(one, mode="eval").body for one in conditions]
    made = wording.any_of(nodes)
    assert (None if made is None else ast.unparse(made)) == told


PLUGIN = "<gazebo><plugin filename='a.so' name='a'><parameters>$(find tool)/a.yaml</parameters></plugin></gazebo>"
MESH = '<xacro:macro name="shown" params="file"><link name="${file}"><visual><geometry>'
MESH += '<mesh filename="file://$(find tool)/meshes/${file}.stl"/></geometry></visual></link>'
MESH += '<joint name="${file}_j" type="fixed"><parent link="base"/><child link="${file}"/></joint></xacro:macro>'


def tool(folder: Path) -> Path:
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>tool</name></package>")
    return folder


def test_a_folder_of_a_package_is_found_on_another_machine(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "here"))
    tool(tmp_path / "here" / "tool")
    made = imported(f'{PLUGIN}{MESH}<xacro:shown file="a"/>')
    assert "<parameters>${find('tool')}/a.yaml</parameters>" in made
    assert "package://tool/meshes/${file}.stl" in made
    assert str(tmp_path) not in made
    there = tool(tmp_path / "there" / "tool")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(there.parent))
    assert main(["all", "made"]) == 0
    assert f"<parameters>{there}/a.yaml</parameters>" in Path("outputs/made/r.urdf").read_text("utf-8")


def test_no_folder_of_this_machine_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tool(tmp_path / "far" / "away" / "tool")
    Path("robot.xacro").write_text(f"{HEAD}{ROBOT}{PLUGIN}</robot>", "utf-8")
    assert main(["import", "robot.xacro", "-o", "made", "--trust", "--package", f"tool={folder}"]) == 0
    assert main(["all", "made", "--package", f"tool={folder}"]) == 0
    made = Path("made/robot.yaml").read_text("utf-8")
    assert "<parameters>${find('tool')}/a.yaml</parameters>" in made
    assert not any(str(folder) in path.read_text("utf-8") for path in Path("made").iterdir())
    assert (
        "it asks for the package tool: source its workspace, or give --package tool=FOLDER" in capsys.readouterr().out
    )


CHOICE = """<xacro:macro name="driver" params="mock_components"><ros2_control name="d" type="system"><hardware>
<xacro:if value="$(arg sim)"><plugin>mock_components/GenericSystem</plugin><param name="a">1</param></xacro:if>
<xacro:unless value="$(arg sim)"><plugin>ur_driver/Hardware</plugin><param name="a">${mock_components}</param>
</xacro:unless></hardware><joint name="j"><command_interface name="position"/></joint></ros2_control></xacro:macro>
<xacro:driver mock_components="2"/>"""


def test_a_text_under_a_condition_is_called_after_its_plugin_unless_something_else_is() -> None:
    made = imported(CHOICE)
    assert "      mock_components_2: |-\n        <plugin>mock_components/GenericSystem</plugin>\n" in made
    assert "${mock_components_2 if sim else ur_driver}" in made


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("<plugin>ur_driver/Hardware</plugin><param name='a'/>", "ur_driver"),
        ("<plugin>${package}/System</plugin>", "plugin"),
        ('<joint name="${prefix}wrist"><param name="x"/></joint>', "wrist"),
        ('<joint name="a"/><joint name="b"><c/></joint>', "joints"),
        ('<gpio name="tool-io"/><param name="b"/>', "tool_io_and_more"),
        ("${more}", "text"),
        ("<mu1>0.2</mu1><mu2>0.2</mu2>", "mu1_and_more"),
    ],
)
def test_names_of_texts(text: str, name: str) -> None:
    assert name_of(text) == name


ODD = """<link name="${list(map(lambda x: x + 'd', ['od']))[0]}"/>"""
DEEP = """<xacro:macro name="deep" params="on"><joint name="${on}_j" type="fixed"><parent link="base"/>
<child link="${on}"/></joint><gazebo reference="${on}">
            <!--<mu1>1</mu1>
            <mu2>1</mu2>-->
            <material>
                    <ambient>1 0 0 1</ambient>
            </material>
        </gazebo></xacro:macro>"""


def test_what_is_written_as_xacro_expands_it_is_indented_as_the_rest() -> None:
    call = """<xacro:deep on="${list(map(lambda x: x + 'd', ['od']))[0]}"/>"""
    made = imported(f"{DEEP}{ODD}{call}")
    expected = '  - |\n    <gazebo reference="odd">\n      <!--<mu1>1</mu1>'
    assert expected in made
    assert "      <material><ambient>1 0 0 1</ambient></material>\n    </gazebo>\n" in made


WHEEL = """<xacro:macro name="wheel" params="side reflect"><link name="${side}"><collision><geometry>
<cylinder radius="0.1" length="0.05"/></geometry></collision></link><joint name="${side}_j" type="continuous">
<parent link="base"/><child link="${side}"/><origin xyz="0 ${reflect * width / 2} 0" rpy="${-pi/2} 0 0"/>
<axis xyz="0 0 1"/></joint></xacro:macro><xacro:property name="width" value="0.4"/>
<xacro:wheel side="left" reflect="1"/><xacro:wheel side="right" reflect="-1"/>"""
DRIVE = """<gazebo><plugin filename="libgazebo_ros_diff_drive.so" name="diff">
<!-- the wheels --><left_joint>left_j</left_joint><right_joint>RIGHT</right_joint>
<wheel_separation>${width}</wheel_separation><wheel_diameter>0.2</wheel_diameter>
<odometry_frame>odom</odometry_frame><robot_base_frame>base</robot_base_frame>
<publish_odom_tf>true</publish_odom_tf></plugin></gazebo>"""


@pytest.mark.parametrize("width", ["${width}", "0.4"])
def test_a_plugin_says_the_drive_with_expressions_too(width: str) -> None:
    drive = DRIVE.replace("RIGHT", "right_j").replace("${width}", width)
    made = imported(WHEEL + drive)
    assert "drive:\n  differential: {left: [left_j], right: [right_j]}\n" in made
    assert "edges:\n  - {parent: odom, child: base, publisher: diff}\n" in made
    assert "urdf_elements:\n  - |\n    <gazebo>\n" in made
    assert f"<wheel_separation>{width}</wheel_separation>" in made


def test_a_drive_that_depends_on_an_argument_is_not_said() -> None:
    arguments = '<xacro:arg name="back" default="false"/>'
    joint = "${'left_j' if '$(arg back)' == 'true' else 'right_j'}"
    made = imported(f"{WHEEL}{arguments}{DRIVE.replace('RIGHT', joint)}")
    assert "drive:" not in made
    assert "edges:" in made
    conditional = DRIVE.replace("RIGHT", "right_j")
    assert "drive:" not in imported(f'{WHEEL}<xacro:if value="$(arg sim)">{conditional}</xacro:if>')


IMU = """<xacro:macro name="unit" params="mass"><link name="unit"><inertial><mass value="${mass}"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="unit_j" type="fixed"><parent link="base"/><child link="unit"/></joint>
<gazebo reference="unit"><sensor name="imu" type="imu"><always_on>true</always_on><update_rate>50</update_rate>
</sensor></gazebo>BLOCK</xacro:macro>"""


@pytest.mark.parametrize("call", ["", '<xacro:if value="$(arg sim)">'])
def test_a_part_that_is_there_once_has_words(call: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The hardware of a part that is not always there is not in words: the URDF would ask for what is not there."""
    body = IMU.replace("BLOCK", block("one"))
    made = imported(f'{body}{call}<xacro:unit mass="2"/>{"</xacro:if>" if call else ""}')
    assert "    sensors:\n      imu:\n        type: imu\n        frame: unit\n" in made
    assert ("    control:\n      one:\n        plugin: mock_components/GenericSystem\n" in made) == (not call)
    assert ('<ros2_control name="one"' in made) == bool(call)
    assert "ignored" not in capsys.readouterr().err


def test_a_part_that_is_there_several_times_keeps_its_elements() -> None:
    body = IMU.replace("BLOCK", "").replace('"unit"', '"${name}unit"').replace('params="mass"', 'params="mass name"')
    body = body.replace('"unit_j"', '"${name}unit_j"').replace('name="${name}unit" params', 'name="unit" params')
    made = imported(f'{body}<xacro:unit mass="2" name="a_"/><xacro:unit mass="2" name="b_"/>{block("one")}')
    assert '<sensor name="imu" type="imu">' in made
    assert "control:\n  one:\n" in made


def test_a_block_has_the_expressions_of_its_values(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = '<xacro:arg name="port" default="/dev/tty0"/><xacro:arg name="rate" default="30"/>'
    arguments += '<xacro:property name="reach" value="1"/>'
    hardware = "<plugin>a/B</plugin><param name='port'>$(arg port)</param><param name='rate'>$(arg rate)</param>"
    hardware += "<param name='file'>dir/$(arg port)/x</param>"
    body = block("one").replace("<plugin>PLUGIN</plugin>", "").replace(">-1<", ">-${reach * 0.5}<")
    body = body.replace("<plugin>mock_components/GenericSystem</plugin>", hardware).replace(">1<", ">${reach}<")
    made = imported(arguments + body)
    assert "<ros2_control" not in made
    assert "kept as they are" not in capsys.readouterr().out
    assert "port: ${port}" in made or 'port: "${port}"' in made
    assert "dir/${port}/x" in made
    assert main(["all", "made", "-a", "port=/dev/x", "-a", "rate=5"]) == 0
    text = Path("outputs/made/r.urdf").read_text("utf-8")
    assert '<param name="port">/dev/x</param>' in text
    assert '<param name="rate">5</param>' in text
    assert "ignored" not in capsys.readouterr().err
