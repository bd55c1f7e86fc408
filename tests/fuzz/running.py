"""Running a command on a folder from a stranger inside this process, with a fence around it and an empty record."""

from __future__ import annotations

import json
import os
import shutil
import signal
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

from stiffcal.trust import notices, record
from stiffcal.trust.foreign_content import fault_of_foreign_content
from tests.fuzz.fence import FENCE, SECRET
from tests.fuzz.wrong_numbers import command_ends, refusal_of


@contextmanager
def fresh_state(folder: Path) -> Iterator[None]:
    """Have an empty record of trust in a folder, as of a user who has run nothing before."""
    environment = {"STIFFCAL_STATE": str(folder), "TMPDIR": str(folder.parent), "HOME": str(folder.parent)}
    with (
        mock.patch.dict(os.environ, environment),
        mock.patch.object(notices, "_given", set()),
        mock.patch.object(tempfile, "tempdir", None),
    ):
        record._of_this_process.clear()
        yield


def fresh_folder(place: Path) -> Path:
    """Return an empty folder for one try, next to which there is one with secrets that nothing may touch."""
    folder = place / "try"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    outside = place / "outside"
    if not outside.is_dir():
        outside.mkdir()
        (outside / "secret.json").write_text(json.dumps({"schema": SECRET, "fits": []}), encoding="utf-8")
        (outside / "generation.json").write_text("{}", encoding="utf-8")
    return folder


def run_fenced(words: list[str], folder: Path) -> tuple[int, dict[str, Any] | None]:
    """Run a command; return its exit code, and its document where that was asked for.

    Raises
    ------
    InputError : it has refused. AssertionError : it has ended as no command may.
    """
    before = signal.getsignal(signal.SIGINT)
    try:
        with FENCE.around((folder,), folder.parent / "outside"):
            code, out, err = command_ends(words)
    except Exception as error:
        raise fault_of_foreign_content(error) or error from None
    finally:
        signal.signal(signal.SIGINT, before)
    if SECRET in out + err:
        raise AssertionError(f"a secret is shown: {out[:200]} {err[:200]}")
    if code == 2:
        raise refusal_of(out, err, "--json" in words)
    if code not in (0, 1):
        raise AssertionError(f"exit code {code}: {err}")
    return code, json.loads(out, parse_constant=_no_constant) if "--json" in words else None


def _no_constant(name: str) -> None:
    raise AssertionError(f"{name} in a JSON document")
