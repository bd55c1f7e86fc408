"""A pipe, socket, device or file of the system where a campaign's file is expected: refused at once, in one line."""

from __future__ import annotations

import os
import signal
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.manifest.thresholds import load_thresholds
from stiffcal.cli.app import main
from stiffcal.commands.init import init_campaign
from stiffcal.compensation.load_table import read_load_table
from stiffcal.errors import InputError
from stiffcal.files import check_regular, open_regular, read_regular
from stiffcal.limits import Limit
from stiffcal.readers import WantedColumns, find_reader
from stiffcal.stages.threshold_verdict import _read_model
from stiffcal.store.source_files import hash_sources
from tests.laboratory.small_campaign import write_small_campaign

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in the file system here")

KINDS = ("pipe", "socket", "device", "endless device", "link to a pipe", "system file")


def put(path: Path, kind: str) -> None:
    """Put something that is no regular file at a path."""
    path.unlink(missing_ok=True)
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        here = Path.cwd()
        os.chdir(path.parent)  # a socket's path may have 108 bytes
        try:
            with socket.socket(socket.AF_UNIX) as listening:
                listening.bind(path.name)
        finally:
            os.chdir(here)
    elif kind == "link to a pipe":
        pipe = path.parent / f"pipe-{path.name}"
        pipe.unlink(missing_ok=True)
        os.mkfifo(pipe)
        path.symlink_to(pipe.name)
    else:
        goals = {"device": "/dev/null", "endless device": "/dev/zero", "system file": "/proc/self/environ"}
        path.symlink_to(goals[kind])


class TestOpening:
    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("opening", [open_regular, read_regular, check_regular])
    def test_what_is_no_regular_file_is_refused_at_once(self, tmp_path: Path, kind: str, opening: object) -> None:
        put(tmp_path / "ft.csv", kind)
        begun = time.monotonic()
        with pytest.raises(InputError) as refused:
            opening(tmp_path / "ft.csv", "raw/ft.csv")  # type: ignore[operator]
        assert time.monotonic() - begun < 1.0
        (fault,) = refused.value.faults
        assert fault.file == "raw/ft.csv"
        assert fault.mend

    def test_a_regular_file_is_read_whole(self, tmp_path: Path) -> None:
        (tmp_path / "ft.csv").write_bytes(b"t,Fx\n" * 2_000_000)
        assert read_regular(tmp_path / "ft.csv") == b"t,Fx\n" * 2_000_000

    def test_missing_files_and_folders_are_what_open_says_of_them(self, tmp_path: Path) -> None:
        with pytest.raises(FileNotFoundError):
            open_regular(tmp_path / "no.csv")
        with pytest.raises(IsADirectoryError):
            open_regular(tmp_path)
        check_regular(tmp_path)

    def test_a_link_is_followed_only_where_that_is_wanted(self, tmp_path: Path) -> None:
        (tmp_path / "a").write_text("x")
        (tmp_path / "b").symlink_to("a")
        assert read_regular(tmp_path / "b") == b"x"
        with pytest.raises(OSError):
            read_regular(tmp_path / "b", follow=False)

    def test_more_bytes_than_the_limit_are_not_read(self, tmp_path: Path) -> None:
        (tmp_path / "a.json").write_bytes(b"x" * 1001)
        with pytest.raises(InputError, match="more than 1000 B of JSON; check the file, or raise SOME_LIMIT"):
            read_regular(tmp_path / "a.json", "store/a.json", limit=Limit("SOME_LIMIT", 1000, "of JSON"))

    def test_no_handle_stays_open(self, tmp_path: Path) -> None:
        if not Path("/proc/self/fd").is_dir():
            pytest.skip("handles cannot be counted here")
        put(tmp_path / "ft.csv", "pipe")
        before = len(list(Path("/proc/self/fd").iterdir()))
        for _ in range(20):
            with pytest.raises(InputError):
                open_regular(tmp_path / "ft.csv")
        assert len(list(Path("/proc/self/fd").iterdir())) == before

    def test_a_pipe_that_took_the_place_of_a_file_meanwhile_is_found_on_the_handle(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        put(tmp_path / "ft.csv", "pipe")
        (tmp_path / "other").write_text("x")
        regular = (tmp_path / "other").stat()
        monkeypatch.setattr(Path, "stat", lambda *_, **__: regular)
        done = threading.Event()

        def read() -> None:
            with pytest.raises(InputError):
                open_regular(tmp_path / "ft.csv")
            done.set()

        threading.Thread(target=read, daemon=True).start()
        assert done.wait(5.0)


class TestCampaigns:
    """Whatever file of a campaign is none: every command ends at once, with one line and exit code 2."""

    FILES = ("campaign.toml", "robot.toml", "model.toml", "raw/states.csv", "arm.urdf", "own.py", "baseline.json")

    @pytest.fixture
    def folder(self, tmp_path: Path) -> Path:
        folder = tmp_path / "c"
        write_small_campaign(folder)
        text = (folder / "campaign.toml").read_text()
        text = text.replace('robot = "robot.toml"', 'robot = "robot.toml"\nplugins = ["own.py"]')
        (folder / "campaign.toml").write_text(text + '\n[thresholds]\nbaseline = "baseline.json"\n')
        (folder / "own.py").write_text("")
        return folder

    @pytest.mark.parametrize("kind", ["pipe", "socket", "link to a pipe"])
    @pytest.mark.parametrize("file", FILES)
    def test_loading_it(self, folder: Path, file: str, kind: str) -> None:
        if file == "arm.urdf":
            (folder / "robot.toml").write_text('schema = "stiffcal/robot/1"\nurdf = "arm.urdf"\n')
        put(folder / file, kind)
        with ended_within(5.0), pytest.raises(InputError) as refused:
            _loaded(folder)
        line = str(refused.value)
        assert file in line
        assert "\n" not in line
        assert "this is a" in line

    @pytest.mark.parametrize("command", ["check", "ingest", "identify", "export", "history", "run"])
    @pytest.mark.parametrize("file", ["campaign.toml", "raw/states.csv"])
    def test_every_command(self, folder: Path, file: str, command: str, capsys: pytest.CaptureFixture[str]) -> None:
        put(folder / file, "pipe")
        words = [command, str(folder), *(["-o", str(folder / "x.csv")] if command == "export" else [])]
        with ended_within(8.0), pytest.raises(SystemExit) as ended:
            main(words)
        assert ended.value.code == 2
        assert "this is a pipe, not a file" in capsys.readouterr().err

    def test_hashing_a_log(self, tmp_path: Path) -> None:
        put(tmp_path / "ft.csv", "pipe")
        with (
            ended_within(5.0),
            pytest.raises(InputError, match="ft.csv: this is a pipe"),
            hash_sources(tmp_path, ["ft.csv"]) as hashes,
        ):
            hashes.result()

    @pytest.mark.parametrize("ending", ["csv", "csv.gz", "h5", "mat", "parquet", "tdms", "mcap", "db3"])
    @pytest.mark.parametrize("kind", ["pipe", "endless device", "system file"])
    def test_reading_a_log_of_any_format(self, tmp_path: Path, ending: str, kind: str) -> None:
        put(tmp_path / f"ft.{ending}", kind)
        with ended_within(5.0), pytest.raises(InputError, match="ft: this is a"):
            _read(tmp_path / f"ft.{ending}")


class TestFilesOfTheCommandLine:
    """What the user names may be a pipe: ``--from <(zcat table.csv.gz)``."""

    def piped(self, path: Path, text: str) -> Path:
        os.mkfifo(path)
        threading.Thread(target=path.write_text, args=(text,), daemon=True).start()
        return path

    def test_a_table_to_propose_a_campaign_from(self, tmp_path: Path) -> None:
        text = "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,dx,dy,dz\n" + "10,20,30,1,2,3,0,0,100,0,0,-0.2\n" * 3
        with ended_within(8.0):
            init_campaign(tmp_path / "c", tables=[self.piped(tmp_path / "pipe", text)], robot="irb4400")
        assert (tmp_path / "c" / "raw" / "table.csv").read_text() == text

    def test_poses_to_predict_at(self, tmp_path: Path) -> None:
        text = "A1,A2,Fx,Fy,Fz\n0,10,0,0,-100\n"
        with ended_within(8.0):
            table = read_load_table(self.piped(tmp_path / "pipe", text), ["A1", "A2"], joints_needed=True)
        assert len(table.wrench) == 1

    def test_thresholds(self, tmp_path: Path) -> None:
        text = 'schema = "stiffcal/thresholds/1"\n[validate]\nmax_rms_m = 2e-4\n'
        with ended_within(8.0):
            load_thresholds(self.piped(tmp_path / "pipe", text))


class TestFilesOfTheCommandLineInACampaign:
    """What lies inside a campaign folder is its maker's, also where the user names it: no pipe, and no link out."""

    @pytest.fixture
    def folder(self, tmp_path: Path) -> Path:
        write_small_campaign(tmp_path / "c")
        return tmp_path / "c"

    WORDS: ClassVar = {
        "thresholds": ["validate", "{folder}", "--thresholds", "{folder}/given"],
        "thresholds of a batch": ["batch", "{folder}", "--thresholds", "{folder}/given"],
        "poses": ["predict", "{folder}", "--poses", "{folder}/given"],
        "load path": ["predict", "{folder}", "--load-path", "{folder}/given", "--at", "0,0,0,0,0,0"],
        "path": ["compensate", "{folder}", "--path", "{folder}/given"],
        "table": ["init", "{folder}/new", "--from", "{folder}/given", "--robot", "irb4400"],
    }

    @pytest.mark.parametrize("kind", ["pipe", "endless device", "link out"])
    @pytest.mark.parametrize("option", list(WORDS))
    def test_it_is_refused_at_once(
        self, folder: Path, option: str, kind: str, state: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        if kind == "link out":
            (folder.parent / "secret").write_text("password,hunter2,1\n1,2,3\n")
            (folder / "given").symlink_to("../secret")
        else:
            put(folder / "given", kind)
        with ended_within(8.0), pytest.raises(SystemExit) as ended:
            main([word.format(folder=folder) for word in self.WORDS[option]])
        assert ended.value.code == 2
        said = capsys.readouterr().err
        assert "this is a pipe, not a file" in said or '"given" is a link to' in said
        assert "hunter2" not in said

    def test_a_table_larger_than_the_limit_is_not_read(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_MAX_TABLE", "1 KiB")
        (folder / "poses.csv").write_text("A1\n" * 1000)
        with pytest.raises(InputError, match="poses.csv: more than 1 KiB of a table; check the file, or raise"):
            read_load_table(folder / "poses.csv", ["A1"], joints_needed=True)


@contextmanager
def ended_within(seconds: float) -> Iterator[None]:
    """Interrupt what waits for ever; a test then fails instead of hanging."""

    def interrupt(*_: object) -> None:
        raise TimeoutError("it waits")

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _loaded(folder: Path) -> None:
    load_campaign(folder)
    _read_model(folder / "baseline.json", "baseline.json")


def _read(path: Path) -> None:
    list(find_reader(path, None, "ft").read_batches(path, {}, WantedColumns(("Fx",)), "ft"))
