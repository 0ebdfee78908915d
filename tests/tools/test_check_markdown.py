"""check --format markdown and --summary: one run, robot by robot, whatever there is to say of each."""

import re
import struct
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.commands import Shown, edit, write_files
from support.paths import data_text

CART = """\
robot: {name}
args: {{mast: {{type: length, default: 100 mm}}, tall: {{type: boolean, default: false}}}}
links: {{base_link: {{}}, mast: {{visual: [{{box: {{size: [1, 1, 1]}}}}]}}}}
joints:
  mast_joint: {{type: fixed, parent: base_link, child: mast, xyz: [0, 0, "${{mast if not tall else 2 * mast}}"]}}
outputs: {{urdf: {{file: {name}.urdf}}, frames: {{file: frames.md}}}}
"""
NAMES = ("arm", "cart", "dog")
PROJECT = {f"descriptions/{name}/robot.yaml": CART.format(name=name) for name in NAMES}


@pytest.fixture
def committed(project: Path, capsys: Shown) -> Path:
    assert main(["all"]) == 0
    capsys.readouterr()
    return project


def told(capsys: Shown, *words: str, code: int) -> str:
    """Return the document; what else is said goes elsewhere."""
    assert main(["check", "--format", "markdown", *words]) == code
    out: str = capsys.readouterr().out
    assert out.startswith("## Robots: ")
    assert out.endswith("\n")
    assert not out.endswith("\n\n")
    return out


def of(name: str) -> Path:
    return Path("descriptions", name, "robot.yaml")


@pytest.mark.usefixtures("committed")
def test_robots_without_a_change_are_a_line_each(capsys: Shown) -> None:
    lines = [f"- `{name}`: 2 artifacts up to date in outputs/{name}\n" for name in NAMES]
    assert told(capsys, code=0) == "## Robots: no problems\n\n" + "".join(lines)


@pytest.mark.usefixtures("committed")
def test_one_that_moved_and_one_that_does_not_compile(capsys: Shown) -> None:
    edit(of("dog"), "default: 100 mm", "default: 120 mm")
    edit(of("arm"), "child: mast", "chidl: mast")
    made = told(capsys, code=1)
    assert made.startswith(
        "## Robots: 2 of 3 with problems\n\n### `arm`: 1 error\n\n|  | rule | place | message | help |\n"
    )
    assert "| error | `unknown-key` | `descriptions/arm/robot.yaml:5:" in made
    assert "### `dog`: not up to date\n\nrun rosorin-compile all to write them again\n" in made
    row = "| mast moved 20.0 mm in `base_link`: origin z 0.1 -&gt; 0.12 m | `urdf`, `frames` |"
    assert made.count(row) == 1
    assert "<details><summary><code>dog.urdf</code>: different text</summary>" in made
    assert made.endswith("</details>\n\n- `cart`: 2 artifacts up to date in outputs/cart\n")


@pytest.mark.usefixtures("committed")
def test_files_that_are_missing_too_many_damaged_or_spelt_otherwise(capsys: Shown) -> None:
    Path("outputs/arm/frames.md").unlink()
    Path("outputs/arm/|old|.urdf").touch()
    Path("outputs/cart/cart.urdf").write_bytes(b"\xff")
    Path("outputs/dog/dog.urdf").write_text(
        Path("outputs/dog/dog.urdf").read_text().replace("<link", "<!-- @me --><link")
    )
    made = told(capsys, code=1)
    assert "| `frames.md` | missing; rosorin-compile all writes it |" in made
    assert "| <code>&#124;old&#124;&#46;urdf</code> | no artifact of this robot;" in made
    assert "| `cart.urdf` | the committed file is no UTF-8 text;" in made
    assert "<details><summary><code>dog.urdf</code>: same meaning, different text</summary>" in made
    assert "| before |" not in made


@pytest.mark.usefixtures("committed")
def test_a_mesh_that_is_another_one(capsys: Shown) -> None:
    corners = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
    faces = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    triangles = [struct.pack("<12fH", 0, 0, 0, *(v for at in face for v in corners[at]), 0) for face in faces]
    mesh = bytes(80) + struct.pack("<I", len(faces)) + b"".join(triangles)
    Path("descriptions/arm/mast.stl").write_bytes(mesh)
    edit(of("arm"), "box: {size: [1, 1, 1]}", "mesh: {file: mast.stl}")
    edit(of("arm"), "frames: {file: frames.md}", "mjcf: {file: arm.xml}")
    assert main(["all", "arm", "--prune"]) == 0
    capsys.readouterr()
    Path("descriptions/arm/mast.stl").write_bytes(mesh.replace(bytes(80), b"new".ljust(80)))
    made = told(capsys, "arm", code=1)
    assert re.search(r"\| \S*mast.stl`? \| another file than the mesh is; rosorin-compile all writes it \|", made)
    assert "| before |" not in made


@pytest.mark.usefixtures("committed")
def test_deployed(capsys: Shown) -> None:
    for place in ("a", "b"):
        Path("share", place).mkdir(parents=True)
        Path("share", place, "dog.urdf").write_bytes(Path("outputs/dog/dog.urdf").read_bytes())
    words = ("deployed", "dog", "share")
    assert "- `dog`: 2 of 2 copies in share as compiled; 1 note" in told(capsys, *words, code=0)
    edit(of("dog"), "default: 100 mm", "default: 120 mm")
    made = told(capsys, *words, code=1)
    summary = "### `dog`: not as deployed\n\nrun rosorin-compile deploy to write them again\n\n0 of 2 copies in share"
    assert summary in made
    assert "| mast moved 20.0 mm in `base_link`: origin z 0.1 -&gt; 0.12 m | `a/dog.urdf`, `b/dog.urdf` |" in made
    assert "--- deployed/" in made


@pytest.mark.usefixtures("committed")
@pytest.mark.parametrize("form", ["text", "json", "github", "sarif", "markdown"])
def test_a_summary_is_the_same_document_whatever_the_form(form: str, capsys: Shown) -> None:
    edit(of("dog"), "default: 100 mm", "default: 120 mm")
    edit(of("arm"), "child: mast", "chidl: mast")
    main(["check", "--format", form])
    plain = capsys.readouterr()
    assert main(["check", "--format", form, "--summary", "summary.md"]) == 1
    assert capsys.readouterr() == plain
    made = told(capsys, code=1)
    assert Path("summary.md").read_text("utf-8") == made
    assert main(["check", "cart", "--summary", "summary.md"]) == 0
    assert Path("summary.md").read_text("utf-8").startswith(made + "## Robots: no problems\n")


@pytest.mark.usefixtures("committed")
def test_a_summary_that_cannot_be_written(capsys: Shown) -> None:
    assert main(["check", "--summary", "nowhere/summary.md"]) == 2
    assert 'cannot write the summary "nowhere/summary.md": No such file or directory' in capsys.readouterr().err


@pytest.mark.parametrize("words", [["all"], ["deploy", "dog", "-o", "."], ["package", "dog", "-o", "pkg"]])
def test_other_commands_have_the_form_too(project: Path, words: list[str], capsys: Shown) -> None:
    edit(of("dog"), "child: mast", "chidl: mast")
    main([*words, "--format", "markdown"])
    out = capsys.readouterr().out
    assert project
    assert "### `dog`: 1 error" in out


# check recognises an artifact that was edited by hand: it contradicts artifacts that are up to date.


ROBOT = data_text("robots/check_markdown.yaml")
DESCRIPTION, URDF, MJCF = "descriptions/mast/robot.yaml", "outputs/mast/mast.urdf", "outputs/mast/mast.xml"
EDITED = " was edited: it differs from the other artifacts"


@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize(
    ("file", "old", "new", "line"),
    [
        (URDF, "0 0 0.1", "0 0 0.2", f"{URDF}{EDITED}"),
        (MJCF, 'pos="0 0 0.1"', 'pos="0 0 0.2"', f"{MJCF}{EDITED}"),
        (
            DESCRIPTION,
            "100 mm",
            "120 mm",
            "mast moved 20.0 mm in base_link: origin z 0.1 -> 0.12 m: urdf, mjcf, frames",
        ),
        (DESCRIPTION, "kp: 30", "kp: 40", "mast_joint kp 30 -> 40 N*m/rad"),
        (MJCF, 'kp="30"', 'kp="40"', "mast_joint kp 40 -> 30 N*m/rad"),  # no other artifact has it
    ],
)
def test_who_changed(file: str, old: str, new: str, line: str, capsys: Shown) -> None:
    edit(Path(file), old, new)
    assert main(["check"]) == 1
    assert capsys.readouterr().out.startswith(line)


@pytest.fixture
def compiled(home: Path, capsys: Shown) -> None:
    write_files(home, {DESCRIPTION: ROBOT})
    assert main(["all"]) == 0
    capsys.readouterr()
