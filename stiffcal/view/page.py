"""From content to one HTML file: data packed into it, our scripts in a row, a policy that allows nothing else."""

from __future__ import annotations

import base64
import hashlib
import math
from dataclasses import fields, is_dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.documents import Document
from stiffcal.view.content import ViewContent, ViewModel, ViewVariable
from stiffcal.view.packing import NOISE_SHARE, Packer

SCRIPTS = (
    "data.js", "words.js", "state.js", "scales.js", "movement.js", "draw.js", "bars.js", "svg.js", "elements.js",
    "saving.js", "pointer.js", "panel.js", "scatter.js", "proposals.js", "against.js", "values.js", "ladder.js",
    "camera.js", "solids.js", "robot.js", "effects.js", "poses.js", "reading.js", "kind_points.js", "kind_picture.js",
    "kinds.js", "forecast.js", "tryout.js", "main.js",
)  # fmt: skip
"""In the order in which they are run; each adds to the one name ``stiffcal``."""
LIVE_SCRIPT = "live.js"
"""Before the last of them where a server sends the page: nothing else asks for anything."""

_ROTATIONS = 3


def build_page(content: ViewContent, live: bool = False) -> str:
    """Return the HTML file as a text; the same content gives the same text.

    Parameters
    ----------
    content : what it shows. live : whether it may ask the server that it came from.
    """
    folder = files("stiffcal.view")
    style = (folder / "style.css").read_text("utf-8")
    names = (*SCRIPTS[:-1], *([LIVE_SCRIPT] if live else []), SCRIPTS[-1])
    script = "\n".join((folder / name).read_text("utf-8") for name in names)
    data = pack(content)
    connect = "; connect-src 'self'" if live else ""
    policy = (
        f"default-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}'; img-src data: blob:; "
        f"base-uri 'none'; form-action 'none'{connect}"
    )
    body = (folder / "body.html").read_text("utf-8")
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="referrer" content="no-referrer">\n'
        '<link rel="icon" href="data:,">\n'
        f"<title>stiffcal view</title>\n<style>{style}</style>\n</head>\n<body>\n{body}"
        f'<script type="text/plain" id="data">{data}</script>\n<script>{script}</script>\n</body>\n</html>\n'
    )


def _hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"


def pack(content: ViewContent | ViewModel) -> str:
    """Return content, or a single model of it, as the text that the scripts read."""
    packer = Packer()

    def plain(value: Any, steps: tuple[float | None, float | None], name: str = "", whole: bool = False) -> Any:
        if is_dataclass(value) and not isinstance(value, type):
            whole = isinstance(value, ViewVariable) and bool(value.levels)
            steps = _steps(value) if isinstance(value, ViewContent) else steps
            document = {
                entry.name: plain(getattr(value, entry.name), steps, entry.name, whole) for entry in fields(value)
            }
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
_STEPS = {"chain": 1e-4, "target": 1e-4, "axes": 1e-4}
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
