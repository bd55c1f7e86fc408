"""Addresses of stores, as ``--store`` and a batch take them: S3, file addresses, folders, spoilt in every part.

Nothing is connected to: the address is taken apart, its place compared with those that the user allows, and, where it
is a folder, looked at.
"""

from __future__ import annotations

import os
import random
import string
from pathlib import Path
from unittest import mock

from stiffcal.errors import InputError
from stiffcal.store import Store
from stiffcal.trust.record import open_record
from tests.fuzz.mutations import NASTY_TEXTS

SCHEMES = (
    "s3://",
    "s3://",
    "s3://",
    "S3://",
    "s3:/",
    "s3:",
    "s3:///",
    "file://",
    "file:",
    "gs://",
    "https://",
    "",
    "://",
)
PARTS = (
    "bucket", "lab", "key:secret@bucket", "user@bucket", "bucket:9000", "127.0.0.1:9", "[::1]", "[::1", "]", "%2e%2e",
    "..", ".", "%2F", "%00", "%", "%zz", "%ff", "a b", "?x=1", "#f", "bucket?endpoint_override=127.0.0.1:9",
    "?region=x&scheme=http", "~", "*", "\\", "\0", "", "generations", "current", "x" * 300, *NASTY_TEXTS,
)  # fmt: skip
OFFLINE = {
    "AWS_ENDPOINT_URL": "http://127.0.0.1:9", "AWS_REGION": "us-east-1", "AWS_ACCESS_KEY_ID": "x",
    "AWS_SECRET_ACCESS_KEY": "x", "AWS_EC2_METADATA_DISABLED": "true",
}  # fmt: skip


class AddressError(AssertionError):
    """An address was accepted, and is not what was given."""


def feed_address(chance: random.Random, folder: Path) -> None:
    """Make an address and open the store there, without reading an object store."""
    pieces = [chance.choice(PARTS) for _ in range(chance.choice((0, 1, 1, 2, 3, 8)))]
    address = chance.choice(SCHEMES) + "/".join(pieces)
    for _ in range(chance.choice((0, 0, 1, 4))):
        at = chance.randrange(len(address) + 1)
        address = address[:at] + chance.choice(string.printable) + address[at + chance.randrange(2) :]
    environment = dict(OFFLINE)
    if chance.random() < 0.2:
        environment[chance.choice(tuple(OFFLINE))] = chance.choice([text for text in NASTY_TEXTS if "\0" not in text])
    before = Path.cwd()
    os.chdir(folder)
    try:
        with mock.patch.dict(os.environ, environment):
            store = Store(address, "store")
            open_record().place_allowed(store.address)
            if store.remote is None:
                if address.startswith("s3://"):
                    raise AddressError(f"{address!r} is taken for the folder {store.folder}")
                _ = store.exists
            elif not store.address.startswith("s3://") or store.address.count("/") < 2:
                raise AddressError(f"{address!r} is the place {store.address!r}")
    except (ValueError, OSError) as error:
        if isinstance(error, InputError):
            raise
        raise AddressError(f"{type(error).__name__} for {address!r}: {error}") from error
    finally:
        os.chdir(before)
