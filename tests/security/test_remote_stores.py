"""A store in S3 into which somebody else may write: as little is believed as of a folder."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.store import Store
from stiffcal.store import remote as remote_module
from stiffcal.trust.record import open_record
from tests.laboratory.s3 import BUCKET, elsewhere


@pytest.fixture
def address(request: pytest.FixtureRequest, bucket: Any, state: Path) -> str:
    return f"s3://{BUCKET}/{hashlib.sha256(request.node.name.encode()).hexdigest()}"


def fill(store: Store, value: float = 1.0) -> None:
    store.commit(
        {"states": {"Fx": np.full(9, value)}}, {"fit": {"value": value}, "history": {"fits": [{"id": "1"}]}},
    )  # fmt: skip


def key_of(address: str, name: str) -> str:
    return f"{address.removeprefix(f's3://{BUCKET}/')}/{name}"


def change(bucket: Any, address: str, name: str, content: Callable[[bytes], bytes]) -> None:
    key = key_of(address, f"generations/{elsewhere(address).generation}/{name}")
    old = bucket.get_object(Bucket=BUCKET, Key=key)["Body"].read()
    bucket.put_object(Bucket=BUCKET, Key=key, Body=content(old))


def test_what_others_write_there_is_foreign_until_the_place_is_trusted(bucket: Any, address: str) -> None:
    fill(Store(address))
    assert elsewhere(address).origin_of("fit") == "own"
    change(bucket, address, "generation.json", lambda text: text + b" ")
    assert elsewhere(address).origin_of("fit") == "foreign"
    open_record().allow_place(f"s3://{BUCKET}")
    assert elsewhere(address).origin_of("fit") == "trusted place"


@pytest.mark.parametrize("name", ["states.parquet", "fit.json"])
@pytest.mark.parametrize("how", ["same size", "shorter", "longer"])
def test_a_changed_object_is_damaged(bucket: Any, address: str, name: str, how: str) -> None:
    fill(Store(address))
    edits = {"same size": lambda old: bytes([old[0] ^ 1]) + old[1:], "shorter": lambda old: old[:-1],
             "longer": lambda old: old + b" " * 100}  # fmt: skip
    change(bucket, address, name, edits[how])
    store = elsewhere(address)
    with pytest.raises(InputError, match=r"(states|fit\.json|fit): damaged|fit\.json: damaged|parquet: damaged"):
        (store.read_table if name.endswith("parquet") else store.read_document)(name.split(".")[0])


@pytest.mark.parametrize("pointer", ["..", "a%2F..%2F..%2Fb", "current", "x y", "generations"])
def test_a_pointer_that_names_no_generation_is_passed_over(bucket: Any, address: str, pointer: str) -> None:
    fill(Store(address))
    bucket.put_object(Bucket=BUCKET, Key=key_of(address, f"current/9999999999-99999999-{pointer}%"), Body=b"")
    assert elsewhere(address).read_document("fit") == {"value": 1.0}


def test_the_history_of_another_is_marked_and_nothing_else_carried_over(bucket: Any, address: str) -> None:
    fill(Store(address))
    change(bucket, address, "generation.json", lambda text: text + b" ")
    store = elsewhere(address)
    store.commit(documents={"more": {"x": 1}})
    store = elsewhere(address)
    assert sorted(store.documents) == ["history", "more"]
    assert store.read_document("history") == {"fits": [{"id": "1", "origin": "foreign"}]}


@pytest.mark.parametrize("name", ["ticket-x-1", "ticket-", "ticket-99999999999999999999-aa", "entering-\u202e"])
def test_a_strange_lock_is_no_traceback(bucket: Any, address: str, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remote_module, "LEASE_S", 0.3)
    monkeypatch.setattr(remote_module, "POLL_S", 0.05)
    for body in (b"[1]", b'{"command": []}', b"[" * 100_000, json.dumps({"pid": "\u202e"}).encode()):
        bucket.put_object(Bucket=BUCKET, Key=key_of(address, f"lock/{name}"), Body=body)
        try:
            with Store(address).begin("identify", wait_s=0.1) as writing:
                writing.write_document("fit", {})
        except InputError as error:
            assert "is writing to it" in str(error)  # noqa: PT017  (either ending is right: no traceback)
    fill(Store(address))


def test_two_dots_behind_percent_signs_lead_out_of_no_trusted_place(state: Path) -> None:
    open_record().allow_place(f"s3://{BUCKET}/cells")
    assert open_record().place_allowed(Store(f"s3://{BUCKET}/cells/a").address)
    assert not open_record().place_allowed(Store(f"s3://{BUCKET}/cells/%2E%2E/others").address)


@pytest.mark.parametrize("address", ["s3://[::1", "S3://[", "file://[x", "http://\udc80[::1/x", "s3:///", "ftp://x/y"])
def test_what_is_no_address_is_one_line(address: str) -> None:
    with pytest.raises(InputError) as refused:
        Store(address)
    assert refused.value.code is FaultCode.STORE_ADDRESS


@pytest.mark.parametrize("address", ["file:///tmp/a%00b", "s3://bucket/a%00b", "a\0b"])
def test_an_address_with_a_nul_is_one_line(address: str) -> None:
    with pytest.raises(InputError) as refused:
        Store(address, "store")
    assert refused.value.code == FaultCode.STORE_ADDRESS


def test_an_endpoint_that_is_no_address_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://[x]")
    with pytest.raises(InputError, match="AWS_ENDPOINT_URL"):
        Store("s3://bucket/prefix", "store")
