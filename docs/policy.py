"""The Content-Security-Policy of each built page: its own files, and inline scripts and styles by their SHA-256 alone.

The theme writes a few lines of script and style into every page. `'unsafe-inline'` would allow these and all others; a
hash allows exactly the text that stands there when the page is built.
"""

from __future__ import annotations

import base64
import hashlib
import html
import re
from collections.abc import Iterable
from pathlib import Path

SCRIPTS, STYLES = "SCRIPT-HASHES", "STYLE-HASHES"
"""What `templates/page.html` holds in place of the hashes."""
_SCRIPT = re.compile(r"<script\b(?![^>]*\bsrc=)[^>]*>(.*?)</script>", re.DOTALL)
_STYLE = re.compile(r"<style\b[^>]*>(.*?)</style>", re.DOTALL)
_ATTRIBUTE = re.compile(r"<[^>]*?\sstyle=\"([^\"]*)\"")


def hold_to_hashes(folder: Path) -> None:
    """Put the hashes into the policy of every page below a folder that has none yet."""
    for page in sorted(folder.rglob("*.html")):
        text = page.read_text(encoding="utf-8")
        if SCRIPTS in text:
            page.write_text(with_hashes(text), encoding="utf-8")


def with_hashes(text: str) -> str:
    """Return a page whose policy names the scripts and styles in it.

    Examples
    --------
    >>> with_hashes("SCRIPT-HASHES <script>1</script>").partition(" ")[0]
    "'sha256-a4ayc/80/OGda4BO/1o/V0etpOqiLx1JwB5S3beHW0s='"
    """
    attributes = [html.unescape(style) for style in _ATTRIBUTE.findall(text)]
    styles = [*(["'unsafe-hashes'"] if attributes else []), *_hashes([*_STYLE.findall(text), *attributes])]
    return text.replace(SCRIPTS, " ".join(_hashes(_SCRIPT.findall(text)))).replace(STYLES, " ".join(styles))


def _hashes(texts: Iterable[str]) -> list[str]:
    """Return a source of a policy for each of different texts."""
    digests = (hashlib.sha256(text.encode()).digest() for text in dict.fromkeys(texts))
    return [f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests]
