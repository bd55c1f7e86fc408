"""How Sphinx builds these pages: `make docs`."""

import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

import stiffcal  # noqa: E402
from docs.expansions import expand  # noqa: E402
from docs.generated_pages import write_pages  # noqa: E402
from docs.notebook_file import write_notebook  # noqa: E402
from docs.policy import hold_to_hashes  # noqa: E402
from docs.section_texts import write_section_texts  # noqa: E402

project = "stiffcal"
author = "the stiffcal authors"
release = version = stiffcal.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
autodoc_typehints = "none"
myst_enable_extensions = ["deflist"]
myst_heading_anchors = 3
# quotation marks and ellipses as printed; two hyphens stay, as options begin with them
smartquotes_action = "qe"
html_theme = "furo"
html_title = f"stiffcal {release}"
# Pages open from a disk: nothing is fetched, neither fonts nor scripts.
html_copy_source = False
# Extracts of the hits would be fetched, which browsers refuse to a page from a disk.
html_show_search_summary = False
html_show_copyright = False
html_static_path = ["static"]
html_css_files = ["pages.css"]
templates_path = ["templates"]
exclude_patterns = ["templates"]
AS_WRITTEN: dict[str, list[str]] = {}
"""Docstrings of attributes, while napoleon works on them."""


def setup(app: Any) -> None:
    """Write the reference pages before Sphinx looks for pages; put pictures and formulas into each page, and hashes."""
    app.connect("builder-inited", lambda _: write_pages(HERE / "reference" / "generated"))
    app.connect("builder-inited", lambda _: write_notebook(HERE / "reference" / "generated"))
    app.connect("source-read", expand_source)
    app.connect("autodoc-process-docstring", keep_words, priority=1)
    app.connect("autodoc-process-docstring", put_words_back, priority=900)
    app.connect("build-finished", finish)


def finish(app: Any, fault: Exception | None) -> None:
    """Write what the search needs, and the hashes of each page."""
    if fault is None and app.builder.format == "html":
        write_section_texts(Path(app.outdir) / "_static", app.env)
        hold_to_hashes(Path(app.outdir))


def keep_words(_app: Any, what: str, name: str, _thing: Any, _options: Any, lines: list[str]) -> None:
    """Remember the docstring of an attribute: napoleon takes what stands before its first colon for a type."""
    if what in ("attribute", "property"):
        AS_WRITTEN[name] = list(lines)


def put_words_back(_app: Any, what: str, name: str, _thing: Any, _options: Any, lines: list[str]) -> None:
    """Put back what `keep_words` has remembered."""
    if what in ("attribute", "property"):
        lines[:] = AS_WRITTEN.pop(name, lines)


def expand_source(_app: Any, name: str, source: list[str]) -> None:
    """Put pictures, drawings and formulas into the Markdown of a page."""
    source[0] = expand(f"{name}.md", source[0])
