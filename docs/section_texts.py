"""The text of every section, so that a search ends at its heading: data of `static/search_sections.js`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def write_section_texts(folder: Path, environment: Any) -> None:
    """Write the sections of all built pages as one script into the folder of static files.

    Parameters
    ----------
    environment : Sphinx's, after the build.
    """
    texts = {page: section_texts(environment.get_doctree(page)) for page in sorted(environment.found_docs)}
    script = f"const SECTION_TEXTS = {json.dumps(texts, ensure_ascii=False, separators=(',', ':'))};\n"
    (folder / "section_texts.js").write_text(script, encoding="utf-8")


def section_texts(page: Any) -> list[tuple[str, str, str]]:
    """Return (anchor, title, words in lower case) of each section, without those in it; anchor "" of the page itself.

    Parameters
    ----------
    page : a document of docutils.
    """
    found = []
    for section in page.findall(lambda node: node.tagname == "section"):
        title = next((part.astext() for part in section.children if part.tagname == "title"), "")
        own = " ".join(part.astext() for part in section.children if part.tagname not in ("title", "section"))
        anchor = "" if section.parent is page else section["ids"][0]
        found.append((anchor, title, " ".join(dict.fromkeys(own.lower().split()))))
    return found
