"""Regenerate committed files that a program writes; review the difference like any other change.

python tests/renew.py schema | planted | goldens | from-xacro | findings
python tests/renew.py docs [PAGE...]
python tests/renew.py commands [PAGE...]
python tests/renew.py messages [TEST FILE...]
python tests/renew.py imported | translated | pictures [NAME...]
"""

import os
import runpy
import sys

from support.paths import DOCS, TESTS

WRITERS = {
    "commands": "commands/test_commands.py",
    "docs": "docs/test_docs.py",
    "schema": "support/generated.py",
    "planted": "judges/planted/test_planted.py",
    "goldens": "judges/goldens/test_goldens.py",
    "from-xacro": "support/xacro_page.py",
    "imported": "importing/test_import_golden.py",
    "translated": "importing/test_translated.py",
    "messages": "support/cases.py",
    "findings": "verify/test_verify_faults.py",
    "pictures": "view/picture/test_picture_committed.py",
}


def main() -> None:
    """Run the module that writes what is asked for."""
    what, *rest = sys.argv[1:] or [""]
    if what not in WRITERS:
        raise SystemExit(f"python tests/renew.py {' | '.join(WRITERS)}")
    sys.argv = [what, *rest]
    os.environ["ROSORIN_COMPILE_PROGRESS"] = "off"  # what is committed depends on no clock
    sys.path.append(str(DOCS / "make"))
    runpy.run_path(str(TESTS / WRITERS[what]), run_name="__main__")


if __name__ == "__main__":
    main()
