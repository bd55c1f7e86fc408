"""A logo for the first page: PNG or SVG of a campaign folder, turned into pixels before it gets into a PDF.

Campaign folders are hostile: an SVG may name other files, a picture may unpack to more than memory holds.
"""

from __future__ import annotations

import io
import re
import tempfile
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

MOST_BYTES = 1_000_000
MOST_PIXELS = 16_000_000
_WIDTH_MM, _PPI = 40.0, 300.0
# What makes an SVG refer to something that is not in it, or run something.
_REFERENCES = re.compile(
    rb"<!DOCTYPE|<!ENTITY|<\?xml-stylesheet|<script|<foreignObject|<image|@import|javascript:"
    rb"|href\s*=\s*[\"'](?!#)|url\(\s*[\"']?(?!#)",
    re.IGNORECASE,
)


def rasterised(content: bytes, file: str, where: tuple[str, str]) -> bytes:
    """Return a logo as a PNG without anything else in it.

    Parameters
    ----------
    content : of the file. file : its name, whose ending states the format. where : file and key that name it.

    Raises
    ------
    InputError : no PNG or SVG, too large, or an SVG with references.
    """
    ending = Path(file).suffix.lower()
    if ending not in (".png", ".svg"):
        raise InputError.at(
            FaultCode.FORMAT_UNKNOWN, *where, f"{file} is not a PNG or SVG file", "use a .png or .svg file"
        )
    if len(content) > MOST_BYTES:
        raise InputError.at(FaultCode.SIZE_EXCEEDED, *where, f"{file} is larger than 1 MB", "use a smaller picture")
    if ending == ".svg" and _REFERENCES.search(content):
        reason = f"{file} refers to other files, or contains a picture or a script"
        raise InputError.at(FaultCode.FORMAT_UNKNOWN, *where, reason, "save it as plain paths, or as PNG")
    try:
        return _pixels_of_png(content) if ending == ".png" else _pixels_of_svg(content)
    except (OSError, ValueError, RuntimeError, SyntaxError) as error:
        reason = f"{file} cannot be read as a picture"
        raise InputError.at(FaultCode.FORMAT_UNKNOWN, *where, reason, "save it again as PNG") from error


def _pixels_of_png(content: bytes) -> bytes:
    from PIL import Image

    with Image.open(io.BytesIO(content), formats=("PNG",)) as picture:
        if picture.width * picture.height > MOST_PIXELS:
            raise ValueError("too many pixels")
        picture.load()
        plain = picture.convert("RGBA")
    written = io.BytesIO()
    plain.save(written, format="PNG")
    return written.getvalue()


def _pixels_of_svg(content: bytes) -> bytes:
    import typst

    page = f'#set page(width: {_WIDTH_MM}mm, height: auto, margin: 0pt, fill: none)\n#image("logo.svg", width: 100%)\n'
    with tempfile.TemporaryDirectory(prefix="stiffcal-logo-") as folder:
        (Path(folder) / "logo.svg").write_bytes(content)
        (Path(folder) / "logo.typ").write_text(page, encoding="utf-8")
        no_fonts = typst.Fonts(include_system_fonts=False, include_embedded_fonts=False)
        pixels = typst.compile(str(Path(folder) / "logo.typ"), root=folder, font_paths=no_fonts, format="png", ppi=_PPI)
    return _pixels_of_png(pixels)
