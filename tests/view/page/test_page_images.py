"""Images of a page: what materials and meshes name is shown if it is an image, within the limit, and nothing else."""

from __future__ import annotations

import os
from base64 import b64decode
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.viewer.page import data_of
from rosorin_compile.viewer.page.images import companion_files
from support.commands import Shown, write_files
from support.schemas import schema

VALID = jsonschema.Draft7Validator(schema("page"))
PNG = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108020000009077"
    "53de0000000c49444154789c63f8cfc0000003010100c9fe92ef0000000049454e44ae426082"
)
ROBOT = """\
robot: r
links:
  base: {visual: [{box: {size: [1, 1, 1]}, texture: images/wood.png}]}
  arm: {visual: [{mesh: {file: meshes/arm.obj}}]}
joints: {j: {type: fixed, parent: base, child: arm}}
outputs: {page: {file: r.html}, urdf: {file: r.urdf}}
"""
OBJ = "mtllib arm.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"
MTL = "newmtl a\nKd 1 0 0\nmap_Kd -s 1 1 1 ../images/skin.png\n"


@pytest.fixture
def robot(home: Path) -> Path:
    """A robot with an image on a box, and a mesh with materials and an image."""
    files = {"robot.yaml": ROBOT, "meshes/arm.obj": OBJ, "meshes/arm.mtl": MTL}
    write_files(home, {f"descriptions/r/{name}": text for name, text in files.items()})
    folder = home / "descriptions/r"
    (folder / "images").mkdir()
    for name in ("wood", "skin"):
        (folder / f"images/{name}.png").write_bytes(PNG)
    return folder


def page(file: str) -> Any:
    data = data_of(Path(file).read_text("utf-8"))
    VALID.validate(data)
    return data["robot"]


def texture(robot: Any) -> Any:
    return next(link["visual"][0]["texture"] for link in robot["links"] if link["name"] == "base")


@pytest.mark.parametrize("way", ["view", "all"])
def test_images_are_in_the_page(robot: Path, capsys: Shown, way: str) -> None:
    if way == "view":
        assert main(["view", "r", "--html", "r.html"]) == 0
    else:
        assert main(["all"]) == 0
        assert main(["check"]) == 0
    shown = page("r.html" if way == "view" else "outputs/r/r.html")
    assert texture(shown) == "images/wood.png"
    wood = shown["textures"]["images/wood.png"]
    assert (wood["type"], b64decode(wood["data"])) == ("image/png", PNG)
    files = shown["meshes"]["meshes/arm.obj"]["files"]
    assert {name: file["type"] for name, file in files.items()} == {
        "arm.mtl": "text/plain",
        "../images/skin.png": "image/png",
    }
    assert str(robot) not in str(shown)
    assert "not shown" not in capsys.readouterr().err


def test_an_image_of_a_material_is_that_of_its_visuals(robot: Path) -> None:
    text = ROBOT.replace("texture: images/wood.png", "material: wood")
    (robot / "robot.yaml").write_text(text + "materials: {wood: {texture: images/wood.png}}\n")
    assert main(["view", "r", "--html", "r.html"]) == 0
    assert texture(page("r.html")) == "images/wood.png"


def test_what_is_no_image_is_not_in_it(robot: Path, capsys: Shown) -> None:
    """A mesh of somebody else names a file that it must not bring out."""
    secret = robot / "images/secret.png"
    secret.write_text("secret")
    (robot / "meshes/arm.mtl").write_text("newmtl a\nmap_Kd ../images/secret.png\n")
    (robot / "images/wood.png").write_text("secret")
    assert main(["view", "r", "--html", "r.html"]) == 0
    shown = page("r.html")
    assert list(shown["meshes"]["meshes/arm.obj"]["files"]) == ["arm.mtl"]
    assert shown["textures"] == {"images/wood.png": {"missing": "no browser reads it"}}
    told = capsys.readouterr()
    assert "not shown: 2 textures (secret.png, images/wood.png)" in told.out + told.err


def test_images_count_for_the_limit(robot: Path, capsys: Shown) -> None:
    (robot / "images/wood.png").write_bytes(PNG + bytes(10_000))
    assert main(["view", "r", "--html", "r.html", "--max-megabytes", "0.005"]) == 0
    assert page("r.html")["textures"] == {"images/wood.png": {"missing": "more than 0.005 MB of meshes"}}
    told = capsys.readouterr()
    assert "not shown: 1 texture (images/wood.png): more than 0.005 MB of meshes" in told.out + told.err
    assert main(["view", "r", "--html", "r.html", "--no-meshes"]) == 0
    assert (page("r.html")["meshes"], page("r.html")["textures"]) == ({}, {})


DAE = """<COLLADA><library_images><image id="a"><init_from>{}</init_from></image></library_images>
<library_effects><surface><init_from>a</init_from></surface></library_effects></COLLADA>"""


@pytest.mark.parametrize(
    ("name", "found", "vain"),
    [
        ("skin.png", ["skin.png"], []),
        ("sk%69n.png", ["skin.png"], []),
        ("other.png", [], ["other.png"]),
        ("C:\\\\files\\\\other.png", [], ["other.png"]),
        ("file:///etc/passwd", [], ["passwd"]),
        ("/etc/passwd", [], ["passwd"]),
    ],
)
def test_images_of_a_dae(tmp_path: Path, name: str, found: list[str], vain: list[str]) -> None:
    (tmp_path / "skin.png").write_bytes(PNG)
    sides, missing = companion_files(tmp_path / "a.dae", DAE.format(name).encode())
    assert ([side.name for side in sides], [*missing]) == (found, vain)


HOMES = [
    pytest.param("descriptions/r/m.dae", "m.dae", "images/t.png", True, id="the project"),
    pytest.param("descriptions/r/m.dae", "m.dae", "../private/t.png", False, id="beside the project"),
    pytest.param("robot/meshes/m.dae", "../meshes/m.dae", "robot/textures/t.png", True, id="of a URDF"),
    pytest.param("robot/meshes/m.dae", "../meshes/m.dae", "t.png", False, id="outside of a URDF"),
    pytest.param("robot/meshes/m.dae", "package://robot/meshes/m.dae", "robot/t.png", True, id="in a package"),
    pytest.param("robot/meshes/m.dae", "package://robot/meshes/m.dae", "t.png", False, id="outside of a package"),
    pytest.param("arm/share/deep/m.dae", "m.dae", "arm/t.png", True, id="by its package.xml"),
    pytest.param("robot/m.dae", "/robot/m.dae", "t.png", False, id="a whole path"),
]


@pytest.mark.parametrize(("mesh", "name", "image", "inside"), HOMES)
def test_an_image_is_in_the_project_of_its_mesh(tmp_path: Path, mesh: str, name: str, image: str, inside: bool) -> None:
    top = tmp_path / "top"
    for file in (top / mesh, top / image, top / "arm" / "package.xml"):
        file.parent.mkdir(parents=True, exist_ok=True)
    (top / "arm" / "package.xml").write_text("<package><name>arm</name></package>", "utf-8")
    (top / image).write_bytes(PNG)
    asked = os.path.relpath(top / image, (top / mesh).parent)
    dae, obj = DAE.format(asked).encode(), f"mtllib {asked}.mtl\n".encode()
    (top / f"{image}.mtl").write_text("newmtl a\nmap_Kd t.png\n", "utf-8")
    assert len(companion_files(top / mesh, dae, name)[0]) == inside
    assert len(companion_files((top / mesh).with_suffix(".obj"), obj, name.replace(".dae", ".obj"))[0]) == inside
    vain = companion_files(top / mesh, dae, name)[1]
    assert vain == ({} if inside else {"t.png": "a mesh names it outside of the project"})


def test_a_link_leads_to_no_image_outside(tmp_path: Path) -> None:
    """A folder that ``colcon build --symlink-install`` made is one of links, to files of the source."""
    source, installed, private = tmp_path / "src", tmp_path / "install", tmp_path / "private"
    for folder in (source, installed, private):
        (folder / "meshes").mkdir(parents=True)
    (source / "package.xml").write_text("<package><name>arm</name></package>", "utf-8")
    (source / "meshes/t.png").write_bytes(PNG)
    (private / "t.png").write_bytes(PNG)
    (source / "meshes/m.dae").write_bytes(DAE.format("t.png").encode())
    for name in ("meshes/m.dae", "meshes/t.png"):
        (installed / name).symlink_to(source / name)
    mesh, name = installed / "meshes/m.dae", "package://arm/meshes/m.dae"
    assert len(companion_files(mesh, mesh.read_bytes(), name)[0]) == 1
    (installed / "meshes/t.png").unlink()
    (installed / "meshes/t.png").symlink_to(private / "t.png")
    assert companion_files(mesh, mesh.read_bytes(), name)[0] == []
