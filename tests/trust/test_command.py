"""`stiffcal trust` shows what it allows, byte for byte, and allows what it has shown."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.trust import allow_shown
from stiffcal.model.catalogue.campaign_effects import plugin_code
from stiffcal.show.answers.trust import code_line
from stiffcal.stages.campaign_code import read_campaign
from stiffcal.trust.queries import query_digest
from stiffcal.trust.record import open_record
from tests.laboratory.offers_of_tests import forget_offers
from tests.laboratory.plugin_campaigns import NAME, ran, stranger, write_plugin
from tests.laboratory.small_campaign import write_small_campaign
from tests.security.test_plugins import digest_of, document, run


@pytest.fixture(autouse=True)
def _offers(_watched: None) -> Iterator[None]:
    """The code of a plugin is shown here, which is Python and no TOML that is offered."""
    yield
    forget_offers()


@pytest.fixture
def folder(state: Path, tmp_path: Path) -> Path:
    return stranger(tmp_path / "stranger")


def allowed(folder: Path) -> bool:
    return plugin_code(load_campaign(folder)).allowed()


class Terminal:
    """Standard input as a terminal where a person types one answer."""

    def __init__(self, answer: str) -> None:
        self._answer = answer

    def isatty(self) -> bool:
        return True

    def readline(self, *_: Any) -> str:
        return self._answer + "\n"


def test_without_a_terminal_it_shows_the_code_and_says_how_to_allow_it(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, error = run(capsys, "trust", folder)
    assert code == 2
    for line in (folder / NAME).read_text(encoding="utf-8").splitlines():
        assert line in out
    assert f"code in 1 file, SHA-256 {digest_of(folder)}: not trusted" in out
    assert "This is no sandbox: code that you allow runs with your rights" in out
    assert f"stiffcal trust {folder} --yes; or STIFFCAL_TRUST={digest_of(folder)}" in error
    assert not allowed(folder)
    assert not ran(folder)


@pytest.mark.parametrize(("answer", "code", "held"), [("y", 0, True), ("n", 1, False), ("", 1, False)])
def test_at_a_terminal_it_asks(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    answer: str,
    code: int,
    held: bool,
) -> None:
    monkeypatch.setattr("sys.stdin", Terminal(answer))
    found, out, error = run(capsys, "trust", folder)
    assert (found, allowed(folder)) == (code, held)
    assert "Allow this to run with your rights?" in error + out
    assert not ran(folder)


def test_yes_allows_and_is_listed_and_revoked_by_folder_and_by_hash(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in (str(folder), digest_of(folder)):
        code, shown = document(capsys, "trust", folder, "--yes")
        assert (code, shown["action"], shown["plugins"]["trusted"]) == (0, "allowed", True)
        assert allowed(folder)
        (entry,) = document(capsys, "trust", "--list")[1]["entries"]
        assert (entry["kind"], entry["key"], entry["note"]) == ("plugin", digest_of(folder), str(folder))
        assert document(capsys, "trust", "--revoke", name)[1]["entries"] == [entry]
        assert not allowed(folder)
    assert document(capsys, "trust", "--revoke", folder)[0] == 2
    assert not ran(folder)


def test_revoking_a_folder_takes_back_what_was_allowed_of_it_before_it_changed(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document(capsys, "trust", folder, "--yes")
    before = digest_of(folder)
    write_plugin(folder, "# changed\n")
    assert document(capsys, "trust", "--revoke", folder)[0] == 0
    assert not open_record().plugin_allowed(before)


def test_what_is_stored_is_what_was_shown(folder: Path) -> None:
    showing = read_campaign(folder)
    write_plugin(folder, "# changed between showing and the answer\n")
    allow_shown(showing)
    assert not allowed(folder)
    assert open_record().plugin_allowed(showing.plugins.digest)


def test_hash_prints_the_hash_alone_for_ci(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    code, out, error = run(capsys, "trust", folder, "--hash")
    assert (code, out, error) == (0, f"{digest_of(folder)}\n", "")
    monkeypatch.setenv("STIFFCAL_TRUST", out)
    assert allowed(folder)
    assert "STIFFCAL_TRUST still contains" in document(capsys, "trust", "--revoke", digest_of(folder))[1]["warnings"][0]


def test_edit_trusts_a_folder_and_store_a_place(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert document(capsys, "trust", folder, "--edit")[0] == 0
    assert allowed(folder)
    assert document(capsys, "trust", "--store", "s3://lab/cells/")[0] == 0
    assert open_record().place_allowed("s3://lab/cells/a")
    listed = document(capsys, "trust", "--list")[1]["entries"]
    assert [(entry["kind"], entry["key"]) for entry in listed] == [("folder", str(folder)), ("place", "s3://lab/cells")]
    for name in (folder, "s3://lab/cells"):
        assert document(capsys, "trust", "--revoke", name)[0] == 0
    assert document(capsys, "trust", "--list")[1]["entries"] == []


@pytest.mark.parametrize("place", ["/", "s3://", "file:///"])
def test_the_place_of_everything_cannot_be_trusted(state: Path, capsys: pytest.CaptureFixture[str], place: str) -> None:
    code, answer = document(capsys, "trust", "--store", place)
    assert code == 2
    assert "contains everything" in answer["error"]["reason"]


def test_code_that_hides_from_a_terminal_is_shown_escaped(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hidden = "# \x1b[8m \x1b]0;t\x07 \u202e\u2066 \u200b\u200d \xa0 \u2028 \x0b\x0c\r\t# \x9b31m \ufeff\n"
    write_plugin(folder, hidden)
    (folder / NAME).write_bytes((folder / NAME).read_bytes() + b"::add-mask::x\n")
    _, out, _ = run(capsys, "trust", folder)
    assert all(character == "\n" or character.isprintable() for character in out)
    for written in (r"\x1b[8m", r"\u202e\u2066", r"\u200b\u200d", r"\xa0", r"\u2028", r"\x9b31m", r"\ufeff"):
        assert written in out
    assert not any(line.lstrip().startswith("::") for line in out.splitlines())


def test_lines_are_numbered_as_python_counts_them(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / NAME).write_bytes(b"a = 1\rb = 2\r\nc = '\x0c \xe2\x80\xa8'\nd = 4")
    _, out, _ = run(capsys, "trust", folder)
    assert [line.split()[:2] for line in out.splitlines()[1:5]] == [["1", "a"], ["2", "b"], ["3", "c"], ["4", "d"]]


QUERIES = """
[sources.lab]
format = "postgres"
file = "select * from ft"
sampling = "time"
postgres = { host = "db", database = "lab", order_by = "t" }
time = { column = "t", unit = "s" }
wrench = { columns = ["Fx", "Fy", "Fz"], axes = "base", point = "load_point", units = { force = "N" } }
"""


def test_queries_of_a_database_are_shown_and_trusted_in_the_same_go(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with (folder / "campaign.toml").open("a", encoding="utf-8") as manifest:
        manifest.write(QUERIES)
    digest = query_digest("select * from ft")
    _, out, _ = run(capsys, "trust", folder)
    assert "     1  select * from ft\n" in out
    assert f"query, SHA-256 {digest}: not trusted" in out
    assert run(capsys, "trust", folder, "--hash")[1].split() == [plugin_code_of(folder), digest]
    assert not open_record().text_allowed(digest)
    assert document(capsys, "trust", folder, "--yes")[1]["action"] == "allowed"
    assert open_record().text_allowed(digest)
    assert open_record().plugin_allowed(plugin_code_of(folder))
    assert document(capsys, "trust", "--revoke", folder)[0] == 0
    assert not open_record().text_allowed(digest)


def plugin_code_of(folder: Path) -> str:
    return read_campaign(folder).plugins.digest


def test_code_line_leaves_plain_text_alone() -> None:
    assert code_line("τ = 'Müller 弾性' \\n") == "τ = 'Müller 弾性' \\n"


def test_a_campaign_without_code_needs_no_trust(
    state: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_small_campaign(tmp_path / "own")
    code, out, _ = run(capsys, "trust", folder)
    assert code == 0
    assert "nothing in this campaign needs trust" in out
    assert run(capsys, "trust", folder, "--hash")[0] == 2


@pytest.mark.parametrize(
    "words", [["--list", "--hash"], ["--list", "DIR"], ["--revoke", "x", "DIR"], ["--store", "s3://x", "--edit"]]
)
def test_wishes_that_exclude_each_other_are_refused(
    state: Path, capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    code, _, error = run(capsys, "trust", *words)
    assert code == 2
    assert error.count("\n") == 1


def test_answers_are_as_their_schema_says(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import jsonschema

    schema = json.loads((Path(__file__).parents[2] / "schemas" / "trust.document.schema.json").read_text("utf-8"))
    for words in ([str(folder), "--yes"], [str(folder)], ["--list"], ["--store", "s3://lab/x"], ["--revoke", folder]):
        code, answer = document(capsys, "trust", *words)
        assert code == 0
        jsonschema.validate(answer, schema)
