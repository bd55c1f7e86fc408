"""The generated pages hold all that there is, the hand-written ones explain all of it, and the whole builds."""

from __future__ import annotations

import html
import json
import re
from dataclasses import fields
from pathlib import Path
from urllib.parse import unquote

import pytest

from docs import generated_pages
from docs.document_page import document_page
from docs.effect_page import effect_page
from docs.effects_api_page import effects_api_page
from docs.formulas import BLANK, FormulaError, mathml
from docs.notebook_file import PAGE
from docs.page_blocks import blocks_of, hand_written_pages, page_text
from stiffcal import effects_api
from stiffcal.campaign.found.file_formats import format_names
from stiffcal.cli import endings
from stiffcal.cli.app import COMMANDS
from stiffcal.commands.effects import describe_effects
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds.declared_tables import declared_tables
from stiffcal.readers import find_reader
from stiffcal.revision import REVISION
from tests.laboratory.browser import chromium
from tests.laboratory.documentation import ROOT

MOST_BYTES = {"README.md": 8000, "CHANGELOG.md": 20_000}
"""What a person still reads in one go."""


def headings(text: str) -> list[str]:
    return re.findall(r"^## (.+)$", text, flags=re.MULTILINE)


def test_the_page_of_commands_has_each_with_its_options() -> None:
    page = generated_pages.command_page()
    assert headings(page) == ["Every command", *COMMANDS]
    section = page.split("\n## identify\n")[1].split("\n## ")[0]
    assert "`--loss" in section


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """The build draws them; here the words count."""
    monkeypatch.setattr("docs.effect_page.draw_once", lambda name, picture: False)


@pytest.mark.usefixtures("no_pictures")
def test_each_effect_has_a_page_that_the_list_names_once_by_its_place(tmp_path: Path) -> None:
    (tmp_path / "effects").mkdir()
    (tmp_path / "effects" / "renamed.md").touch()
    generated_pages.write_pages(tmp_path)
    names = {effect.name for effect in describe_effects().effects}
    assert {page.stem for page in (tmp_path / "effects").glob("*.md")} == names
    text = (tmp_path / "effects.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^\| \[`(\S+)`\]\(effects/\1\.md\)", text, flags=re.MULTILINE)) == sorted(names)


def test_the_page_of_the_effects_api_has_each_name_with_a_line() -> None:
    rows = re.findall(r"^\| `(\w+)` \| (.+) \|$", effects_api_page(), flags=re.MULTILINE)
    n_names = len(effects_api.__all__)
    assert [name for name, _ in rows[:n_names]] == effects_api.__all__
    assert all(line.endswith(".") for _, line in rows)
    members = dict(rows[n_names:])
    properties = ["logs_temperature", "reference_kelvin"]
    assert list(members) == [*(entry.name for entry in fields(effects_api.StateOrder)), *properties]
    assert members["temperature"].startswith("(n,) K, rise")


@pytest.mark.usefixtures("no_pictures")
def test_the_law_of_each_effect_begins_with_a_formula() -> None:
    names = [effect.name for effect in describe_effects().effects]
    assert [name for name in names if '<math display="block">' not in effect_page(name)] == []


def test_a_quotient_has_the_product_before_it_above_the_line() -> None:
    assert mathml("a = F L³/(3 E)", display=False) == (
        "<math><mi>a</mi><mo>=</mo><mfrac><mrow><mi>F</mi>" + BLANK + "<msup><mi>L</mi><mn>3</mn></msup></mrow>"
        "<mrow><mn>3</mn>" + BLANK + "<mi>E</mi></mrow></mfrac></math>"
    )


def test_a_formula_that_is_none_is_refused() -> None:
    for words in ("a = (b", "= / c", "a b)", "τ ? 2"):
        with pytest.raises(FormulaError):
            mathml(words)


def test_the_page_of_formats_has_each_with_its_options() -> None:
    page = generated_pages.format_page()
    assert headings(page) == list(format_names())
    csv = page.split("\n## csv\n")[1].split("\n## ")[0]
    assert all(f"| `{option}` |" in csv for option in find_reader(Path("log.csv"), "csv").options.model_fields)


def test_the_page_of_exit_codes_has_each() -> None:
    page = generated_pages.exit_code_page()
    numbers = {value for name, value in vars(endings).items() if name.isupper() and isinstance(value, int)}
    assert {int(number) for number in re.findall(r"^\| `(\d+)` \|", page, flags=re.MULTILINE)} == numbers


def test_the_page_of_campaign_toml_has_each_key() -> None:
    schema = json.loads((ROOT / "schemas" / "campaign.schema.json").read_text(encoding="utf-8"))
    page = generated_pages.toml_page("campaign")
    assert set(headings(page)) == {"Top level", *schema["$defs"]}
    assert all(f"`{key}`" in page for key in schema["properties"])


def test_the_page_of_columns_has_each_table_and_column() -> None:
    page = generated_pages.column_page()
    assert sorted(headings(page)) == sorted(declared.name for declared in declared_tables())
    rows = re.findall(r"^\| `(.+?)` \| (\S+) \|", page, flags=re.MULTILINE)
    assert sorted(rows) == sorted((field.name, str(field.type)) for one in declared_tables() for field in one.schema)


def test_each_key_of_a_json_document_has_a_meaning() -> None:
    rows = re.findall(r"^\| `(\S+)` \| .* \| (.*) \|$", document_page(), flags=re.MULTILINE)
    assert len(rows) > 900
    assert [key for key, meaning in rows if not meaning.strip()] == []


def test_each_fault_code_has_a_cause_an_example_and_a_cure() -> None:
    text = page_text("troubleshooting.md")
    sections = dict(re.findall(r"^### (\S+)\n(.*?)(?=^##|\Z)", text, flags=re.MULTILINE | re.DOTALL))
    assert set(sections) == {code.value for code in FaultCode}
    for code, section in sections.items():
        for word in ("Cause", "Example", "Cure"):
            assert re.search(rf"^\*\*{word}:\*\* \S", section, flags=re.MULTILINE), f"{code}: {word}"


@pytest.mark.parametrize("name", MOST_BYTES)
def test_links_of_the_readme_and_the_changes_lead_to_files(name: str) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    assert len(text.encode()) <= MOST_BYTES[name]
    links = re.findall(r"\]\(([^)#]+)", text)
    assert len(links) > 10
    assert [link for link in links if not (ROOT / link).is_file()] == []


def test_each_revision_since_the_first_version_has_its_reason() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+)(?:[–, ]+(\d+))? \| \S", text, flags=re.MULTILINE)
    listed = [number for first, last in rows for number in range(int(last or first), int(first) - 1, -1)]
    assert listed == list(range(REVISION, 5, -1))


def test_the_readme_lists_every_page() -> None:
    listed = set(re.findall(r"\]\(docs/([^)#]+\.md)", (ROOT / "README.md").read_text(encoding="utf-8")))
    assert set(hand_written_pages()) - listed == {"index.md"}


def dead_links(folder: Path) -> list[str]:
    """Return the links within built pages that lead to no file, or to no place in it."""
    texts = {file: file.read_text(encoding="utf-8") for file in folder.rglob("*.html")}
    places = {file: set(re.findall(r"\bid=\"([^\"]+)\"", text)) for file, text in texts.items()}
    dead = []
    for file, text in texts.items():
        for link in re.findall(r"\b(?:href|src)=\"([^\"]+)\"", text):
            path, _, place = html.unescape(link).partition("#")
            if re.match(r"[a-z]+:", path):
                continue
            target = (file.parent / unquote(path.partition("?")[0])).resolve() if path else file
            if not target.is_file() or (place and target in places and unquote(place) not in places[target]):
                dead.append(f"{file.relative_to(folder)}: {link}")
    return dead


@pytest.mark.docs
def test_the_pages_build_without_warnings_and_fetch_nothing(built: Path) -> None:
    pages = list(built.rglob("*.html"))
    assert len(pages) > 50
    assert dead_links(built) == []
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert not re.search(r"<(?:script|img|link|iframe)\b[^>]*(?:src|href)=\"(?:https?:)?//", text), page.name
        assert "Content-Security-Policy" in text, page.name
        assert "unsafe-inline" not in text, page.name
        assert "-HASHES" not in text, page.name
    # extracts of the hits would be fetched, which browsers refuse to a page from a disk
    options = (built / "_static" / "documentation_options.js").read_text(encoding="utf-8")
    assert "SHOW_SEARCH_SUMMARY: false" in options


@pytest.mark.docs
def test_the_notebook_holds_the_page_s_cells_with_their_output(built: Path) -> None:
    (file,) = (built / "_downloads").rglob("*.ipynb")
    document = json.loads(file.read_text(encoding="utf-8"))
    assert (document["nbformat"], document["nbformat_minor"]) == (4, 4)
    cells = [cell for cell in document["cells"] if cell["cell_type"] == "code"]
    assert [cell["source"] + "\n" for cell in cells] == [block.text for block in blocks_of(PAGE) if block.tag == "run"]
    kinds = [output["output_type"] for cell in cells for output in cell["outputs"]]
    assert (kinds.count("stream"), kinds.count("display_data")) == (5, 2)
    words = "".join(cell["source"] for cell in document["cells"] if cell["cell_type"] == "markdown")
    assert ".md)" not in words
    assert "{download}" not in words


@pytest.mark.docs
def test_every_page_in_a_browser_from_a_disk(built: Path) -> None:
    """At phone width in the dark and at desk width in the light: nothing broken, nothing wider than the window."""
    pages = sorted(page for page in built.rglob("*.html") if "_static" not in page.parts)
    broken = "[...document.images].filter(image => !image.naturalWidth).map(image => image.src)"
    complaints: list[str] = []
    with chromium() as browser:
        window = browser.new_context(offline=True, reduced_motion="reduce").new_page()
        window.on("console", lambda said: complaints.append(said.text) if said.type != "log" else None)
        window.on("pageerror", lambda error: complaints.append(str(error)))
        for page in pages:
            for scheme, width in (("dark", 390), ("light", 1280)):
                window.emulate_media(color_scheme=scheme)
                window.set_viewport_size({"width": width, "height": 900})
                if scheme == "dark":
                    window.goto(page.as_uri())
                assert window.evaluate(broken) == [], page.name
                assert window.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0, page.name
                assert complaints == [], page.name


@pytest.mark.docs
def test_the_search_finds_a_word_from_a_disk_and_ends_at_its_heading(built: Path) -> None:
    with chromium() as browser:
        window = browser.new_context(offline=True).new_page()
        window.goto((built / "search.html").as_uri() + "?q=backlash")
        # results are listed one after another
        window.wait_for_selector('#search-results li a[href*="missing-effect.html"]')
        found = window.eval_on_selector_all("#search-results li a", "links => links.map(link => link.href)")
        window.goto(found[0])
        assert "backlash" in window.inner_text("body")
        window.goto((built / "search.html").as_uri() + "?q=negative+work")
        window.wait_for_selector('#search-results li a[href="troubleshooting.html#wrench-mismatch"]')
