"""An imported MJCF has its files: the next line that import says makes an MJCF with all meshes, textures and skins.

What is written is what was proven, and what is not there any more is never left out in silence.
"""

import re
import shlex
import struct
import zlib
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.mujoco.mjcf import process
from support.commands import Shown
from support.paths import data_text

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.slow

CORNER = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
# What has a file stands in: its folders by <compiler>, from the file, included from a folder, named from an own folder.
WAYS = {
    "meshdir": ('meshdir="m/parts" texturedir="t"', "{m}.obj", "{t}.png", "m/parts", "t"),
    "assetdir": ('assetdir="assets"', "{m}.obj", "deep/{t}.png", "assets", "assets/deep"),
    "beside": ("", "{m}.obj", "{t}.png", ".", "."),
    "up": ('meshdir="../other/m" texturedir="../t"', "{m}.obj", "{t}.png", "../other/m", "../t"),
    "stripped": ('strippath="true" meshdir="m" texturedir="m"', "gone/{m}.obj", "gone/{t}.png", "m", "m"),
}
ROBOT = data_text("robots/import_mjcf_files.mjcf.xml")


def png() -> bytes:
    rows = b"\x00\x10\x80\x00\xc0\xff"
    chunks = ((b"IHDR", struct.pack(">IIBBBBB", 2, 2, 8, 0, 0, 0, 0)), (b"IDAT", zlib.compress(rows)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )


def skin() -> bytes:
    corners = (0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0)
    made = struct.pack("<4i", 3, 0, 1, 2) + struct.pack("<9f", *corners) + struct.pack("<3i", 0, 1, 2)
    for name in ("base", "tip"):
        made += name.encode().ljust(40, b"\0") + struct.pack("<7f", 0, 0, 0, 1, 0, 0, 0)
        made += struct.pack("<i3i3f", 3, 0, 1, 2, 0.5, 0.5, 0.5)
    return made


def write_robot(folder: Path, way: str) -> Path:
    folders, mesh, image, meshes, images = WAYS[way]
    for name, data in (("seen.obj", CORNER.encode()), ("solid.obj", CORNER.encode()), ("cover.skn", skin())):
        (folder / meshes).mkdir(parents=True, exist_ok=True)
        (folder / meshes / name).write_bytes(data)
    # A height field is looked for where meshes are, a texture where textures are.
    for place in (meshes, f"{meshes}/deep", images):
        (folder / place).mkdir(parents=True, exist_ok=True)
        (folder / place / "wood.png").write_bytes(png())
    named = {"seen": mesh.format(m="seen"), "solid": mesh.format(m="solid"), "wood": image.format(t="wood")}
    path = folder / "arm.xml"
    path.write_text(ROBOT.format(folders=folders, skin="cover.skn", **named), "utf-8")
    return path


@pytest.fixture(name="vendor")
def _vendor(home: Path) -> Path:
    folder = home.parent / f"{home.name}_of_others" / "robot"
    folder.mkdir(parents=True)
    return folder


def images(model: Any) -> set[bytes]:
    ends = [*model.tex_adr[1:].tolist(), len(model.tex_data)]
    return {model.tex_data[at:to].tobytes() for at, to in zip(model.tex_adr, ends, strict=True)}


def next_line(said: str) -> list[str]:
    (line,) = re.findall(r"(?m)^next: rosorin-compile (.*)$", said)
    return shlex.split(line)


@pytest.mark.landing("engines", "assetdir", "stripped")
@pytest.mark.parametrize("way", WAYS)
def test_the_next_line_makes_an_mjcf_with_all_files(
    way: str, vendor: Path, capsys: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, asked = write_robot(vendor, way), []
    real = process._in_child

    def watched(job: str, request: Any, seconds: int) -> Any:
        asked.extend([request["text"]] if job == "prove" else [])
        return real(job, request, seconds)

    monkeypatch.setattr(process, "_in_child", watched)
    assert main(["import", str(path)]) == 0
    said = capsys.readouterr()
    assert "MuJoCo's model of the MJCF is that of the source, in every field but its appearance" in said.out
    assert main(next_line(said.out)) == 0
    shown = capsys.readouterr()
    assert "accepted" not in said.out + said.err + shown.out + shown.err
    made = Path("outputs/arm/arm.xml")
    assert asked == [made.read_text("utf-8")], "what is written is not what was proven"
    source, ours = (mujoco.MjModel.from_xml_path(str(one)) for one in (path, made))
    for count in ("nmesh", "nskin", "nhfield", "nbody", "ngeom", "npair", "nsensor"):
        assert getattr(ours, count) == getattr(source, count), count
    assert images(source) <= images(ours)
    assert ours.hfield_data.tolist() == source.hfield_data.tolist()
    assert not re.search(r'file="(/|\.\.)', made.read_text("utf-8")), "the folder of artifacts is not complete"


def brought(vendor: Path, capsys: Shown) -> list[str]:
    assert main(["import", str(write_robot(vendor, "beside"))]) == 0
    return next_line(capsys.readouterr().out)


@pytest.mark.parametrize(
    ("gone", "message"),
    [
        ("cover.skn", "error[element-file-not-found]: file cover.skn is not there: MuJoCo does not load the MJCF"),
        ("wood.png", "error[element-file-not-found]: file wood.png is not there: MuJoCo does not load the MJCF"),
        ("solid.obj", 'error[mjcf-left-out]: a shape of link "base" is left out of the MJCF, and something names it'),
    ],
)
def test_what_the_mjcf_needs_is_an_error_where_it_is_gone(gone: str, message: str, vendor: Path, capsys: Shown) -> None:
    words = brought(vendor, capsys)
    (vendor / gone).unlink()
    assert main(words) == 1
    assert message in capsys.readouterr().err
    assert not Path("outputs").exists()


def test_what_nothing_names_is_left_out_with_a_warning(vendor: Path, capsys: Shown) -> None:
    words = brought(vendor, capsys)
    (vendor / "seen.obj").unlink()
    assert main(words) == 0
    said = capsys.readouterr()
    assert "warning[mesh-not-found]: mesh seen.obj is not there" in said.err
    assert "left out of arm.xml" in said.err
    model = mujoco.MjModel.from_xml_path("outputs/arm/arm.xml")
    assert (model.nmesh, model.npair, model.nskin) == (1, 1, 1)


def test_an_mjcf_that_mujoco_does_not_load_is_not_written(
    vendor: Path, capsys: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fault of ours is told with the words of MuJoCo, and is no success."""
    real = process._in_child

    def damaged(job: str, request: dict[str, Any], seconds: int) -> Any:
        text = request.get("text", "").replace('geom2="finger"', 'geom2="nothing"')
        return real(job, {**request, "text": text}, seconds)

    monkeypatch.setattr(process, "_in_child", damaged)
    assert main(["import", str(write_robot(vendor, "beside"))]) == 1
    said = capsys.readouterr().err
    assert "error[import-untold]" in said
    assert "MuJoCo does not load the MJCF that it becomes:" in said
    assert not Path("descriptions").exists()
