"""The known word that a person means, and no other: misspelt, in other letters, part of a name, or in another order."""

from __future__ import annotations

import pytest

from rosorin_compile.language.expand.declarations import _SENSOR_TYPE_KEYS
from rosorin_compile.language.schema import of_types, schema
from rosorin_compile.language.suggestions import _data, plain, synonyms, unit_meant, words_for
from rosorin_compile.source.diagnostics import did_you_mean, nearest
from rosorin_compile.source.units import parse_unit

LINKS = ["base_link", "left_wheel", "right_wheel", "laser_frame", "front_camera_link"]


@pytest.mark.parametrize(
    ("word", "known", "meant"),
    [
        ("base_lnik", LINKS, "base_link"),
        ("Base_Link", LINKS, "base_link"),
        ("base-link", LINKS, "base_link"),
        ("/base_link", LINKS, "base_link"),
        ("baseLink", LINKS, "base_link"),
        ("base", LINKS, "base_link"),
        ("wheel_left", LINKS, "left_wheel"),
        ("laser", LINKS, "laser_frame"),
        ("robot1/laser_frame", LINKS, "laser_frame"),
        ("camera", LINKS, "front_camera_link"),
        ("lasr_frame", LINKS, "laser_frame"),
        ("xzy", ["rpy", "xyz"], "xyz"),
        ("rpt", ["rpy", "xyz"], "rpy"),
        ("parst", ["args", "parts", "poses"], "parts"),
        ("revolut", ["continuous", "revolute"], "revolute"),
        ("rotation", ["calibration", "rpy", "xyz"], None),
        ("linear", ["planar", "prismatic"], None),
        ("topic", ["optical", "stamps"], None),
        ("bodies", ["links", "modes"], None),
        ("m", ["mm", "km"], None),
        ("warp", LINKS, None),
    ],
)
def test_the_nearest_word(word: str, known: list[str], meant: str | None) -> None:
    assert nearest(word, known) == meant


def test_words_that_are_equally_near_are_all_told() -> None:
    assert did_you_mean("wheel", LINKS) == 'did you mean "left_wheel" or "right_wheel"?'
    assert did_you_mean("lidar", ["lidar_3d", "camera", "lidar_2d"]) == 'did you mean "lidar_2d" or "lidar_3d"?'
    assert did_you_mean("warp", ["b", "a"]) == "known: a, b"


def test_many_words_are_not_all_compared() -> None:
    many = [f"link_{number}" for number in range(10_000)]
    assert nearest("Link_77", many) is not None


@pytest.mark.parametrize(
    "kind", sorted(kind for kind, one in schema()["$defs"].items() if "properties" in one and kind != "arg")
)
def test_synonyms_lead_to_keys_that_there_are(kind: str) -> None:
    legal = schema()["$defs"][kind]["properties"]
    for word, meaning in words_for(kind).items():
        assert word == plain(word)
        assert " " in meaning or meaning in legal, (kind, word, meaning)
        # A legal key is never unknown.
        assert word not in map(plain, legal), (kind, word)


def test_synonyms_of_sections_lead_to_sections() -> None:
    legal = {*schema()["properties"], "parts", "use", "sensor_types"}
    assert all(" " in meaning or meaning in legal for meaning in words_for("top").values())
    of_type = {*_SENSOR_TYPE_KEYS, *of_types()}
    assert all(" " in meaning or meaning in of_type for meaning in synonyms("keys", "sensor_type").values())
    assert set(_data()["others"]) <= set(schema()["$defs"])
    types = schema()["$defs"]["joint"]["properties"]["type"]["enum"]
    assert all(" " in meaning or meaning in types for meaning in synonyms("values", "joint type").values())
    statuses = schema()["$defs"]["source"]["properties"]["status"]["enum"]
    assert set(synonyms("values", "status").values()) <= set(statuses)


@pytest.mark.parametrize(
    ("text", "wanted", "unit"),
    [
        ("inches", ["m"], "inch"),
        ('"', ["m"], "inch"),
        ("µm", ["m"], "um"),
        ("MM", ["m"], "mm"),
        ("°", ["rad"], "deg"),
        ("° / s", ["rad/s"], "deg/s"),
        ("m per sec", ["m/s"], "m/s"),
        ("kg m²", ["kg*m^2"], "kg*m^2"),
        ("kgm2", ["kg*m^2"], "kg*m^2"),
        ("nm", ["N*m", "N"], "Nm"),
        ("kg-cm", ["N*m"], "kgf*cm"),
        ("kg", ["N"], "kgf"),
        ("kg", ["kg"], "kg"),
        ("parsec", ["m"], ""),
        ("", ["m"], ""),
        ("*/^", [], ""),
    ],
)
def test_units_as_people_write_them(text: str, wanted: list[str], unit: str) -> None:
    assert unit_meant(text, wanted) == unit
    assert unit == "" or parse_unit(unit) is not None
