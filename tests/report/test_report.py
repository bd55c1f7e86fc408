"""The PDF: it opens, repeats byte for byte, holds the numbers, and says what it leaves out."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pypdf import PageObject, PdfReader
from pypdf.generic import ArrayObject, DictionaryObject

from stiffcal.campaign.manifest.report_settings import ReportSettings
from stiffcal.compensation.predict_result import LoadPath
from stiffcal.errors import no_progress
from stiffcal.report.blocks import Facts, ReportSection, TableBlock, TableColumn
from stiffcal.report.building import PagesHeading, build_report, lay_out, write_pages
from stiffcal.report.content import ReportContent
from stiffcal.report.provenance_content import ReportProvenance, ReportSource
from tests.laboratory.report_content import made_up_content

SPACES = re.compile(r"\s+")


def text_of(path: Path, pages: int | None = None) -> str:
    """All words of a PDF (of its first pages), one space between them."""
    return SPACES.sub(" ", " ".join(page.extract_text() for page in PdfReader(path).pages[:pages]))


def fonts_of(page: PageObject) -> list[DictionaryObject]:
    resources = page["/Resources"].get_object()
    assert isinstance(resources, DictionaryObject)
    fonts = resources.get("/Font", DictionaryObject()).get_object()
    assert isinstance(fonts, DictionaryObject)
    return [font.get_object() for font in fonts.values()]


def bookmarks_of(path: Path) -> list[str]:
    def titles(entries: list[object]) -> list[str]:
        return [
            title
            for entry in entries
            for title in (titles(entry) if isinstance(entry, list) else [str(getattr(entry, "title", ""))])
        ]

    return titles(list(PdfReader(path).outline))


@pytest.fixture(scope="module")
def small_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "report.pdf"
    build_report(made_up_content(), path)
    return path


@pytest.fixture(scope="module")
def small_text(small_report: Path) -> str:
    return text_of(small_report)


def test_pdf_opens_with_pages_numbers_and_bookmarks(small_report: Path) -> None:
    reader = PdfReader(small_report)
    pages = len(reader.pages)
    assert pages >= 4
    for number, page in enumerate(reader.pages, start=1):
        assert f"page {number} of {pages}" in SPACES.sub(" ", page.extract_text())
    titles = " | ".join(bookmarks_of(small_report))
    for word in ("Summary", "The campaign", "Stiffness", "Load and deflection", "History of fits"):
        assert word in titles
    assert reader.metadata is not None
    assert reader.metadata.title == "Stiffness of test robot, made-up"


def test_pdf_holds_the_numbers(small_text: str) -> None:
    # 1 / 1e-6 N·m/rad, std 1e-8 of 1e-6: 1 %, 95 % half-width about 19600.
    assert "(1.000 ± 0.020)·10⁶" in small_text
    assert "N·m/rad" in small_text
    validation = made_up_content().validate
    assert validation is not None
    assert f"{(validation.rms.translation or 0.0) * 1e3:.4f} mm" in small_text


def test_axis_labels_of_pictures_are_searchable(small_text: str) -> None:
    for label in ("deflection Dx [mm]", "force Fx [N]", "residual [mm]"):
        assert label in small_text


def test_same_content_gives_same_bytes(small_report: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.pdf"
    build_report(made_up_content(), again)
    assert again.read_bytes() == small_report.read_bytes()
    assert again.read_bytes().rstrip(b"\n").endswith(b"%%EOF")
    assert [each.name for each in tmp_path.iterdir()] == ["again.pdf"]


def test_every_font_is_embedded_and_none_else_used(small_report: Path) -> None:
    families = set()
    for page in PdfReader(small_report).pages:
        for font in fonts_of(page):
            descendants = font["/DescendantFonts"].get_object()
            assert isinstance(descendants, ArrayObject)
            descriptor = descendants[0].get_object()["/FontDescriptor"].get_object()
            assert isinstance(descriptor, DictionaryObject)
            assert {"/FontFile2", "/FontFile3"} & set(descriptor)
            families.add(str(descriptor["/FontName"]).split("+")[-1])
    assert families
    assert all(name.startswith("DejaVuSans") for name in families)


def test_no_letter_is_missing_in_the_fonts(small_text: str) -> None:
    assert "\ufffd" not in small_text
    # Glyph 0 is the box drawn for a letter that no font holds; DejaVu's own cmap must have all that our words use.
    import matplotlib
    from matplotlib.ft2font import FT2Font

    font = FT2Font(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"))
    known = font.get_charmap()
    for section in lay_out(made_up_content()):
        for letter in set(repr(section)) - {"\n"}:
            assert ord(letter) in known, f"{letter!r} in {section.title}"


def test_noise_that_cannot_be_judged_is_said(small_text: str) -> None:
    assert "noise cannot be judged" in small_text
    assert "nan" not in small_text.lower().split()


def test_what_is_left_out_has_a_reason() -> None:
    content = replace(made_up_content(), identify=None, validate=None, history=None)
    text = repr(lay_out(content))
    assert "Left out: " in text
    assert "no model has been fitted yet" in text
    assert "the history contains no fit yet" in text
    # no reason, where nothing is there to show
    assert "Deflection along a path of loads" not in text


def test_the_short_report_has_the_answer_values_and_signatures(tmp_path: Path) -> None:
    settings = ReportSettings(serial_number="42-7", operator="A. Example", sign_off=("measured by",))
    content = replace(made_up_content(n_runs=1), settings=settings)
    titles = [section.title for section in lay_out(content, is_short=True)]
    assert titles[0] == "Summary"
    assert titles[-1] == "Sign-off"
    assert {"Summary", "Stiffness", "Sign-off"} <= {*titles} < {section.title for section in lay_out(content)}
    build_report(content, tmp_path / "short.pdf", is_short=True)
    assert len(PdfReader(tmp_path / "short.pdf").pages) <= 2
    text = text_of(tmp_path / "short.pdf")
    assert "42-7" in text
    assert "A. Example" in text
    assert "Contents" not in text


def test_report_of_nothing_at_all(tmp_path: Path) -> None:
    path = tmp_path / "empty.pdf"
    build_report(ReportContent(provenance=ReportProvenance("x", "y", "2026-11-21"), runs=(), joint_names=()), path)
    assert "no runs are known" in text_of(path)


def test_names_with_markup_are_printed_as_they_are(tmp_path: Path) -> None:
    content = made_up_content(n_runs=1)
    origin = replace(content.provenance, campaign='#panic("x") *a* _b_ $c$ <d> "e" \\f')
    runs = tuple(replace(run, name="$\\alpha$ & <b>") for run in content.runs)
    path = tmp_path / "markup.pdf"
    build_report(ReportContent(provenance=origin, runs=runs, joint_names=content.joint_names), path)
    text = text_of(path)
    assert '#panic("x") *a* _b_ $c$ <d> "e" \\f' in text
    assert "$\\alpha$ & <b>" in text


def test_long_tables_repeat_their_header(tmp_path: Path) -> None:
    sources = tuple(ReportSource(f"raw/log{i:03d}.csv", f"{i:064x}", 1000 + i) for i in range(120))
    content = made_up_content(n_runs=1)
    origin = replace(content.provenance, sources=sources)
    content = ReportContent(provenance=origin, runs=content.runs, joint_names=content.joint_names)
    path = tmp_path / "long.pdf"
    build_report(content, path)
    pages = [
        page.extract_text() for page in PdfReader(path).pages if "raw/log" in page.extract_text().replace("\u200b", "")
    ]
    assert len(pages) >= 2
    assert all("SHA-256" in page for page in pages)
    assert f"{119:064x}" in text_of(path)


def test_a_long_table_begins_below_the_facts_above_it(tmp_path: Path) -> None:
    """Its caption was printed over their last line."""
    table = TableBlock((TableColumn("file", align="left"),), tuple((f"log{k}",) for k in range(20)), "Captioned.")
    section = ReportSection("Origin", (Facts((("date", "yesterday"),)), table))
    path = tmp_path / "table.pdf"
    write_pages(PagesHeading("Title", "kind", "campaign", "2026-12-01", "maker"), [section], path, no_progress)
    baselines: dict[str, float] = {}

    def keep(text: str, outer: list[float], inner: list[float], _font: object, _size: float) -> None:
        baselines.setdefault(text.strip(), outer[3] * inner[5] + outer[5])

    PdfReader(path).pages[0].extract_text(visitor_text=keep)
    caption = next(y for text, y in baselines.items() if "Captioned." in text)
    # lines of 8 pt
    assert abs(baselines["yesterday"] - caption) > 8.0


def test_many_runs_are_thinned_and_that_is_said() -> None:
    content = made_up_content(n_runs=200, per_run=4)
    runs = tuple(replace(run, joints=run.joints + 0.01 * number) for number, run in enumerate(content.runs))
    sections = {section.title: section for section in lay_out(replace(content, runs=runs))}
    captions = " ".join(getattr(block, "caption", "") for block in sections["Load and deflection"].blocks)
    assert re.search(r"Of 19[78] such runs 40, evenly spread, are drawn", captions)
    assert "12 of 200 poses, the 6 with the largest residuals" in repr(sections["Robot poses"])


def test_a_failed_report_leaves_the_old_one(tmp_path: Path) -> None:
    path = tmp_path / "report.pdf"
    path.write_bytes(b"old")
    broken = replace(made_up_content(n_runs=1), load_paths=(LoadPath("p", "q", np.zeros((0, 3)), np.zeros((1, 3))),))
    with pytest.raises((ValueError, IndexError)):
        build_report(broken, path)
    assert path.read_bytes() == b"old"
    assert [each.name for each in tmp_path.iterdir()] == ["report.pdf"]


def test_progress_runs_from_nought_to_one(tmp_path: Path) -> None:
    reported: list[float] = []
    build_report(made_up_content(n_runs=1), tmp_path / "r.pdf", lambda _, share: reported.append(share or 0.0))
    assert reported == sorted(reported)
    assert reported[-1] == 1.0


def test_the_ladder_ends_with_the_present_fit_where_an_earlier_model_was_restored() -> None:
    content = made_up_content()
    assert content.identify is not None
    captions = []
    for present in ("2", "1"):
        restored = replace(content, identify=replace(content.identify, fit_id=present))
        ladder = next(section for section in lay_out(restored) if section.title.startswith("History of fits"))
        captions.append(repr(ladder.blocks[0]))
    assert "with fit 2" in captions[0]
    assert "with fit 1" in captions[1]
