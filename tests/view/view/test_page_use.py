"""The page as a new user tries it, by real clicks and keys: tree, search, numbers, links to a state, warnings."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.model import Joint, Limit, Link, Robot
from rosorin_compile.viewer.page import html
from rosorin_compile.viewer.page.data import robot_data
from support.browsing import Browser, lacking
from support.commands import Shown, ask
from support.paths import ROOT, ROSORIN, data_text
from support.robots import copy_of_rosorin
from support.viewing import Viewing

pytestmark = [
    pytest.mark.slow,
    pytest.mark.xdist_group("browser"),
    pytest.mark.skipif(bool(lacking()), reason=lacking()),
]
ROBOT = data_text("robots/page_use_robot.yaml")


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    made = Browser(tmp_path_factory.mktemp("browser"))
    yield made
    made.close()


@pytest.fixture
def rosorin(home: Path, capsys: Shown) -> str:
    ask(capsys, "view", str(ROSORIN), "--html", "robot.html")
    assert (home / "robot.html").stat().st_size <= 1_200_000
    return f"file://{home}/robot.html"


@pytest.fixture
def small(home: Path) -> str:
    (home / "small.yaml").write_text(ROBOT)
    assert main(["view", "small.yaml", "--html", "small.html"]) == 0
    return f"file://{home}/small.html"


def row(name: str) -> str:
    return f"[data-frame='{name}']"


def hidden(browser: Browser, name: str) -> bool:
    return bool(browser.evaluate(f"app.panels.tree.rows.get('{name}').hidden"))


def test_the_tree_folds_and_the_search_finds_what_is_folded(browser: Browser, rosorin: str) -> None:
    browser.open(rosorin)
    assert hidden(browser, "front_left_wheel_roller_3"), "rollers are folded under their wheel"
    assert not hidden(browser, "front_left_wheel_link")
    browser.click(f"{row('front_left_wheel_link')} .twist")
    assert not hidden(browser, "front_left_wheel_roller_3")
    browser.click(f"{row('link1')} .twist")
    assert hidden(browser, "gripper_link")
    browser.click(f"{row('laser')} .twist")
    assert browser.evaluate("app.selected") == "laser", "a leaf has nothing to fold"
    browser.ask("press", key="/")
    browser.ask("type", text="rear_right_wheel_roller_5")
    browser.ask("press", key="Enter")
    assert browser.evaluate("app.selected") == "rear_right_wheel_roller_5"
    browser.enter("input[type=search]", "gripper")
    assert browser.evaluate("app.selected") == "gripper_link"
    assert not hidden(browser, "gripper_link"), "what is chosen is unfolded"
    browser.enter("input[type=search]", "rgb")
    assert browser.evaluate("app.selected") == "rgb_camera_link", "a frame of another node is found, too"
    assert "only that one knows" in browser.evaluate("document.querySelector('.card').innerText")


def test_names_are_whole_and_the_tree_becomes_wider(browser: Browser, rosorin: str) -> None:
    browser.open(rosorin)
    cut = "[...document.querySelectorAll('.row span')].filter((one) => one.scrollWidth > one.clientWidth + 1)"
    assert browser.evaluate(f"{cut}.length") == 0
    browser.ask("drag", on=".grip", to=[470, 300])
    assert browser.evaluate("document.querySelector('.side.left').offsetWidth") == pytest.approx(470, abs=3)
    browser.ask("drag", on=".grip", to=[5, 300])
    assert browser.evaluate("document.querySelector('.side.left').offsetWidth") == 160
    assert browser.evaluate(f"{cut}.length") == 0


def test_a_number_is_held_at_its_limit_and_reset(browser: Browser, small: str) -> None:
    browser.open(small)
    box = "[data-joint=turn] input[type=number]"
    note = "document.querySelector('[data-joint=turn] .note').textContent"
    browser.enter(box, "170")
    assert browser.evaluate("app.state.turn") == pytest.approx(1.7453292519943295)
    assert browser.evaluate(note) == "the limit is 100 deg"
    browser.enter(box, "-12.25")
    assert (browser.evaluate(note), browser.evaluate(f"document.querySelector('{box}').value")) == ("", "-12.25")
    browser.click(box, 2)
    browser.ask("press", key="Backspace")
    browser.ask("press", key="Enter")
    assert browser.evaluate(f"document.querySelector('{box}').value") == "-12.25", "a double click, an empty box"
    widths = set()
    for value in (0.0, 1.2345, -0.5):
        browser.slide("turn", value)
        widths.add(browser.evaluate("document.querySelector('[data-joint=turn] input[type=range]').offsetWidth"))
    assert len(widths) == 1, "the slider stays as it is while it is dragged"
    for units in ("m, rad", "mm, deg"):
        browser.evaluate(f"app.use({{units: '{units}'}})")
        assert browser.evaluate(f"((one) => one.scrollWidth <= one.clientWidth)(document.querySelector('{box}'))")
    browser.click("[data-joint=turn] .name", 2)
    assert browser.evaluate("app.state.turn") == 0


def test_a_pose_is_copied_as_yaml(browser: Browser, small: str, home: Path) -> None:
    browser.open(small)
    browser.evaluate("navigator.clipboard.writeText = async (text) => { window.copied = text; }")
    browser.enter("[data-joint=turn] input[type=number]", "45")
    browser.click("#copy-pose")
    text = browser.evaluate("window.copied")
    assert text == "  new_pose:\n    positions:\n      turn: 0.785398163 rad\n"
    (home / "posed.yaml").write_text(f"{ROBOT}poses:\n{text}")
    assert main(["picture", "posed.yaml", "--pose", "new_pose", "-o", "posed.png", "--size", "64x64"]) == 0


@pytest.mark.parametrize("live", [False, True], ids=["file", "served"])
def test_the_address_holds_the_state_of_the_page(browser: Browser, home: Path, rosorin: str, live: bool) -> None:
    if not live:
        check_address(browser, rosorin)
        return
    copy_of_rosorin(home / "live")
    with Viewing(home / "live", "--port", "0") as viewing:
        check_address(browser, f"http://localhost:{viewing.port}/")


def check_address(browser: Browser, url: str) -> None:
    browser.open(url)
    browser.evaluate("navigator.clipboard.writeText = async (text) => { window.copied = text; }")
    browser.enter("[data-joint=joint2] input[type=number]", "-30")
    browser.click(row("laser"))
    browser.click("#show-masses")
    browser.evaluate("app.use({units: 'm, rad', theme: 'dark'})")
    browser.evaluate("app.switchMode('slam', true)")
    browser.click("#copy-link")
    browser.wait("window.copied")
    link, kept = (
        browser.evaluate("window.copied"),
        "[app.state, app.selected, app.shown, app.units, app.theme, app.modes]",
    )
    assert link.startswith(url)
    before = browser.evaluate(kept)
    browser.wait(f"window.location.href === {link!r}")
    browser.open(link)
    after = browser.evaluate(kept)
    assert after[0].pop("joint2") == pytest.approx(before[0].pop("joint2"), abs=1e-6)
    assert after == before
    assert (before[1], before[3], before[4]) == ("laser", "m, rad", "dark")


def test_another_address_is_followed_and_a_wrong_one_is_ignored(browser: Browser, small: str) -> None:
    browser.open(f"{small}#theme=foo&joints=a%25b:1")
    browser.evaluate("window.location.hash = 'joints=turn:0.5&theme=dark'")
    browser.wait("app.state.turn === 0.5 && app.theme === 'dark'")
    browser.evaluate("window.location.hash = 'select=arm'")
    browser.wait("app.selected === 'arm' && !app.state.turn && app.theme === 'auto'")
    assert browser.ask("kept")["complaints"] == []


def test_where_this_comes_from_leads_to_the_lines(browser: Browser, rosorin: str, home: Path) -> None:
    browser.open(f"{rosorin}#select=laser")
    browser.click(".chain summary")
    browser.wait("document.querySelectorAll('.chain table tr').length > 5")
    places = browser.evaluate("[...document.querySelectorAll('.chain .place')].map((one) => one.textContent)")
    assert any(place.endswith("lidar_and_imu.yaml:25") for place in places)
    assert "x 0, y 0, z 1, w 0" in browser.evaluate("document.querySelector('.chain').textContent")
    copy_of_rosorin(home / "live")
    with Viewing(home / "live", "--port", "0") as viewing:
        browser.open(f"http://localhost:{viewing.port}/#select=laser")
        browser.click(".chain summary")
        browser.wait("document.querySelectorAll('.chain table a').length > 5")
        link = browser.evaluate("document.querySelector('.chain table a').getAttribute('href')")
        assert link.startswith(f"vscode://file{home}/live/descriptions/rosorin/")


def test_a_warning_leads_to_its_part(browser: Browser, small: str) -> None:
    browser.open(small)
    browser.click(".warned button")
    assert browser.evaluate("document.querySelector('.warnings').open")
    browser.click(".warnings li .go")
    assert browser.evaluate("app.selected") == "arm"


def test_sensors_and_empty_frames_have_a_marker_that_is_chosen_by_a_click(browser: Browser, small: str) -> None:
    browser.open(small)
    assert sorted(browser.evaluate("app.markers.names")) == ["arm", "eye2", "eye2_optical"]
    browser.ask("click", at=browser.evaluate("app.stage.pixel(app.places.get('eye2').p)"))
    assert browser.evaluate("app.selected") == "eye2"


def test_without_webgl_all_but_the_picture_is_there(browser: Browser, rosorin: str) -> None:
    browser.open(rosorin, webgl=False)
    assert browser.evaluate("document.querySelector('.nopicture').checkVisibility()")
    assert "no WebGL" in browser.evaluate("document.querySelector('.nopicture').textContent")
    browser.click(row("laser"))
    assert "48.16" in browser.evaluate("document.querySelector('.card').innerText")
    browser.enter("[data-joint=joint1] input[type=number]", "10")
    assert browser.evaluate("app.state.joint1") == pytest.approx(0.17453292519943295)
    assert browser.ask("kept")["complaints"] == []


def test_rollers_are_folded_in_the_list_of_joints_and_found(browser: Browser, rosorin: str) -> None:
    browser.open(rosorin)
    shown = "document.querySelector('[data-joint={}]').checkVisibility()"
    roller = shown.format("rear_right_wheel_roller_5_joint")
    assert browser.evaluate(shown.format("rear_right_wheel_joint"))
    assert not browser.evaluate(roller)
    browser.ask("press", key="/")
    browser.ask("type", text="rear_right_wheel_roller_5")
    browser.ask("press", key="Enter")
    assert browser.evaluate(roller)
    browser.click("[data-wheel=rear_right_wheel_link] summary")
    assert not browser.evaluate(roller)


def test_the_row_that_is_clicked_is_marked(browser: Browser, rosorin: str) -> None:
    browser.open(rosorin)
    marked = "[...document.querySelectorAll('.row.selected')].map((row) => row.dataset.parent)"
    for parent in ("odom", "base_footprint"):
        browser.click(f"{row('base_link')}[data-parent={parent}]")
        assert browser.evaluate(marked) == [parent]
    assert "ekf, /tf (in odom)" in browser.evaluate("document.querySelector('.card').innerText")


def test_measuring_ends_by_escape_and_from_another_card(browser: Browser, rosorin: str) -> None:
    browser.open(rosorin)
    browser.click(row("laser"))
    browser.click("#measure")
    browser.click(row("link3"))
    card = "document.querySelector('.card').innerText"
    assert "170.35 mm" in browser.evaluate(card)
    browser.click("#measure")
    assert "170.35 mm" not in browser.evaluate(card)
    browser.click("#measure")
    browser.ask("press", key="Escape")
    assert browser.evaluate("[app.card.from, app.selected]") == ["", "link3"]
    browser.ask("press", key="Escape")
    assert browser.evaluate("app.selected") == ""


def test_fly_there_shows_a_part_beside_the_card_and_the_pointer_its_name(browser: Browser, rosorin: str) -> None:
    browser.open(rosorin)
    browser.click(row("front_left_wheel_link"))  # hidden by the base in the first view
    browser.click(".card footer button:last-child")
    browser.evaluate("window.box = app.view.boundsOf('front_left_wheel_link')")
    at = browser.evaluate("app.stage.pixel(box.min.add(box.max).multiplyScalar(0.5).toArray())")
    assert at[1] < browser.evaluate("document.querySelector('.card').getBoundingClientRect().top")
    browser.ask("move", at=at)
    browser.wait("document.querySelector('.pointed').textContent === 'front_left_wheel_link'")
    browser.ask("move", at=[100, 100])
    browser.wait("document.querySelector('.pointed').hidden")


def test_an_empty_picture_is_explained(browser: Browser, rosorin: str, home: Path) -> None:
    browser.open(rosorin)
    hint = "document.querySelector('.nopicture').checkVisibility()"
    assert not browser.evaluate(hint)
    browser.click("#show-collision")
    assert browser.evaluate(hint)
    (home / "meshes.yaml").write_text(
        "robot: r\nlinks: {a: {visual: [{mesh: {file: a.stl}}], collision: [{box: {size: [1, 1, 1]}}]}}\n"
    )
    (home / "a.stl").write_bytes(bytes(84))
    assert main(["view", "meshes.yaml", "--html", "meshes.html", "--no-meshes"]) == 0
    browser.open(f"file://{home}/meshes.html")
    assert "made without meshes" in browser.evaluate("document.querySelector('.warnings').textContent")
    assert browser.evaluate("[app.shown.visual, app.shown.collision]") == [False, True]


def test_a_window_that_becomes_small_keeps_one_panel(browser: Browser, rosorin: str) -> None:
    browser.open(rosorin)
    browser.ask("size", width=700, height=800)
    browser.wait("!document.querySelector('.side.right').checkVisibility({visibilityProperty: true})")
    assert browser.evaluate("document.querySelector('.side.left').checkVisibility({visibilityProperty: true})")
    browser.open(rosorin, width=390, height=700, webgl=False)
    assert browser.evaluate("document.querySelector('.side.left').checkVisibility({visibilityProperty: true})")


def test_five_thousand_links_are_usable(browser: Browser, home: Path) -> None:
    names = [f"link_{number}" for number in range(5_000)]
    limit = Limit(-1.0, 1.0)
    joints = [
        Joint(f"joint_{at}", "revolute", names[(at - 1) // 4], names[at], axis=(0.0, 0.0, 1.0), limit=limit)
        for at in range(1, len(names))
    ]
    robot = Robot("large", tuple(map(Link, names)), tuple(joints))
    (home / "large.html").write_text(html({"robot": robot_data(robot)}), "utf-8")
    started = time.monotonic()
    browser.open(f"file://{home}/large.html")
    assert time.monotonic() - started < 60
    took = browser.evaluate("""(() => {
        const { search } = app.panels.tree;
        const begun = performance.now();
        search.value = "link_4999";
        search.dispatchEvent(new Event("input"));
        document.body.offsetHeight;
        return performance.now() - begun;
    })()""")
    assert took < 100
    browser.enter("input[type=search]", "link_4321")
    assert browser.evaluate("app.selected") == "link_4321"


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_serious(browser: Browser, rosorin: str, theme: str) -> None:
    axe = ROOT / "viewer/node_modules/axe-core/axe.min.js"
    if not axe.is_file():
        pytest.skip("npm ci in viewer brings axe-core")
    browser.open(f"{rosorin}#theme={theme}&select=laser&joints=joint1:0.5")
    browser.click(".chain summary")
    browser.evaluate(f"{axe.read_text('utf-8')}; 0")
    found = browser.evaluate(
        "axe.run(document, {resultTypes: ['violations']}).then(({violations}) => violations.map("
        "({id, impact, nodes}) => [id, impact, nodes[0].html]))"
    )
    assert [entry for entry in found if entry[1] in ("serious", "critical")] == []
