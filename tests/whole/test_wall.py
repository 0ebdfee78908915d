"""The packages outside of the core import only its public names, and those of ``rosorin_compile.backend``."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

from support.door import BACKEND, DOOR, breaches
from support.paths import PACKAGE, PACKAGES


def door() -> dict[str, ModuleType]:
    """Return the modules of the door by their names within the package."""
    return {name: import_module(f"{PACKAGE.name}.{name}".rstrip(".")) for name in DOOR}


def public() -> dict[str, list[str]]:
    return {name: module.__all__ for name, module in door().items()}


def backend() -> dict[str, list[str]]:
    """Return the names that the door hands on to the tool's own packages, by module."""
    folder = PACKAGE / BACKEND
    names = [f"{BACKEND}.{path.stem}" for path in sorted(folder.glob("*.py")) if path.stem != "__init__"]
    return {name: import_module(f"{PACKAGE.name}.{name}").__all__ for name in names}


@pytest.mark.parametrize("package", [one for one in PACKAGES if one != PACKAGE], ids=lambda path: path.name)
def test_a_package_beside_the_core_takes_the_public_names_alone(package: Path) -> None:
    wrong = breaches(package, PACKAGE.name, {**public(), **backend()})
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", DOOR)
def test_each_public_name_is_there_and_no_module(name: str) -> None:
    module = door()[name]
    assert len(module.__all__) == len(set(module.__all__))
    assert set(module.__all__) <= set(dir(module))
    assert [each for each in module.__all__ if isinstance(getattr(module, each), ModuleType)] == []
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = module.nothing


def test_importing_the_door_loads_none_of_the_rooms() -> None:
    program = (
        "import sys, rosorin_compile.extending as e; dir(e); e.__all__; "
        "print(*(n for n in sys.modules if n.startswith('rosorin_compile.')))"
    )
    ran = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert set(ran.stdout.split()) <= {
        *("rosorin_compile.extending", "rosorin_compile.startup", "rosorin_compile.startup.lazily"),
    }
