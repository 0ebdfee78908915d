"""Owners, locks, limits, forks and signals are taken away: the same artifacts come out, or a sentence."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.commands import write_files
from support.paths import TESTS

ROBOT = """\
robot: bot
args: {height: {type: number, default: 0.1}}
links: {base_link: {}, mast: {inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}}}}
joints: {mast_joint: {type: fixed, parent: base_link, child: mast, xyz: [0, 0, "${height}"]}}
outputs: {urdf: {file: bot.urdf}, static_tf_json: {file: tf.json}}
"""
XACRO = """\
<robot name="mast" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="x" value="1"/>
<link name="a"/><link name="b"/>
<joint name="j" type="fixed"><parent link="a"/><child link="b"/><origin xyz="${x} 0 0"/></joint></robot>
"""
PROJECT = {
    "descriptions/bot/robot.yaml": ROBOT,
    "variants.csv": "name,height\nlow,0.1\nhigh,0.2\n",
    "mast.urdf.xacro": XACRO,
}
RUN = """\
import json, sys
from rosorin_compile.cli.main import main
if __name__ == "__main__":
    print(json.dumps([main(words) for words in json.loads(sys.argv[1])]))
"""
OFTEN = [
    *[["all", "-q"]] * 2,
    ["check", "-q"],
    ["print", "urdf", "-q", "-o", "printed.urdf"],
    ["diff", "descriptions/bot", "outputs/bot/bot.urdf", "-q"],
]


def run(home: Path, without: str, commands: list[list[str]]) -> tuple[list[int], str]:
    write_files(home, PROJECT)
    (home / "run.py").write_text(RUN)
    folder = str(TESTS / "support" / "without_posix")
    environment = {**os.environ, "PYTHONPATH": folder, "WITHOUT": without, "ROSORIN_COMPILE_CACHE": str(home / "cache")}
    command = [sys.executable, "run.py", json.dumps(commands)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=home, check=False)
    assert "Traceback" not in done.stderr, done.stderr
    return json.loads(done.stdout.splitlines()[-1]), done.stdout + done.stderr


def written(home: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in [*sorted(home.glob("outputs/bot/*")), home / "printed.urdf"]}


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    home = tmp_path_factory.mktemp("posix")
    assert run(home, "", OFTEN)[0] == [0] * len(OFTEN)
    return written(home)


@pytest.mark.parametrize("without", ["geteuid", "fcntl", "resource", "fork", "SIGALRM", "link", "windows"])
def test_the_commands_of_every_day_do_without(without: str, tmp_path: Path, expected: dict[str, bytes]) -> None:
    codes, said = run(tmp_path, without, OFTEN)
    assert codes == [0] * len(OFTEN), said
    assert "system-lacks" not in said
    assert written(tmp_path) == expected
    assert sorted(path.name for path in (tmp_path / "outputs").iterdir()) == ["bot"], "nothing of a run stays"


@pytest.mark.slow
def test_what_needs_locks_or_limits_says_so(tmp_path: Path) -> None:
    codes, said = run(
        tmp_path,
        "windows",
        [
            *[["sweep", "bot", "--over", "variants.csv", "-o", "made", "-j", "2"]] * 2,
            ["import", "mast.urdf.xacro", "--trust", "-o", "mast"],
            ["package", "bot", "-o", "ws"],
            *[["deploy", "bot", "-o", "ws"]] * 2,
            ["init", "other"],
            ["frames", "bot"],
        ],
    )
    assert set(codes) == {0}, said
    notes = [line for line in said.splitlines() if "system-lacks" in line]
    assert [note.split("(")[1].split(")")[0] for note in notes] == ["fcntl", "fcntl", "resource"]
    assert "nothing keeps another run from writing into the same folder" in notes[0]
    assert "a file that asks for too much memory is not stopped" in notes[2]
