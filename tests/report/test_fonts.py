"""Letters that the report's own font lacks: a font of the system where one has them, else written out, never a box."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

import pytest

from stiffcal.report import fonts
from stiffcal.report.drawing_library import drawing_library
from stiffcal.report.figures import canvas
from stiffcal.report.fonts import drawable, further_fonts, own_fonts

STIX = Path(drawing_library().get_data_path()) / "fonts" / "ttf" / "STIXGeneral.ttf"
OF_STIX = "\u1d81"
"""A letter that DejaVu Sans lacks and STIX has."""


@pytest.fixture
def system(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Path]]:
    """The fonts of the system, which a test puts there."""
    there: list[Path] = []
    monkeypatch.setattr(fonts, "_system_fonts", lambda: there)
    fonts._fonts_covering.cache_clear()
    yield there
    fonts._fonts_covering.cache_clear()


def test_ordinary_texts_need_no_further_font(system: list[Path]) -> None:
    system.append(STIX)
    assert further_fonts(["Prüfstand 5 µm, 2·10⁵ … – ذراع זרוע Ωя"]) == []


def test_a_letter_that_no_font_has_is_written_out(system: list[Path]) -> None:
    assert drawable("pose 姿, ü") == r"pose \u59ff, ü"
    assert drawable("🤖") == r"\U0001f916"


def test_a_font_of_the_system_is_taken(system: list[Path]) -> None:
    system += [own_fonts()[-1], STIX]
    assert drawable(OF_STIX) == OF_STIX
    assert further_fonts([OF_STIX, "姿"]) == [STIX]


def test_a_damaged_font_is_passed_over(system: list[Path], tmp_path: Path) -> None:
    (tmp_path / "broken.ttf").write_bytes(b"no font")
    system += [tmp_path / "broken.ttf", tmp_path / "absent.otf"]
    assert drawable("姿") == r"\u59ff"


@pytest.mark.usefixtures("system")
def test_a_picture_s_texts_are_written_out(tmp_path: Path) -> None:
    @canvas.styled
    def drawn() -> None:
        figure = canvas.new_figure(80, 60)
        panel = figure.subplots()
        panel.barh([0, 1], [1.0, 2.0])
        panel.set_yticks([0, 1], ["run \x1b[31m", "</text><script>\u202e"])
        panel.set_title("$\\frac{ 姿\nsecond line")
        panel.plot([0.0, 1.0], [0.0, 1.0], label=canvas.in_legend("_hidden"))
        panel.legend()
        canvas.save_figure(figure, tmp_path / "picture.svg", text_as_shapes=False)

    drawn()
    root = ElementTree.parse(tmp_path / "picture.svg").getroot()
    texts = {"".join(element.itertext()) for element in root.iter("{http://www.w3.org/2000/svg}text")}
    assert {r"run \x1b[31m", r"</text><script>\u202e", r"$\frac{ \u59ff", "second line", "\u200c_hidden"} <= texts
    assert not list(root.iter("{http://www.w3.org/2000/svg}script"))


def test_a_picture_takes_a_font_of_the_system(system: list[Path], tmp_path: Path) -> None:
    system.append(STIX)
    figure = canvas.new_figure(80, 60)
    figure.subplots().set_title(OF_STIX)
    canvas.save_figure(figure, tmp_path / "picture.svg", text_as_shapes=False)
    assert "STIXGeneral" in (tmp_path / "picture.svg").read_text(encoding="utf-8")


def test_letters_that_are_known_are_those_of_the_font() -> None:
    assert {ord(letter) for letter in fonts.KNOWN} <= fonts._letters(fonts.own_fonts()[0])
