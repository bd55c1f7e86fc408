"""Provenance: which sources changed since they were read."""

from __future__ import annotations

import hashlib
import os
import time
from pathlib import Path
from typing import Any

import pytest

from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.store import Provenance, Store, changed_sources, hash_sources, versions
from stiffcal.store.document_shape import result_from
from stiffcal.store.file_systems import shows_mapped_writes


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "raw").mkdir()
    for name in "abc":
        (tmp_path / "raw" / f"{name}.csv").write_text(f"{name}\n1.5\n")
    return tmp_path


FILES = ("raw/a.csv", "raw/b.csv", "raw/c.csv")


def record(folder: Path) -> Provenance:
    with hash_sources(folder, FILES) as hashes:
        return Provenance.now("ingest", hashes.result(), {"sources": {"ft": {"unit": "N"}}})


def test_hashes_and_versions_come_back_from_the_store(folder: Path) -> None:
    provenance = record(folder)
    assert provenance.sources[0].sha256 == hashlib.sha256(b"a\n1.5\n").hexdigest()
    store = Store(folder / "store")
    store.commit(documents={"provenance": document_of(provenance)})
    assert result_from(Provenance, store.read_document("provenance"), "store", "provenance") == provenance
    assert {"stiffcal", "numpy", "scipy", "pyarrow", "python"} <= set(versions())


@pytest.mark.parametrize("thorough", [False, True])
def test_changes_are_named(folder: Path, thorough: bool) -> None:
    provenance = record(folder)
    assert not changed_sources(provenance, folder, FILES, thorough)
    status = (folder / "raw/a.csv").stat()
    (folder / "raw/a.csv").write_text("a\n1.6\n")
    # Same size, same time: shortly after reading, only the content tells.
    os.utime(folder / "raw/a.csv", ns=(status.st_atime_ns, status.st_mtime_ns))
    (folder / "raw/b.csv").unlink()
    (folder / "raw/d.csv").write_text("d\n1\n")
    changes = changed_sources(provenance, folder, ("raw/a.csv", "raw/b.csv", "raw/d.csv"), thorough)
    assert changes.changed == ("raw/a.csv",)
    assert changes.missing == ("raw/b.csv",)
    assert changes.new == ("raw/d.csv",)
    assert changes.dropped == ("raw/c.csv",)
    text = "changed: raw/a.csv; missing: raw/b.csv; new: raw/d.csv; no longer named: raw/c.csv"
    assert str(changes) == text


def test_a_touched_file_of_the_same_content_is_unchanged(folder: Path) -> None:
    provenance = record(folder)
    os.utime(folder / "raw/a.csv", (time.time() - 3600, time.time() - 3600))
    assert not changed_sources(provenance, folder)


def test_a_log_still_being_written_is_refused(folder: Path) -> None:
    with hash_sources(folder, FILES) as hashes:
        hashes._pool.shutdown()
        (folder / "raw/b.csv").write_text("b\n1.5\n2.5\n")
        with pytest.raises(InputError, match=r"raw/b\.csv: the file changed while it was read"):
            hashes.result()


def test_a_missing_file_is_named_and_the_others_are_hashed(folder: Path) -> None:
    with hash_sources(folder, ("raw/a.csv", "raw/x.csv", "raw/b.csv")) as hashes:
        assert hashes.of("raw/b.csv").file == "raw/b.csv"
        assert [source.file for source in hashes.finished()] == ["raw/a.csv", "raw/b.csv"]
        with pytest.raises(InputError, match=r"raw/x\.csv: cannot be read: No such file"):
            hashes.result()


def test_of_many_logs_only_so_many_bytes_are_compared_in_every_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hundred gigabytes of small logs are hashed once, as one log of a hundred gigabytes is."""
    from stiffcal.store import source_files

    if not shows_mapped_writes(tmp_path):
        pytest.skip("this file system does not show every change in the files' times")
    monkeypatch.setattr(source_files, "RACY_NS", -(10**18))  # as if the logs had been written long ago
    monkeypatch.setattr(source_files, "ALWAYS_HASHED", 25)
    files = [f"log{k}.csv" for k in range(6)]
    for file in files:
        (tmp_path / file).write_text("0123456789")
    with source_files.hash_sources(tmp_path, files) as hashes:
        sources = hashes.result()
    then = Provenance.now("ingest", sources, {})
    hashed: list[str] = []
    true_hash = source_files.hash_file

    def hash_file(folder: Path, file: str, *rest: Any) -> Any:
        hashed.append(file)
        return true_hash(folder, file, *rest)

    monkeypatch.setattr(source_files, "hash_file", hash_file)
    assert not changed_sources(then, tmp_path, files, known_state=hashes.state)
    assert len(hashed) == 2
    (tmp_path / "log5.csv").write_text("0123456780")
    assert changed_sources(then, tmp_path, files, known_state=hashes.state).changed == ("log5.csv",)
