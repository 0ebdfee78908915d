"""Each module of the language can be the first that a program imports."""

import subprocess
import sys

from support.paths import ROOT

LANGUAGE = ROOT / "compiler" / "rosorin_compile" / "language"
# A process of its own for each module, none of which has imported another one before.
SCRIPT = """\
import os, sys
for name in sys.argv[1:]:
    child = os.fork()
    if child == 0:
        __import__(name)
        os._exit(0)
    if os.waitpid(child, 0)[1]:
        sys.exit(f"{name} cannot be imported first")
"""


def test_each_module_can_be_imported_first() -> None:
    files = [path.relative_to(LANGUAGE.parents[1]).with_suffix("") for path in LANGUAGE.rglob("*.py")]
    names = sorted(".".join(file.parts).removesuffix(".__init__") for file in files)
    assert len(names) > 20
    subprocess.run([sys.executable, "-c", SCRIPT, *names], check=True)
