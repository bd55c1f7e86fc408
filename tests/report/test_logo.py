"""Logos of a hostile campaign folder: pixels alone get into a report."""

from __future__ import annotations

import io

import pytest
from PIL import Image

from stiffcal.errors import InputError
from stiffcal.report.logo import MOST_BYTES, rasterised

WHERE = ("campaign.toml", "report.logo")
SVG = b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 20 10"><rect width="20" height="10" fill="#036"/>%s</svg>'


def png(width: int, height: int) -> bytes:
    written = io.BytesIO()
    Image.new("RGB", (width, height), (0, 51, 102)).save(written, format="PNG", pnginfo=None)
    return written.getvalue()


@pytest.mark.parametrize(("file", "content"), [("logo.png", png(40, 20)), ("a/logo.SVG", SVG % b"")])
def test_a_logo_becomes_pixels(file: str, content: bytes) -> None:
    with Image.open(io.BytesIO(rasterised(content, file, WHERE))) as picture:
        assert picture.format == "PNG"
        assert picture.width == 2 * picture.height
        assert picture.convert("RGB").getpixel((5, 5)) == (0, 51, 102)


@pytest.mark.parametrize(
    "part",
    [
        b'<image href="/etc/passwd"/>',
        b'<use xlink:href="other.svg#a"/>',
        b'<rect fill="url(http://host/x)"/>',
        b"<style>@import 'x.css'</style>",
        b"<script>1</script>",
        b"<foreignObject/>",
    ],
)
def test_an_svg_with_references_is_refused(part: bytes) -> None:
    with pytest.raises(InputError, match="refers to other files"):
        rasterised(SVG % part, "logo.svg", WHERE)


def test_an_svg_may_refer_to_its_own_parts() -> None:
    own = b'<defs><linearGradient id="g"/></defs><rect fill="url(#g)" width="1" height="1"/><use href="#g"/>'
    assert rasterised(SVG % own, "logo.svg", WHERE)


@pytest.mark.parametrize(
    ("file", "content", "reason"),
    [
        ("logo.jpg", b"", "not a PNG or SVG"),
        ("logo.png", b"\x89PNG" + bytes(MOST_BYTES), "larger than 1 MB"),
        ("logo.png", b"no picture", "cannot be read"),
        ("logo.png", png(5000, 5000), "cannot be read"),
        ("logo.svg", b"<svg", "cannot be read"),
        ("logo.svg", b'<!DOCTYPE svg [<!ENTITY a "b">]>' + SVG % b"&a;", "refers to other files"),
    ],
)
def test_other_files_are_refused_in_one_line(file: str, content: bytes, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        rasterised(content, file, WHERE)
