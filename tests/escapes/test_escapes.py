"""One set of hostile names through every sink: an outside parser of that sink finds a text, and nothing else."""

from __future__ import annotations

import csv
import html.parser
import io
import json
import re
import shutil
import subprocess
import tomllib
import tracemalloc
import unicodedata
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable

import pytest
from markdown_it import MarkdownIt
from markdown_it.token import Token

from stiffcal.escapes import (
    csv_cell,
    escape_invisible,
    file_name,
    hidden,
    html_text,
    json_text,
    refused,
    sinks,
    terminal,
)
from stiffcal.escapes.workflow_commands import escaped_property
from tests.laboratory import hostile_names
from tests.laboratory.hostile_names import ALLOWED, NAMES

BREAK = "\u200b"
"""What Markdown's escape puts into what would become a link."""

# github.com/actions/runner, ActionCommand.cs: TryParseV2 and TryParse.
V2 = re.compile(r"\s*::(debug|warning|error|notice|group|endgroup|echo|set-|add-|save-|stop-|internal-)", re.IGNORECASE)
V1 = re.compile(r"##\[|##vso\[|##teamcity\[", re.IGNORECASE)


def assert_no_command(text: str) -> None:
    """Look at a printed text as a CI system's runner does, at every place where the line could be broken."""
    assert not V1.search(text)
    assert not any(V2.match(text, at) for at in range(len(text)))


def assert_printable(text: str) -> None:
    """See that a terminal finds nothing to obey: the Unicode categories of controls, separators, surrogates."""
    for character in text:
        assert unicodedata.category(character) not in ("Cc", "Cs", "Zl", "Zp"), hex(ord(character))
        assert unicodedata.bidirectional(character) not in (
            "LRE",
            "RLE",
            "LRO",
            "RLO",
            "PDF",
            "LRI",
            "RLI",
            "FSI",
            "PDI",
        )


def judge_terminal(name: str, escaped: str) -> None:
    assert_printable(escaped)
    assert_no_command(escaped)
    escaped.encode("utf-8")


def judge_workflow_commands(name: str, escaped: str) -> None:
    judge_terminal(name, escaped)
    assert escaped.replace("%25", "%") or not name
    assert not {":", ","} & set(escaped_property(name))


def judge_toml_text(name: str, escaped: str) -> None:
    assert tomllib.loads(f"name = {escaped}") == {"name": re.sub("[\ud800-\udfff]", "\ufffd", name)}
    assert_printable(escaped)


def judge_json_text(name: str, escaped: str) -> None:
    assert json.loads(escaped) == name
    assert_printable(escaped)
    assert not V1.search(escaped)


def judge_xml_text(name: str, escaped: str) -> None:
    root = ElementTree.fromstring(f"<a b=\"{escaped}\" c='{escaped}'>{escaped}</a>")
    # The parser turns a tab of an attribute into a blank, so that text with none left is the same everywhere.
    assert root.text == root.get("b") == root.get("c") == escape_invisible(name)
    assert len(root) == 0
    assert list(root.attrib) == ["b", "c"]


def judge_code_comment(name: str, escaped: str) -> None:
    """A C preprocessor and an XML parser find one comment; no pair ends or begins one of Structured Text."""
    escaped.encode("ascii")
    assert_printable(escaped)
    assert "*)" not in escaped
    assert "(*" not in escaped
    assert not {"\\", "\n"} & set(escaped)
    page = f"<a><!-- {escaped} --></a>"
    assert len(ElementTree.fromstring(page)) == 0
    if (gcc := shutil.which("gcc")) is not None:
        text = f"/* {escaped} */ 1\n"
        done = subprocess.run(
            [gcc, "-E", "-P", "-std=c99", "-Wall", "-Werror", "-"],
            input=text,
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout.split() == ["1"]


def judge_robot_program(name: str, escaped: str) -> None:
    """None of the characters and words is left that end a comment or a fold in any of the four languages."""
    escaped.encode("ascii")
    assert_printable(escaped)
    assert not set("\\\n;!#$%&\"'[]{}*=@|") & set(escaped)
    assert "fold" not in escaped.lower()


class _Collector(html.parser.HTMLParser):
    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[tuple[str, list[tuple[str, str | None]]]] = []
        self.text = ""

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, attributes))

    def handle_data(self, data: str) -> None:
        self.text += data

    def handle_comment(self, data: str) -> None:
        raise AssertionError(f"a comment: {data}")


def read_html(page: str) -> _Collector:
    """Parse a piece of HTML."""
    collector = _Collector()
    collector.feed(page)
    collector.close()
    return collector


def judge_html_text(name: str, escaped: str) -> None:
    page = read_html(f"<p title=\"{escaped}\" id='{escaped}'>{escaped}</p>")
    assert page.tags == [("p", [("title", escape_invisible(name)), ("id", escape_invisible(name))])]
    assert page.text == escape_invisible(name)


def _tokens(tokens: list[Token]) -> list[Token]:
    return [inner for token in tokens for inner in (token, *_tokens(token.children or []))]


PLAIN_TAGS = {"h1", "ul", "li", "strong", "table", "thead", "tbody", "tr", "th", "td"}


def judge_markdown(name: str, escaped: str) -> None:
    def page(text: str) -> str:
        return f"# t\n\n- {text}\n- **{text}x** 1\n\n| a | b |\n|---|---|\n| {text} | 1 |\n"

    def kinds(text: str) -> list[str]:
        found = [token.type for token in _tokens(parser.parse(page(text)))]
        return [kind for kind in found if kind not in ("text", "text_special")]

    parser = MarkdownIt("gfm-like", {"linkify": False})
    assert kinds(escaped) == kinds("pose")
    shown = read_html(parser.render(page(escaped)))
    assert {tag for tag, _ in shown.tags} <= PLAIN_TAGS
    lines = [line.strip() for line in shown.text.replace(BREAK, "").split("\n")]
    assert escape_invisible(name).strip() in lines
    # What GitHub and GitLab make links and pictures of in the text that is left: mentions, issues, addresses, emoji.
    assert not re.search(r"(?<!\w)@\w|#\d|GH-\d|!\d|://\w|www\.\w|(?<!\d):[\w+-]+:", shown.text)
    assert "$" not in escaped  # what begins mathematics


def judge_csv_cell(name: str, escaped: str) -> None:
    stream = io.StringIO(newline="")
    csv.writer(stream).writerow(["x", escaped, "-1.5"])
    (row,) = csv.reader(io.StringIO(stream.getvalue(), newline=""))
    assert row == ["x", escaped, "-1.5"]
    assert not escaped.startswith(("=", "+", "-", "@", "\t", "\r")) or re.fullmatch(r"[-+][\d.]+", escaped)
    assert csv_cell.original(escaped) == name


def judge_shell(name: str, escaped: str) -> None:
    assert_printable(escaped)
    assert_no_command(f"next: stiffcal check {escaped}"[6:])
    bash = shutil.which("bash")
    if bash is None or "\0" in name or "\ud800" in name:  # no word of a command holds them
        return
    done = subprocess.run([bash, "-c", f"printf '%s|' {escaped}"], capture_output=True, check=True, env={"LC_ALL": "C"})
    assert done.stdout == name.encode("utf-8", "surrogateescape") + b"|"


def judge_file_name(name: str, escaped: str) -> None:
    assert escaped.isascii()
    assert escaped.isprintable()
    assert 0 < len(escaped.encode()) <= file_name.LONGEST
    assert not set('/\\:*?"<>|') & set(escaped)
    assert escaped.strip(".") == escaped.rstrip(".") == escaped.strip() or escaped.startswith(".")
    assert not escaped.endswith((".", " "))
    assert not escaped.startswith("-")
    assert escaped.split(".")[0].strip().upper() not in {"CON", "PRN", "AUX", "NUL", "COM1", "LPT1"}


def judge_typst_text(name: str, escaped: str) -> None:
    # Pages with these names are set in test_names.py; here: what is left has glyphs and no hidden characters.
    assert all(not hidden().search(line) for line in escaped.split("\n"))
    assert escape_invisible(name) == escape_invisible(escaped).replace("\\n", "\\n")


JUDGES: dict[str, Callable[[str, str], None]] = {
    name.removeprefix("judge_"): judge for name, judge in sorted(globals().items()) if name.startswith("judge_")
}


def test_every_sink_has_its_parser() -> None:
    assert set(sinks()) == set(JUDGES)


@pytest.mark.parametrize("sink", sorted(JUDGES))
@pytest.mark.parametrize("kind", sorted(NAMES))
def test_a_hostile_name_is_a_text_and_nothing_else(sink: str, kind: str) -> None:
    name = NAMES[kind]
    JUDGES[sink](name, sinks()[sink](name))


@pytest.mark.parametrize("sink", sorted({*JUDGES} - {"csv_cell", "json_text", "toml_text", "file_name", "shell"}))
def test_what_is_hidden_is_written_out_and_not_dropped(sink: str) -> None:
    escaped = sinks()[sink]("a\u202eb\x1bc")
    assert "u202e" in escaped
    assert "x1b" in escaped


def test_different_names_give_different_file_names() -> None:
    long = [f"{'x' * 5000}{k}" for k in range(50)]
    names = [*NAMES.values(), *long, "x%20", "x ", "a/b", "a%2Fb", "CON", "%43ON"]
    assert len({file_name.escaped(name).casefold() for name in names}) == len(set(names))


def test_data_in_a_script_ends_no_script() -> None:
    text = html_text.script_data({"names": list(NAMES.values())})
    assert json.loads(text) == {"names": list(NAMES.values())}
    assert not re.search("[<>&\u2028\u2029]", text)


def test_a_document_of_json_is_on_lines_that_begin_no_command() -> None:
    document = {"names": {name: name for name in NAMES.values()}}
    text = json_text.document_text(document)
    assert json.loads(text) == document
    for line in text.split("\n"):
        assert not V2.match(line)
        assert not V1.search(line)
        assert_printable(line)


def test_a_document_has_the_layout_of_the_json_module() -> None:
    leaf = {"a": 1, "b": [], "c": {}, "d": "é\n", "e": None, "f": 1e-9, "g": True}
    for document in (leaf, [leaf, 2, [leaf, {"h": [1.5, 2], "i": leaf}]], {"j": [[1], [leaf]], "k": (1, leaf)}, [], 3):
        for indent in (1, 2):
            assert json_text.document_text(document, indent=indent) == json.dumps(
                document, indent=indent, ensure_ascii=False
            )
    with pytest.raises(ValueError, match="."):
        json_text.document_text({"a": [{"b": float("nan")}]})


def test_writing_a_long_document_holds_no_text_of_each_token() -> None:
    document = {"runs": [{"columns": [{"low": 1.5, "high": 2.5, "unit": "N"}] * 12} for _ in range(300)]}
    tracemalloc.start()
    try:
        size = len(json_text.document_text(document))
        assert tracemalloc.get_traced_memory()[1] < 3 * size  # of json.dumps 7
    finally:
        tracemalloc.stop()


def test_a_document_for_a_terminal_is_written_out_throughout() -> None:
    document = {"a": list(NAMES.values()), **dict.fromkeys(NAMES.values(), 1)}
    assert_printable(str(terminal.escaped_document(document)))


def test_the_sets_are_what_they_say() -> None:
    assert all(refused().search(name) for name in hostile_names.REFUSED.values())
    assert not any(refused().search(name) for name in ALLOWED.values())
