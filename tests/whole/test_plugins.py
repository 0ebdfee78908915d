"""Plug-ins: a distribution in a folder of its own, and the tool in a process that finds it."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import pytest

from rosorin_compile.cli.main import COMPLETE
from support import forks

pytestmark = pytest.mark.slow

ROBOT = """\
robot: cart
let: {width: 0.2}
links:
  base_link: {}
  wheel: {inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}}}
joints:
  axle: {type: fixed, parent: base_link, child: wheel, xyz: [0, "${VALUE}", 0]}
outputs: {urdf: {file: cart.urdf}}
"""
TOY = """\
from rosorin_compile.language.expression.functions import function
from rosorin_compile.source.rule_registry import rule


@rule("wheel-too-heavy", "A wheel is heavier than a motor can turn.", "Take a lighter one.", accept="link")
def wheels(case):
    for link in case.robot.links:
        if link.name == "wheel" and link.inertial.mass > 0.5:
            yield case.problem("wheel-too-heavy", "the wheel is too heavy", case.link(link.name, "inertial", "mass"))


@function("halved", "half of it")
def halved(value):
    return value / 2
"""
BOTH = "[rosorin_compile.functions]\nhalved = toy:halved\n\n[rosorin_compile.rules]\nwheels = toy:wheels\n"


class Machine:
    def __init__(self, folder: Path) -> None:
        self.packages = folder / "packages"
        self.work = folder / "work"
        for each in (self.packages, self.work):
            each.mkdir()
        self.describe("${halved(width)}")

    def describe(self, value: str, more: str = "") -> None:
        (self.work / "robot.yaml").write_text(ROBOT.replace("${VALUE}", value) + more, "utf-8")

    def install(self, entry_points: str = BOTH, code: str = TOY, name: str = "toy", version: str = "1.2") -> None:
        for old in self.packages.glob(f"{name}_robot-*.dist-info"):
            old.rename(old.with_name(f"{name}_robot-{version}.dist-info"))
        info = self.packages / f"{name}_robot-{version}.dist-info"
        info.mkdir(exist_ok=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}-robot\nVersion: {version}\n", "utf-8")
        (info / "entry_points.txt").write_text(entry_points, "utf-8")
        (self.packages / f"{name}.py").write_text(code, "utf-8")

    def complete(self, line: str) -> str:
        *before, current = line.split(" ")
        words = {"COMP_WORDS": " ".join(["rosorin-compile", *before]), "COMP_CWORD": current}
        return self.run(environment={**words, COMPLETE: "fish_complete"})[1]

    def run(self, *words: str, environment: Mapping[str, str] = MappingProxyType({})) -> tuple[int, str]:
        environment = {**os.environ, **environment, "PYTHONPATH": str(self.packages), "PYTHONDONTWRITEBYTECODE": "1"}
        environment["ROSORIN_COMPILE_CACHE"] = str(self.work / ".cache")
        code, printed = forks.run(words, self.work, environment)
        assert "Traceback" not in printed, printed
        return code, printed


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_a_rule_and_a_function_of_a_plugin(machine: Machine):
    machine.install()
    code, printed = machine.run("all", "robot.yaml")
    assert code == 1
    assert "robot.yaml:5:28: error[wheel-too-heavy]: the wheel is too heavy" in printed
    machine.describe("${halved(width)}", "accept: [{rule: wheel-too-heavy, of: [wheel], reason: it is strong}]\n")
    code, printed = machine.run("all", "robot.yaml", "--notes")
    assert code == 0, printed
    assert "note[wheel-too-heavy]: accepted: the wheel is too heavy (it is strong)" in printed
    (urdf,) = machine.work.rglob("cart.urdf")
    assert 'xyz="0 0.1 0"' in urdf.read_text("utf-8")


def test_without_it_the_same_description_is_refused(machine: Machine):
    machine.describe("${halved(width)}", "accept: [{rule: wheel-too-heavy, of: [wheel], reason: it is strong}]\n")
    code, printed = machine.run("all", "robot.yaml")
    assert code == 1
    assert 'there is no function "halved"' in printed
    machine.describe("${width}", "accept: [{rule: axis-not-unitt, of: [wheel], reason: it is strong}]\n")
    code, printed = machine.run("all", "robot.yaml")
    assert 'error[wrong-value]: accept[0] rule cannot be "axis-not-unitt"' in printed
    assert 'did you mean "axis-not-unit"? (one of angle-looks-like-degrees, axis-' in printed


def test_it_is_listed(machine: Machine):
    machine.install()
    assert machine.run("--version") == (0, "rosorin-compile 0.3.0\nplug-in toy-robot 1.2 (functions, rules)\n")
    code, printed = machine.run("rule", "wheel-too-heavy")
    assert code == 0
    assert printed == (
        "wheel-too-heavy\n"
        "  A wheel is heavier than a motor can turn.\n"
        "  What to do: Take a lighter one.\n"
        "  A link may break it: accept: [{rule: wheel-too-heavy, of: [NAME], reason: WHY}]\n"
    )
    _, printed = machine.run("check", "robot.yaml", "--format", "sarif")
    rules = json.loads(printed[printed.index("{") : printed.rindex("}") + 1])["runs"][0]["tool"]["driver"]["rules"]
    (told,) = [one for one in rules if one["id"] == "wheel-too-heavy"]
    assert told["shortDescription"]["text"] == "A wheel is heavier than a motor can turn."


def test_it_comes_goes_and_changes_though_nothing_else_does(machine: Machine):
    def told(version: str) -> str:
        code = TOY.replace('"mass"))', '"mass"), severity="note")').replace("the wheel is", f"for {version} it is")
        machine.install(code=code, version=version.partition(" ")[0])
        machine.run("all", "robot.yaml", "--notes")
        return machine.run("all", "robot.yaml", "--notes")[1]

    machine.describe("${width}")
    assert "wheel-too-heavy" not in machine.run("all", "robot.yaml")[1]
    assert "wheel-too-heavy" not in machine.run("all", "robot.yaml")[1]
    assert "note[wheel-too-heavy]: for 1.2 it is too heavy" in told("1.2")
    assert "note[wheel-too-heavy]: for 1.3 it is too heavy" in told("1.3")
    assert "note[wheel-too-heavy]: for 1.3 mended it is too heavy" in told("1.3 mended")
    (info,) = machine.packages.glob("*.dist-info")
    info.rename(info.with_suffix(".gone"))
    assert "wheel-too-heavy" not in machine.run("all", "robot.yaml")[1]


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (TOY.replace("wheel-too-heavy", "axis-zero"), 'brings "axis-zero", which is built in'),
        (TOY.replace('"halved"', '"sqrt"'), 'brings "sqrt", which is built in'),
        (TOY.replace('"halved"', '"pi"'), 'brings "pi", which is built in'),
    ],
)
def test_one_cannot_replace_what_is_built_in(machine: Machine, code: str, words: str):
    machine.install(code=code)
    machine.describe("${width}")
    exit_code, printed = machine.run("all", "robot.yaml")
    assert exit_code == 1
    assert "error[plugin-clash]: the plug-in toy-robot 1.2 (" in printed
    assert words in printed


def test_metadata_that_are_no_good(machine: Machine):
    machine.install()
    (info,) = machine.packages.glob("*.dist-info")
    (info / "METADATA").unlink()
    assert machine.run("--version")[1].endswith("plug-in toy_robot 1.2 (functions, rules)\n")
    (info / "entry_points.txt").write_bytes(b"[rosorin_compile.rules]\n\xff\xfe = \n")
    machine.describe("${width}")
    assert machine.run("all", "robot.yaml")[0] == 0


def test_nothing_is_imported_where_there_is_no_plugin(machine: Machine):
    machine.describe("${width}")
    code = "import sys; from rosorin_compile.cli.main import main; main(['check', 'robot.yaml']); "
    code += "print('importlib.metadata' in sys.modules)"
    ran = subprocess.run([sys.executable, "-c", code], cwd=machine.work, capture_output=True, text=True, check=True)
    assert ran.stdout.splitlines()[-1] == "False"


# ---- Commands and checks ----

COMMAND = """\
from rosorin_compile.cli.command import argument, check, command, option


@command("greet", group="inspect", help="say hello", exits="0 said")
@argument("words", nargs=-1)
@option("--loud", is_flag=True)
def GREET(options):
    print("HELLO" if options.loud else "hello", *options.words)
    return 0


@check("light", help="see whether it is light", exits="0 it is, 1 it is not")
@argument("words", nargs=-1)
def LIGHT(options):
    print("light enough:", *options.words)
    return 1
"""
OF_COMMANDS = "[rosorin_compile.commands]\ngreet = toy:GREET\n\n[rosorin_compile.checks]\nlight = toy:LIGHT\n"


def test_a_command_and_a_check_of_a_plugin(machine: Machine):
    machine.install(OF_COMMANDS, COMMAND)
    assert machine.run("greet", "you", "--loud") == (0, "HELLO you\n")
    assert machine.run("check", "light", "cart") == (1, "light enough: cart\n")
    assert machine.run("check", "toy-robot:light", "cart") == (1, "light enough: cart\n")
    assert "\n  greet       say hello\n" in machine.run("--help")[1]
    assert "\n  light       see whether it is light\n" in machine.run("check", "--help")[1]
    assert "Exit codes: 0 said, 2 wrong usage." in machine.run("greet", "--help")[1]
    assert machine.complete("gre") == "plain,greet\tof toy-robot 1.2\n"
    assert machine.complete("check lig") == "plain,light\tof toy-robot 1.2\n"
    assert machine.complete("greet --l") == "plain,--loud\n"
    assert machine.run("greet", "--lod")[0] == 2
    assert machine.run("--version")[1].endswith("plug-in toy-robot 1.2 (checks, commands)\n")


def test_completion_imports_no_plugin_that_is_not_called(machine: Machine):
    machine.install(OF_COMMANDS, "1 / 0\n")
    assert "plain,greet\tof toy-robot 1.2\n" in machine.complete("")


def test_a_robot_goes_before_a_check_of_a_plugin(machine: Machine):
    machine.install(OF_COMMANDS, COMMAND)
    folder = machine.work / "descriptions" / "light"
    folder.mkdir(parents=True)
    (folder / "robot.yaml").write_text("robot: light\nlinks: {a: {}}\noutputs: {urdf: {file: a.urdf}}\n", "utf-8")
    machine.run("all", "light")
    said = '"light" is a robot here; the check of that name of toy-robot: rosorin-compile check toy-robot:light\n'
    code, printed = machine.run("check", "light")
    assert (code, printed.count(said)) == (0, 1)
    assert "light: 1 artifact up to date in outputs/light\n" in printed
    assert machine.run("check", "toy-robot:light") == (1, "light enough:\n")


BROKEN_COMMANDS = {
    "import raises": ("1 / 0\n", "cannot be loaded: ZeroDivisionError: division by zero"),
    "no command": (COMMAND.replace("@command(", "@dict("), "cannot be loaded: "),
    "another name": (
        COMMAND.replace('"greet", group', '"gret", group'),
        'is called "gret", and its entry point "greet"',
    ),
    "run raises": (COMMAND.replace('    print("HELLO', '    [][0]\n    print("HELLO'), "fails: IndexError: list index"),
    "run leaves": (
        COMMAND.replace('    print("HELLO', '    raise SystemExit(0)\n    print("HELLO'),
        "fails: SystemExit: 0",
    ),
    "no exit code": (COMMAND.replace("return 0", "return 'fine'"), "gives no exit code, but 'fine'"),
}


@pytest.mark.parametrize("case", BROKEN_COMMANDS)
def test_a_broken_command_is_one_sentence_and_the_rest_works(machine: Machine, case: str):
    code, words = BROKEN_COMMANDS[case]
    machine.install(OF_COMMANDS, code)
    exit_code, printed = machine.run("greet")
    assert exit_code == 1
    assert printed.count("plugin-broken]: the plug-in toy-robot 1.2 (rosorin_compile.commands: greet = toy:GREET)") == 1
    assert words in printed
    machine.describe("${width}")
    code_of_all, printed = machine.run("all", "robot.yaml")
    assert code_of_all == 0
    assert "1 artifact in outputs/" in printed
    assert "plugin-broken" not in printed
    shown = machine.run("--help")
    assert shown[0] == 0
    assert "\n  all   " in shown[1]


def test_one_that_is_called_as_ours_is_told_and_ours_is_done(machine: Machine):
    text = OF_COMMANDS.replace("greet =", "args =").replace("light =", "physics =")
    machine.install(text, COMMAND.replace('"greet"', '"args"').replace('"light"', '"physics"'))
    code, printed = machine.run("args", "robot.yaml")
    assert code == 0
    assert "hello" not in printed
    assert printed.count('(rosorin_compile.commands: args = toy:GREET) brings "args", which is built in\n') == 1
    printed = machine.run("check", "physics", "--help")[1]
    assert printed.count('(rosorin_compile.checks: physics = toy:LIGHT) brings "physics", which is built in\n') == 1
    assert "see whether it is light" not in printed  # the help is that of the built-in check


def test_all_of_them_can_be_left_out(machine: Machine, monkeypatch: pytest.MonkeyPatch):
    machine.install(BOTH + OF_COMMANDS, TOY + COMMAND)
    machine.describe("${width}")
    assert machine.run("all", "robot.yaml")[0] == 1
    monkeypatch.setenv("ROSORIN_COMPILE_PLUGINS", "off")
    for _ in range(2):
        assert machine.run("all", "robot.yaml")[0] == 0
    assert machine.run("greet")[0] == 2
    assert machine.run("--version") == (0, "rosorin-compile 0.3.0\n")
    monkeypatch.delenv("ROSORIN_COMPILE_PLUGINS")
    assert machine.run("all", "robot.yaml")[0] == 1
