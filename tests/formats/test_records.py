"""What a wheel knows of formats is what their modules say; what they do is imported when it is done."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from rosorin_compile import formats
from rosorin_compile.formats import FORMATS, is_built_in
from rosorin_compile.formats.ahead import records_of
from rosorin_compile.formats.format import Format

HERE = Path(__file__).resolve().parent
BUILT_IN = [one for one in FORMATS.values() if is_built_in(one.name)]


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch) -> dict[str, Format]:
    """The formats as an installed tool knows them."""
    module = ModuleType("records")
    exec(records_of(BUILT_IN), vars(module))  # noqa: S102 - what a wheel has
    monkeypatch.setitem(sys.modules, "rosorin_compile.formats.records", module)
    return dict(formats._unloaded.__wrapped__())


def test_every_format_is_known(known: dict[str, Format]) -> None:
    assert list(known) == [one.name for one in BUILT_IN]
    assert len(known) > 12


@pytest.mark.parametrize("format", BUILT_IN, ids=lambda one: one.name)
def test_a_record_says_the_same(format: Format, known: dict[str, Format]) -> None:
    loaded = sys.modules[f"rosorin_compile.formats.{format.name}"].FORMAT
    for name, value in vars(loaded).items():
        told = getattr(known[format.name], name)
        if callable(value):
            assert callable(told), name
        else:
            assert told == value, name
            assert type(told) is type(value), name
    for name in ("is_xml", "named", "listed"):
        assert getattr(known[format.name], name) == getattr(loaded, name)


def test_a_function_is_that_of_the_module(known: dict[str, Format], monkeypatch: pytest.MonkeyPatch) -> None:
    loaded: Any = sys.modules["rosorin_compile.formats.static_tf_json"].FORMAT
    asked: list[str] = []
    monkeypatch.setitem(vars(loaded), "facts", lambda text: asked.append(text) or {})
    assert known["static_tf_json"].facts is not None
    assert known["static_tf_json"].facts("a text") == {}
    assert asked == ["a text"]


def test_the_text_is_the_same_each_time() -> None:
    code = "from rosorin_compile.formats import FORMATS; from rosorin_compile.formats.ahead import records_of; "
    code += "print(records_of(FORMATS.values()), end='')"
    texts = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={"PYTHONHASHSEED": seed, "ROSORIN_COMPILE_CACHE": "off"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(texts) == 1
