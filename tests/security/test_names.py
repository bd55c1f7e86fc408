"""Whole campaigns with unusual names through the commands: nothing fails, and every output holds texts alone."""

from __future__ import annotations

import csv
import json
import os
import re
import sys
import tomllib
import unicodedata
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

import pyarrow as pa
import pytest
from markdown_it import MarkdownIt
from pypdf import PdfReader
from rich.progress import TextColumn

from stiffcal.batch.campaigns import BatchOptions, batch_campaigns, find_campaigns, store_below
from stiffcal.batch.summary import junit_text, markdown_text
from stiffcal.batch.task import run_task
from stiffcal.campaign.loading import load_campaign
from stiffcal.cli.app import main
from stiffcal.cli.endings import report_fault
from stiffcal.cli.progress import ProgressBar
from stiffcal.escapes import csv_cell, hidden
from stiffcal.escapes.file_name import with_short_name
from stiffcal.ingest.reading.recording_tables import recording_name
from stiffcal.report import fonts
from stiffcal.report.typesetting import set_pages
from stiffcal.results.batch_results import BatchTask
from stiffcal.store.table_files import write_table
from stiffcal.trust.output_kinds import EXPORT
from stiffcal.validation.results import ThresholdCheck
from tests.escapes.test_escapes import V1, V2, assert_printable, read_html
from tests.laboratory.named_campaign import write_named_campaign

RUNS = ("=cmd()|'x'", "<script>alert(1)</script> $x$ ::error::", "-rf")
JOINTS = ("=A1", "\"A2'", "$\\frac$", "A|4`", "#eval(5)", "ذراع 姿")
NAMED = {
    "campaign": "[bold]%0A x|y @octocat <b>", "robot": "ロボット $x$ #1 [red] Ü", "source": "a/../b",
    "target": "--target", "run": "@run", "Fx": "+Fx", "link_A2": "<i>", "X": "X [mm]; --", "load_point": "_hook",
}  # fmt: skip
NO_UTF_8 = sys.platform.startswith("linux")


Stiffcal: TypeAlias = Callable[..., "Run"]


@dataclass(frozen=True)
class Run:
    """What a command left: exit code, standard output and standard error."""

    code: int
    out: str
    err: str


@pytest.fixture
def stiffcal(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Stiffcal:
    """Run the command line in this process, and see that a terminal and a CI system find nothing to obey."""

    def run(*words: str) -> Run:
        capsys.readouterr()
        with pytest.raises(SystemExit) as done:
            main(words)
        printed = capsys.readouterr()
        for line in (*printed.out.split("\n"), *printed.err.split("\n")):
            assert_printable(line)
            assert not V1.search(line)
            assert not V2.match(line)
        return Run(int(done.value.code or 0), printed.out, printed.err)

    monkeypatch.chdir(tmp_path)
    return run


@pytest.fixture(scope="module")
def fitted_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of hostile names in a folder called like an option, fitted and validated."""
    folder = write_named_campaign(tmp_path_factory.mktemp("hostile") / "--help", runs=RUNS, joints=JOINTS, named=NAMED)
    outcome = run_task(BatchTask(folder=str(folder), campaign="cells/--help", report=False))
    assert outcome.error is None
    return folder


@pytest.mark.parametrize("command", ["check", "identify", "validate", "history"])
def test_answers_of_commands(
    stiffcal: Stiffcal, fitted_folder: Path, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(fitted_folder.parent)
    shown = stiffcal(command, "./--help")
    assert shown.code == 0
    assert re.search(r"^next: stiffcal \w+ \./--help$", shown.out, re.MULTILINE)
    answer = json.loads(stiffcal(command, "./--help", "--json").out)
    assert RUNS[2] in json.dumps(answer) or command in ("identify", "history")


def test_a_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fonts, "_system_fonts", list)
    fonts._fonts_covering.cache_clear()
    names = [*RUNS, *JOINTS, *NAMED.values(), "\x1b[31m", "a\u202eb", "\ud800"]
    columns = [{"title": "#x", "unit": "$", "align": "left", "width": 1.0, "mono": mono} for mono in (False, True)]
    blocks = [
        {"kind": "paragraph", "tone": "plain", "text": "".join(names)},
        {"kind": "items", "texts": names},
        {"kind": "subheading", "text": RUNS[1]},
        {"kind": "facts", "rows": [[name, name] for name in names]},
        {
            "kind": "table",
            "columns": columns,
            "rows": [[name, name] for name in names],
            "doubtful": [[1, 1]],
            "caption": RUNS[0],
        },
        {"kind": "verdict", "level": "ok", "text": RUNS[1]},
        {"kind": "numbers", "numbers": [[RUNS[2], JOINTS[0]], [RUNS[0], JOINTS[1]]]},
    ]
    sections = [{"title": JOINTS[4], "blocks": blocks}]
    head = {
        "title": NAMED["robot"],
        "kind": "x",
        "campaign": NAMED["campaign"],
        "date": "#",
        "maker": "*m*",
        "has_contents": True,
        "logo": "",
    }
    (tmp_path / "page.pdf").write_bytes(set_pages({**head, "sections": sections}, tmp_path, "2026-11-22"))
    fonts._fonts_covering.cache_clear()
    pages = PdfReader(tmp_path / "page.pdf").pages
    text = re.sub(r"[\s\u200b]", "", "".join(page.extract_text() for page in pages))
    for name in (*RUNS, *JOINTS[:5], NAMED["campaign"], r"\u30ed\u30dc", r"\x1b[31m", r"a\u202eb", r"\ud800"):
        assert text.count(re.sub(r"\s", "", name)) >= 4, name
    notes = [note.get_object() for page in pages for note in page.get("/Annots") or ()]
    assert not any("/URI" in (note.get("/A") or {}) for note in notes)


def test_a_picture_of_a_run_called_like_an_option(stiffcal: Stiffcal, fitted_folder: Path, tmp_path: Path) -> None:
    assert stiffcal("plot", str(fitted_folder), "--run=-rf", "-o", "run.svg").code == 0
    tags = {element.tag.rpartition("}")[2] for element in ElementTree.parse(tmp_path / "run.svg").iter()}
    assert not tags & {"script", "a", "image", "foreignObject"}


def test_exported_tables_start_no_formula_and_come_back(
    stiffcal: Stiffcal, fitted_folder: Path, tmp_path: Path
) -> None:
    assert stiffcal("export", str(fitted_folder), "-o", "states.csv").code == 0
    with (tmp_path / "states.csv").open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    for cell in (*header, *(cell for row in rows for cell in row)):
        assert not cell.startswith(("=", "+", "@")), cell
        assert not cell.startswith("-") or float(cell) <= 0.0
    assert {csv_cell.original(row[0]) for row in rows} == set(RUNS)
    assert stiffcal("export", str(fitted_folder), "-o", "raw.csv", "--raw-text").code == 0
    with (tmp_path / "raw.csv").open(newline="", encoding="utf-8") as file:
        assert {row[0] for row in list(csv.reader(file))[1:]} == set(RUNS)
    assert stiffcal("export", str(fitted_folder), "-o", "robot.urdf").code == 0
    root = ElementTree.parse(tmp_path / "robot.urdf").getroot()
    assert [joint.get("name") for joint in root.iter("joint")][:6] == list(JOINTS)


def test_the_summaries_of_a_batch(fitted_folder: Path) -> None:
    result = batch_campaigns([fitted_folder], BatchOptions(jobs=1, report=False))
    outcomes = [
        replace(
            outcome,
            campaign=NAMED["campaign"],
            failed=[f"run {run} \x1b[31m" for run in RUNS],
            checks=[ThresholdCheck(RUNS[1], JOINTS[3], 1.0, 2.0, "", False, "]]>\x00\ud800")],
        )
        for outcome in result.campaigns
    ]
    result = replace(result, campaigns=outcomes)
    shown = read_html(MarkdownIt("gfm-like", {"linkify": False}).render(markdown_text(result)))
    assert {tag for tag, _ in shown.tags} <= {
        "h2", "p", "ul", "li", "strong", "table", "thead", "tbody", "tr", "th", "td"
    }  # fmt: skip
    assert not any(dict(attributes).get("href") for _, attributes in shown.tags)
    suite = ElementTree.fromstring(junit_text(result))[0]
    assert suite.get("name") == NAMED["campaign"]
    assert any(case.get("name") == f"{RUNS[1]} {JOINTS[3]}" for case in suite)


@pytest.mark.skipif(not NO_UTF_8, reason="file systems here take no names that are not UTF-8")
class TestFolders:
    """Folders whose names are in no encoding, composed in several ways, or hold what a terminal obeys."""

    @pytest.mark.parametrize("name", [b"M\xfcller \x9b[31m", b"two\nlines ::error::", "Pru\u0308f 姿 ذ".encode()])
    def test_a_campaign_in_such_a_folder(self, stiffcal: Stiffcal, tmp_path: Path, name: bytes) -> None:
        folder = tmp_path / os.fsdecode(name)
        write_named_campaign(folder, runs=("pose 1", "姿势"))
        manifest = folder / "campaign.toml"
        manifest.write_text(manifest.read_text(encoding="utf-8").replace('name = "small"\n', ""), encoding="utf-8")
        assert stiffcal("check", str(folder)).code == 0
        for words in (["identify"], ["plot", "-o", f"{folder}/p.svg"], ["export", "-o", f"{folder}/s.csv"]):
            document = json.loads(stiffcal(words[0], str(folder), *words[1:], "--json").out)
            assert "error" not in document
            if "file" in document:
                assert Path(document["file"]).is_file()
        assert load_campaign(folder).name.isprintable()

    def test_what_is_wrong_there_is_one_line(self, stiffcal: Stiffcal, tmp_path: Path) -> None:
        folder = tmp_path / os.fsdecode(b"M\xfcller\n")
        shown = stiffcal("check", str(folder))
        assert (shown.code, shown.err.count("\n")) == (2, 1)
        assert json.loads(stiffcal("check", str(folder), "--json").out)["error"]["file"].endswith("M\\udcfcller\\n")

    def test_the_report_of_an_internal_fault(self, capsys: pytest.CaptureFixture[str]) -> None:
        name = os.fsdecode(b"M\xfcller \x1b[31m")
        for as_json in (False, True):
            assert report_fault(ValueError(f"{name}\n::error::"), ["check", name], as_json) == 3
            printed = capsys.readouterr()
            (printed.out + printed.err).encode("utf-8")
            assert not hidden().search((printed.out + printed.err).replace("\n", ""))
            assert printed.err.count("\n") == (0 if as_json else 1)

    def test_a_batch_of_such_folders(self, tmp_path: Path) -> None:
        folder = write_named_campaign(tmp_path / "cells" / os.fsdecode(b"M\xfc"), runs=("pose1", "pose2"))
        ((found, label),), _ = find_campaigns([tmp_path / "cells"])
        assert found == folder
        result = batch_campaigns([tmp_path / "cells"], BatchOptions(jobs=1, report=False))  # by a process of its own
        assert result.passed
        assert result.campaigns[0].campaign == label
        (markdown_text(result) + junit_text(result)).encode("utf-8")


def test_progress_takes_no_markup(monkeypatch: pytest.MonkeyPatch) -> None:
    bar = ProgressBar(terminal=True)
    bar("reading [/red] \x1b[31m", 0.5)
    assert bar._bar is not None
    text = bar._bar.tasks[0].description
    assert "\x1b" not in text
    column = bar._bar.columns[0]
    assert isinstance(column, TextColumn)
    assert "[/red]" in str(column.render(bar._bar.tasks[0]))  # as markup it would raise
    bar.stop()


def test_stores_below_one_address_do_not_meet() -> None:
    labels = ["a", "%61", "a?", "a#b", "a b", "50 %"]
    assert len({store_below("s3://lab/x", label) for label in labels}) == len(labels)
    assert not any(set("?#") & set(store_below("s3://lab/x", label)) for label in labels)


def test_recordings_of_runs_with_slashes_do_not_meet() -> None:
    names = [("a/b", "c"), ("a", "b/c"), ("a%2Fb", "c"), ("/", "c"), ("a//b", "c")]
    assert len({recording_name(*name) for name in names}) == len(names)
    assert all(name.count("/") == 2 and "//" not in name for name in (recording_name(*name) for name in names))


def test_a_report_s_name_fits_into_a_file_system() -> None:
    long = unicodedata.normalize("NFD", "ü") * 85  # 255 bytes: the longest folder
    assert len(os.fsencode(with_short_name(long, ".pdf"))) <= 255
    assert with_short_name("cells/a", ".pdf") == "cells/a.pdf"


def test_numbers_of_a_table_stay_numbers(tmp_path: Path) -> None:
    write_table({"name": ["-1.5", "+A", "x"], "value": pa.array([-1.5, 2.0, 3.0])}, tmp_path / "t.csv", EXPORT)
    with (tmp_path / "t.csv").open(newline="", encoding="utf-8") as file:
        assert list(csv.reader(file))[1:] == [["-1.5", "-1.5"], ["'+A", "2"], ["x", "3"]]


def test_a_columns_name_from_a_strangers_table_stays_one_text_in_robot_toml(tmp_path: Path) -> None:
    header = ['A1"', 'A2 "]\\', "A3", "A4", "A5", "A6", "Fx", "Fy", "Fz", "dx", "dy", "dz"]
    with (tmp_path / "table.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows([f"{k}.{row}" for k in range(len(header))] for row in range(4))
    with pytest.raises(SystemExit) as ended:
        main(["init", str(tmp_path / "cell"), "--from", str(tmp_path / "table.csv")])
    assert ended.value.code == 0
    robot = tomllib.loads((tmp_path / "cell" / "robot.toml").read_text(encoding="utf-8"))
    assert [joint["name"] for joint in robot["joints"]] == header[:6]
