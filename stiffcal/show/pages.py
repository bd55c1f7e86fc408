"""The page of any answer."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

from stiffcal.show import answers

if TYPE_CHECKING:
    from stiffcal.documents import CommandResult
    from stiffcal.presentation.values import Page


def page_of(result: CommandResult, details: bool = False) -> Page:
    """Return what every medium shows of an answer.

    Parameters
    ----------
    result : of a command; its document "stiffcal/NAME/1" has the file NAME of `stiffcal.show.answers`.
    details : also what most readers do not ask for.
    """
    page: Page = import_module(_module(result)).page(result, details)
    return page


def has_page(result: CommandResult) -> bool:
    """Return whether there is a file for an answer."""
    return find_spec(_module(result)) is not None


def _module(result: CommandResult) -> str:
    return f"{answers.__name__}.{result.schema.split('/')[1].replace('-', '_')}"
