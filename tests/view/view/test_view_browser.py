"""The page in a browser, as a person uses it: from disk and from the server; what is seen, moved, clicked and followed.

Pictures that are compared are in tests/data/pages; ``RENEW_PICTURES=1`` writes them anew. Look at them then.
"""

import json
import math
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosorin_compile.model import Robot
from support.browsing import Browser, apart, is_near, lacking
from support.commands import Shown, ask, edit
from support.paths import DATA, ROOT, ROSORIN, data_text
from support.robots import compiled, copy_of_rosorin
from support.viewing import Viewing

PICTURES = DATA / "pages"
ROBOTS = {
    "rosorin": (ROSORIN, "pose=tuck&from=iso"),
    "turtlebot3_burger": (ROOT / "examples/turtlebot3_burger/robot.yaml", "from=iso"),
    "ur5e": (ROOT / "examples/ur5e/robot.yaml", "from=iso"),
    "unitree_a1": (ROOT / "examples/unitree_a1/robot.yaml", "from=iso"),
}
PICTURED = {"width": 640, "height": 400, "light": True}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.xdist_group("browser"),
    pytest.mark.skipif(bool(lacking()), reason=lacking()),
]


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """A browser for all tests here; each opens a page of its own."""
    made = Browser(tmp_path_factory.mktemp("browser"))
    yield made
    made.close()


@pytest.fixture
def sent(home: Path, capsys: Shown) -> Path:
    ask(capsys, "view", str(ROSORIN), "--html", "robot.html")
    return home / "robot.html"


@pytest.fixture
def live(home: Path) -> Iterator[Viewing]:
    copy_of_rosorin(home)
    with Viewing(home, "--port", "0") as viewing:
        yield viewing


def kept_to_itself(browser: Browser, port: int = 0) -> None:
    own = (f"http://localhost:{port}/", "data:", "blob:") if port else ("file:///", "data:", "blob:")
    assert [url for url in browser.asked if not url.startswith(own)] == []
    assert browser.complaints == []


@pytest.mark.landing("outside", "turtlebot3_burger")
@pytest.mark.parametrize("name", ROBOTS)
def test_both_forms_look_as_they_did(browser: Browser, home: Path, capsys: Shown, name: str) -> None:
    path, asked = ROBOTS[name]
    ask(capsys, "view", str(path), "--html", "robot.html")
    meant = PICTURES / f"{name}.png"
    browser.open(f"file://{home}/robot.html#{asked}&panels=off&theme=light", **PICTURED)
    kept_to_itself(browser)
    from_disk = browser.picture(home / "disk.png")
    if os.environ.get("RENEW_PICTURES"):
        meant.write_bytes(from_disk.read_bytes())
    with Viewing(path.parent, str(path), "--port", "0") as viewing:
        browser.open(f"http://localhost:{viewing.port}/#{asked}&panels=off&theme=light", **PICTURED)
        kept_to_itself(browser, viewing.port)
        browser.wait("document.getElementById('touching').textContent !== ''")
        # A page on disk knows nothing of parts that touch: it has none in red.
        browser.evaluate("(app.view.mark({touching: new Set()}), app.stage.touch())")
        served = browser.picture(home / "served.png")
    cells = browser.cells(meant)
    for picture in (from_disk, served):
        assert is_near(cells, browser.cells(picture)), apart(cells, browser.cells(picture))


def near_model(browser: Browser, robot: Robot, state: dict[str, float]) -> None:
    for link, meant in robot.poses_in_root(state).items():
        place, rotation = browser.place(link)
        assert math.dist(place, meant.xyz) < 1e-9, link
        assert rotation[0::3] == pytest.approx(meant.rotate((1.0, 0.0, 0.0)), abs=1e-9), link


def test_a_slider_moves_the_robot_as_tf_says(browser: Browser, sent: Path, capsys: Shown) -> None:
    robot = compiled().robot
    assert robot is not None
    browser.open(f"file://{sent}")
    browser.slide("joint2", -0.5)
    value = browser.evaluate("app.state.joint2")
    assert value == pytest.approx(-0.5, abs=0.01), "the step of a slider"
    near_model(browser, robot, {"joint2": value})
    told = json.loads(
        ask(capsys, "tf", str(ROSORIN), "base_link", "link3", "--joint", f"joint2={value!r}", "--format", "json")
    )["result"]
    place = browser.evaluate("(({p}) => p)(app.kinematics.between('base_link', 'link3', app.state))")
    assert place == pytest.approx(told["translation"], abs=1e-9)
    shown = browser.evaluate("document.querySelector('[data-joint=joint2] input[type=number]').value")
    assert float(shown) == pytest.approx(math.degrees(value), abs=0.006)
    browser.evaluate("document.querySelector('[data-pose=tuck]').click()")
    tuck = next(pose for pose in robot.poses if pose.name == "tuck")
    near_model(browser, robot, dict(tuck.positions))
    browser.evaluate("document.querySelector('[data-pose=zero]').click()")
    near_model(browser, robot, {})
    kept_to_itself(browser)


def test_a_save_moves_the_robot_and_leaves_the_rest(browser: Browser, live: Viewing) -> None:
    browser.open(f"http://localhost:{live.port}/#pose=tuck")
    browser.evaluate("(app.lookFrom('side'), app.show({masses: true, frames: 'chosen'}), app.select('laser'))")
    browser.slide("joint1", 0.3)
    rounded = "(_, value) => typeof value === 'number' ? value.toFixed(9) : value"
    kept = f"JSON.stringify([app.stage.place, app.state, app.shown, app.selected], {rounded})"
    before, place = browser.evaluate(kept), browser.place("laser")
    edit(Path("descriptions/rosorin/lidar_and_imu.yaml"), "0.106748", "0.206748")
    browser.wait(f"app.places.get('laser').p[2] > {place[0][2] + 0.05}")
    assert browser.place("laser")[0][2] == pytest.approx(place[0][2] + 0.1)
    assert browser.evaluate(kept) == before
    kept_to_itself(browser, live.port)


@pytest.mark.tier("outside")
def test_parts_that_touch_are_red(browser: Browser, live: Viewing) -> None:
    browser.open(f"http://localhost:{live.port}/")
    browser.wait("document.getElementById('touching').textContent === 'no parts touch that are not adjacent'")
    browser.slide("joint2", 1.9)
    browser.slide("joint3", 1.9)
    browser.wait("document.getElementById('touching').textContent.endsWith('parts touch others, and are red')")
    assert browser.evaluate("app.touching.size") >= 2
    assert browser.evaluate("document.querySelectorAll('.row.touching').length") >= 2
    kept_to_itself(browser, live.port)


@pytest.mark.tier("outside")
def test_a_page_waits_for_a_robot_that_does_not_compile_yet(browser: Browser, home: Path) -> None:
    (home / "robot.yaml").write_text("robot: r\nlinks: {base: {}\n")
    with Viewing(home, "robot.yaml", "--port", "0") as viewing:
        browser.open(f"http://localhost:{viewing.port}/", ready=False)
        browser.wait("!document.querySelector('.problem').hidden")
        assert "robot.yaml:" in browser.evaluate("document.querySelector('.problem').innerText")
        for key in ("v", "f", "1", "Escape", "/", "h"):
            browser.ask("press", key=key)
        browser.ask("click", at=[600, 400])
        (home / "robot.yaml").write_text("robot: r\nlinks: {base: {collision: [{sphere: {radius: 0.1}}]}}\n")
        browser.wait("document.body.dataset.ready === 'yes'")
        assert browser.evaluate("document.title") == "r"
        assert browser.evaluate("document.querySelector('.problem').hidden") is True
        kept_to_itself(browser, viewing.port)


FREE = data_text("robots/view_browser_free.yaml")


@pytest.mark.tier("outside")
def test_sliders_of_planar_and_floating_joints(browser: Browser, home: Path, capsys: Shown) -> None:
    (home / "free.yaml").write_text(FREE)
    ask(capsys, "view", "free.yaml", "--html", "free.html")
    browser.open(f"file://{home}/free.html")
    browser.evaluate("app.select('drone')")
    rows = "[...document.querySelectorAll('.card tr')]"
    now = f"{rows}.find((row) => row.firstChild.textContent === 'now').lastChild.textContent"
    browser.evaluate(f"window.kept = {rows}")
    half = math.sqrt(0.5)
    browser.evaluate(f"app.move({{fly: [0.1, 0, 0.2, 0, 0, {half}, {half}], slide: [0.1, -0.1, 0.5]}})")
    assert browser.evaluate(now) == "100  0  500 mm; 0  0  90 deg"
    assert browser.evaluate(f"{rows}.every((row, index) => row === window.kept[index])"), "the card is not drawn anew"
    numbers = "[...document.querySelectorAll('[data-joint={}] input[type=number]')].map((one) => Number(one.value))"
    assert browser.evaluate(numbers.format("fly")) == [100, 0, 200, 0, 0, 90]
    assert browser.evaluate(numbers.format("slide")) == [100, -100, pytest.approx(math.degrees(0.5), abs=0.01)]
    kept_to_itself(browser)


@pytest.mark.tier("outside")
def test_images_are_on_the_parts(browser: Browser, home: Path, capsys: Shown) -> None:
    """An image of one red pixel on a box and, by its materials, on one of two parts of a mesh; from disk and served."""
    header = b"BM" + (58).to_bytes(4, "little") + bytes(4) + (54).to_bytes(4, "little") + (40).to_bytes(4, "little")
    size = (1).to_bytes(4, "little") * 2 + (1).to_bytes(2, "little") + (24).to_bytes(2, "little") + bytes(24)
    (home / "red.bmp").write_bytes(header + size + bytes([0, 0, 255, 0]))
    (home / "part.mtl").write_text("newmtl plain\nKd 0 0 1\nnewmtl image\nKd 0 0 0\nmap_Kd red.bmp\n")
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\n"
    (home / "part.obj").write_text(f"mtllib part.mtl\n{corners}usemtl plain\nf 1 2 3\nusemtl image\nf 1/1 3/1 4/1\n")
    (home / "r.yaml").write_text(
        "robot: r\nlinks: {a: {visual: [{box: {size: [1, 1, 1]}, texture: red.bmp}]},"
        " b: {visual: [{mesh: {file: part.obj}}, {mesh: {file: part.obj, scale: [1, -1, 1]}}]}}\n"
        "joints: {j: {type: fixed, parent: a, child: b, xyz: [2, 0, 0]}}\n"
    )
    ask(capsys, "view", "r.yaml", "--html", "r.html")
    looks = "app.view.pieces.map(({link, map, colour}) => [link, map?.image.width ?? 0, map ? 0 : colour.getHex()])"
    meant = [["a", 1, 0]] + [["b", 0, 0x0000FF], ["b", 1, 0]] * 2
    browser.open(f"file://{home}/r.html")
    assert sorted(browser.evaluate(looks)) == sorted(meant)
    assert browser.evaluate("app.view.group.children.length") == 5, "a mirrored mesh has its faces the other way round"
    kept_to_itself(browser)
    with Viewing(home, "r.yaml", "--port", "0") as viewing:
        browser.open(f"http://localhost:{viewing.port}/")
        assert sorted(browser.evaluate(looks)) == sorted(meant)
        kept_to_itself(browser, viewing.port)


@pytest.mark.parametrize(("width", "height"), [(390, 844), (844, 390)])
def test_a_phone_shows_the_robot_first(browser: Browser, sent: Path, width: int, height: int) -> None:
    browser.open(f"file://{sent}", width=width, height=height, touch=True)
    seen = "getComputedStyle(document.querySelector('{}')).visibility"
    assert browser.evaluate(seen.format(".side.left")) == "hidden"
    assert browser.evaluate(seen.format(".side.right")) == "hidden"
    assert browser.evaluate("document.documentElement.scrollWidth <= innerWidth")
    for side in ("left", "right"):
        assert browser.evaluate(seen.format(f".fold.{side}")) == "visible", "what opens a panel is there"
        browser.evaluate(f"document.querySelector('.fold.{side}').click()")
        assert browser.evaluate(seen.format(f".side.{side}")) == "visible"
        if height > width:
            sheet = browser.evaluate(f"document.querySelector('.side.{side}').getBoundingClientRect().top")
            canvas = browser.evaluate("document.querySelector('canvas').getBoundingClientRect().bottom")
            assert canvas <= sheet + 1, "the robot is above the panel"
        for name in ("side", "fold"):
            box = browser.evaluate(f"document.querySelector('.{name}.{side}').getBoundingClientRect().toJSON()")
            assert box["left"] >= 0
            assert box["right"] <= width
        browser.evaluate(f"document.querySelector('.fold.{side}').click()")
        assert browser.evaluate(seen.format(f".side.{side}")) == "hidden"
    browser.evaluate("app.select('laser')")
    card = browser.evaluate("document.querySelector('.card').getBoundingClientRect().height")
    assert card <= 0.45 * height, "the card leaves the robot in sight"
