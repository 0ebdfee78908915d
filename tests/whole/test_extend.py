"""The package examples/rosorin-toy, installed with pip: each command with it, and errors of broken plug-ins."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support import forks
from support.pages import PACKAGES, install
from support.paths import ROOT

pytestmark = pytest.mark.slow

EXAMPLE = ROOT / "examples" / "rosorin-toy"
RIDER = "robot: rider\ninclude: [{file: doll.toy, parent: seat, xyz: [0, 0, 0.4]}]\nlinks: {seat: {}}\n"
FILES = {
    "cart/robot.yaml": (EXAMPLE / "cart.yaml").read_text("utf-8"),
    "dolls/doll.toy": (EXAMPLE / "doll.toy").read_text("utf-8"),
    "dolls/broken.toy": "robot broken\nlink body 1.5 0.2\nwheel left\n",
    "rider/robot.yaml": f"{RIDER}outputs: {{urdf: {{file: rider.urdf}}, toy: {{file: rider.toy}}}}\n",
}
PLAIN = "robot: plain\nlinks: {base: {}, tip: {}}\njoints: {j: {type: fixed, parent: base, child: tip}}\n"
URDF = (
    '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/>'
)
URDF += "</joint></robot>\n"
WHO = "the plug-in rosorin-toy 1.0 (rosorin_compile.formats: toy = toy_robot.toy:FORMAT)"


class Machine:
    def __init__(self, folder: Path, packages: Path) -> None:
        self.folder = folder
        self.packages = folder / PACKAGES
        shutil.copytree(packages, self.packages)
        for name, text in FILES.items():
            self.write(name, text)
        self.write("plain/robot.yaml", f"{PLAIN}outputs: {{toy: {{file: plain.toy}}, urdf: {{file: plain.urdf}}}}\n")
        self.write("arm.urdf", URDF)

    def write(self, name: str, text: str) -> None:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")

    def read(self, name: str) -> str:
        return (self.folder / name).read_text("utf-8")

    def change(self, *pairs: tuple[str, str]) -> None:
        path = self.packages / "toy_robot" / "toy.py"
        text = path.read_text("utf-8")
        for old, new in pairs:
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        path.write_text(text, "utf-8")

    def record(self, *fields: str, before: str = "") -> None:
        text = before + "FORMAT = dataclasses.replace(FORMAT, " + ", ".join(fields) + ")\n"
        path = self.packages / "toy_robot" / "toy.py"
        path.write_text(f"{path.read_text('utf-8')}\nimport dataclasses\n\n{text}", "utf-8")

    @property
    def environment(self) -> dict[str, str]:
        own = {"PYTHONPATH": str(self.packages), "ROSORIN_COMPILE_CACHE": str(self.folder / ".cache")}
        return {**os.environ, **own, "PYTHONDONTWRITEBYTECODE": "1"}

    def run(self, *words: str, code: int | None = None) -> str:
        """Return what a command prints; it ends with ``code``, and never with a traceback."""
        ended, printed = forks.run(words, self.folder, self.environment)
        assert "Traceback" not in printed, printed
        assert code in (None, ended), printed
        return printed


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("example")
    shutil.copytree(EXAMPLE, folder / "rosorin-toy")
    assert install("./rosorin-toy", folder) == ("", 0)
    return folder / PACKAGES


@pytest.fixture
def machine(tmp_path: Path, packages: Path) -> Machine:
    return Machine(tmp_path, packages)


def test_it_is_listed_and_the_schema_is_as_it_was(machine: Machine):
    assert machine.run("--version", code=0).splitlines()[1:] == [
        "plug-in rosorin-toy 1.0 (checks, commands, formats, functions, rules)"
    ]
    with_it = machine.run("schema", code=0)
    shutil.rmtree(machine.packages)
    assert machine.run("schema", code=0) == with_it
    assert '"toy"' not in with_it
    assert 'there is no backend "toy"' in machine.run("all", "plain", code=1)


def test_the_command_and_the_check(machine: Machine):
    assert machine.run("balls", "cart", code=0).startswith("cart: ball, radius 0.04 m, 2.09 kg\n")
    answer = json.loads(machine.run("balls", "cart", "--format", "json", code=0))
    assert [one["link"] for one in answer["result"]] == ["ball", "base"]
    assert answer["command"] == "balls"
    assert "the balls weigh 4.09 kg, more than the limit of 4 kg" in machine.run("check", "parcel", "cart", code=1)
    assert machine.run("check", "parcel", "cart", "--most", "5", code=0) == "cart: 4.09 kg, within the limit\n"


def test_all_and_check(machine: Machine):
    machine.run("all", "cart", code=0)
    assert "2 artifacts up to date" in machine.run("check", "cart", code=0)
    text = machine.read("outputs/cart/cart.toy")
    machine.write("outputs/cart/cart.toy", text.replace("2.000000", "2.500000").replace("0.785398", "0.700000"))
    printed = machine.run("check", "cart", code=1)
    assert "outputs/cart/cart.toy was edited: it differs from the other artifacts" in printed
    assert "pole turned" in printed or "pole yaw" in printed or "mast" in printed
    machine.write("outputs/cart/cart.toy", text.replace("joint axle", "joint"))
    assert "the committed file is damaged and compared as text alone" in machine.run("check", "cart", code=1)
    machine.write("outputs/cart/cart.toy", f"{text}# a word more\n")
    assert "cart.toy: same meaning" not in machine.run("check", "cart", code=1)  # it has no syntax to tell by


@pytest.mark.parametrize("words", ["all", "check", "check --every-argument", "package -o new", "deploy -o mine"])
def test_it_is_held_against_the_other_artifacts_before_it_is_used(machine: Machine, words: str):
    machine.run("all", "cart", code=0)
    before = machine.read("outputs/cart/cart.toy")
    machine.change(("[*joint.origin.xyz,", "[0.25, *joint.origin.xyz[1:],"))
    machine.write("mine/package.xml", '<package format="3"><name>mine</name><version>1.0.0</version></package>\n')
    printed = machine.run(*words.split(), "cart", code=1)
    assert "error[artifacts-disagree]: cart.toy is not as it is meant to be: ball moved 250.0 mm in base" in printed
    assert machine.read("outputs/cart/cart.toy") == before
    assert not (machine.folder / "new").exists()
    assert not (machine.folder / "mine/toy").exists()


def test_a_format_that_cannot_be_read_is_compared_as_text(machine: Machine):
    machine.record("view=None, read=None")
    machine.run("all", "cart", code=0)
    assert "up to date" in machine.run("check", "cart", code=0)
    text = machine.read("outputs/cart/cart.toy")
    machine.write("outputs/cart/cart.toy", text.replace("0.150000", "0.160000"))
    printed = machine.run("check", "cart", code=1)
    assert "--- committed/cart.toy\n+++ compiled/cart.toy\n" in printed
    assert "\n-joint axle fixed base ball 0.000000 0.160000" in printed
    assert "\n+joint axle fixed base ball 0.000000 0.150000" in printed
    assert "moved" not in printed


def test_the_other_commands_on_such_a_file(machine: Machine):
    machine.run("import", "dolls/doll.toy", code=0)
    assert "type: fixed" in machine.read("descriptions/doll/robot.yaml")
    assert "rpy: [0, 0, 90 deg]" in machine.read("descriptions/doll/robot.yaml")
    machine.run("diff", "dolls/doll.toy", "doll", code=0)
    machine.write("dolls/other.toy", machine.read("dolls/doll.toy").replace("0.3", "0.4"))
    assert "head moved 100.0 mm" in machine.run("diff", "dolls/doll.toy", "dolls/other.toy", code=1)
    assert "head" in machine.run("frames", "dolls/doll.toy", code=0)
    assert "0.3" in machine.run("tf", "dolls/doll.toy", "body", "head", code=0)
    code = (
        "import rosorin_compile as r; print(r.read('dolls/doll.toy')); print(*r.read('dolls/broken.toy').diagnostics)"
    )
    command = [sys.executable, "-c", code]
    ran = subprocess.run(
        command, cwd=machine.folder, env=machine.environment, check=False, capture_output=True, text=True
    )
    printed = ran.stdout + ran.stderr
    assert "Traceback" not in printed, printed
    assert "<Reading <Robot doll: 2 links, 1 joint" in printed
    assert 'dolls/broken.toy:3:1: error[file-syntax]: unknown line "wheel"' in printed


def test_include(machine: Machine):
    machine.write("rider/doll.toy", machine.read("dolls/doll.toy"))
    machine.run("all", "rider", code=0)
    assert "joint neck fixed body head 0.000000 0.000000 0.300000" in machine.read("outputs/rider/rider.toy")
    machine.write("rider/doll.toy", machine.read("dolls/broken.toy"))
    printed = machine.run("all", "rider", code=1)
    assert "rider/doll.toy:3:1: error[file-syntax]" in printed
    assert "included here" in printed


def test_package_deploy_and_verify(machine: Machine):
    machine.run("all", "cart", code=0)
    machine.run("package", "cart", "-o", "cart_description", code=0)
    assert machine.read("cart_description/toy/cart.toy") == machine.read("outputs/cart/cart.toy")
    assert "config doc launch meshes mjcf rviz sdf srdf toy urdf" in machine.read("cart_description/CMakeLists.txt")
    machine.write("mine/package.xml", '<package format="3"><name>mine</name><version>1.0.0</version></package>\n')
    assert "toy/cart.toy" in machine.run("deploy", "cart", "-o", "mine", code=0)
    machine.write("mine/toy/cart.toy", machine.read("mine/toy/cart.toy").replace("0.500000", "0.600000"))
    assert "toy/cart.toy" in machine.run("check", "deployed", "cart", "mine", code=1)
    echo = "At time 0.0\n- Translation: [0.000, 0.000, {}]\n"
    echo += "- Rotation: in Quaternion (xyzw) [0.000, 0.000, 0.383, 0.924]\n"
    asked = ("--frames", "base", "mast")
    for height, code in (("0.500", 0), ("0.600", 1)):
        machine.write("echo.txt", echo.format(height))
        machine.run("verify", "cart", "echo.txt", *asked, code=code)
        machine.run("verify", "outputs/cart/cart.toy", "echo.txt", *asked, code=code)


def test_a_format_that_has_no_folder_is_deployed_by_its_ending(machine: Machine):
    machine.record("folder=''")
    machine.write("mine/package.xml", '<package format="3"><name>mine</name><version>1.0.0</version></package>\n')
    machine.run("deploy", "plain", "-o", "mine", code=0)
    assert (machine.folder / "mine" / "config" / "plain.toy").is_file()


def test_the_rules_of_a_format(machine: Machine):
    assert "cannot express a link that is not a ball" in machine.run("rule", "toy-cannot-say", code=0)
    machine.write(
        "box.yaml", "robot: b\nlinks: {a: {collision: [{box: {size: [1, 1, 1]}}]}}\noutputs: {toy: {file: b.toy}}\n"
    )
    printed = machine.run("all", "box.yaml", code=0)
    assert "box.yaml:3:11: warning[toy-cannot-say]: link a is not a ball: written without mass and shape" in printed


def test_options(machine: Machine):
    def told(options: str) -> str:
        machine.write("plain/robot.yaml", f"{PLAIN}outputs: {{toy: {{file: plain.toy, {options}}}}}\n")
        return machine.run("all", "plain", code=1)

    assert 'plain/robot.yaml:4:42: error[wrong-value]: output "toy" angles cannot be "dge"' in told("angles: dge")
    assert 'did you mean "deg"? (one of rad, deg)' in told("angles: dge")
    assert 'plain/robot.yaml:4:42: error[wrong-value]: output "toy" digits is 0, less than 1' in told("digits: 0")
    assert 'output "toy" digits is 16, more than 15' in told("digits: 16")
    assert 'output "toy" digits is a whole number, not the text "few"' in told("digits: few")
    assert 'plain/robot.yaml:4:34: error[unknown-option]: the backend "toy" has no option "digts"' in told("digts: 3")
    assert 'did you mean "digits"?' in told("digts: 3")


def test_templates_of_the_package(machine: Machine):
    template = machine.packages / "toy_robot" / "templates" / "robot.toy.jinja"
    text = template.read_text("utf-8")
    machine.run("all", "plain", code=0)
    template.write_text(text.replace("angles", "# changed\nangles"), "utf-8")
    assert "written: plain.toy" in machine.run("all", "plain", code=0)  # though nothing else did
    template.write_text(text.replace("robot.name", "robot.nam"), "utf-8")
    assert "toy_robot/templates/robot.toy.jinja:1:1: error[template-failed]: a Robot has no attribute 'nam'" in (
        machine.run("all", "plain", code=1)
    )
    template.unlink()
    printed = machine.run("all", "plain", code=1)
    assert "there is no template robot.toy.jinja in the package toy_robot" in printed


LEGO = """
def read(opened):
    links = {one.get("name"): opened.at({}, one.span) for one in opened.xml.root.children if one.tag == "brick"}
    told = [opened.left_out(f"<{one.tag}>", one.span) for one in opened.xml.root.children if one.tag != "brick"]
    return {"robot": opened.options.arguments.get("name", "lego"), "links": links}, told


FORMAT = Format(name="toy", word="Lego", roots=("lego",), endings=(".lego",), load=read, takes_arguments=True)
"""


def test_a_format_in_xml_that_takes_arguments(machine: Machine):
    machine.record(before=LEGO)
    machine.write("a.lego", '<lego>\n<brick name="red"/>\n  <glue/>\n</lego>\n')
    printed = machine.run("import", "a.lego", "name:=tower", code=0)
    assert "a.lego:3:4: warning[import-cannot-carry]: <glue> is not carried over" in printed
    assert "descriptions/tower: 1 link" in printed
    assert "not carried over: 1, see the warning above" in printed
    machine.write(
        "tower.yaml", "robot: t\ninclude: [{file: a.lego, args: {name: b}}]\noutputs: {urdf: {file: t.urdf}}\n"
    )
    machine.run("all", "tower.yaml", code=0)
    machine.write("a.lego", '<lego>\n<brick name="re&lt;d"/>\n</lego>\n')
    assert "a.lego:2:2: error[bad-name]" in machine.run("import", "a.lego", code=1)
    assert "a.xml:1:2: error[wrong-root]: the root element is <duplo>" in (
        machine.write("a.xml", "<duplo/>") or machine.run("import", "a.xml", code=1)
    )


def test_an_output_that_an_imported_robot_has(machine: Machine):
    machine.record("asked=lambda tree, version, name: {'file': f'{name}.toy'}")
    machine.run("import", "dolls/doll.toy", code=0)
    assert "toy: {file: doll.toy}" in machine.read("descriptions/doll/robot.yaml")
    machine.run("all", "doll", code=0)


WRITE = "def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:\n"
CONTENTS = '    """Return what an artifact contains. Raises ValueError if it is damaged."""\n'
END = "    return templates.package("
# A change of the module, and what is said of it by ``all``.
WRITTEN = {
    "import raises": (
        ("import math\n", "import math\nraise OSError('no disk')\n"),
        "cannot be loaded: OSError: no disk",
    ),
    "no format": (("\nFORMAT = Format(", "\nFORMAT = dict("), "it is of type dict, not a Format of rosorin_compile"),
    "write raises": ((WRITE, f"{WRITE}    1 / 0\n"), "fails: ZeroDivisionError: division by zero"),
    "write leaves": ((WRITE, f"{WRITE}    raise SystemExit(3)\n"), "fails: SystemExit: 3"),
    "write gives nothing": ((END, f"    return None\n{END}"), "fails: TypeError"),
    "write gives bytes": (
        (END, f"    return b'', []\n{END}"),
        "write gives a text and diagnostics, and this text is of",
    ),
    "write tells text": ((END, f"    return '', ['oh']\n{END}"), "a Diagnostic is expected, not 'oh'"),
    "read raises": ((CONTENTS, f"{CONTENTS}    return {{}}[0]\n"), "fails: KeyError: 0"),
    "read refuses": ((CONTENTS, f"{CONTENTS}    raise ValueError('damaged')\n"), "fails: ValueError: damaged"),
    "read gives a list": ((CONTENTS, f"{CONTENTS}    return [1]\n"), "view and read return a dataclass"),
    "no package of templates": (('package("toy_robot")', 'package("toys")'), "No module named 'toys'"),
}
# Fields of the record.
RECORDS = {
    "check=lambda case, output: 1 / 0": "fails: ZeroDivisionError",
    "check=lambda case, output: ['oh']": "a Diagnostic is expected, not 'oh'",
    "options={'digits': {'type': 'nmber'}}": "cannot be loaded: ",
    "options=['digits']": "options of its format is \"['digits']\"",
    "endings='.toy'": "endings of its format is '.toy'",
    "endings=('.Toy',)": "what is read ends like .toy, in small letters, not .Toy",
    "word=3": "word of its format is '3'",
    "name='Toy'": '"Toy" cannot be the name of a format',
    "load=None, write=None": "toy is neither written nor loaded",
    "becomes='lego'": 'becomes is "lego", which is no format',
    "schema='lego'": 'schema is "lego", which is none of those that ship with the tool',
    "unsupported=('links.*.inertial',)": "unsupported of its format is",
    "rules=('toy-cannot-say',)": "rules of its format is",
}
# What is noticed when somebody compares.
COMPARED = {
    "view=lambda robot, output: 1 / 0": "fails: ZeroDivisionError",
    "view=lambda robot, output: 3": "view and read return a dataclass",
}
READ = '    """Return the description that a file contains, as plain YAML values."""\n'
READINGS = {
    "raise OSError('gone')": "fails: OSError: gone",
    "return None": "a reader gives a description, not NoneType",
    "return [3]": "a reader gives a description, not list",
    "return {1: 2}": "the description has a key that is no text: 1",
    "return {'links': {'a': object()}}": 'link "a" is of the type object, which no description holds',
    "return {'links': {}}, ['oh']": "a Diagnostic is expected, not 'oh'",
    "a = {}; a['links'] = a; return a": "nested deeper than",
}


@pytest.mark.parametrize("case", WRITTEN)
def test_a_broken_writer_is_told_and_nothing_is_written(machine: Machine, case: str):
    change, words = WRITTEN[case]
    machine.change(change)
    _refused(machine, words)


@pytest.mark.parametrize("fields", RECORDS)
def test_a_broken_record_is_told(machine: Machine, fields: str):
    machine.record(fields)
    _refused(machine, RECORDS[fields])


def _refused(machine: Machine, words: str) -> None:
    printed = machine.run("all", "plain", code=1)
    assert f"error[plugin-broken]: {WHO} " in printed
    assert words in printed
    assert "upgrade it, or pip uninstall rosorin-toy" in printed
    assert not (machine.folder / "outputs").exists()
    assert "the same robot" in machine.run("diff", "arm.urdf", "arm.urdf", code=0)


@pytest.mark.parametrize("fields", COMPARED)
def test_a_record_that_fails_when_it_is_compared(machine: Machine, fields: str):
    machine.run("all", "plain", code=0)
    machine.record(fields)
    machine.write("outputs/plain/plain.toy", machine.read("outputs/plain/plain.toy").replace("0.000000", "0.100000"))
    printed = machine.run("check", "plain", code=1)
    assert f"error[plugin-broken]: {WHO} " in printed
    assert COMPARED[fields] in printed


@pytest.mark.parametrize("body", READINGS)
def test_a_broken_reader_is_told(machine: Machine, body: str):
    machine.change((READ, f"{READ}    {body}\n"))
    for words in (("import", "dolls/doll.toy"), ("diff", "dolls/doll.toy", "plain"), ("frames", "dolls/doll.toy")):
        printed = machine.run(*words, code=1)
        assert f"error[plugin-broken]: {WHO} fails: " in printed
        assert READINGS[body] in printed
    assert not (machine.folder / "descriptions").exists()


def test_a_file_that_a_broken_plugin_would_read(machine: Machine):
    machine.record("word=3")
    printed = machine.run("import", "dolls/doll.toy", code=1)
    assert "error[wrong-format]: dolls/doll.toy is not XML" in printed
    assert f"error[plugin-broken]: {WHO} cannot be loaded" in printed


@pytest.mark.parametrize(
    ("fields", "name"),
    [
        ("name='urdf'", "urdf"),
        ("endings=('.json',)", ".json"),
        ("endings=('.urdf',)", ".urdf"),
        ("endings=('.yaml',)", ".yaml"),
        ("roots=('robot',)", "<robot>"),
        ("rules=(Rule('axis-zero', 'It is zero.'),)", "axis-zero"),
    ],
)
def test_it_cannot_take_what_is_built_in(machine: Machine, fields: str, name: str):
    machine.record(fields)
    printed = machine.run("all", "plain", code=1)
    assert f'error[plugin-clash]: {WHO} brings "{name}", which is built in' in printed
    assert "the same robot" in machine.run("diff", "arm.urdf", "arm.urdf", code=0)
    machine.write("small.yaml", f"{PLAIN}outputs: {{urdf: {{file: plain.urdf}}}}\n")
    shutil.rmtree(machine.packages)
    machine.run("all", "small.yaml", code=0)


def test_it_does_not_come_before_what_is_built_in(machine: Machine):
    machine.record("rank=-1", "feeds=('robot_state_publisher',)", "recognises=lambda document, path: True")
    assert "the compiled URDF is the same robot" in machine.run("import", "arm.urdf", code=0)
    assert "A: arm.urdf (URDF of r, 2 links" in machine.run("diff", "arm.urdf", "arm.urdf", code=0)


def test_two_packages_with_one_ending(machine: Machine):
    other = machine.packages / "other_toy-2.dist-info"
    other.mkdir()
    (other / "METADATA").write_text("Metadata-Version: 2.1\nName: other-toy\nVersion: 2\n", "utf-8")
    (other / "entry_points.txt").write_text("[rosorin_compile.formats]\nother = other_toy:FORMAT\n", "utf-8")
    code = "from rosorin_compile.extend import Format\n"
    code += "FORMAT = Format(name='other', word='Other', endings=('.toy',), load=print)\n"
    (machine.packages / "other_toy.py").write_text(code, "utf-8")
    printed = machine.run("all", "plain", code=1)
    assert (
        'rosorin-toy 1.0 (rosorin_compile.formats: toy = toy_robot.toy:FORMAT) brings ".toy", which the plug-in other'
        in (printed)
    )


def _rule(body: str, head: str = '@rule("ball-too-heavy", "It is too heavy.")') -> str:
    top = "from rosorin_compile.extend import Case, Diagnostic, function, rule\n\n\n"
    text = f'{top}@function("ball_mass", "x")\ndef ball_mass(radius, density):\n    return 1\n\n\n'
    return f"{text}{head}\ndef light_enough(case):\n    print('a forgotten print')\n    {body}\n"


def _yields(words: str) -> str:
    return _rule(f'yield Diagnostic("ball-too-heavy", {words})')


# What the module of the rule is, and what is said of it.
RULES = {
    "another severity": (_yields('"fatal", "oh"'), "the severity of ball-too-heavy is error, warning or note"),
    "a message that is no text": (_yields('"error", 3'), "message of a Diagnostic is a str, not '3'"),
    "a line for a place": (_yields('"error", "oh", 7'), "the place of a Diagnostic is a Span"),
    "related texts": (_yields('"error", "oh", None, ("here",)'), "related of a Diagnostic is a tuple of Related"),
    "numbers that are none": (_yields('"error", "oh", numbers=((1,),)'), "element #0 has length 1; 2 is required"),
    "a text": (_rule('yield "oh"'), "yields oh, no Diagnostic of its rules (ball-too-heavy)"),
    "a rule of others": (_yields('"error", "oh"').replace('ic("ball', 'ic("a'), "no Diagnostic of its rules"),
    "nothing": (_rule("return None"), "fails: TypeError: 'NoneType' object is not iterable"),
    "ends the program": (_rule("raise SystemExit(3)"), "fails: SystemExit: 3"),
    "a problem without text": (
        _rule("raise type('Odd', (Exception,), {'__str__': lambda self: 1 / 0})"),
        "(rosorin_compile.rules: balls = toy_robot.balls:light_enough) fails: Odd\n",
    ),
    "no rule": (_rule("yield None", ""), "it is of type function, not a Check of rosorin_compile"),
    "an id that is none": (
        _rule("yield None", '@rule("Too Heavy", "x")'),
        'the rule "Too Heavy" is invalid: its id has small',
    ),
    "what it accepts": (_rule("yield None", '@rule("a-b", "x", accept="leg")'), 'the rule "a-b" is invalid: its id'),
    "no module": ("raise ImportError('no such thing')\n", "cannot be loaded: ImportError: no such thing"),
    "no text of Python": ("def (:\n", "cannot be loaded: SyntaxError"),
}


@pytest.mark.parametrize("case", RULES)
def test_a_broken_rule_is_told_in_one_sentence(machine: Machine, case: str):
    text, words = RULES[case]
    machine.write(f"{PACKAGES}/toy_robot/balls.py", text)
    who = "error[plugin-broken]: the plug-in rosorin-toy 1.0 (rosorin_compile.rules: "
    printed = machine.run("all", "plain", code=1)
    assert who in printed
    assert words in printed
    machine.run("rule", "ball-too-heavy")
    machine.run("rule")


def test_a_rule_that_is_alone_and_says_nothing_of_an_order(machine: Machine):
    machine.write(f"{PACKAGES}/toy_robot/balls.py", _yields('"note", "oh"'))
    assert "note[ball-too-heavy]: oh" in machine.run("all", "plain", "--notes", code=0)


FUNCTIONS = {
    "raises": ("raise RuntimeError('oh')", "ball_mass() of rosorin-toy 1.0 fails: RuntimeError: oh"),
    "ends the program": ("raise SystemExit(3)", "ball_mass() of rosorin-toy 1.0 fails: SystemExit: 3"),
    "gives no number": ("return [float('nan')]", "not a finite number"),
    "gives an object": ("return object()", "ball_mass() of rosorin-toy 1.0 gives what is no value: object"),
}


@pytest.mark.parametrize("case", FUNCTIONS)
def test_a_broken_function_is_told_at_its_place(machine: Machine, case: str):
    body, words = FUNCTIONS[case]
    text = _rule("return []").replace("return 1\n", f"{body}\n")
    machine.write(f"{PACKAGES}/toy_robot/balls.py", text)
    printed = machine.run("all", "cart", code=1)
    assert "cart/robot.yaml:5:" in printed
    assert words in printed


def test_what_a_plugin_prints_is_in_no_artifact(machine: Machine):
    """Neither what it prints when it is imported, nor what each of its functions prints."""
    module = machine.packages / "toy_robot" / "toy.py"
    text = module.read_text("utf-8").replace("    return", "    print('FORGOTTEN')\n    return")
    module.write_text(text.replace("import math\n", "import math\nprint('FORGOTTEN')\n", 1), "utf-8")
    text = _rule("return []").replace("    return 1", "    print('FORGOTTEN')\n    return 2")
    machine.write(f"{PACKAGES}/toy_robot/balls.py", text.replace("a forgotten print", "FORGOTTEN"))
    environment = {**os.environ, "PYTHONPATH": str(machine.packages), "ROSORIN_COMPILE_CACHE": "off"}
    for words, first in (
        (("print", "cart", "toy"), "# Generated"),
        (("print", "cart", "urdf"), "<?xml"),
        (("frames", "dolls/doll.toy", "--format", "json"), "{"),
        (("check", "plain", "--format", "json"), "{"),
    ):
        done = subprocess.run(
            [sys.executable, "-m", "rosorin_compile", *words],
            cwd=machine.folder, env=environment, check=False, capture_output=True, text=True,
        )  # fmt: skip
        assert done.stdout.startswith(first), done.stdout[:100]
        assert "FORGOTTEN" not in done.stdout
        assert "FORGOTTEN" in done.stderr
