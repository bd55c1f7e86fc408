"""A store in S3, on a server of the tests' own: whole generations, two writers, killed writers, the command line."""

from __future__ import annotations

import json
import multiprocessing
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.cli.app import main
from stiffcal.errors import InputError
from stiffcal.store import Store
from stiffcal.store import remote as remote_module
from tests.laboratory.s3 import BUCKET, elsewhere
from tests.laboratory.small_campaign import write_small_campaign


@pytest.fixture
def address(request: pytest.FixtureRequest, bucket: Any) -> str:
    return f"s3://{BUCKET}/{request.node.name.replace('[', '-').replace(']', '')}"


def objects(bucket: Any, address: str) -> list[str]:
    prefix = address.removeprefix(f"s3://{BUCKET}/") + "/"
    found = bucket.list_objects_v2(Bucket=BUCKET, Prefix=prefix).get("Contents", [])
    names = [entry["Key"].removeprefix(prefix) for entry in found]
    return sorted(name for name in names if not name.endswith("/"))  # Arrow marks folders that have become empty


def fill(store: Store, value: float, name: str = "fit") -> None:
    store.commit(tables={"states": {"Fx": np.full(1000, value)}}, documents={name: {"value": value}})


def test_what_is_written_is_read_elsewhere(bucket: Any, address: str) -> None:
    store = Store(address)
    assert not store.exists
    assert store.tables == ()
    with pytest.raises(InputError, match="nothing is stored here yet"):
        store.read_table("states")
    fill(store, 1.0)
    fill(store, 2.0, "history")
    other = elsewhere(address)
    assert other.documents == ("history", "fit")
    assert other.read_document("fit") == {"value": 1.0}  # kept, copied inside the object store
    assert other.read_table("states", ["Fx"]).column(0)[999].as_py() == 2.0
    with other.snapshot() as snapshot:
        fill(store, 3.0)
        assert snapshot.read_document("history") == {"value": 2.0}  # the generation it began with
    assert other.read_document("fit") == {"value": 3.0}
    assert not [name for name in objects(bucket, address) if name.startswith("lock/")]
    fill(store, 4.0)
    generations = {name.split("/")[1] for name in objects(bucket, address) if name.startswith("generations/")}
    assert len(generations) == 2  # the one that holds, and the one before it for those who still read it


def test_without_commit_nothing_changes(bucket: Any, address: str) -> None:
    store = Store(address)
    fill(store, 1.0)
    before = objects(bucket, address)
    with store.begin("ingest") as writing:
        writing.write_document("fit", {"value": 2.0})
    assert objects(bucket, address) == before
    assert elsewhere(address).read_document("fit") == {"value": 1.0}


def _interrupted(address: str, at: str) -> None:
    import os

    original = remote_module.Remote._write

    def dies(self: Any, name: str, content: bytes) -> None:
        if name.startswith(at):
            os._exit(9)
        original(self, name, content)

    remote_module.Remote._write = dies  # type: ignore[method-assign]
    remote_module._mirrors.clear()
    fill(Store(address), 2.0)


def test_a_killed_writer_leaves_the_old_store(bucket: Any, address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    fill(Store(address), 1.0)
    process = multiprocessing.get_context("spawn").Process(target=_interrupted, args=(address, "current/"))
    process.start()
    process.join()
    assert process.exitcode == 9
    store = elsewhere(address)
    assert store.read_document("fit") == {"value": 1.0}
    with pytest.raises(InputError, match=r"another stiffcal \(stiffcal, process \d+ on .*\) is writing to it"):
        store.begin("identify", wait_s=0.3).__enter__()
    monkeypatch.setattr(remote_module, "LEASE_S", 0.5)  # its lock stands still, and ends
    fill(store, 3.0)
    assert elsewhere(address).read_document("fit") == {"value": 3.0}
    assert len({name.split("/")[1] for name in objects(bucket, address) if name.startswith("generations/")}) == 2


@pytest.mark.long
def test_two_writers_come_one_after_the_other(bucket: Any, address: str) -> None:
    stores = [Store(address), elsewhere(address), elsewhere(address)]

    def count(store: Store) -> None:
        for _ in range(3):
            store.commit(documents=lambda stored: {"count": {"n": (stored("count") or {"n": 0})["n"] + 1}})

    threads = [threading.Thread(target=count, args=(store,)) for store in stores]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert elsewhere(address).read_document("count") == {"n": 9}  # nothing that one wrote was lost to another


def test_a_writer_that_was_taken_for_dead_is_reported(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    store, other = Store(address), elsewhere(address)
    fill(store, 1.0)
    monkeypatch.setattr(remote_module, "LEASE_S", 0.3)
    with store.begin("ingest") as slow:
        slow.write_document("fit", {"value": 2.0})
        fill(other, 3.0)  # waits until the first one's lease is over: it is not renewed so quickly
        with pytest.raises(InputError, match="took over the lock"):
            slow.commit()
    assert elsewhere(address).read_document("fit") == {"value": 3.0}


@pytest.mark.long
@pytest.mark.parametrize("first", ["the one that slept", "the other"])
def test_a_writer_that_sleeps_between_its_last_look_and_the_switch(
    first: str, address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    store, other = Store(address), elsewhere(address)
    fill(store, 1.0)
    monkeypatch.setattr(remote_module, "LEASE_S", 0.3)
    original = remote_module.Remote._write
    slept: list[str] = []

    def sleeps(self: Any, name: str, content: bytes) -> None:
        if name.startswith("current/") and not slept:
            slept.append(name)
            if first == "the other":  # all of its writing falls between the first one's look and switch
                fill(other, 3.0)
            else:  # it has looked, too, when the first one wakes up
                original(self, name, content)
                monkeypatch.setattr(remote_module.Remote, "_write", original)
                original(self, f"current/{name[8:18]}-00000009-20990101T000000-abcdef", b"")
                return
        original(self, name, content)

    monkeypatch.setattr(remote_module.Remote, "_write", sleeps)
    with pytest.raises(InputError, match="wrote to the store; the results of this process are not stored"):
        fill(store, 2.0)
    assert slept
    if first == "the other":
        assert elsewhere(address).read_document("fit") == {"value": 3.0}
        fill(elsewhere(address), 4.0)
        assert elsewhere(address).read_document("fit") == {"value": 4.0}


def test_a_long_writing_keeps_its_lock(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remote_module, "RENEW_S", 0.2)
    monkeypatch.setattr(remote_module, "LEASE_S", 2.5)  # S3 tells times of change in whole seconds
    store, other = Store(address), elsewhere(address)
    with store.begin("ingest") as slow:
        with pytest.raises(InputError, match="is writing to it"):
            other.begin("identify", wait_s=4.0).__enter__()
        slow.write_document("fit", {"value": 1.0})
        slow.commit()
    assert elsewhere(address).read_document("fit") == {"value": 1.0}


def test_faults_are_one_line(bucket: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="the address contains no bucket"):
        Store("s3:///prefix")
    with pytest.raises(InputError, match="gs: addresses are not supported"):
        Store("gs://lab/prefix")
    store = Store("s3://no-such-bucket/prefix")
    with pytest.raises(InputError) as caught:
        fill(store, 1.0)
    assert "s3://no-such-bucket/prefix: cannot be used: " in str(caught.value)
    assert "\n" not in str(caught.value)
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")
    began = time.monotonic()
    with pytest.raises(InputError, match="cannot be used") as caught:
        _ = Store("s3://lab/prefix").exists
    assert time.monotonic() - began < 60.0
    assert "geheim" not in str(caught.value)


def test_the_command_line(address: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=3)

    def answer(command: str) -> Any:
        remote_module._mirrors.clear()
        with pytest.raises(SystemExit) as ended:
            main([command, str(folder), "--store", address, "--json"])
        assert ended.value.code == 0
        return json.loads(capsys.readouterr().out)

    assert answer("ingest")["unchanged"] is False
    assert len(answer("identify")["parameters"]) == 6
    assert answer("validate")["passed"] is True
    assert len(answer("history")["fits"]) == 1
    assert answer("ingest")["unchanged"] is True
    assert not (folder / "store").exists()
