"""Standard streams that are closed, full or no longer read: no traceback, and an exit code that can be relied on."""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from stiffcal.cli.app import main
from stiffcal.cli.streams import guarded_streams
from stiffcal.errors import InputError
from stiffcal.module_path import quiet_libraries
from tests.laboratory.campaign_folders import write_campaign

FULL = Path("/dev/full")
needs_full_device = pytest.mark.skipif(not FULL.exists(), reason="this system has no device that is always full")
needs_shell = pytest.mark.skipif(os.name == "nt", reason="the shell's way to close a stream")


def shell(words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run `stiffcal` in a shell with its redirections; {dir} stands for the folder."""
    command = f'"{sys.executable}" -P -m stiffcal {words}'.replace("{dir}", f'"{folder}"')
    return subprocess.run(["bash", "-c", command], capture_output=True, text=True, cwd=folder.parent, timeout=60)


class Failing(io.StringIO):
    """A text stream whose system refuses to take what is written."""

    def __init__(self, error: OSError) -> None:
        super().__init__()
        self.error = error

    def write(self, text: str) -> int:
        raise self.error


def ends(monkeypatch: pytest.MonkeyPatch, *words: str, out: io.StringIO, err: io.StringIO) -> int:
    """Run the command line on these streams, and return its exit code."""
    monkeypatch.setattr(sys, "stdout", out)
    monkeypatch.setattr(sys, "stderr", err)
    with pytest.raises(SystemExit) as end:
        main(words)
    assert isinstance(end.value.code, int)
    return end.value.code


@needs_shell
@pytest.mark.parametrize(
    "closed", [*(pytest.param(one, marks=pytest.mark.practice) for one in (">&-", "2>&-")), "<&- >&- 2>&-"]
)
def test_a_command_with_closed_streams_ends_with_its_own_code(closed: str, tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "c")
    wrong = shell(f"check {{dir}} {closed}", folder)  # its table lacks columns
    assert (wrong.returncode, "Traceback" in wrong.stderr) == (2, False)
    help_page = shell(f"check --help {closed}", folder)
    assert (help_page.returncode, help_page.stderr) == (0, "")


@needs_shell
def test_no_file_is_opened_under_the_number_of_a_closed_stream(tmp_path: Path) -> None:
    """What a library writes to standard error would otherwise land in the first file that is opened."""
    code = (
        "import os; from stiffcal.cli.streams import guarded_streams\n"
        "with guarded_streams(): print(os.open('/dev/zero', os.O_RDONLY) > 2, file=open('found', 'w'))"
    )
    done = subprocess.run(["bash", "-c", f"'{sys.executable}' -P -c \"{code}\" <&- >&- 2>&-"], cwd=tmp_path)
    assert done.returncode == 0
    assert (tmp_path / "found").read_text() == "True\n"


@needs_full_device
@needs_shell
@pytest.mark.parametrize("words", ["--version", "effects", "effects --json", "check --help", "check {dir} --json"])
def test_an_answer_that_a_full_disk_does_not_take_is_one_line_with_exit_2(words: str, tmp_path: Path) -> None:
    folder = tmp_path / "c"
    done = shell(f"{words} > {FULL}", folder)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith(
        "standard output: cannot be read or written: No space" if "{" not in words else str(folder)
    )


@needs_full_device
@needs_shell
def test_standard_error_on_a_full_disk_changes_no_exit_code(tmp_path: Path) -> None:
    assert shell(f"check {{dir}} 2> {FULL}", tmp_path / "nowhere").returncode == 2
    assert shell(f"effects 2> {FULL}", tmp_path / "nowhere").returncode == 0


@pytest.mark.parametrize("words", [["effects"], ["effects", "--json"], ["effects", "backlash"], ["--help"]])
def test_a_reader_that_has_gone_ends_the_command_with_its_own_code(
    words: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    err = io.StringIO()
    assert ends(monkeypatch, *words, out=Failing(BrokenPipeError(32, "Broken pipe")), err=err) == 0
    assert err.getvalue() == ""


def test_a_check_that_does_not_hold_still_ends_with_1_when_its_reader_has_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tests.laboratory.small_campaign import write_small_campaign

    folder = write_small_campaign(tmp_path / "c", poses=1)
    table = folder / "raw" / "states.csv"
    lines = table.read_text(encoding="utf-8").splitlines()
    table.write_text("\n".join(lines[:3]) + "\n", encoding="utf-8")
    gone = Failing(BrokenPipeError(32, "Broken pipe"))
    whole = ends(monkeypatch, "check", str(folder), out=io.StringIO(), err=io.StringIO())
    assert whole == 1
    assert ends(monkeypatch, "check", str(folder), out=gone, err=io.StringIO()) == whole


def test_with_json_the_fault_goes_to_standard_error_where_standard_output_takes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    err = io.StringIO()
    full = Failing(OSError(28, "No space left on device"))
    assert ends(monkeypatch, "check", str(tmp_path / "nowhere"), "--json", out=full, err=err) == 2
    assert err.getvalue().splitlines() == [
        (
            f"{tmp_path / 'nowhere'}: no such folder; give a campaign folder, or create one: stiffcal init DIR "
            "[file-missing]"
        )
    ]


def test_a_failed_write_is_not_forgotten_where_a_library_catches_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", Failing(OSError(28, "No space left on device")))
    with guarded_streams():
        with contextlib.suppress(Exception):
            sys.stdout.write("lost")
        with pytest.raises(InputError, match="standard output: "):
            sys.stdout.flush()


def test_texts_of_any_script_can_be_written_whatever_the_coding(monkeypatch: pytest.MonkeyPatch) -> None:
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding="ascii"))
    with guarded_streams():
        sys.stdout.write("Größe µm 力 \udcff")
    assert raw.getvalue().decode() == "Größe µm 力 \\udcff"


@pytest.mark.parametrize(
    "odd",
    [
        {"PYTHONWARNINGS": "error", "COLUMNS": "abc", "PYTHONIOENCODING": "ascii", "MPLBACKEND": "nowhere"},
        {"COLUMNS": "-5", "TERM": "dumb"},
    ],
    ids=" ".join,
)
def test_an_odd_environment_changes_nothing(odd: dict[str, str], tmp_path: Path) -> None:
    words = [sys.executable, "-P", "-m", "stiffcal", "effects", "backlash", "-o", str(tmp_path / "b.svg")]
    done = subprocess.run(words, capture_output=True, encoding="utf-8", env={**os.environ, **odd}, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""


def test_memory_that_does_not_suffice_is_the_users_to_mend(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def greedy() -> None:
        raise MemoryError("Unable to allocate 74 TiB")

    monkeypatch.setattr("stiffcal.cli.app.application", lambda *_: greedy)
    with pytest.raises(SystemExit) as end:
        main(["effects"])
    assert end.value.code == 2
    assert capsys.readouterr().err.startswith("not enough memory (Unable to allocate 74 TiB); ")


def test_a_folder_that_vanishes_is_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def lost() -> None:
        raise FileNotFoundError(2, "No such file or directory", "raw/ft.csv")

    monkeypatch.setattr("stiffcal.cli.app.application", lambda *_: lost)
    with pytest.raises(SystemExit) as end:
        main(["effects"])
    assert end.value.code == 2
    assert capsys.readouterr().err.startswith("raw/ft.csv: cannot be read or written: ")


def test_warnings_of_libraries_are_kept_from_standard_error() -> None:
    import warnings

    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("error")
        quiet_libraries()
        warnings.warn("overflow encountered in multiply", RuntimeWarning, stacklevel=1)
    assert shown == []


def test_a_warning_of_a_library_ends_no_task_of_a_batch(tmp_path: Path) -> None:
    code = (
        "import sys, warnings; from stiffcal.batch import task as batch_task, worker as batch_worker\n"
        "from stiffcal.results import batch_results as results\n"
        "def run_task(task, begin):\n"
        "    warnings.warn('overflow', RuntimeWarning)\n"
        "    return results.outcome_of(task, 'held')\n"
        "class Channel:\n"
        '    def requests(self): yield b\'{"folder": "a", "campaign": "b"}\'\n'
        "    def send(self, message): sys.stdout.buffer.write(message + b'\\n')\n"
        "batch_task.run_task = run_task; batch_worker.work(Channel())"
    )
    environment = {**os.environ, "PYTHONWARNINGS": "error"}
    words = [sys.executable, "-P", "-c", code]
    ended = subprocess.run(words, stdout=subprocess.PIPE, env=environment, cwd=tmp_path, timeout=60, check=True)
    line = ended.stdout.splitlines()[-1]
    assert json.loads(line)["state"] == "held"
