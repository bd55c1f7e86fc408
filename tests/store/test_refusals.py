"""What the system does not let be read is neither missing nor damaged: nothing is computed or removed because of it."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest

from stiffcal.errors import InputError
from stiffcal.store import Store
from stiffcal.store.index import DamagedStoreError, UnreadableError
from stiffcal.store.origin import check_entries

posix = pytest.mark.skipif(os.name == "nt", reason="links of POSIX")


@contextmanager
def refused(name: str, number: int = errno.EACCES) -> Iterator[None]:
    """Let the system refuse to open files of a name, and to read links of it; root is refused nothing by rights."""

    def refusing(true: Callable[..., Any]) -> Callable[..., Any]:
        def act(path: Any, *args: Any, **named: Any) -> Any:
            if isinstance(path, str | Path) and Path(path).name == name:
                raise OSError(number, os.strerror(number), str(path))
            return true(path, *args, **named)

        return act

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "open", refusing(os.open))
        patch.setattr(os, "readlink", refusing(os.readlink))
        yield


@pytest.fixture
def store(tmp_path: Path, state: Path) -> Store:
    store = Store(tmp_path / "store", display_name="store")
    history = {"fits": [{"id": "1"}]}
    store.commit({"states": pa.table({"Fx": [1.0, 2.0]})}, {"fit": {"value": 1}, "history": history})
    return store


def contents(store: Store) -> dict[str, bytes]:
    files = (path for path in (store.folder / "generations").rglob("*") if path.is_file())
    return {path.relative_to(store.folder).as_posix(): path.read_bytes() for path in files}


@pytest.mark.parametrize(
    ("number", "mend"),
    [(errno.EACCES, "get permission to read it, then do this again"), (errno.EMFILE, "close other programs"),
     (errno.EIO, "check the disk")],
)  # fmt: skip
def test_a_file_that_cannot_be_read_is_named_with_its_cause(store: Store, number: int, mend: str) -> None:
    line = rf"^store: fit: cannot be read \({os.strerror(number)}\); {mend}"
    with refused("fit.json", number), pytest.raises(UnreadableError, match=line):
        store.read_document("fit")


@pytest.mark.parametrize("name", ["fit.json", "states.parquet", "history.json", "generation.json", "current"])
def test_nothing_is_written_instead_of_what_cannot_be_read(store: Store, name: str) -> None:
    before, generation = contents(store), store.generation
    with refused(name), pytest.raises(UnreadableError, match="get permission to read it"):
        store.commit(documents={"more": {"x": 1}})
    assert contents(store) == before
    assert store.generation == generation
    assert not (store.folder / "set-aside").exists()


@pytest.mark.parametrize("name", ["generation.json", "current"])
def test_a_store_that_cannot_be_read_is_not_taken_for_an_empty_one(store: Store, name: str) -> None:
    for read in (lambda: store.exists and store.documents, lambda: store.read_document("fit")):
        with refused(name), pytest.raises(UnreadableError):
            read()


def test_what_is_needed_is_not_left_out_where_it_is_damaged(store: Store) -> None:
    (store.folder / "current" / "states.parquet").write_bytes(b"damaged")
    before = contents(store)
    with store.begin() as writing:
        writing.needed = lambda name: name == "states"
        with pytest.raises(DamagedStoreError, match="states: damaged"):
            writing.keep_rest()
    assert contents(store) == before
    store.commit(documents={"more": {"x": 1}})  # where nothing says that it is needed, it is left out
    assert store.tables == ()


def leave(store: Store) -> Path:
    """Make what a killed command has left."""
    left = store.folder / "generations" / "20200101T000000-aaaaaa"
    left.mkdir()
    (left / "states.parquet").write_bytes(b"half")
    return left


def test_leftovers_are_removed_by_a_command_that_only_reads(store: Store) -> None:
    before, left = contents(store), leave(store)
    store.remove_leftovers()
    assert not left.exists()
    assert contents(store) == before


def test_leftovers_stay_while_somebody_writes(store: Store) -> None:
    with store.begin() as writing:
        left = leave(store)
        store.remove_leftovers()
        assert left.exists()
        assert writing.folder.exists()


@posix
def test_nothing_is_removed_where_no_generation_is_named(store: Store) -> None:
    left = leave(store)
    (store.folder / "current").unlink()
    before = contents(store)
    store.remove_leftovers()
    assert left.exists()
    assert contents(store) == before


@posix
def test_a_damaged_history_is_not_moved_through_a_link_out_of_the_store(store: Store, tmp_path: Path) -> None:
    (tmp_path / "outside").mkdir()
    (store.folder / "set-aside").symlink_to(tmp_path / "outside")
    (store.folder / "current" / "history.json").write_text("not JSON")
    before = contents(store)
    with pytest.raises(InputError, match=r"store: set-aside: this is a link, not a plain folder; remove it"):
        store.commit(documents={"more": {"x": 1}})
    assert list((tmp_path / "outside").iterdir()) == []
    assert contents(store) == before


@pytest.mark.parametrize("document", [{"fits": "abc"}, {"fits": {}}, []])
def test_a_history_whose_entries_are_no_list_is_damaged(document: object) -> None:
    with pytest.raises(ValueError, match="fits"):
        check_entries("history", document)
    check_entries("history", {"fits": []})
    check_entries("history", {})
    check_entries("identify", document)
