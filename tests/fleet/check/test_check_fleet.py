"""``check fleet``: typos that are planted in a fleet, and sweeps of which something is missing or changed."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from rosorin_compile.cli import main
from rosorin_compile_fleet.check import columns as columns_module
from rosorin_compile_view.page import data_of
from support.answers import hold
from support.commands import Shown
from support.fleets import BOT, Rows, calibrated, lines_of, rewrite, swept
from support.schemas import schema


def told(capsys: Shown, file: Path, code: int = 0, *words: str) -> list[dict[str, Any]]:
    """Return what a check says, as programs get it."""
    capsys.readouterr()
    assert main(["check", "fleet", str(file), "--format", "json", *words]) == code
    return list(json.loads(capsys.readouterr().out)["diagnostics"])


def outliers(capsys: Shown, file: Path, code: int = 0) -> list[str]:
    return [one["message"] for one in told(capsys, file, code) if one["rule"] == "fleet-outlier"]


def shown(capsys: Shown, file: Path, *words: str) -> str:
    capsys.readouterr()
    main(["check", "fleet", str(file), *words])
    return capsys.readouterr().out


def planted(home: Path, name: str, values: dict[str, Any], count: int = 10) -> Path:
    rows = calibrated(count)
    rows[name] |= values
    return swept(home, rows)


def test_a_sound_fleet(home: Path, capsys: Shown) -> None:
    file = swept(home, calibrated(12))
    assert outliers(capsys, file) == []
    said = shown(capsys, file)
    assert "12 robots in fleet/sweep.json: 12 made; 12 with stand-ins" in said
    head, first, gives = said.splitlines()[:3]
    assert head.split() == ["number", "robots", "smallest", "median", "largest"]
    assert first.startswith("lidar_x, mm")
    assert "▁" <= max(first) <= "█"
    assert gives == "  gives laser origin x, lidar_frame origin x"


def test_what_a_program_gets_of_a_fleet(home: Path, capsys: Shown) -> None:
    file = planted(home, "r004", {"lidar_x": 48.1})
    capsys.readouterr()
    assert main(["check", "fleet", str(file), "--format", "json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    hold(answer)
    result = answer["result"]
    assert (result["robots"], result["made"], result["with_outliers"], result["with_stand_ins"]) == (10, 10, 1, 10)
    numbers = {one["name"]: one for one in result["numbers"]}
    assert numbers["lidar_x"]["gives"] == ["laser origin x", "lidar_frame origin x"]
    assert (numbers["lidar_x"]["unit"], numbers["lidar_x"]["largest"]) == ("m", 48.1)
    assert [(one["robot"], one["number"], one["value"]) for one in result["outliers"]] == [("r004", "lidar_x", 48.1)]
    said = shown(capsys, file)
    assert f"{result['differing']} numbers of the artifacts differ, {result['same']} are the same in all robots" in said


@pytest.mark.parametrize(
    ("values", "message", "help"),
    [
        ({"lidar_x": 48.1}, "r004: lidar_x is 48,100.00 mm, 1,000 times that of the others", "mm where m is meant?"),
        ({"lidar_x": "48.1 m"}, "r004: lidar_x is 48,100.00 mm, 1,000 times that of", "mm where m is meant?"),
        ({"lidar_y": -0.012}, "r004: lidar_y is -12.00 mm, that of the others with the other", "a sign that is lost"),
        ({"lidar_yaw": 0.001}, "r004: lidar_yaw is 0.06 deg, half a turn from that of", "looks it the other way?"),
        ({"lidar_x": 0.06}, "r004: lidar_x is 60.00 mm, ", "a typo? look it up where it was measured"),
        ({"camera_pitch": "-90 deg"}, "r004: camera_pitch is -90 deg, that of the others with", "a sign that is lost"),
    ],
)
def test_a_planted_typo_is_one_warning(
    home: Path, capsys: Shown, values: dict[str, Any], message: str, help: str
) -> None:
    rows = calibrated(8)
    for row in rows.values() if "camera_pitch" in values else ():
        row["camera_pitch"] = "90 deg"
    rows["r004"] |= values
    found = [one for one in told(capsys, swept(home, rows)) if one["rule"] == "fleet-outlier"]
    (one,) = found
    assert one["message"].startswith(message)
    assert one["help"].startswith(help)
    assert one["severity"] == "warning"
    line = (home / "fleet/sweep.json").read_text("utf-8").splitlines()[one["line"] - 1]
    there = line[one["column"] - 1 :][: one["length"]]
    assert json.loads(there) == next(iter(values.values()))
    assert "bot.sdf, bot.urdf, bot.xml and 2 more" in one["related"][0]["message"]


def test_swapped_axes_are_said_so(home: Path, capsys: Shown) -> None:
    (message,) = outliers(capsys, planted(home, "r006", {"lidar_x": 0.012, "lidar_y": 0.048}))
    assert message.startswith("r006: lidar_x is 12.00 mm and lidar_y 48.00 mm, each that of the other one")


def test_swapped_places_of_a_list_are_said_so(home: Path, capsys: Shown) -> None:
    text = BOT["descriptions/bot/robot.yaml"]
    text = text.replace("  mast: {default: true}\n", "  mast: {default: true}\n  at: {default: [1, 2, 3]}\n")
    text = text.replace('xyz: ["${lidar_x}", "${lidar_y}", "${lidar_z}"]', 'xyz: "${at}"')
    rows: Rows = {name: {"at": [one["lidar_x"], one["lidar_y"], 0.1]} for name, one in calibrated(9).items()}
    rows["r002"]["at"][:2] = [0.012, 0.048]
    (message,) = outliers(capsys, swept(home, rows, {"descriptions/bot/robot.yaml": text}))
    assert message.startswith("r002: at[0] is 12.00 mm and at[1] 48.00 mm, each that of the other one")


def test_two_robots_and_two_numbers_of_one(home: Path, capsys: Shown) -> None:
    rows = calibrated(12)
    rows["r001"]["lidar_x"] = 48.0
    rows["r009"] |= {"lidar_y": -0.012, "wheel": 0.325}
    found = outliers(capsys, swept(home, rows))
    assert [one.split(" is ")[0] for one in found] == ["r001: lidar_x", "r009: lidar_y", "r009: wheel"]


def test_a_number_that_follows_no_argument_is_told_by_itself(home: Path, capsys: Shown) -> None:
    """The arguments are not in the list: the numbers of the artifacts are all that there is."""
    file = planted(home, "r003", {"lidar_x": 48.1, "wheel": 0.5})
    rewrite(file, [{**one, "arguments": {}} for one in lines_of(file)])
    found = [one for one in told(capsys, file) if one["rule"] == "fleet-outlier"]
    assert [one["message"].split(" is ")[0] for one in found] == ["r003: laser origin x", "r003: wheel origin z"]
    assert "and with it" in found[0]["related"][1]["message"]
    assert "wheel inertia ixx" in found[0]["related"][1]["message"]


def test_a_number_that_gives_none_may_be_anything(home: Path, capsys: Shown) -> None:
    text = BOT["descriptions/bot/robot.yaml"].replace("  mast: {", "  serial: {default: 0}\n  mast: {")
    rows = {name: {**one, "serial": 1000 + index} for index, (name, one) in enumerate(calibrated(9).items())}
    rows["r004"]["serial"] = 900_000
    file = swept(home, rows, {"descriptions/bot/robot.yaml": text})
    assert outliers(capsys, file) == []
    assert "serial " in shown(capsys, file)


def test_an_argument_that_gives_its_numbers_by_a_formula(home: Path, capsys: Shown) -> None:
    """No line leads from the angle to the place: both are far, and the angle is the cause."""
    text = BOT["descriptions/bot/robot.yaml"].replace('"${lidar_x}"', '"${0.1 * cos(lidar_yaw / 3)}"')
    text = text.replace('rpy: [0, 0, "${lidar_yaw}"]', "rpy: [0, 0, 0]")
    rows = {name: {"lidar_yaw": one["lidar_yaw"]} for name, one in calibrated(12).items()}
    rows["r004"]["lidar_yaw"] = 0.5
    file = swept(home, rows, {"descriptions/bot/robot.yaml": text})
    (one,) = [one for one in told(capsys, file) if one["rule"] == "fleet-outlier"]
    assert one["message"].startswith("r004: lidar_yaw is ")
    assert "and with it 1 number of this robot: laser origin x" in one["related"][0]["message"]


def test_an_angle_that_goes_round_is_no_outlier(home: Path, capsys: Shown) -> None:
    rows = calibrated(10)
    rows["r003"]["lidar_yaw"] = -3.141
    assert outliers(capsys, swept(home, rows)) == []


def test_a_camera_that_looks_down_has_no_roll_of_its_own(home: Path, capsys: Shown) -> None:
    """At a pitch of 90 degrees roll and yaw jump; the turn from the first robot does not."""
    rows = calibrated(12)
    for index, row in enumerate(rows.values()):
        row["camera_pitch"] = f"{89.5 + index / 10} deg"
    file = swept(home, rows)
    assert outliers(capsys, file) == []
    assert "gives camera turn y" in shown(capsys, file)
    assert "camera roll" not in shown(capsys, file)


def test_few_robots_are_said_to_be_few(home: Path, capsys: Shown) -> None:
    rows = calibrated(5)
    rows["r001"]["lidar_x"] = 48.1
    found = told(capsys, swept(home, rows))
    assert [one["rule"] for one in found] == ["fleet-numbers", "fleet-few", "stand-in"]
    assert found[1]["message"] == "5 robots: too few to say which number is an outlier; that takes 6"


def test_one_robot_and_none(home: Path, capsys: Shown) -> None:
    file = swept(home, calibrated(1))
    assert "1 robot in fleet/sweep.json: 1 made" in shown(capsys, file)
    rewrite(file, [])
    assert "0 robots in fleet/sweep.json: 0 made" in shown(capsys, file)


def test_what_is_not_a_number_is_counted(home: Path, capsys: Shown) -> None:
    rows = calibrated(10)
    rows["r003"]["side"] = "right"
    rows["r004"]["mast"] = False
    said = shown(capsys, swept(home, rows))
    assert "flag parent: laser (9), camera (1)\n" in said
    assert "not in all robots: pole (9), pole_joint (9)\n" in said


def test_stand_ins_are_told_by_robot(home: Path, capsys: Shown) -> None:
    file = swept(home, calibrated(9))
    variants = lines_of(file)
    for one in variants[2:]:
        one["diagnostics"] = [two for two in one["diagnostics"] if two["rule"] != "stand-in"]
    rewrite(file, variants)
    (one,) = [one for one in told(capsys, file) if one["rule"] == "stand-in"]
    assert one["message"] == "the camera is not weighed (camera inertial) (in 2 of 9 robots: r000, r001)"
    assert one["file"] == "descriptions/bot/robot.yaml"
    assert "9 made; 2 with stand-ins" in shown(capsys, file)


def test_robots_that_failed_are_told_by_their_reason(home: Path, capsys: Shown) -> None:
    rows = calibrated(12)
    for name in ("r001", "r002", "r003", "r004"):
        rows[name]["wheel"] = -1
    rows["r007"]["side"] = "up"
    found = [one for one in told(capsys, swept(home, rows), 1) if one["rule"] == "fleet-failed"]
    assert [one["message"].split(":")[0] for one in found] == [
        "r001, r002, r003 and 1 more were not made",
        "r007 was not made",
    ]
    assert found[0]["related"][0]["file"] == "descriptions/bot/robot.yaml"
    assert found[0]["line"] == 3


def test_what_was_changed_or_is_missing_is_an_error(home: Path, capsys: Shown) -> None:
    file = swept(home, calibrated(9))
    changed = home / "fleet/r001/bot.urdf"
    text = changed.read_text("utf-8")
    changed.unlink()
    changed.write_text(text.replace('length="0.03"', 'length="0.5"'), "utf-8")
    (home / "fleet/r002/bot.xml").unlink()
    (home / "fleet/r002/frames.md").unlink()
    shutil.rmtree(home / "fleet/r003")
    found = {one["rule"]: one for one in told(capsys, file, 1)}
    assert found["fleet-changed"]["message"] == "r001: bot.urdf of fleet/r001 is not what was made"
    missing = [one["message"] for one in told(capsys, file, 1) if one["rule"] == "fleet-missing"]
    assert missing == [
        "r002: bot.xml and frames.md of fleet/r002 are not there",
        "r003: there is no folder fleet/r003",
    ]
    assert "fleet-outlier" not in found


def test_an_artifact_that_was_made_so_and_cannot_be_read(home: Path, capsys: Shown) -> None:
    file = swept(home, calibrated(9))
    variants = lines_of(file)
    for name in variants[4]["artifacts"]:
        path = home / "fleet/r004" / name
        text = path.read_text("utf-8")[:-200]
        path.unlink()
        path.write_text(text, "utf-8")
        variants[4]["artifacts"][name] = hashlib.sha256(path.read_bytes()).hexdigest()
    rewrite(file, variants)
    found = [one["message"] for one in told(capsys, file, 1) if one["rule"] == "fleet-unreadable"]
    assert any(one.startswith("r004: fleet/r004/bot.xml cannot be read: ") for one in found)


def test_a_robot_without_the_artifact_that_is_read_is_read_from_others(home: Path, capsys: Shown) -> None:
    file = planted(home, "r005", {"wheel": 0.5})
    variants = lines_of(file)
    variants[5]["arguments"] = {}
    variants[5]["artifacts"] = {"bot.urdf": variants[5]["artifacts"]["bot.urdf"]}
    rewrite(file, variants)
    found = [one for one in told(capsys, file) if one["rule"] == "fleet-outlier"]
    assert [one["message"].split(" is ")[0] for one in found] == ["r005: wheel origin z"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is no JSON, or ends in the middle"),
        ("not json", "is no JSON"),
        ("[1, 2]", 'is JSON, but no sweep: it has no "sweep": 1'),
        ('{"robots": []}', 'is JSON, but no sweep: it has no "sweep": 1'),
        ('{"sweep": 2, "variants": []}', "is a sweep of version 2; this rosorin-compile reads version 1"),
        ('{"sweep": 1}', "has no list of variants"),
        ('{"sweep": 1, "variants": [\n{"folder": "x"}\n]}', "has a variant without a name"),
        ('{"sweep": 1, "variants": [\n{"name": "x", "artifacts": {"../y": "' + "0" * 64 + '"}}\n]}', "outside of its"),
        ('{"sweep": 1, "variants": [\n{"name": "x", "artifacts": {"y": "z"}}\n]}', "no names with SHA-256 sums"),
        ('{"sweep": 1, "variants": [\n{"name": "x", "artif', "ends in the middle, after 0 variants"),
        ('{"sweep": 1, "variants": [\n{"name": "x", "status": "error"},\n', "ends in the middle, after 1 variants"),
        ('{"sweep": 1, "variants": [\n' + "[" * 5000 + "\n]}", "or is damaged: nested deeper"),
        ('{"sweep": 1, "variants": [\n{"name": "x", "arguments": 3}\n]}', "whose arguments are no names with values"),
        ('{"sweep": 1, "variants": [\n{"name": "x", "diagnostics": [3]}\n]}', "whose diagnostics are no list"),
        ('{"sweep": 1, "variants": [\n{"name": "x", "folder": 3}\n]}', "whose folder is no text"),
    ],
)
def test_what_is_no_sweep_is_said(home: Path, capsys: Shown, text: str, message: str) -> None:
    (home / "sweep.json").write_text(text, "utf-8")
    found = [one for one in told(capsys, home / "sweep.json", 1) if one["rule"] == "fleet-file"]
    assert len(found) == 1
    assert message in found[0]["message"]
    assert found[0]["help"] or "readable" in found[0]["message"]


@pytest.mark.parametrize("text", [b'{"sweep": 1, "variants": [\n\xff\xfe\n]}', b"{\n" + b" " * 20_000 + b"\xff}"])
def test_bytes_that_are_no_text(home: Path, capsys: Shown, text: bytes) -> None:
    (home / "sweep.json").write_bytes(text)
    (one,) = told(capsys, home / "sweep.json", 1)
    assert one["message"].endswith("cannot be read: it is no UTF-8")


def test_numbers_that_are_none(home: Path, capsys: Shown) -> None:
    file = swept(home, calibrated(8))
    variants = lines_of(file)
    for one, value in zip(variants, ["1e999", 10**400, "1e999 mm", None, True, [], {}, "\ud800"], strict=True):
        one["arguments"] |= {"odd": value, "\ud800": value}
    rewrite(file, variants)
    assert outliers(capsys, file) == []
    assert "8 made" in shown(capsys, file, "--html", "fleet.html")
    assert (home / "fleet.html").is_file()


def test_a_sweep_that_another_program_has_laid_out(home: Path, capsys: Shown) -> None:
    file = planted(home, "r003", {"lidar_x": 48.1})
    file.write_text(json.dumps(json.loads(file.read_text("utf-8")), indent=2), "utf-8")
    (message,) = outliers(capsys, file)
    assert message.startswith("r003: lidar_x is 48,100.00 mm")


def test_two_variants_of_one_name(home: Path, capsys: Shown) -> None:
    file = swept(home, calibrated(6))
    rewrite(file, [*lines_of(file), lines_of(file)[0]])
    (one,) = [one for one in told(capsys, file, 1) if one["rule"] == "fleet-file"]
    assert one["message"] == 'fleet/sweep.json has two variants "r000"'


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["check", "fleet", "nothing.json"], 'there is no file "nothing.json"'),
        (["check", "fleet", "."], 'there is no file "sweep.json"'),
        (["check", "fleet"], "a fleet is the sweep.json of one sweep: rosorin-compile check fleet FILE"),
        (["check", "fleet", "x", "bot"], 'a fleet is the sweep.json of one sweep; what is "bot" for?'),
        (["check", "fleet", "x", "--physics"], "check fleet has no option --physics"),
        (["check", "fleet", "x", "-a", "y=1"], "check fleet has no option -a"),
        (["check", "fleet", "x", "--launch", "y"], "check fleet has no option --launch"),
        (["check", "fleet", "x", "--package", "y=."], "check fleet has no option --package"),
    ],
)
def test_wrong_usage(home: Path, capsys: Shown, words: list[str], message: str) -> None:
    assert home.is_dir()
    assert main(words) == 2
    assert message in capsys.readouterr().err


def test_forms_for_programs(home: Path, capsys: Shown) -> None:
    file = planted(home, "r003", {"lidar_x": 48.1})
    assert "::warning file=fleet/sweep.json,line=5," in shown(capsys, file, "--format", "github")
    sarif = json.loads(shown(capsys, file, "--format", "sarif"))
    assert "fleet-outlier" in [one["ruleId"] for one in sarif["runs"][0]["results"]]
    markdown = shown(capsys, file, "--format", "markdown")
    assert "| `lidar_x, mm` | 10 |" in markdown
    assert "1,000 times that of the others" in markdown
    main(["check", "fleet", str(file), "--summary", "summary.md", "-q"])
    assert "1,000 times" not in capsys.readouterr().out
    assert "fleet/sweep.json" in (home / "summary.md").read_text("utf-8")
    table = next(one for one in told(capsys, file) if one["rule"] == "fleet-numbers")
    assert table["message"].startswith("number ")


def test_quiet(home: Path, capsys: Shown) -> None:
    file = planted(home, "r003", {"lidar_x": 48.1})
    capsys.readouterr()
    assert main(["check", "fleet", str(file), "-q"]) == 0
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == "1 stand-in: values that are not measured; without -q they are listed\n"


def test_a_terminal_without_blocks_gets_letters(home: Path, capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    from rosorin_compile_fleet.check import report

    file = swept(home, calibrated(9))
    monkeypatch.setattr(report, "_can_print", lambda _: False)
    assert shown(capsys, file).isascii()


@pytest.mark.parametrize("columns", [200, 100, 80, 40])
def test_the_table_is_as_wide_as_the_terminal(
    home: Path, capsys: Shown, monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    import sys

    file = swept(home, calibrated(9))
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setattr(type(sys.stdout), "isatty", lambda _: True, raising=False)
    lines = shown(capsys, file).splitlines()
    numbers = [line for line in lines if line.startswith(("number", "lidar", "wheel"))]
    assert len(numbers) == 6
    assert max(map(len, numbers)) <= max(columns, 62)  # the numbers themselves are not cut
    assert any("█" in line for line in numbers) == (columns >= 80)


def test_full_lists_all(home: Path, capsys: Shown) -> None:
    keys = [f"n{index:02}" for index in range(40)]
    text = "robot: many\nargs:\n" + "".join(f"  {key}: {{default: 1}}\n" for key in keys)
    text += "links: {base_link: {}}\noutputs: {frames: {file: frames.md}}\n"
    rows: Rows = {f"r{index}": dict.fromkeys(keys, index / 10) for index in range(7)}
    file = swept(home, rows, {"descriptions/many/robot.yaml": text})
    assert "and 10 more numbers; --full lists all" in shown(capsys, file)
    assert "n39" not in shown(capsys, file)
    assert "n39" in shown(capsys, file, "--full")


def test_names_do_not_steer_the_terminal(home: Path, capsys: Shown) -> None:
    file = planted(home, "r003", {"lidar_x": 48.1})
    variants = lines_of(file)
    variants[3]["name"] = "evil\x1b[31m\n::error::x"
    variants[4] |= {"name": "f\x07", "status": "bro\x1bken"}
    rewrite(file, variants)
    for words in ([], ["--format", "github"], ["--format", "markdown"]):
        capsys.readouterr()
        main(["check", "fleet", str(file), *words])
        said = capsys.readouterr()
        assert "\x1b" not in said.out + said.err
        assert not any(line.startswith("::error::x") for line in said.out.splitlines())


def test_the_page(home: Path, capsys: Shown) -> None:
    file = planted(home, "r003", {"lidar_x": 48.1})
    variants = lines_of(file)
    variants[3]["name"] = "</script><b>r003"
    rewrite(file, variants)
    said = shown(capsys, file, "--html", "fleet.html", "--no-meshes")
    assert "fleet.html: a page of 10 robots" in said
    text = (home / "fleet.html").read_text("utf-8")
    assert "</script><b>" not in text
    assert "http://" not in text.partition("<script>")[0]
    data = data_of(text)
    jsonschema.Draft7Validator(schema("page")).validate(data)
    assert data["robot"]["name"] == "bot"
    first = data["fleet"]["numbers"][0]
    assert (first["name"], first["frame"], first["robots"], first["above"]) == ("lidar_x", "laser", 10, 1)
    assert sum(first["bins"]) == 9
    assert data["fleet"]["problems"][0]["text"].startswith("</script><b>r003: lidar_x is 48,100.00 mm")
    assert str(home) not in text
    once = text
    shown(capsys, file, "--html", "fleet.html", "--no-meshes")
    assert (home / "fleet.html").read_text("utf-8") == once


def test_the_page_knows_the_arguments_of_all(home: Path, capsys: Shown) -> None:
    file = swept(home, calibrated(6), BOT, "-a", "mast=false", "-a", "lidar_z=0.75 m")
    shown(capsys, file, "--html", "fleet.html")
    data = data_of((home / "fleet.html").read_text("utf-8"))
    assert "pole" not in {link["name"] for link in data["robot"]["links"]}
    assert next(one for one in data["robot"]["joints"] if one["name"] == "laser_joint")["xyz"][2] == 0.75


def test_the_page_without_the_description_shows_an_artifact(home: Path, capsys: Shown) -> None:
    file = planted(home, "r003", {"lidar_x": 48.1})
    shutil.rmtree(home / "descriptions")
    shown(capsys, file, "--html", "fleet.html")
    data = data_of((home / "fleet.html").read_text("utf-8"))
    assert {link["name"] for link in data["robot"]["links"]} >= {"base_link", "laser", "camera", "wheel"}
    assert data["fleet"]["numbers"][0]["frame"] == "laser"


@pytest.mark.slow
def test_very_many_numbers_are_drawn_and_the_far_ones_found(
    home: Path, capsys: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = calibrated(60)
    rows["r037"]["lidar_x"] = 48.1
    file = swept(home, rows)
    whole = shown(capsys, file)
    monkeypatch.setattr(columns_module, "MOST", 300)
    said = shown(capsys, file)
    assert "medians are those of " in said
    (message,) = outliers(capsys, file)
    assert message.startswith("r037: lidar_x is 48,100")
    assert said != whole


def test_an_artifact_is_read_once_however_many_robots_have_it(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: Shown
) -> None:
    rows = {name: {"lidar_x": 0.04 + (index % 3) / 1000} for index, name in enumerate(calibrated(30))}
    file = swept(home, rows)
    read: list[str] = []
    usual = columns_module.Texts.read

    def counted(self: Any, variant: Any, name: str) -> str:
        read.append(name)
        return usual(self, variant, name)

    monkeypatch.setattr(columns_module.Texts, "read", counted)
    shown(capsys, file)
    assert max(read.count(name) for name in set(read)) <= 4  # three texts, and the first of them to know its format
