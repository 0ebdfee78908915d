"""What pyproject.toml cannot say: when a wheel is built, templates, a schema and records of formats become Python."""

import json
import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

TEMPLATES = Path("templates")
SCHEMA = "description"  # what every run asks for
sys.path.insert(0, "compiler")


class BuildPy(build_py):
    """Copies the packages, and puts what is compiled ahead beside what it was."""

    def run(self) -> None:
        super().run()
        if self.editable_mode:  # there they are made at the first use
            return
        from rosorin_compile.formats import FORMATS, RECORDS, is_built_in
        from rosorin_compile.formats.ahead import Unsuited, module_of, python_of, records_of

        records = records_of(one for one in FORMATS.values() if is_built_in(one.name))
        Path(self.build_lib, "rosorin_compile", "formats", f"{RECORDS}.py").write_text(records, "utf-8")
        schema = json.loads(Path("schemas", f"{SCHEMA}.schema.json").read_text("utf-8"))
        (self.ahead("schemas") / f"{SCHEMA}.py").write_text(f"SCHEMA = {schema!r}\n", "utf-8")
        folder = self.ahead("templates")
        for file in sorted(TEMPLATES.glob("*.jinja")):
            if file.name.startswith(("package_", "license_")):  # of a command
                continue
            try:
                made = python_of(file.name, file.read_text("utf-8"))
            except Unsuited:  # a page's, which comes with Jinja
                continue
            (folder / f"{module_of(file.name)}.py").write_text(made, "utf-8")

    def ahead(self, data: str) -> Path:
        """Return a new package of modules in a package of data."""
        from rosorin_compile.formats.ahead import FOLDER

        folder = Path(self.build_lib, "rosorin_compile", data, FOLDER)
        folder.mkdir(exist_ok=True)
        (folder / "__init__.py").touch()
        return folder


setup(cmdclass={"build_py": BuildPy})
