"""Fixtures that several folders use, which tests are slow, and which belong to a tier of ``.ci/full``."""

import gc
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from rosorin_compile.cli import console
from support.answers import held_envelope
from support.commands import write_files
from support.forks import preload
from support.robots import copy_of_rosorin
from support.tiers import is_property, tiers_of

# A loaded machine is not a failure: no example has a deadline.
settings.register_profile("no deadline", deadline=None)
settings.load_profile("no deadline")

# At a landing a property tries one example in PART, and FEW at least; all of them in a tier.
PART, FEW = 5, 10
HELD = "_hypothesis_internal_use_settings"


@pytest.fixture(scope="session", autouse=True)
def _asks_once() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        preload(patch)
        yield


@pytest.fixture(scope="session", autouse=True)
def _no_fsync() -> Iterator[None]:
    """Do not wait for the disk: what a test writes need not survive a crash of the machine."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda _: None)
        yield


@pytest.fixture(autouse=True)
def _every_answer_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever a test asks of a command of this process as JSON is held against the schema that it names."""
    monkeypatch.setattr(console, "envelope", held_envelope)


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, which is the current one and has the cache."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    return tmp_path


@pytest.fixture
def project(home: Path, request: pytest.FixtureRequest) -> Path:
    """The current folder, a project with the files that ``PROJECT`` of the test's module names."""
    write_files(home, request.module.PROJECT)
    return home


@pytest.fixture
def rosorin(home: Path) -> Path:
    """The current folder, a project with the description of the reference robot."""
    copy_of_rosorin(home)
    return home


def pytest_configure() -> None:
    """Take interrupts where a shell's job in the background ignores them: its children would ignore them, too.

    What a command prints depends on no clock: nothing is shown of what takes long, but by the tests of that. Modules
    are compiled once, also where the machine says otherwise: else each process would do so with the whole tool.
    """
    gc.disable()  # until all tests are collected: they live until the end of the process
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ["ROSORIN_COMPILE_PROGRESS"] = "off"
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--tier", metavar="NAME", help="run the tests of a tier of .ci/full, and no others")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """Give each worker tests that stand beside each other, so that what a module prepares is prepared once."""
    from xdist.scheduler import WorkStealingScheduling

    return WorkStealingScheduling(config, log)


def pytest_collection_finish() -> None:
    """Exclude everything that exists before the first test from garbage collection."""
    gc.collect()
    gc.freeze()
    gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark as slow what tries many inputs; leave out what belongs to a tier, or all else where one is asked for."""
    asked = config.getoption("tier")
    for item in filter(is_property, items):
        item.add_marker(pytest.mark.slow)
        if asked is None:
            _shorten(item)
    chosen = [item for item in items if asked in tiers_of(item)]
    if len(chosen) < len(items):
        config.hook.pytest_deselected(items=[item for item in items if asked not in tiers_of(item)])
        items[:] = chosen


def _shorten(item: pytest.Item) -> None:
    """Let a property try a part of its examples, the same in every run; the tier tries all, and other ones each time.

    The settings are kept where the plug-in of hypothesis looks, too.
    """
    test = getattr(item.obj, "__func__", item.obj)  # type: ignore[attr-defined]
    own = getattr(test, HELD, settings.default)
    few = max(own.max_examples // PART, min(own.max_examples, FEW))
    setattr(test, HELD, settings(own, max_examples=few, derandomize=True, database=None))
