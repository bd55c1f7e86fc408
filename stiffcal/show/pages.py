"""The page of any answer."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

from stiffcal.presentation.values import ORIGIN, Sentence
from stiffcal.show import answers
from stiffcal.show.options import PLAIN, ShowOptions

if TYPE_CHECKING:
    from stiffcal.documents import CommandResult
    from stiffcal.presentation.values import Page


def page_of(result: CommandResult, options: ShowOptions = PLAIN) -> Page:
    """Return what every medium shows of an answer.

    Parameters
    ----------
    result : of a command; its document "stiffcal/NAME/1" has the file NAME of `stiffcal.show.answers`.
    options : how much of it, and of which campaign.
    """
    page: Page = import_module(_module(result)).page(result, options)
    if getattr(result, "origin", None) != "foreign":
        return page
    text = "not computed by you: the results came with the folder, and its logs are missing"
    return replace(page, blocks=(Sentence((text,), ORIGIN, "warning"), *page.blocks))


def has_page(result: CommandResult) -> bool:
    """Return whether there is a file for an answer."""
    return find_spec(_module(result)) is not None


def _module(result: CommandResult) -> str:
    return f"{answers.__name__}.{result.schema.split('/')[1].replace('-', '_')}"
