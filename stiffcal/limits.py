"""How much a file may ask for: bytes once unpacked, rows, columns, nodes.

A file of a few kilobytes can unpack to terabytes, and a table can claim more rows than a disk holds. Each limit below
lies far above what a laboratory records in a day, is named in the message of the file that exceeds it, and is raised by
an environment variable: a plain number, or for bytes one with a unit (``STIFFCAL_MAX_UNPACKED="2 TiB"``).

============================= =========== ============================================================================
variable                      default     what is counted
============================= =========== ============================================================================
``STIFFCAL_MAX_UNPACKED``     1 TiB       bytes of one log once unpacked (packed text, HDF5, MAT, Parquet, bags)
``STIFFCAL_MAX_RATIO``        250         unpacked bytes per packed byte, counted once a log has unpacked to 512 MiB
``STIFFCAL_MAX_PIECE``        2 GiB       bytes of memory that the parser of a binary log may take: for an HDF5 chunk,
                                          a Parquet page, a MAT variable, a message of a bag
``STIFFCAL_MAX_SECONDS``      5           seconds of a processor that it may compute until its next rows, besides one
                                          for each 10 MB of the file
``STIFFCAL_MAX_LINE``         16 MiB      bytes of one line of a text log
``STIFFCAL_MAX_ROWS``         4000000000  rows of one log
``STIFFCAL_MAX_COLUMNS``      20000       columns of one log
``STIFFCAL_MAX_TOML``         32 MiB      bytes of campaign.toml, robot.toml, model.toml and their kin
``STIFFCAL_MAX_TABLE``        512 MiB     bytes of a table of poses, loads or a path on the command line
``STIFFCAL_MAX_RUNS``         100000      runs of one campaign, and likewise its excludes
``STIFFCAL_MAX_ENTRIES``      1000        entries of any other list or table in a TOML file: frames, sources, effects
``STIFFCAL_MAX_BALANCES``     1000000     balances of the loaded robot that one simulation solves
``STIFFCAL_MAX_SAMPLES``      100000000   readings of all sensors that one simulation logs
``STIFFCAL_MAX_PLANNED``      4000000     load states of all runs that a plan chooses from
``STIFFCAL_MAX_URDF``         64 MiB      bytes of a URDF
``STIFFCAL_MAX_URDF_NODES``   200000      elements of a URDF
``STIFFCAL_MAX_MESHES``       256 MiB     bytes of the meshes of one robot, which the page of ``view`` draws
``STIFFCAL_MAX_DOCUMENT``     1 GiB       bytes of one JSON document of a store
``STIFFCAL_MAX_PLUGIN``       2 MiB       bytes of one file of plugin code
``STIFFCAL_MAX_PLUGINS``      200         files of plugin code in one campaign
============================= =========== ============================================================================

Limits of depth have no variable, as no lab needs more: 20 tables in tables in TOML, 100 elements in elements in XML.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

KIB, MIB, GIB, TIB = 1 << 10, 1 << 20, 1 << 30, 1 << 40
_UNITS = {
    "": 1, "B": 1, "KB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12, "KIB": KIB, "MIB": MIB, "GIB": GIB, "TIB": TIB,
}  # fmt: skip
_AMOUNT = r"\s*(?P<number>\d{1,18}(\.\d{1,9})?)\s*(?P<unit>[A-Za-z]*)\s*"
RATIO_FROM = 512 * MIB
"""Unpacked bytes below which any ratio is allowed: a log that stands still packs very small."""


@dataclass(frozen=True)
class Limit:
    """One limit."""

    variable: str
    """The environment variable that changes it."""
    default: int
    """What holds without it."""
    what: str
    """What is counted, as it follows the number in a message."""
    in_bytes: bool = True
    """True where a unit of bytes may stand in the variable."""

    @property
    def most(self) -> int:
        """The largest amount that is allowed now.

        Raises
        ------
        InputError
            The environment variable holds no amount.

        Examples
        --------
        >>> LINE.most == 16 * MIB
        True
        """
        text = os.environ.get(self.variable, "")
        if not text.strip():
            return self.default
        match = re.fullmatch(_AMOUNT, text, re.ASCII)
        factor = _UNITS.get(match["unit"].upper()) if match is not None else None
        if match is None or factor is None or (match["unit"] and not self.in_bytes):
            example = shown_amount(4 * self.default, self.in_bytes)
            mend = f'write a number{" with a unit" if self.in_bytes else ""}, e.g. {self.variable}="{example}"'
            raise InputError.at(FaultCode.OPTION_INVALID, "", self.variable, f"{text!r} is not an amount", mend)
        return int(float(match["number"]) * factor) if "." in match["number"] else int(match["number"]) * factor

    def check(self, amount: float, file: str, place: str = "", mend: str = "") -> None:
        """Raise an `InputError` where `amount` is more than is allowed.

        Parameters
        ----------
        amount : as counted, or as the file states it.
        file, place : of what asks for so much.
        mend : what to do; absent: check the file, or raise the limit.

        Examples
        --------
        >>> COLUMNS.check(7, "ft.csv")
        >>> COLUMNS.check(30000, "ft.csv")
        Traceback (most recent call last):
        stiffcal.errors.InputError: ft.csv: more than 20000 columns; check the file, or raise STIFFCAL_MAX_COLUMNS \
[size-exceeded]
        """
        if amount > self.most:
            raise self.exceeded(file, place, mend)

    def exceeded(self, file: str, place: str = "", mend: str = "") -> InputError:
        """Return the error of a file that asks for more than is allowed."""
        reason = f"more than {shown_amount(self.most, self.in_bytes)} {self.what}"
        return InputError.at(
            FaultCode.SIZE_EXCEEDED, file, place, reason, mend or f"check the file, or raise {self.variable}"
        )


def shown_amount(amount: int, in_bytes: bool = True) -> str:
    """Return an amount as a message shows it, and as the environment variable takes it.

    Examples
    --------
    >>> shown_amount(64 * GIB), shown_amount(20000, in_bytes=False), shown_amount(1000)
    ('64 GiB', '20000', '1000 B')
    """
    if not in_bytes:
        return str(amount)
    for name, size in (("TiB", TIB), ("GiB", GIB), ("MiB", MIB), ("KiB", KIB)):
        if amount >= size and (amount / size * 10).is_integer():
            return f"{amount / size:g} {name}"
    return f"{amount} B"


UNPACKED = Limit("STIFFCAL_MAX_UNPACKED", TIB, "once unpacked")
RATIO = Limit("STIFFCAL_MAX_RATIO", 250, "unpacked bytes for each packed one", in_bytes=False)
PIECE = Limit("STIFFCAL_MAX_PIECE", 2 * GIB, "of memory at once")
SECONDS = Limit("STIFFCAL_MAX_SECONDS", 5, "seconds of a processor for the next rows", in_bytes=False)
LINE = Limit("STIFFCAL_MAX_LINE", 16 * MIB, "in one line")
ROWS = Limit("STIFFCAL_MAX_ROWS", 4_000_000_000, "rows", in_bytes=False)
COLUMNS = Limit("STIFFCAL_MAX_COLUMNS", 20_000, "columns", in_bytes=False)
TOML = Limit("STIFFCAL_MAX_TOML", 32 * MIB, "of TOML")
TABLE = Limit("STIFFCAL_MAX_TABLE", 512 * MIB, "of a table")
RUNS = Limit("STIFFCAL_MAX_RUNS", 100_000, "entries", in_bytes=False)
ENTRIES = Limit("STIFFCAL_MAX_ENTRIES", 1000, "entries", in_bytes=False)
BALANCES = Limit("STIFFCAL_MAX_BALANCES", 1_000_000, "balances of the robot", in_bytes=False)
SAMPLES = Limit("STIFFCAL_MAX_SAMPLES", 100_000_000, "readings of sensors", in_bytes=False)
PLANNED = Limit("STIFFCAL_MAX_PLANNED", 4_000_000, "load states to choose from", in_bytes=False)
URDF = Limit("STIFFCAL_MAX_URDF", 64 * MIB, "of URDF")
URDF_NODES = Limit("STIFFCAL_MAX_URDF_NODES", 200_000, "elements", in_bytes=False)
MESHES = Limit("STIFFCAL_MAX_MESHES", 256 * MIB, "of meshes")
DOCUMENT = Limit("STIFFCAL_MAX_DOCUMENT", GIB, "of JSON")
PLUGIN = Limit("STIFFCAL_MAX_PLUGIN", 2 * MIB, "of code")
PLUGINS = Limit("STIFFCAL_MAX_PLUGINS", 200, "files of code", in_bytes=False)

ALL = (
    UNPACKED,
    RATIO,
    PIECE,
    SECONDS,
    LINE,
    ROWS,
    COLUMNS,
    TOML,
    TABLE,
    RUNS,
    ENTRIES,
    BALANCES,
    SAMPLES,
    PLANNED,
    URDF,
    URDF_NODES,
    MESHES,
    DOCUMENT,
    PLUGIN,
    PLUGINS,
)


def check_unpacked(unpacked: int, packed: int, file: str, place: str = "") -> None:
    """Raise an `InputError` where a log unpacks to more than is allowed, in bytes or for each packed byte.

    Parameters
    ----------
    unpacked : bytes so far, or as the file states it.
    packed : bytes of the file, or of the part that holds them.
    file, place : of what is unpacked.

    Examples
    --------
    >>> check_unpacked(8 * GIB, GIB, "ft.csv.gz")
    >>> check_unpacked(8 * GIB, MIB, "ft.csv.gz")
    Traceback (most recent call last):
    stiffcal.errors.InputError: ft.csv.gz: more than 250 unpacked bytes for each packed one; check the file, or raise \
STIFFCAL_MAX_RATIO [size-exceeded]
    """
    if unpacked > most_unpacked(packed):
        raise unpacked_exceeded(packed, file, place)


def most_unpacked(packed: int) -> int:
    """Return the bytes to which so many packed ones may unpack.

    Examples
    --------
    >>> most_unpacked(10) == RATIO_FROM, most_unpacked(GIB) == 250 * GIB, most_unpacked(TIB) == TIB
    (True, True, True)
    """
    return min(UNPACKED.most, max(RATIO_FROM, RATIO.most * packed))


def unpacked_exceeded(packed: int, file: str, place: str = "") -> InputError:
    """Return the error of a file whose `packed` bytes unpack to more than `most_unpacked` allows."""
    return (UNPACKED if most_unpacked(packed) == UNPACKED.most else RATIO).exceeded(file, place)
