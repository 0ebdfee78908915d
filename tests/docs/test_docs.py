"""The documentation holds: its files compile, its commands print what the page shows, its links lead somewhere.

How a page is read. An HTML comment on the line above a block says what to do with the block:

    <!-- file: PATH -->       it is written to PATH
    <!-- edit: PATH -->       it is a diff: in PATH, its lines with "-" become those with "+"

and ``<!-- continues: PAGE -->`` means that the files and commands of another page come before. In a ``console`` block
each line that begins with "$ " is run in the folder of the page, and what it prints is compared with the lines below
it; a line "..." there stands for any lines. A ``python`` block that begins with ">>> " is a session: it is run at the
top of the project, with what the sessions above it on the page have defined.

    python tests/renew.py docs [PAGE...]

writes into the pages what the commands print now, then those that a generator makes (``support.generated``). With
arguments, such as ``frames``, only these pages are renewed. What a page shows with "..." is left to its author, and
named.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.source.diagnostics import text as report
from support.generated import GENERATED, generate, language_pages
from support.pages import ELLIPSIS, FENCED, README, blocks, play
from support.paths import DOCS, ROOT, TESTS

HEAD = DOCS / "_language_head.md"
RULES_HEAD = DOCS / "_rules_head.md"
LIBRARY_HEAD = DOCS / "_library_head.md"
PAGES = sorted(path for path in DOCS.glob("*.md") if not path.name.startswith("_"))

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#{1,6} (.+)$", re.MULTILINE)


def links(text: str) -> list[str]:
    """Return the targets of the links of a page; what looks like one in code is none."""
    return LINK.findall(re.sub(r"`[^`\n]*`", "", FENCED.sub("", text)))


def anchors(text: str) -> set[str]:
    """Return the anchors of a page: those that GitHub gives to its headings, and those that it has itself."""
    headings = HEADING.findall(FENCED.sub("", text))
    own = set(re.findall(r'<a id="([^"]+)"></a>', text))
    return own | {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in headings}


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_page_holds(page: Path, tmp_path: Path) -> None:
    for ran in play(page, tmp_path):
        shown = "\n".join(ran.shown)
        printed = "\n".join(ran.printed)
        assert ran.holds, f"{page.name}:{ran.start}: $ {ran.command}\nshown:\n{shown}\nprinted:\n{printed}"
    for path in sorted(tmp_path.glob("descriptions/*/robot.yaml")):
        made = compile_robot(path)
        assert made.robot is not None, report(made.diagnostics)


def checkout(folder: Path) -> Path:
    for name in ("descriptions", "outputs", "tests/imported", "tests/data/recordings"):
        shutil.copytree(ROOT / name, folder / name)
    return folder


def test_readme_holds(tmp_path: Path) -> None:
    pytest.importorskip("numpy")  # the extra [verify]
    ran = play(README, checkout(tmp_path))
    assert len(ran) >= 3
    for one in ran:
        assert one.holds, f"$ {one.command}\nprinted:\n" + "\n".join(one.printed)


def test_the_tutorial_shows_the_template() -> None:
    written = (ROOT / "templates" / "start" / "base" / "robot.yaml").read_text("utf-8").splitlines()
    shown = [
        block
        for block in blocks((DOCS / "tutorial.md").read_text("utf-8"))
        if block.language == "yaml" and not block.mark[0]
    ]
    assert len(shown) > 3
    assert [line for block in shown for line in block.lines if line and line not in written] == []


@pytest.mark.parametrize(
    "page",
    [*PAGES, *sorted((DOCS / "language").glob("*.md")), *sorted(ROOT.glob("*.md")), TESTS / "README.md"],
    ids=lambda page: page.relative_to(ROOT).as_posix(),
)
def test_links_lead_somewhere(page: Path) -> None:
    for target in links(page.read_text("utf-8")):
        if target.startswith("https://"):
            continue
        name, _, anchor = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        assert path.exists(), f"{page.name}: {target}"
        assert DOCS not in page.parents or DOCS in path.parents, f"{page.name}: {target} is not on the site"
        assert not anchor or anchor in anchors(path.read_text("utf-8")), f"{page.name}: {target}"


def test_the_tree_of_frames_is_the_artifact() -> None:
    """The site has only files of docs/, so the picture is a copy."""
    picture = "frames_slam.svg"
    assert (DOCS / "pictures" / picture).read_bytes() == (ROOT / "outputs" / "rosorin" / picture).read_bytes()


def test_python_on_a_page_runs(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    page = DOCS / "artifacts.md"
    play(page, tmp_path)
    (block,) = [block for block in blocks(page.read_text("utf-8")) if block.language == "python"]
    subprocess.run([sys.executable, "-c", "\n".join(block.lines)], cwd=tmp_path, check=True, capture_output=True)


def test_excerpts_are_those_of_the_examples() -> None:
    """The blocks of extend.md that no command runs are excerpts of files in examples/, whose tests run them."""
    files = sorted(path for path in (ROOT / "examples").glob("rosorin-*/**/*.*") if path.is_file())
    texts = [path.read_text("utf-8") for path in files if path.suffix in (".py", ".json", ".yaml")]
    excerpts = [block for block in blocks((DOCS / "extend.md").read_text("utf-8")) if not block.mark[0]]
    for block in excerpts:
        if block.language in ("python", "json", "yaml"):
            assert any("\n".join(block.lines) in text for text in texts), "\n".join(block.lines)


def rewrite(page: Path) -> None:
    lines = page.read_text("utf-8").splitlines()
    with tempfile.TemporaryDirectory() as folder:
        ran = play(page, checkout(Path(folder)) if page == README else Path(folder))
    for command in reversed(ran):
        if ELLIPSIS not in command.shown:
            lines[command.start : command.start + len(command.shown)] = command.printed
        elif not command.holds:
            sys.stderr.write(f"{page.name}:{command.start}: $ {command.command}\n" + "\n".join(command.printed) + "\n")
    page.write_text("\n".join(lines) + "\n", "utf-8")


if __name__ == "__main__":
    for each in [HEAD, RULES_HEAD, LIBRARY_HEAD, README, *PAGES]:
        if each.stem not in (sys.argv[1:] or [each.stem]):
            continue
        if each == DOCS / "language.md":
            for path, text in language_pages().items():
                path.write_text(text, "utf-8")
        elif each in GENERATED:
            generate(each)
        else:
            rewrite(each)
