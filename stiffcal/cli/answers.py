"""What a command answers: one JSON document, or a short text with the next step as its last line."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from typing import TYPE_CHECKING

from stiffcal.cli.log import record
from stiffcal.cli.progress import ProgressBar
from stiffcal.cli.standard_error import for_terminal
from stiffcal.cli.supervision import current
from stiffcal.escapes.json_text import document_text
from stiffcal.escapes.terminal import escaped, escaped_document
from stiffcal.masking import mask, masked
from stiffcal.show.options import PLAIN, ShowOptions

if TYPE_CHECKING:
    from stiffcal.documents import CommandResult
    from stiffcal.presentation.values import NextStep, Page


class Answer:
    """Where a command's words go: the answer to standard output, progress, notes and warnings to standard error."""

    def __init__(self, as_json: bool) -> None:
        self.as_json = as_json
        self.progress = ProgressBar()

    def notify(self, text: str, level: str = "INFO") -> None:
        """Write a sentence to standard error: a step that is run first, a file that was written."""
        self.progress.stop()
        record(text, level, is_printed=True)
        sys.stderr.write(for_terminal(escaped(mask(text))) + "\n")
        sys.stderr.flush()

    def show(
        self,
        result: CommandResult,
        then: NextStep | None = None,
        options: ShowOptions = PLAIN,
        page: Page | None = None,
    ) -> None:
        """Print the answer: its document, or its page.

        Parameters
        ----------
        result : what the command answers. then : the next sensible step; None: nothing follows.
        options : how much is shown, and of which campaign. page : what is shown in place of the answer's page.
        """
        self.progress.stop()
        supervision = current()
        with supervision.answering() if supervision is not None else nullcontext():
            self._show(result, then, options, page)

    def _show(self, result: CommandResult, then: NextStep | None, options: ShowOptions, page: Page | None) -> None:
        if self.as_json:
            from stiffcal.documents import document_of

            document = document_of(result)
            if document.get("warnings"):
                document = document | {"warnings": masked(document["warnings"])}
            sys.stdout.write(document_text(document) + "\n")
            return
        from stiffcal.cli.console import answer_console
        from stiffcal.cli.pages import draw_page
        from stiffcal.show.pages import page_of

        console = answer_console(lambda text: self.notify(f"warning: {mask(text)}", "WARNING"))
        shown = escaped_document(page or page_of(result, options))
        draw_page(console, replace(shown, next_step=then), escaped_document(result.warnings))


@contextmanager
def answering(as_json: bool) -> Iterator[Answer]:
    """Hand out an `Answer` and take its progress bar away at the end, however that comes."""
    answer, supervision = Answer(as_json), current()
    if supervision is not None:
        supervision.before_child = answer.progress.stop
    try:
        yield answer
    finally:
        answer.progress.stop()
