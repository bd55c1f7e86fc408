"""The tutorial on notebooks as a file that Jupyter opens: its words, its cells, what they print and draw."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path

from docs.page_blocks import Block, blocks_of, page_text
from docs.page_runs import PageRun, run_page

PAGE = "tutorials/notebook.md"
FILE = "missing-effect.ipynb"
_FENCE = re.compile(r"^```(?P<info>[^\n]*)\n(?P<body>.*?)^```$\n?", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"\[([^\]]+)\]\([^)]+\)")
_ROLE = re.compile(r"^.*\{download\}.*\n", re.MULTILINE)
_PICTURE = re.compile(r"\{picture\} (\S+)")


def write_notebook(folder: Path) -> None:
    """Write the notebook into a folder, from the run of the page's cells that the build keeps."""
    text = json.dumps(notebook(run_page(PAGE)), ensure_ascii=False, indent=1) + "\n"
    place = folder / FILE
    if not place.exists() or place.read_text(encoding="utf-8") != text:
        folder.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")


def notebook(done: PageRun) -> dict[str, object]:
    """Return the notebook as Jupyter's format 4.4 has it (nbformat 4)."""
    text, end = page_text(PAGE), 0
    cells: list[dict[str, object]] = []
    sources = iter([block for block in blocks_of(PAGE) if block.tag == "run"])
    for fence in _FENCE.finditer(text):
        _add_words(cells, text[end : fence.start()])
        end = fence.end()
        if fence["info"] == "python run":
            cells.append(_code(next(sources), done, 1 + sum(cell["cell_type"] == "code" for cell in cells)))
        elif picture := _PICTURE.match(fence["info"]):
            outputs = cells[-1]["outputs"]
            assert isinstance(outputs, list)
            outputs.append(_image(done.pictures[picture[1], 0]))
    _add_words(cells, text[end:])
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 4}


def _add_words(cells: list[dict[str, object]], text: str) -> None:
    """Add a cell of Markdown; links lead to pages, which a notebook does not have."""
    words = _LINK.sub(r"\1", _ROLE.sub("", text)).strip()
    if words:
        cells.append({"cell_type": "markdown", "metadata": {}, "source": words})


def _code(block: Block, done: PageRun, number: int) -> dict[str, object]:
    printed = done.printed[block.line]
    outputs = [{"output_type": "stream", "name": "stdout", "text": printed}] if printed else []
    source = block.text.rstrip("\n")
    return {"cell_type": "code", "metadata": {}, "execution_count": number, "source": source, "outputs": outputs}


def _image(picture: Path) -> dict[str, object]:
    data = {"image/png": base64.b64encode(picture.read_bytes()).decode()}
    return {"output_type": "display_data", "metadata": {}, "data": data}
