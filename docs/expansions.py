"""What the pages write in their own short forms, put into Markdown before Sphinx reads it.

`{equation}` is a formula in the field's plain notation, `{drawing} NAME` one of `docs/drawings.py`, `{picture} FILE` a
file that the commands of the page make, and `{picture} FILE page N` one page of a PDF.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from docs.drawings import DRAWINGS
from docs.formulas import mathml
from docs.page_blocks import GENERATED
from docs.page_runs import picture_name, run_page

FENCE = re.compile(r"^```\{(equation|drawing|picture)\} ?([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PICTURES = GENERATED / "pictures"


def expand(page: str, text: str) -> str:
    """Return a page's Markdown with formulas, drawings and pictures in it.

    Parameters
    ----------
    page : its name relative to docs/, such as how-to/friction.md.
    text : its Markdown.
    """

    def replaced(match: re.Match[str]) -> str:
        kind, argument, body = match.groups()
        if kind == "equation":
            return f'<div class="equation">{mathml(body.strip())}</div>'
        if kind == "drawing":
            caption = body.strip() or f"`python -m docs.drawings {argument}`"
            return f"<figure>{DRAWINGS[argument]()}</figure>\n\n*{caption}*"
        return _picture(page, argument, body)

    return FENCE.sub(replaced, text)


def _picture(page: str, argument: str, body: str) -> str:
    """Return the figure of a file that the page's commands make; the body is what it shows."""
    file, _, number = argument.partition(" page ")
    wanted = file, int(number or 0)
    made = run_page(page, pictures_alone=True).pictures[wanted]
    folder = PICTURES / page.removesuffix(".md").replace("/", "-")
    folder.mkdir(parents=True, exist_ok=True)
    place = folder / picture_name(*wanted)
    if not place.exists() or place.read_bytes() != made.read_bytes():
        shutil.copyfile(made, place)
    return figure(place, body)


def figure(place: Path, words: str) -> str:
    """Return the directive that shows a picture; what it shows is its caption and its text for who cannot see it."""
    alt = " ".join(words.split())
    source = "/" + place.relative_to(GENERATED.parents[1]).as_posix()
    return f"```{{figure}} {source}\n:alt: {alt.replace('`', '')}\n\n{alt}\n```"
