"""Whose results a command is using: with those of somebody else, what goes wrong is their content and no fault of ours.

Each document and table is checked when it is read. That a number of one fits the rows of another is not; a program that
meets such a mismatch ends with one line like that of any other wrong input.
"""

from __future__ import annotations

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

_in_use: list[str] = []


def use_foreign_results(display_name: str) -> None:
    """Note that results from a store are used that the user's own runs have not written; `shown` names the store."""
    if display_name not in _in_use:
        _in_use.append(display_name)


def use_own_results() -> None:
    """Begin a command or a task of a batch: no stranger's results are in use yet."""
    _in_use.clear()


def fault_of_foreign_content(error: Exception) -> InputError | None:
    """Return an unforeseen error as that of the stranger's results in use, None where none are.

    Examples
    --------
    >>> use_own_results()
    >>> fault_of_foreign_content(KeyError("x")) is None
    True
    >>> use_foreign_results("store")
    >>> print(fault_of_foreign_content(KeyError("x")))
    store: not computed by you, and not in the form that stiffcal writes (KeyError: 'x'); ask for the logs, or remove \
the store [content-untrusted]
    >>> use_own_results()
    """
    if not _in_use:
        return None
    text = " ".join(str(error).split())
    reason = f"not computed by you, and not in the form that stiffcal writes ({type(error).__name__}: {text[:200]})"
    return InputError.at(
        FaultCode.CONTENT_UNTRUSTED, ", ".join(_in_use), "", reason, "ask for the logs, or remove the store"
    )
