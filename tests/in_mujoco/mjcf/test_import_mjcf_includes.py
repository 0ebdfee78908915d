"""Files that include files are found as MuJoCo finds them: MuJoCo reads the same folder, and has the same bodies."""

import os
from pathlib import Path

import pytest
import yaml

from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.mujoco.mjcf.robot import read_mjcf
from support.paths import data_text

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.slow


def _file(*names: str) -> str:
    return f"<mujocoinclude>{''.join(f'<include file={name!r}/>' for name in names)}</mujocoinclude>"


def _main(*names: str, more: str = "") -> str:
    return _file(*names).replace("mujocoinclude", "mujoco").replace("</mujoco>", f"{more}</mujoco>")


LAYOUTS = yaml.safe_load(data_text("mjcf/includes.yaml"))


@pytest.mark.parametrize("files", LAYOUTS.values(), ids=LAYOUTS)
def test_included_files_are_found_as_mujoco_finds_them(files: dict[str, str], tmp_path: Path) -> None:
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True, parents=True)
        (tmp_path / name).write_text(text, "utf-8")
    made = read_mjcf(tmp_path / "main.xml", ReadOptions())
    try:
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "main.xml"))
    except ValueError:
        assert made.tree is None
        assert [d.rule for d in made.diagnostics if d.span] in (
            ["mjcf-refused"],
            ["include-cycle"],
            ["file-unreadable"],
        )
    else:
        assert made.tree is not None
        assert {model.body(index).name for index in range(1, model.nbody)} == set(made.tree["links"]) - {"ground"}


_OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
_MESH = '<asset><mesh name="m" file="corner.obj"/></asset>'
_SHOWN = '<worldbody><body name="base"><geom type="mesh" mesh="m"/></body></worldbody>'


def test_a_mesh_beside_an_included_file_is_named_as_seen_from_the_main_one(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "corner.obj").write_text(_OBJ, "utf-8")
    (tmp_path / "in" / "a.xml").write_text(f"<mujocoinclude>{_MESH}{_SHOWN}</mujocoinclude>", "utf-8")
    (tmp_path / "main.xml").write_text(_main("in/a.xml"), "utf-8")
    made = read_mjcf(tmp_path / "main.xml", ReadOptions())
    assert made.tree is not None
    assert made.tree["links"]["base"]["collision"][0]["mesh"] == {"file": "in/corner.obj"}
    assert [file.name for file in made.files] == ["main.xml", "a.xml", "corner.obj"]


def test_a_mesh_of_an_attached_model_is_named_as_seen_from_the_main_one(tmp_path: Path) -> None:
    (tmp_path / "in" / "assets").mkdir(parents=True)
    (tmp_path / "in" / "assets" / "corner.obj").write_text(_OBJ, "utf-8")
    inner = f'<compiler meshdir="assets"/>{_MESH}{_SHOWN}'
    (tmp_path / "in" / "arm.xml").write_text(f"<mujoco>{inner}</mujoco>", "utf-8")
    attach = '<worldbody><attach model="arm" body="base" prefix="left_"/></worldbody>'
    (tmp_path / "main.xml").write_text(
        _main(more=f'<asset><model name="arm" file="in/arm.xml"/></asset>{attach}'), "utf-8"
    )
    made = read_mjcf(tmp_path / "main.xml", ReadOptions())
    assert made.tree is not None
    assert made.tree["links"]["left_base"]["collision"][0]["mesh"] == {"file": "in/assets/corner.obj"}


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_a_mesh_that_is_no_file_is_refused_at_once(tmp_path: Path, kind: str) -> None:
    (tmp_path / "assets").mkdir()
    path = tmp_path / "assets" / "corner.obj"
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero")
    (tmp_path / "main.xml").write_text(f'<mujoco><compiler meshdir="assets"/>{_MESH}{_SHOWN}</mujoco>', "utf-8")
    (found,) = read_mjcf(tmp_path / "main.xml", ReadOptions()).diagnostics
    assert (found.rule, found.message) == ("file-unreadable", "corner.obj is not a regular file")
    assert found.span is not None
    assert (found.span.line, found.span.column) == (1, 65)
