"""A store from somebody else: nothing is read or written outside it, nothing hangs, what is damaged is one line."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import socket
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.store import Store
from stiffcal.store.index import DamagedStoreError, parse_index

SECRET = b"-----BEGIN PRIVATE KEY-----\n"
posix = pytest.mark.skipif(os.name == "nt", reason="links, pipes and sockets of POSIX")


def fill(store: Store, value: float = 1.0) -> None:
    store.commit(
        {"states": {"Fx": np.full(3, value)}, "recordings/a/ft": {"t": np.arange(9.0)}},
        {"fit": {"value": value}, "history": {"fits": [{"id": "1", "value": value}]}},
        keep_rest=False,
    )


@pytest.fixture
def store(tmp_path: Path, state: Path) -> Store:
    store = Store(tmp_path / "campaign" / "store", display_name="store")
    (tmp_path / "campaign").mkdir()
    fill(store)
    return store


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    file = tmp_path / "id_ed25519"
    file.write_bytes(SECRET)
    return file


def forge(store: Store, change: Callable[[dict[str, Any]], None]) -> None:
    """Rewrite the index as somebody might who knows the format."""
    file = store.folder / "current" / "generation.json"
    index = json.loads(file.read_text("utf-8"))
    change(index)
    file.write_text(json.dumps(index), "utf-8")


def trees(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file() and not path.is_symlink())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def rewrite(store: Store) -> None:
    """Do what every command does that adds a document."""
    store.commit(documents={"more": {"x": 1}})


def test_a_file_name_in_the_index_neither_reads_nor_writes_outside(store: Store, secret: Path, tmp_path: Path) -> None:
    outside = "../../../../id_ed25519"

    def forged(index: dict[str, Any]) -> None:
        for kind in ("tables", "documents"):
            for entry in index[kind].values():
                entry["file"] = outside
        index["documents"]["key"] = {
            "file": outside,
            "bytes": len(SECRET),
            "sha256": hashlib.sha256(SECRET).hexdigest(),
        }

    forge(store, forged)
    rewrite(store)
    assert secret.read_bytes() == SECRET
    assert secret.stat().st_nlink == 1
    assert not [name for name, content in trees(store.folder).items() if content == SECRET]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["campaign", "id_ed25519"]


@pytest.mark.parametrize("name", ["../../../../id_ed25519", "/etc/passwd", "a/../../b", "", ".", "x\0y", "\ud800"])
def test_a_name_that_leads_outside_is_none(store: Store, secret: Path, name: str) -> None:
    def forged(index: dict[str, Any]) -> None:
        index["tables"][name] = {"file": "x", "rows": 1, "bytes": len(SECRET), "sha256": "0" * 64}

    forge(store, forged)
    rewrite(store)
    assert secret.stat().st_nlink == 1
    assert not [path for path in trees(store.folder).values() if path == SECRET]


@posix
@pytest.mark.parametrize("name", ["states.parquet", "fit.json", "history.json", "recordings/a/ft.parquet"])
def test_a_linked_file_of_a_store_is_neither_read_nor_carried_over(store: Store, secret: Path, name: str) -> None:
    file = store.folder / "current" / name
    file.unlink()
    file.symlink_to(secret)
    with pytest.raises(InputError, match="this is a link, not a plain file"):
        (store.read_table if name.endswith("parquet") else store.read_document)(name.rsplit(".", 1)[0])
    rewrite(store)
    assert secret.stat().st_nlink == 1
    assert not [path for path in trees(store.folder).values() if path == SECRET]


@posix
def test_a_linked_folder_of_a_store_is_not_followed(store: Store, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    (store.folder / "current" / "recordings").rename(outside)
    (store.folder / "current" / "recordings").symlink_to(outside)
    with pytest.raises(InputError, match="this is a link, not a plain folder"):
        store.read_table("recordings/a/ft")
    rewrite(store)
    assert trees(outside).keys() == {"a/ft.parquet"}


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _socket(path: Path) -> None:
    place = Path.cwd()
    os.chdir(path.parent)  # a socket's path is short
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(path.name)
    finally:
        os.chdir(place)


@posix
@pytest.mark.parametrize("make", [_pipe, _socket])
@pytest.mark.parametrize("name", ["states.parquet", "fit.json", "generation.json", "current.id", "lock"])
def test_a_pipe_or_socket_in_a_store_holds_nothing_up(store: Store, make: Callable[[Path], None], name: str) -> None:
    place = store.folder if name in ("current.id", "lock") else (store.folder / "current").resolve()
    (place / name).unlink(missing_ok=True)
    make(place / name)
    for read in (lambda: store.read_table("states"), lambda: store.read_document("fit")):
        with suppress(InputError):  # in one line, or what the newest whole generation holds
            read()
    if name == "lock":
        with pytest.raises(InputError, match=r"store: lock: this is a (pipe|socket), not a plain file; remove it"):
            rewrite(store)
    else:
        rewrite(store)
        assert store.read_document("more") == {"x": 1}


@posix
def test_a_linked_lock_empties_no_file(store: Store, secret: Path) -> None:
    (store.folder / "lock").unlink()
    (store.folder / "lock").symlink_to(secret)
    with pytest.raises(InputError, match="lock: this is a link, not a plain file; remove it"):
        rewrite(store)
    assert secret.read_bytes() == SECRET


@posix
def test_linked_generations_are_not_written_through(store: Store, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    (store.folder / "generations").rename(outside)
    (store.folder / "generations").symlink_to(outside)
    before = trees(outside)
    with pytest.raises(InputError, match="generations: this is a link, not a plain folder"):
        rewrite(store)
    assert trees(outside) == before


@posix
def test_a_linked_generation_is_removed_and_what_it_leads_to_stays(store: Store, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "generation.json").write_text("{}")
    (store.folder / "generations" / "20200101T000000-aaaaaa").symlink_to(outside)
    rewrite(store)
    assert trees(outside) == {"generation.json": b"{}"}
    assert len(list((store.folder / "generations").iterdir())) == 1


@posix
@pytest.mark.parametrize(
    "target", ["../../elsewhere", "/tmp", ".", "generations", "generations/../..", "generations/x/y"]
)
def test_current_names_a_generation_and_nothing_else(store: Store, tmp_path: Path, target: str) -> None:
    elsewhere = tmp_path / "elsewhere"
    shutil.copytree(store.folder / "current", elsewhere)
    forged = json.loads((elsewhere / "fit.json").read_text()) | {"value": 666.0}
    (elsewhere / "fit.json").write_text(json.dumps(forged))
    (store.folder / "current").unlink()
    (store.folder / "current").symlink_to(target)
    # The newest whole generation is used instead.
    assert store.read_document("fit") == {"value": 1.0}
    rewrite(store)
    assert store.read_document("fit") == {"value": 1.0}
    assert (store.folder / "current").resolve().parent.name == "generations"


def test_without_current_the_newest_whole_generation_is_used_and_named(
    store: Store, capsys: pytest.CaptureFixture[str]
) -> None:
    generation = store.generation
    (store.folder / "current").unlink()
    newer = store.folder / "generations" / "29991231T000000-aaaaaa"
    shutil.copytree(store.folder / "generations" / str(generation), newer)
    (newer / "states.parquet").unlink()
    assert store.generation == generation
    assert store.read_document("fit") == {"value": 1.0}
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert lines[0].endswith(f"current refers to no existing generation: the newest complete one is used, {generation}")
    rewrite(store)
    assert (store.folder / "current").is_symlink() or os.name == "nt"
    assert store.read_document("history") == {"fits": [{"id": "1", "value": 1.0}]}


def test_current_as_a_text_file_is_mended(store: Store) -> None:
    generation = store.generation
    (store.folder / "current").unlink()
    (store.folder / "current").write_text(f"generations/{generation}")  # as an archive without links keeps it
    assert store.generation == generation
    rewrite(store)
    assert store.read_document("fit") == {"value": 1.0}
    assert (store.folder / "current" / "fit.json").is_file()


@pytest.mark.parametrize("place", ["current", "latest"])
def test_a_store_of_a_newer_version_is_left_alone(store: Store, place: str) -> None:
    forge(store, lambda index: index.update(schema="stiffcal/store/3"))
    if place == "latest":
        (store.folder / "current").unlink()
    before = trees(store.folder / "generations")
    for use in (lambda: store.read_document("fit"), lambda: rewrite(store), lambda: store.documents):
        with pytest.raises(InputError, match=r"written by a newer stiffcal \(stiffcal/store/3\); update stiffcal"):
            use()
    assert trees(store.folder / "generations") == before


def test_the_history_survives_a_damaged_index_and_a_damaged_history_is_set_aside(store: Store) -> None:
    (store.folder / "current" / "generation.json").write_text("{")
    assert store.documents == ()
    rewrite(store)
    assert store.read_document("history")["fits"] == [{"id": "1", "value": 1.0, "origin": "foreign"}]
    (store.folder / "current" / "history.json").write_text("not JSON")
    rewrite(store) if "more" not in store.documents else store.commit(documents={"again": {}})
    assert "history" not in store.documents
    aside = list((store.folder / "set-aside").rglob("history.json"))
    assert [file.read_text() for file in aside] == ["not JSON"]


BOMBS = {
    "deep": b'{"a":' + b"[" * 200_000 + b"]" * 200_000 + b"}",
    "digits": b'{"a": ' + b"9" * 5000 + b"}",
    "many digits": b'{"a": ' + b"9" * 4000 + b"}",
    "NaN": b'{"a": NaN}',
    "infinity": b'{"a": -Infinity}',
    "beyond floats": b'{"a": 1e999}',
    "list": b"[1, 2]",
    "incomplete character": b'{"a": "\\ud800"}',
    "latin-1": b'{"a": "\xe9"}',
    "empty": b"",
}


@pytest.mark.parametrize("content", BOMBS.values(), ids=BOMBS.keys())
def test_a_document_that_is_no_plain_json_is_one_line(store: Store, content: bytes) -> None:
    (store.folder / "current" / "fit.json").write_bytes(content)
    digest = hashlib.sha256(content).hexdigest()
    forge(store, lambda index: index["documents"]["fit"].update(bytes=len(content), sha256=digest))
    with pytest.raises(InputError, match=r"^store: fit: damaged \([^\n]*\); run stiffcal ingest again"):
        store.read_document("fit")
    with pytest.raises(DamagedStoreError):
        parse_index(content, "store")


@pytest.mark.parametrize(
    "entry",
    [None, 1, [], {}, {"bytes": "1", "sha256": "0" * 64}, {"bytes": -1, "sha256": "0" * 64}, {"bytes": 1},
     {"bytes": 1, "sha256": 7}, {"bytes": 1, "sha256": "x" * 64}, {"bytes": 1e400, "sha256": "0" * 64},
     {"bytes": 1, "sha256": "0" * 64, "origin": "mine"}, {"bytes": True, "sha256": "0" * 64}],
)  # fmt: skip
def test_an_index_of_the_wrong_shape_is_damaged(store: Store, entry: object) -> None:
    text = json.dumps({"schema": "stiffcal/store/2", "tables": {}, "documents": {"fit": entry}}).encode()
    with pytest.raises(InputError, match=r"store: generation\.json: damaged"):
        parse_index(text, "store")


def test_a_file_changed_after_it_was_written_is_damaged(store: Store) -> None:
    file = store.folder / "current" / "fit.json"
    found = file.stat()
    file.write_bytes(file.read_bytes().replace(b"1.0", b"9.0"))
    os.utime(file, ns=(found.st_atime_ns, found.st_mtime_ns))
    with pytest.raises(InputError, match="fit: damaged \\(its content has changed since it was written\\)"):
        store.read_document("fit")
    table = store.folder / "current" / "states.parquet"
    Store(store.folder.parent / "other").commit({"states": {"Fx": np.full(3, 2.0)}})
    other = store.folder.parent / "other" / "current" / "states.parquet"
    table.write_bytes(other.read_bytes())
    with pytest.raises(InputError, match="states: damaged"):
        store.read_table("states")


def test_the_index_holds_the_hash_and_size_of_every_file(store: Store) -> None:
    rewrite(store)
    folder = store.folder / "current"
    index = json.loads((folder / "generation.json").read_text("utf-8"))
    entries = {entry["file"]: entry for kind in ("tables", "documents") for entry in index[kind].values()}
    files = {name: content for name, content in trees(folder).items() if name != "generation.json"}
    assert {name: entry["sha256"] for name, entry in entries.items()} == {
        name: hashlib.sha256(content).hexdigest() for name, content in files.items()
    }
    assert {name: entry["bytes"] for name, entry in entries.items()} == {n: len(c) for n, c in files.items()}
