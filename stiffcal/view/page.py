"""From content to one HTML file: data packed into it, our scripts in a row, a policy that allows nothing else."""

from __future__ import annotations

import base64
import hashlib
import math
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.documents import Document
from stiffcal.escapes.html_text import escaped
from stiffcal.presentation.bars import table_of
from stiffcal.presentation.texts import printed_columns, printed_rows, text_of
from stiffcal.presentation.values import Bars, Table
from stiffcal.view.content import ViewContent, ViewForecast, ViewVariable
from stiffcal.view.packing import NOISE_SHARE, Packer

SCRIPTS = (
    "data.js", "words.js", "state.js", "scales.js", "movement.js", "draw.js", "legend.js", "bars.js", "svg.js",
    "elements.js", "saving.js", "pointer.js", "panel.js", "scatter.js", "proposals.js", "against.js", "values.js",
    "ladder.js", "camera.js", "solids.js", "raster.js", "meshes.js", "robot_parts.js", "robot_bodies.js",
    "robot.js", "effects.js", "poses.js", "compliance.js", "reading.js", "kind_points.js", "kind_picture.js",
    "kinds.js", "forecast.js", "chips.js", "tryout.js", "main.js",
)  # fmt: skip
"""In the order in which they are run; each adds to the one name ``stiffcal``."""
LIVE_SCRIPT = "live.js"
"""Before the last of them where a server sends the page: nothing else asks for anything."""
WATCH_SCRIPT = "watch.js"
"""After all others where the server follows the logs: alone on the page until there is something to show."""

_ROTATIONS = 3


def build_page(content: ViewContent, live: bool = False, watched: int | None = None) -> str:
    """Return the HTML file as a text; the same content gives the same text.

    Parameters
    ----------
    content : what it shows. live : whether it may ask the server that it came from.
    watched : the version of the logs that it shows, where the server follows them; None: it does not.
    """
    follows = [] if watched is None else [WATCH_SCRIPT]
    names = (*SCRIPTS[:-1], *([LIVE_SCRIPT] if live else []), SCRIPTS[-1], *follows)
    data = f'<script type="text/plain" id="data">{pack(content)}</script>\n'
    return _document(_read("body.html"), names, data, live, watched)


def build_waiting_page(reason: str, version: int = 0) -> str:
    """Return the page that a server sends until there is something to show: the logs alone.

    Parameters
    ----------
    reason : why what has come cannot be shown, "" where nothing has. version : of the logs.
    """
    text = escaped(reason) if reason else "No log has come yet; this page follows them."
    body = (
        '<main id="page" tabindex="-1">\n<header>\n<h1 id="title">stiffcal view</h1>\n'
        f'<p id="verdict">{text}</p>\n</header>\n<div id="panels"></div>\n</main>\n'
    )
    return _document(body, (WATCH_SCRIPT,), "", True, version)


def _document(body: str, scripts: Sequence[str], data: str, live: bool, watched: int | None) -> str:
    """Return the HTML of a page with our scripts, and with a policy that allows nothing else."""
    style = _read("style.css") + (_read("watch.css") if watched is not None else "")
    script = "\n".join(map(_read, scripts))
    connect = "; connect-src 'self'" if live else ""
    policy = (
        f"default-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}'; img-src data: blob:; "
        f"base-uri 'none'; form-action 'none'{connect}"
    )
    version = "" if watched is None else f'<meta name="watched" content="{watched}">\n'
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="referrer" content="no-referrer">\n'
        f'<link rel="icon" href="data:,">\n{version}'
        f"<title>stiffcal view</title>\n<style>{style}</style>\n</head>\n<body>\n{body}"
        f"{data}<script>{script}</script>\n</body>\n</html>\n"
    )


def _read(name: str) -> str:
    return (files("stiffcal.view") / name).read_text("utf-8")


def _hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"


def pack(content: ViewContent | ViewForecast) -> str:
    """Return content, or a forecast, as the text that the scripts read."""
    packer = Packer()

    def plain(value: Any, steps: tuple[float | None, float | None], name: str = "", whole: bool = False) -> Any:
        if name in _OF_WORDS and isinstance(value, tuple):
            return text_of(value)
        if isinstance(value, Bars):
            return plain(table_of(value), steps)
        if isinstance(value, Table):
            heads = [column.title + (f" [{unit}]" if unit else "") for column, unit in printed_columns(value)]
            rows = [list(row) for row in printed_rows(value)]
            return {"heads": heads, "rows": rows, "caption": value.caption, "kind_": "Table"}
        if is_dataclass(value) and not isinstance(value, type):
            whole = isinstance(value, ViewVariable) and bool(value.levels)
            steps = _steps(value) if isinstance(value, ViewContent) else steps
            document = {
                entry.name: plain(getattr(value, entry.name), steps, entry.name, whole) for entry in fields(value)
            }
            if isinstance(value, ViewContent):
                document["units"] = plain(value.units, steps)
            return document | {"kind_": type(value).__name__}
        if isinstance(value, np.ndarray):
            if value.dtype.kind in "biu":
                return packer.add_integers(value)
            if name in _OF_NOISE:
                translation = packer.add(value[:, :_ROTATIONS], steps[0])
                return [translation, packer.add(value[:, _ROTATIONS:], steps[1])]
            return packer.add(value, 1.0 if whole else _STEPS.get(name))
        if isinstance(value, dict) and name == "readings":
            return {key: packer.add(item, _fine(item)) for key, item in value.items()}
        if isinstance(value, dict):
            return {key: plain(item, steps, name) for key, item in value.items()}
        if isinstance(value, list | tuple | frozenset):
            return [plain(item, steps) for item in (sorted(value) if isinstance(value, frozenset) else value)]
        if isinstance(value, float | np.floating):
            return float(value) if math.isfinite(value) else None
        return value.item() if isinstance(value, np.generic) else value

    document: Document = plain(content, _steps(content) if isinstance(content, ViewContent) else (None, None))
    return packer.packed(document)


_OF_NOISE = frozenset({"residual_fit", "residual_heldout", "measured", "part"})
"""Arrays of translations (three columns) and rotations that are rounded by the noise."""
_OF_WORDS = frozenset({"words", "caption"})
"""Texts of kinds of experiment, piece by piece."""
_STEPS = {"chain": 1e-4, "target": 1e-4, "axes": 1e-4, "across": 1e-4, "points": 5e-4}
"""Steps of lengths and directions that only a picture shows, m and 1."""


def _fine(values: Floats) -> float | None:
    """Return the step of readings: nine digits of the largest."""
    return float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0)) * 1e-9 or None


def _steps(content: ViewContent) -> tuple[float | None, float | None]:
    """Return the steps of the first three and of the further columns: readings of each kind have noise of their own."""
    noise = content.noise
    if noise is None:
        return None, None
    return _step(getattr(noise, content.measure)), _step(noise.rotation)


def _step(noise: float | None) -> float | None:
    """Return the step of rounding from an rms length of the noise, which is of three components together."""
    return None if not noise else NOISE_SHARE * noise / math.sqrt(3.0)
