"""The site of the documentation, which zensical.toml configures: it builds strictly and needs no other host."""

import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

from support.paths import DOCS, ROOT

CONFIGURATION = (ROOT / "zensical.toml").read_text("utf-8")
PAGES = sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md") if not path.name.startswith("_"))
# Browsers load the targets of these attributes; that of a link to click is not loaded.
LOADED = {"src", "srcset", "data", "poster"}
LOADED_LINKS = {"stylesheet", "icon", "preload", "modulepreload", "prefetch", "preconnect", "dns-prefetch", "manifest"}
ELSEWHERE = re.compile(r"^\s*(?:\w+:)?//")


class Loads(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        self.addresses += [value for name, value in values.items() if name in LOADED]
        if tag == "link" and LOADED_LINKS & set(values.get("rel", "").split()):
            self.addresses.append(values["href"])


@pytest.fixture(scope="module")
def zensical(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pinned = re.search(r"zensical==\S+", CONFIGURATION)
    assert pinned
    folder = tmp_path_factory.mktemp("zensical")
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    subprocess.run([folder / "bin/pip", "install", "--quiet", pinned[0]], check=True)
    return folder / "bin/zensical"


@pytest.fixture(scope="module")
def site(zensical: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    assert " build --clean --strict\n" in CONFIGURATION
    project = copied(tmp_path_factory.mktemp("project"))
    built = build(zensical, project)
    assert built.returncode == 0, built.stdout + built.stderr
    return project / "site"


def copied(project: Path) -> Path:
    shutil.copytree(DOCS, project / "docs")
    shutil.copy(ROOT / "zensical.toml", project)
    return project


def build(zensical: Path, project: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([zensical, "build", "--clean", "--strict"], cwd=project, capture_output=True, text=True)


def folder_of(page: str) -> str:
    return "" if page == "README.md" else page.removesuffix(".md") + "/"


def test_every_page_is_in_the_navigation_once() -> None:
    assert sorted(re.findall(r'"([\w/-]+\.md)"', CONFIGURATION)) == PAGES


@pytest.mark.slow
@pytest.mark.tier("outside")
def test_the_site_has_every_page_and_a_search_index(site: Path) -> None:
    built = sorted(path.relative_to(site).as_posix() for path in site.rglob("*.html"))
    assert built == sorted(["404.html", *(f"{folder_of(page)}index.html" for page in PAGES)])
    assert "override" in (site / "search.json").read_text("utf-8")


@pytest.mark.slow
@pytest.mark.tier("outside")
@pytest.mark.parametrize("link", ["no-page.md", "sensors.md#no-such-section"])
def test_a_broken_link_fails_the_build(zensical: Path, tmp_path: Path, link: str) -> None:
    page = copied(tmp_path) / "docs" / "parts.md"
    page.write_text(page.read_text("utf-8") + f"\n[broken]({link})\n", "utf-8")
    built = build(zensical, tmp_path)
    assert built.returncode != 0
    assert "does not exist" in built.stdout + built.stderr


@pytest.mark.slow
@pytest.mark.tier("outside")
def test_no_page_loads_anything_from_another_host(site: Path) -> None:
    found = []
    for path in site.rglob("*.html"):
        page = Loads()
        page.feed(path.read_text("utf-8"))
        found += [f"{path.name}: {address}" for address in page.addresses if ELSEWHERE.match(address)]
    for path in (*site.rglob("*.css"), *site.rglob("*.html")):
        loaded = re.findall(r"(?:url\(|@import\s)\s*[\"']?((?:https?:)?//[^\"')\s]+)", path.read_text("utf-8"))
        found += [f"{path.name}: {address}" for address in loaded]
    assert found == []
