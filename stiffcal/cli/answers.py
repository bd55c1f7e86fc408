"""What a command answers: one JSON document, or a short text with the next step as its last line."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from stiffcal.cli.log import record
from stiffcal.cli.progress import ProgressBar
from stiffcal.cli.standard_error import for_terminal
from stiffcal.cli.supervision import current
from stiffcal.escapes.json_text import document_text
from stiffcal.escapes.terminal import escaped, escaped_document
from stiffcal.masking import mask, masked

if TYPE_CHECKING:
    from stiffcal.cli.console import AnswerConsole
    from stiffcal.documents import CommandResult

Shown = TypeVar("Shown", bound="CommandResult")


@dataclass(frozen=True, slots=True)
class NextLine:
    """The last line of an answer."""

    command: str
    """A line to copy."""
    once: str = ""
    """What a person has to do or to have first, in words; "" where the command runs as it is."""

    @property
    def text(self) -> str:
        """As it is printed: only a command that runs now stands after "next"."""
        return f"once {self.once}: {self.command}" if self.once else f"next: {self.command}"


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

    def give(self, result: Shown, show: Callable[[AnswerConsole, Shown], None], then: NextLine | None = None) -> None:
        """Print the answer.

        Parameters
        ----------
        result : what the command answers.
        show : draws it for people.
        then : the next sensible step; None: nothing follows.
        """
        self.progress.stop()
        supervision = current()
        with supervision.answering() if supervision is not None else nullcontext():
            self._give(result, show, then)

    def show(self, result: CommandResult, then: NextLine | None = None, details: bool = False) -> None:
        """Print the answer as its page.

        Parameters
        ----------
        result : what the command answers. then : the next sensible step; None: nothing follows.
        details : also what most readers do not ask for.
        """

        def draw(console: AnswerConsole, shown: CommandResult) -> None:
            from stiffcal.cli.pages import draw_page
            from stiffcal.show.pages import page_of

            draw_page(console, page_of(shown, details), shown.warnings)

        self.give(result, draw, then)

    def _give(self, result: Shown, show: Callable[[AnswerConsole, Shown], None], then: NextLine | None) -> None:
        if self.as_json:
            from stiffcal.documents import document_of

            document = document_of(result)
            if document.get("warnings"):
                document = document | {"warnings": masked(document["warnings"])}
            sys.stdout.write(document_text(document) + "\n")
            return
        from stiffcal.cli.console import answer_console

        console = answer_console(lambda text: self.notify(f"warning: {mask(text)}", "WARNING"))
        if getattr(result, "origin", None) == "foreign":
            console.print("not computed by you: the results came with the folder, and its logs are missing")
        shown = escaped_document(result)
        show(console, shown)
        console.show_warnings(shown.warnings)
        if then is not None:
            # Never wrapped: the line is there to be copied.
            console.out(f"\n{mask(then.text)}", highlight=False)


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
