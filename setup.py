"""What pyproject.toml cannot say: when a wheel is built, the templates of formats are compiled to Python."""

import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

TEMPLATES = Path("templates")
sys.path.insert(0, "compiler")


class BuildPy(build_py):
    """Copies the packages, and puts the compiled templates beside the templates."""

    def run(self) -> None:
        super().run()
        if self.editable_mode:  # there they are made at the first use
            return
        from rosorin_compile.formats.ahead import FOLDER, Unsuited, module_of, python_of

        folder = Path(self.build_lib, "rosorin_compile", TEMPLATES, FOLDER)
        folder.mkdir(exist_ok=True)
        (folder / "__init__.py").touch()
        for file in sorted(TEMPLATES.glob("*.jinja")):
            if file.name.startswith(("package_", "license_")):  # of a command
                continue
            try:
                made = python_of(file.name, file.read_text("utf-8"))
            except Unsuited:  # a page's, which comes with Jinja
                continue
            (folder / f"{module_of(file.name)}.py").write_text(made, "utf-8")


setup(cmdclass={"build_py": BuildPy})
