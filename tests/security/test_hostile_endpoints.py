"""An endpoint of S3, or who stands between, that answers without end or not at all."""

from __future__ import annotations

import hashlib
import os
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.bounded_work import object_store
from stiffcal.bounded_work.object_child import serve
from stiffcal.bounded_work.waiting import WaitingChildren
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.store import Store
from tests.laboratory.hostile_endpoint import HEAD, hostile_endpoint
from tests.laboratory.s3 import BUCKET, elsewhere

LISTING, INDEX, POINTER = rb"GET /lab\?", rb"GET /lab/\S*generation\.json", rb"PUT /lab/\S*/current/"
LIMIT = 192 << 20


@pytest.fixture
def address(request: pytest.FixtureRequest, bucket: Any, state: Path) -> str:
    return f"s3://{BUCKET}/{hashlib.sha256(request.node.name.encode()).hexdigest()}"


@pytest.fixture
def little_memory(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Processes with less memory than the tests have to send."""
    children = WaitingChildren(serve, memory_bytes=LIMIT)
    monkeypatch.setattr(object_store, "_CHILDREN", children)
    yield
    children.stop_all()


def fill(store: Store, value: float) -> None:
    store.commit({"states": {"Fx": np.full(9, value)}}, {"fit": {"value": value}})


@pytest.mark.parametrize("what", [LISTING, INDEX])
@pytest.mark.usefixtures("little_memory")
def test_an_answer_without_end_is_cut(what: bytes, address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    fill(Store(address), 1.0)
    sent: list[int] = []

    def flood(asker: socket.socket, request: bytes) -> None:
        asker.sendall(HEAD + b"<ListBucketResult>")
        text = b"<Contents><Key>a</Key></Contents>" * 30_000
        while sum(sent) < 3 * LIMIT:
            asker.sendall(text)
            sent.append(len(text))

    with hostile_endpoint(os.environ["AWS_ENDPOINT_URL"], what, flood) as endpoint:
        monkeypatch.setenv("AWS_ENDPOINT_URL", endpoint.address)
        with pytest.raises(InputError) as refused:
            elsewhere(address).read_document("fit")
    assert refused.value.code == FaultCode.STORE_INACCESSIBLE
    assert "\n" not in str(refused.value)
    assert sum(sent) < 2 * LIMIT


def silence(asker: socket.socket, request: bytes) -> None:
    """Hold the connection until the asker has gone."""
    while asker.recv(1 << 16):
        pass


def dribble(asker: socket.socket, request: bytes) -> None:
    """Send a byte now and then, which no limit of a silence notices."""
    asker.sendall(HEAD)
    while True:
        asker.sendall(b"<")
        time.sleep(0.05)


@pytest.mark.parametrize("act", [silence, dribble])
def test_an_endpoint_that_does_not_answer_is_given_up_once(
    act: Any, address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(Store(address), 1.0)
    monkeypatch.setattr(object_store, "ANSWER_S", 0.5)
    asked: list[bytes] = []

    def counted(asker: socket.socket, request: bytes) -> None:
        asked.append(request)
        act(asker, request)

    with hostile_endpoint(os.environ["AWS_ENDPOINT_URL"], LISTING, counted) as endpoint:
        monkeypatch.setenv("AWS_ENDPOINT_URL", endpoint.address)
        store = elsewhere(address)
        for _ in range(2):
            with pytest.raises(InputError) as refused:
                fill(store, 2.0)
            assert refused.value.code == FaultCode.STORE_INACCESSIBLE
    assert len(asked) == 1


@pytest.mark.parametrize("act", [silence, lambda asker, request: None])
def test_a_switch_without_an_answer_takes_nothing_back(
    act: Any, bucket: Any, address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The switch may come late: what it names has to be there then."""
    fill(Store(address), 1.0)
    true = os.environ["AWS_ENDPOINT_URL"]
    held: list[str] = []

    def hold(asker: socket.socket, request: bytes) -> None:
        held.append(request.split()[1].decode("ascii").removeprefix(f"/{BUCKET}/"))
        act(asker, request)

    monkeypatch.setattr(object_store, "ANSWER_S", 2.0)
    with hostile_endpoint(true, POINTER, hold) as endpoint:
        monkeypatch.setenv("AWS_ENDPOINT_URL", endpoint.address)
        with pytest.raises(InputError) as refused:
            fill(elsewhere(address), 2.0)
    assert refused.value.code == FaultCode.STORE_INACCESSIBLE
    monkeypatch.setenv("AWS_ENDPOINT_URL", true)
    assert elsewhere(address).read_document("fit") == {"value": 1.0}
    bucket.put_object(Bucket=BUCKET, Key=held[0].partition("?")[0], Body=b"")
    assert elsewhere(address).read_document("fit") == {"value": 2.0}
