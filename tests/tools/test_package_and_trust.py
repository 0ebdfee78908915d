"""``--package`` and ``--trust`` reach the xacro that a description includes, in each command that reads one."""

import pytest

from rosorin_compile.cli.main import main

pytest.importorskip("xacro")

ROBOT = """\
robot: cell
include: [{file: gripper.xacro}]
links: {tip: {}}
joints: {tip: {type: fixed, parent: gripper, child: tip}}
outputs: {urdf: {file: cell.urdf}}
"""
XACRO = """\
<robot name="gripper" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="$(find gripper_description)/macros.xacro"/>
  <link name="gripper"/>
</robot>
"""
MACROS = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="a" value="1"/></robot>'
PROJECT = {
    "descriptions/cell/robot.yaml": ROBOT,
    "descriptions/cell/gripper.xacro": XACRO,
    "vendor/macros.xacro": MACROS,
    "mine/notes.txt": "",
}
COMMANDS = (
    "all",
    "check --every-argument",
    "deploy -o mine",
    "diff cell cell",
    "explain cell tip",
    "frames cell",
    "package cell -o made --maintainer A<a@b.de> --license MIT",
    "tf cell gripper tip",
)


@pytest.mark.landing("fuzz", "all", "diff cell cell", "tf cell gripper tip")
@pytest.mark.slow
@pytest.mark.usefixtures("project")
@pytest.mark.parametrize("command", COMMANDS)
def test_package_and_trust(command, capsys):
    code = main([*command.split(), "--package", "gripper_description=vendor", "--trust"])
    said = capsys.readouterr()
    told = [line for line in said.err.splitlines() if not line.startswith("note[deploy-no-package]")]
    assert (code, told) == (0, [])
    assert "xacro-runs-code" not in said.out
    main([*command.split(), "--package", "gripper_description=vendor"])
    assert "xacro-runs-code" in capsys.readouterr().err
