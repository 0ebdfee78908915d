"""Every reference in every file of a built package resolves: meshes, their materials, textures and buffers."""

import json
import re
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.paths import data_text

CORNERS = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
PNG = bytes.fromhex(
    "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c49444154789c63f8cfc0000003010100"
    "c9fe92ef0000000049454e44ae426082"
)
COLLADA = """<COLLADA version="1.4.1"><library_images><image id="i"><init_from>../textures/skin.png</init_from></image>
</library_images><library_effects><surface><init_from>i</init_from></surface></library_effects></COLLADA>"""
ROBOT = data_text("robots/package_references.yaml")


def write(folder: Path) -> None:
    for name, data in {
        "robot.yaml": ROBOT,
        "meshes/part.obj": f"mtllib part.mtl\n{CORNERS}",
        "meshes/part.mtl": "newmtl a\nKd 1 1 1\nmap_Kd -s 1 1 1 paint.png\n",
        "meshes/paint.png": PNG,
        "meshes/visual/shell.dae": COLLADA,
        "meshes/textures/skin.png": PNG,
        "meshes/box.gltf": json.dumps({"buffers": [{"uri": "box%20data.bin"}, {"uri": "data:,"}], "images": []}),
        "meshes/box data.bin": b"\0",
        "gun/meshes/grip.obj": f"mtllib grip.mtl\n{CORNERS}",
        "gun/meshes/grip.mtl": "newmtl b\n",
    }.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data if isinstance(data, bytes) else data.encode())


def dangling(package: Path, name: str) -> list[str]:
    found = []
    patterns = {
        ".urdf": r'filename="([^"]*)"',
        ".sdf": r"<(?:uri|albedo_map)>([^<]*)<",
        ".xml": r'file="([^"]*)"',
        ".obj": r"mtllib (\S+)",
        ".mtl": r"map_Kd .*?(\S+)\n",
        ".dae": r"<image[^>]*>\s*<init_from>([^<]*)<",
        ".gltf": r'"uri": "([^"]*)"',
    }
    for file in package.rglob("*"):
        pattern = patterns.get(file.suffix) if file.name != "package.xml" else None
        for reference in re.findall(pattern, file.read_text("utf-8")) if pattern else ():
            target = file.parent / reference.replace("%20", " ")
            for prefix in (f"package://{name}/", f"$(find-pkg-share {name})/"):
                if reference.startswith(prefix):
                    target = package / reference.removeprefix(prefix)
            if not reference.startswith("data:") and not target.is_file():
                found.append(f"{file.relative_to(package)}: {reference}")
    return found


@pytest.mark.parametrize("build", ["ament_cmake", "ament_python"])
def test_every_reference_of_a_package_resolves(tmp_path: Path, build: str) -> None:
    write(tmp_path / "r")
    assert main(["package", str(tmp_path / "r"), "-o", str(tmp_path / "r_description"), "--build-type", build]) == 0
    assert dangling(tmp_path / "r_description", "r_description") == []
    names = {file.name for file in (tmp_path / "r_description").rglob("*")}
    assert {"part.mtl", "paint.png", "skin.png", "box data.bin", "grip.mtl"} <= names


def test_files_that_a_mesh_names_are_copied_beside_the_artifacts(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    write(tmp_path / "r")
    (tmp_path / "r/meshes/part.mtl").write_text("newmtl a\nmap_Kd lost.png\n", "utf-8")
    main(["all", str(tmp_path / "r"), "-o", str(tmp_path / "out")])
    message = "warning[mesh-not-found]: file of a mesh lost.png is not there, and part.obj names it"
    assert message in capsys.readouterr().err
    assert dangling(tmp_path / "out", "r") == ["r.sdf: model://gun/meshes/grip.obj", "meshes/part.mtl: lost.png"]
