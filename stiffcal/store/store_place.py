"""Where a store is: a folder, or a place in an object store with a folder that mirrors it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias
from urllib.parse import unquote, urlsplit

from stiffcal.documents import Document
from stiffcal.errors import InputError, one_line
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from stiffcal.store.declared_table import Declared
    from stiffcal.store.remote import Remote

Documents: TypeAlias = Mapping[str, Mapping[str, Any]]
Stored: TypeAlias = Callable[[str], Document | None]


class StorePlace:
    """The place of a campaign's store.

    Parameters
    ----------
    location : its folder (or a ``file:`` address), or its place in an object store, ``s3://bucket/prefix``; it need
        not exist.
    display_name : its name in messages; default: the location.
    declared : finds what a table of its name is to hold; None: every table is written and read as it is.
    """

    def __init__(self, location: str | Path, display_name: str = "", declared: Declared | None = None) -> None:
        self.display_name = display_name or str(location)
        self.declared = declared
        _check_address(location, self.display_name)
        self.remote = _remote_of(location, self.display_name)
        self.folder = self.remote.mirror if self.remote is not None else _folder_of(location, self.display_name)

    @property
    def address(self) -> str:
        """The store's place, as the user allows places."""
        return self.remote.address if self.remote is not None else str(self.folder)


def _check_address(location: str | Path, display_name: str) -> None:
    """Refuse what no system takes, and what looks like an address and cannot be taken apart, as an open bracket."""
    text = str(location)
    if "\0" in (unquote(text) if "://" in text else text):
        reason, mend = "it contains a character NUL", "give a folder, or s3://BUCKET/PREFIX"
        raise InputError.at(FaultCode.STORE_ADDRESS, one_line(display_name), "--store", reason, mend)
    if isinstance(location, Path) or "://" not in location:
        return
    try:
        urlsplit(location)
    except ValueError as error:
        reason, mend = f"not an address ({error})", "give a folder, or s3://BUCKET/PREFIX"
        raise InputError.at(FaultCode.STORE_ADDRESS, display_name, "--store", reason, mend) from None


def _folder_of(location: str | Path, display_name: str) -> Path:
    if isinstance(location, Path) or "://" not in location:
        return Path(location)
    address = urlsplit(location)
    if address.scheme == "file" and address.netloc in ("", "localhost"):
        return Path(unquote(address.path))
    reason = f"{address.scheme}: addresses are not supported"
    raise InputError.at(
        FaultCode.STORE_ADDRESS, display_name, "--store", reason, "give a folder, or s3://BUCKET/PREFIX"
    )


def _remote_of(location: str | Path, display_name: str) -> Remote | None:
    if isinstance(location, Path) or not location.startswith("s3://"):
        return None
    from stiffcal.store.remote import Remote

    return Remote(location, display_name)
