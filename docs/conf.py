"""How the documentation is built: `make docs`. What can be read from the code is written by `generate.py` first."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
sys.path.append(str(HERE.parent))  # for tests.measured; last, so that kernel, sweep, analysis are the installed ones

import generate  # noqa: E402
from docutils import nodes  # noqa: E402

from kernel.version import __version__  # noqa: E402

generate.everything(HERE / "_generated")

project, author, release = "bistable-sweep", "the bistable-sweep authors", __version__
copyright = "the bistable-sweep authors"  # noqa: A001 (Sphinx's name)
extensions = [
    *("myst_parser", "sphinx.ext.autodoc", "numpydoc"),
    "sphinx_gallery.gen_gallery",
]
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 3
html_math_renderer = "mathml"
exclude_patterns = ["_build", "_generated", "tutorials"]
suppress_warnings = ["config.cache"]
numpydoc_show_class_members = False
sphinx_gallery_conf = {
    "examples_dirs": "tutorials",
    "gallery_dirs": "auto_tutorials",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "show_memory": False,
    "capture_repr": (),
    "download_all_examples": False,
    "remove_config_comments": True,
    "min_reported_time": 1e9,
    "write_computation_times": False,
}
html_theme = "pydata_sphinx_theme"
html_title = "bistable-sweep"
html_theme_options = {
    "show_prev_next": True,
    "header_links_before_dropdown": 4,
    "navigation_with_keys": False,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
    "logo": {"text": "bistable-sweep"},
}
html_sidebars = {page.stem: [] for page in Path(__file__).parent.glob("*.md")} | {
    "auto_tutorials/*": ["sidebar-nav-bs"]
}
html_show_sourcelink = False
html_static_path, html_css_files = ["_static"], ["pages.css"]


def setup(app):
    """Formulas as MathML, which browsers draw by themselves: the pages ask no other site for a script."""
    from latex2mathml.converter import convert

    def inline(self, node):
        self.body.append(convert(node.astext()))
        raise nodes.SkipNode

    def display(self, node):
        self.body.append(f'<div class="math">{convert(node.astext(), display="block")}</div>')
        raise nodes.SkipNode

    app.add_html_math_renderer("mathml", (inline, None), (display, None))
