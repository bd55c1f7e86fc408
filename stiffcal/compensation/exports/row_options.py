"""How the rows of a robot file are written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.conventions import Convention


@dataclass(frozen=True)
class RowOptions:
    """How the rows of a robot file are written."""

    convention: Convention | None = None
    """None: that of the campaign's robot file, modified DH for a URDF."""
    strict: bool = False
    """Without β, also where axes are nearly parallel."""


def row_options(convention: str | None, *, strict: bool) -> RowOptions:
    """Return the options as the command line gives them.

    Raises
    ------
    InputError : there is no such convention.
    """
    for known in get_args(Convention):
        if convention == known:
            return RowOptions(known, strict)
    if convention is None:
        return RowOptions(None, strict)
    mend = f"choose {' or '.join(get_args(Convention))}"
    raise InputError.at(
        FaultCode.OPTION_INVALID, "command line", "--convention", f"no convention is called {convention}", mend
    )
