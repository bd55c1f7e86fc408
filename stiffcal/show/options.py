"""How an answer is shown: how much of it, and of which campaign."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from stiffcal.escapes.shell import command_line


@dataclass(frozen=True, slots=True)
class ShowOptions:
    """What a page needs to know that stands in no answer."""

    details: bool = False
    """Also what most readers do not ask for."""
    folder: Path | None = None
    """The campaign's, as it was given: for lines to copy, and for pictures of what lies in its store; None: any."""
    store: str | None = None
    """Where its results are kept; None: in the folder."""

    def line(self, command: str, *words: str) -> str:
        """Return a line to copy: a command for this campaign."""
        return command_line(command, Path("DIR") if self.folder is None else self.folder, *words, store=self.store)


PLAIN = ShowOptions()
"""What most readers ask for, of any campaign."""
