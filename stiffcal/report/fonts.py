r"""Fonts for pages and pictures: matplotlib's own DejaVu, and for letters that it lacks what this machine has.

Names of robots and runs may be Chinese or Japanese, or hold an emoji. DejaVu has Latin, Greek, Cyrillic, Arabic and
Hebrew letters; for others the fonts of the system are searched, and only then: a report without such letters has the
same bytes on every machine. A letter that no font has is written out as ``\u59ff``, as an empty box would not identify
it.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache, partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiffcal.escapes.typst_text import escaped

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Text

FONT_FILES = (
    "DejaVuSans.ttf",
    "DejaVuSans-Bold.ttf",
    "DejaVuSans-Oblique.ttf",
    "DejaVuSans-BoldOblique.ttf",
    "DejaVuSansMono.ttf",
)
_PLAIN_END = 0x250  # Latin letters with their accents: DejaVu has all of them
KNOWN = frozenset("–—‘’“”…′″−≈≤≥≠√∞∥→←↑↓ΔΣΩαβγδεζηθικλμνξπρστυφχψω⁰⁴⁵⁶⁷⁸⁹⁻₀₁₂₃₄₅₆₇₈₉\u2009\u200a\u200b\u200c\u202f")
"""Letters of sentences and formulas that DejaVu has: no font is read for them."""
_ENDINGS = {".ttf", ".otf", ".ttc"}


def own_fonts() -> list[Path]:
    """Return the files of the fonts that every report has."""
    # found without loading matplotlib, which takes as long as to set a page
    found = find_spec("matplotlib")
    if found is None or found.origin is None:
        raise ModuleNotFoundError("matplotlib", name="matplotlib")
    folder = Path(found.origin).parent / "mpl-data" / "fonts" / "ttf"
    return [folder / name for name in FONT_FILES]


def is_in_own_letters(text: str) -> bool:
    """Return whether DejaVu has all letters of a text, and none was written out because no font has it."""
    return not _unusual([text]) and "\\u" not in text and "\\U" not in text


def further_fonts(texts: Iterable[str]) -> list[Path]:
    """Return the files of the system's fonts that have letters of these texts which DejaVu lacks."""
    wanted = _unusual(texts)
    return list(_fonts_covering(wanted)[0]) if wanted else []


@lru_cache(maxsize=4096)  # the labels of ticks come again with every picture
def drawable(text: str) -> str:
    """Return a text with what is hidden, and what no font here has, written out."""
    text = escaped(text)
    wanted = _unusual([text])
    lost = _fonts_covering(wanted)[1] if wanted else frozenset()
    return "".join(c.encode("unicode_escape").decode("ascii") if c in lost else c for c in text) if lost else text


def drawable_data(value: Any) -> Any:
    """Return the data of a page with all texts in it as `drawable` has them."""
    if isinstance(value, str):
        return drawable(value)
    if isinstance(value, dict):
        return {key: drawable_data(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [drawable_data(item) for item in value]
    return value


def texts_of(value: Any) -> set[str]:
    """Return every text in the data of a page."""
    if isinstance(value, str):
        return {value}
    items = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ()
    return {text for item in items for text in texts_of(item)}


def make_drawable(figure: Figure) -> bool:
    """Write out in a picture's texts what is hidden, and give letters that DejaVu lacks a font that has them.

    Returns
    -------
    Whether labels of ticks were given fonts of their own.
    """
    has_unusual_ticks = False
    for panel in figure.axes:
        for axis in (panel.xaxis, panel.yaxis):
            formatter = axis.get_major_formatter()  # when drawn it would give its ticks the old texts again
            has_unusual_ticks = has_unusual_ticks or bool(
                _unusual(formatter.format_ticks(axis.get_majorticklocs().tolist()))
            )
            vars(formatter)["format_ticks"] = partial(_drawable_ticks, formatter.format_ticks)
    for text in _texts(figure, with_ticks=has_unusual_ticks):
        written = text.get_text()
        text.set_text(drawable(written))
        families = [_family(file) for file in further_fonts([written])]
        if families:
            text.set_fontfamily(["DejaVu Sans", *families])
    return has_unusual_ticks


def _texts(figure: Figure, with_ticks: bool) -> list[Text]:
    """Return a figure's texts; those of its ticks, of which there are hundreds, only where they need a font."""
    from matplotlib.text import Text

    if with_ticks:
        return [text for text in figure.findobj(Text) if isinstance(text, Text)]
    legends = list(figure.legends)
    texts = list(figure.texts)
    for panel in figure.axes:
        texts += [panel.xaxis.label, panel.yaxis.label]
        # the panel's own texts and titles, not those of its axes
        texts += [child for child in panel.get_children() if isinstance(child, Text)]
        legend = panel.get_legend()
        legends += [legend] if legend is not None else []
    return texts + [text for legend in legends for text in (*legend.get_texts(), legend.get_title())]


def _drawable_ticks(format_ticks: Callable[[Any], list[str]], values: Any) -> list[str]:
    return [drawable(label) for label in format_ticks(values)]


@contextmanager
def silence_font_notices() -> Iterator[None]:
    """Keep matplotlib from printing that a further font has another weight than DejaVu."""
    log = logging.getLogger("matplotlib.font_manager")
    before = log.level
    log.setLevel(logging.ERROR)
    try:
        yield
    finally:
        log.setLevel(before)


def _unusual(texts: Iterable[str]) -> frozenset[str]:
    unusual = {c for text in texts if not text.isascii() for c in text if ord(c) >= _PLAIN_END} - KNOWN
    return frozenset(c for c in unusual if ord(c) not in _own_letters()) if unusual else frozenset()


@lru_cache(maxsize=1)
def _own_letters() -> frozenset[int]:
    return _letters(own_fonts()[0])


@lru_cache(maxsize=64)
def _letters(file: Path) -> frozenset[int]:
    """Return the code points that a font has; none where the file is no font."""
    from matplotlib.ft2font import FT2Font

    try:
        return frozenset(FT2Font(str(file)).get_charmap())
    except (OSError, RuntimeError, ValueError):
        return frozenset()


@lru_cache(maxsize=16)
def _fonts_covering(wanted: frozenset[str]) -> tuple[tuple[Path, ...], frozenset[str]]:
    """Return fonts of the system that cover the letters, the one with most first, and the letters that none has."""
    missing, chosen = {ord(c) for c in wanted}, []
    letters_of_font = {file: missing & _letters(file) for file in _system_fonts()}
    while missing and letters_of_font:
        best = max(sorted(letters_of_font), key=lambda file: len(letters_of_font[file] & missing))
        if not letters_of_font[best] & missing:
            break
        chosen.append(best)
        missing -= letters_of_font.pop(best)
    return tuple(chosen), frozenset(chr(code) for code in missing)


def _system_fonts() -> list[Path]:
    from matplotlib.font_manager import findSystemFonts

    files = (Path(file) for file in findSystemFonts())
    return sorted(file for file in files if file.suffix.lower() in _ENDINGS and "LastResort" not in file.name)


@lru_cache(maxsize=16)
def _family(file: Path) -> str:
    """Make a font known to matplotlib, and return its name."""
    from matplotlib.font_manager import FontProperties, fontManager

    fontManager.addfont(str(file))
    return str(FontProperties(fname=str(file)).get_name())
