"""What a stranger has put into a folder does not redirect what stiffcal writes there."""

from __future__ import annotations

import os
import shutil
import socket
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from stiffcal.batch.summary import prepare_files, write_summary
from stiffcal.cli.common_options import CommonOptions
from stiffcal.cli.log import logging_to
from stiffcal.commands import demo
from stiffcal.commands.init import init_campaign
from stiffcal.commands.plan import plan_campaign
from stiffcal.commands.simulate import simulate_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import write_whole
from stiffcal.planning.campaign.request import PlanRequest
from stiffcal.propose.templates import write_template
from stiffcal.stages.steps import RunContext
from stiffcal.trust.output_kinds import MARKDOWN

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
pytestmark = pytest.mark.skipif(os.name == "nt", reason="links need a right there")


def test_a_link_with_the_name_of_the_temporary_file_is_not_written_through(tmp_path: Path) -> None:
    """The name was the goal's with this process's number: a folder can hold links for all of them."""
    victim = tmp_path / "authorized_keys"
    victim.write_text("mine")
    folder = tmp_path / "campaign"
    folder.mkdir()
    (folder / f".report.txt.{os.getpid()}").symlink_to(victim)
    write_whole(folder / "report.txt", "new")
    assert victim.read_text() == "mine"
    assert (folder / "report.txt").read_text() == "new"


@pytest.mark.parametrize("linked", [False, True], ids=["itself", "by a link"])
@pytest.mark.parametrize("kind", ["pipe", "socket", "device"])
def test_a_file_takes_no_place_of_what_is_none(tmp_path: Path, kind: str, linked: bool) -> None:
    """With the rights of root, a report written to /dev/null took the device's place for all programs."""
    special, goal = tmp_path / "special", tmp_path / ("report.txt" if linked else "special")
    if kind == "pipe":
        os.mkfifo(special)
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as listening:
            listening.bind(os.path.relpath(special))  # the path of a socket may not be long
    else:
        try:
            os.mknod(special, stat.S_IFCHR | 0o600, os.makedev(1, 3))
        except OSError:
            pytest.skip("this user may make no devices")
    if linked:
        goal.symlink_to(special)
    before = special.lstat()
    with pytest.raises(InputError) as caught:
        write_whole(goal, "new")
    assert str(caught.value) == f"{goal}: this is a {kind}, not a file; name another file [file-kind]"
    assert (special.lstat().st_mode, special.lstat().st_ino) == (before.st_mode, before.st_ino)
    assert goal.is_symlink() == linked


@pytest.mark.parametrize("place", ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1", "/dev/a-new-name"])
def test_a_file_takes_no_place_of_the_running_system(place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def written(*_: object, **__: object) -> None:
        raise AssertionError("the system's own file would have been replaced")

    monkeypatch.setattr(Path, "write_text", written)
    monkeypatch.setattr(Path, "replace", written)
    with pytest.raises(InputError, match=r"; name another file \[file-kind\]$"):
        write_whole(Path(place), "new")


@pytest.mark.parametrize("to", ["a file", "a pipe"])
def test_a_summary_to_standard_output_goes_where_that_leads(tmp_path: Path, to: str) -> None:
    code = "from pathlib import Path; from stiffcal.batch.summary import write_summary as w; "
    code += "w('all', Path('/dev/stdout'), None)"
    before = Path("/dev/stdout").readlink()
    words = [sys.executable, "-c", f"import stiffcal.files as f; f.write_whole = None; {code}"]
    if to == "a file":
        with (tmp_path / "summary.txt").open("w") as output:
            subprocess.run(words, stdout=output, check=True)
        assert (tmp_path / "summary.txt").read_text() == "all"
    else:
        assert subprocess.run(words, stdout=subprocess.PIPE, check=True).stdout == b"all"
    assert Path("/dev/stdout").readlink() == before


@pytest.fixture
def pipe(tmp_path: Path) -> Iterator[Path]:
    """A pipe that can be opened for writing: where it is, nothing waits for a reader."""
    path = tmp_path / "junit.xml"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    yield path
    os.close(reader)


@pytest.mark.parametrize("linked", [False, True], ids=["itself", "by a link"])
def test_no_summary_and_no_log_goes_to_a_pipe_in_a_folder(pipe: Path, linked: bool) -> None:
    """Without a reader both would wait for ever, and what is checked out may bring the pipe."""
    goal = pipe
    if linked:
        goal = pipe.with_name("link.xml")
        goal.symlink_to(pipe)
    tries: list[Callable[[], None]] = [
        lambda: prepare_files(goal, None),
        lambda: write_summary("all", goal, MARKDOWN),
        lambda: _log_to(goal),
    ]
    for write in tries:
        with pytest.raises(InputError) as caught:
            write()
        assert caught.value.faults[0].code == FaultCode.FILE_KIND
    assert stat.S_ISFIFO(pipe.lstat().st_mode)


def _log_to(file: Path) -> None:
    with logging_to(CommonOptions(log_file=str(file)), []):
        raise AssertionError("the log is open")


def test_two_summaries_have_two_files(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path)
    with pytest.raises(InputError) as caught:
        prepare_files(tmp_path / "summary", tmp_path / "link" / "summary")
    assert caught.value.faults[0].code == FaultCode.OPTION_INVALID
    prepare_files(tmp_path / "junit.xml", tmp_path / "summary.md")


@pytest.mark.parametrize("kind", ["load", "clamped"])
def test_init_writes_nothing_through_a_link_that_leads_out(tmp_path: Path, kind: str) -> None:
    outside, folder = tmp_path / "outside", tmp_path / "campaign"
    outside.mkdir()
    folder.mkdir()
    (folder / "raw").symlink_to(outside)
    with pytest.raises(InputError, match="outside the"):
        write_template(folder, kind)
    assert not list(outside.iterdir())


def test_init_from_a_table_copies_nothing_through_a_link_that_leads_out(tmp_path: Path) -> None:
    outside, folder, table = tmp_path / "outside", tmp_path / "campaign", tmp_path / "table.csv"
    outside.mkdir()
    folder.mkdir()
    (folder / "raw").symlink_to(outside)
    shutil.copy(CAMPAIGNS / "hidden" / "01" / "raw" / "states.csv", table)
    with pytest.raises(InputError, match="outside the"):
        init_campaign(folder, tables=[table], robot="irb4400")
    assert not list(outside.iterdir())


def test_simulate_writes_nothing_through_a_link_that_leads_out(tmp_path: Path) -> None:
    outside, out = tmp_path / "outside", tmp_path / "out"
    outside.mkdir()
    out.mkdir()
    (out / "truth.json").write_text("{}")
    (out / "raw").symlink_to(outside)
    with pytest.raises(InputError, match="outside the"):
        simulate_campaign(CAMPAIGNS / "irb4400", out, 1, overwrite=True)
    assert not list(outside.iterdir())


@dataclass
class FitAndPdf:
    """What stands in for the answer of `run`."""

    folder: str = ""
    history: object = None


def test_demo_writes_its_readme_through_no_link(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder that passes for an earlier demo: it holds truth.json."""
    victim, folder = tmp_path / "authorized_keys", tmp_path / "demo"
    victim.write_text("mine")
    folder.mkdir()
    (folder / "truth.json").write_text("{}")
    (folder / "README.md").symlink_to(victim)
    for step in ("simulate_campaign", "improve_campaign", "read_history"):
        monkeypatch.setattr(demo, step, lambda *_, **__: {})
    monkeypatch.setattr(demo, "run_campaign", lambda *_: FitAndPdf())
    with pytest.raises(InputError, match=FaultCode.FILE_EXISTS.value):
        demo.run_demo(folder)
    demo.run_demo(folder, RunContext(overwrite=True))
    assert victim.read_text() == "mine"
    assert (folder / "README.md").read_text() == (demo.EXAMPLE / "README.md").read_text()


def test_plan_writes_neither_sheet_nor_program_through_a_link(tmp_path: Path) -> None:
    """A link in a stranger's folder, with the name that a run sheet or a program would get."""
    folder = tmp_path / "campaign"
    folder.mkdir()
    for name in ("campaign.toml", "robot.toml", "model.toml"):
        shutil.copy(CAMPAIGNS / "irb4400" / name, folder / name)
    (folder / "plan.toml").write_text('schema = "stiffcal/plan-input/1"\ncandidates = 20\nload = { force_N = 450 }\n')
    victim = tmp_path / "authorized_keys"
    victim.write_text("mine")
    sheet, program = folder / "runs.csv", folder / "drive.src"
    for file in (sheet, program):
        file.symlink_to(victim)
    for request in (PlanRequest(runs=3, sheet=sheet), PlanRequest(runs=3, program=program)):
        with pytest.raises(InputError, match=FaultCode.FILE_EXISTS.value):
            plan_campaign(folder, request=request)
    plan_campaign(folder, RunContext(overwrite=True), PlanRequest(runs=3, sheet=sheet, program=program))
    assert victim.read_text() == "mine"
    assert sheet.read_text().startswith("run,rank,row,state,")
    assert program.read_text().startswith("&ACCESS RVP\nDEF drive()\n")
