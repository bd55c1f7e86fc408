"""A pipe, socket, device or file of the system where a campaign's file is expected: refused at once, in one line."""

from __future__ import annotations

import os
import socket
import threading
import time
from pathlib import Path

import pytest

from stiffcal.errors import InputError
from stiffcal.files import check_regular, open_regular, read_regular
from stiffcal.limits import Limit

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

    def test_a_pipe_that_took_the_place_of_a_file_meanwhile_is_seen_on_the_handle(
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
