"""The documentation builds without a warning, its tutorials run, its links lead somewhere, and it asks nobody."""

import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import analysis
import kernel
import sweep
from analysis.cli import parser as analysis_parser
from sweep.cli import parser as sweep_parser
from sweep.plan.spec import Spec
from sweep.schema import ROW

from . import measured
from .conftest import clean_environment

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("plot_*.py"))
README = (ROOT / "README.md").read_text()


class Page(HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.links, self.names, self.loads = [], set(), []
        self.feed(path.read_text())

    def handle_starttag(self, tag, attrs):
        told = dict(attrs)
        self.names |= {told[key] for key in ("id", "name") if told.get(key)}
        if tag == "a" and told.get("href"):
            self.links.append(told["href"])
        if tag in ("img", "script") and told.get("src"):
            self.loads.append(told["src"])
        if tag == "link" and told.get("rel") in ("stylesheet", "icon", "preload"):
            self.loads.append(told["href"])


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The pages, by their paths within the folder; built as `make docs` builds them, from a copy."""
    root = tmp_path_factory.mktemp("docs")
    made = shutil.ignore_patterns("_build", "_generated", "auto_tutorials", "sg_execution_times.rst")
    shutil.copytree(ROOT / "docs", root / "docs", ignore=made)
    for name in ("jobs", "tests"):
        (root / name).symlink_to(ROOT / name)
    shutil.copy(ROOT / "CONTRIBUTING.md", root)
    command = [sys.executable, "-P", "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "docs", "built"]
    done = subprocess.run(command, cwd=root, env=clean_environment(), capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr[-3000:]
    pages = {path.relative_to(root / "built").as_posix(): path for path in (root / "built").rglob("*.html")}
    return {name: (path, Page(path)) for name, path in pages.items() if not name.startswith("_")}


def test_every_tutorial_ran_and_shows_what_it_gave(built):
    assert len(TUTORIALS) == 6
    for tutorial in TUTORIALS:
        text = built[f"auto_tutorials/{tutorial.stem}.html"][0].read_text()
        assert "sphx_glr_plot" in text or "sphx-glr-script-out" in text
        assert "Traceback" not in text


def test_every_link_between_pages_leads_somewhere(built):
    for path, page in built.values():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or not (parts.path or parts.fragment):
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path.resolve()
            assert target.exists(), (path.name, link)
            if parts.fragment and target.suffix == ".html":
                names = next(other.names for where, other in built.values() if where.resolve() == target)
                assert unquote(parts.fragment) in names, (path.name, link)


def test_no_page_loads_anything_from_another_site(built):
    for path, page in built.values():
        assert [one for one in page.loads if urlsplit(one).scheme in ("http", "https")] == [], path.name


def test_every_key_column_and_command_is_explained(built):
    spec, table, commands = (built[f"{name}.html"][0].read_text() for name in ("spec", "table", "commands"))
    for name, field in Spec.model_fields.items():
        assert name in spec, name
        assert field is not None
    assert all(f">{name}<" in table for name in ROW.names)
    for top in (sweep_parser(), analysis_parser()):
        names = [name for action in top._actions for name in getattr(action, "choices", None) or () if action.nargs]
        assert len(names) > 5
        assert all(f"{top.prog} {name}" in commands for name in names)


def test_every_public_name_has_its_docstring(built):
    path, page = built["python.html"]
    public = [f"{package.__name__}.{name}" for package in (kernel, sweep, analysis) for name in package.__all__]
    assert {name for name in public if "__" not in name} <= page.names
    assert ".. auto" not in path.read_text()


def test_the_readme_is_short_and_its_links_lead_somewhere():
    assert len(README.splitlines()) <= 120
    assert measured.markdown("promises") in README, "the table as tests.promises --keep found it"
    for link in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / link).exists(), link


def test_what_the_documentation_says_of_the_version_is_the_packages_own():
    from kernel.version import __version__

    assert f"version: {__version__}\n" in (ROOT / "CITATION.cff").read_text()
