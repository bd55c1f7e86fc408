"""What every step of a campaign answers in Python: the command's result, and how a notebook shows it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Self

from stiffcal.show.options import PLAIN, ShowOptions

if TYPE_CHECKING:
    from pathlib import Path

    from stiffcal.documents import CommandResult, Document
    from stiffcal.results.next_step import Step


class CampaignAnswer:
    """What a step answers.

    Parameters
    ----------
    result : what the command's function returns.
    """

    def __init__(self, result: CommandResult) -> None:
        self.result = result
        self._options: ShowOptions = PLAIN
        self._after: Step | None = None

    def of_campaign(self, folder: Path, store: str | None, after: Step) -> Self:
        """Take the campaign that was asked, whose next step and pictures a notebook then shows too; return itself.

        Parameters
        ----------
        folder, store : as they were given. after : the step that has answered.
        """
        self._options, self._after = ShowOptions(folder=folder, store=store), after
        return self

    def to_dict(self) -> Document:
        """Return the document that the command prints with ``--json``: SI, null for what is not known."""
        return self.result.to_document()

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the result must know, a line each."""
        return tuple(self.result.warnings)

    def _repr_html_(self) -> str:
        from stiffcal.python.notebook import html_of
        from stiffcal.show.pages import page_of

        page, folder = page_of(self.result, self._options), self._options.folder
        if folder is not None:
            from stiffcal.commands.next_step import following

            page = replace(page, next_step=following(folder, self._options.store, self._after))
        return html_of(page, self.warnings)
