"""A progress bar on standard error, for what takes longer than two seconds."""

from __future__ import annotations

import sys
import threading
from typing import TYPE_CHECKING

from stiffcal.cli.log import is_verbose, record
from stiffcal.escapes.terminal import escaped
from stiffcal.presentation.time_left import TimeLeft

if TYPE_CHECKING:
    import rich.progress
    from rich.console import RenderableType

BAR_AFTER_S = 1.0
"""How long nothing is shown: what ends sooner needs no bar, and a terminal should not flicker."""


class ProgressBar:
    """The `progress(text, fraction)` callable that `commands` and the rooms below take.

    The bar appears one second after the first call and vanishes with `stop`. Without a terminal on standard error
    nothing is drawn, so that logs stay readable.

    Examples
    --------
    >>> bar = ProgressBar(terminal=False)
    >>> bar("reading", 0.5)
    >>> bar.stop()
    """

    def __init__(self, terminal: bool | None = None) -> None:
        self._drawn = sys.stderr.isatty() if terminal is None else terminal
        self.above: RenderableType | None = None
        """What is drawn above the bar as long as that is there."""
        self._bar: rich.progress.Progress | None = None
        self._task: rich.progress.TaskID | None = None
        self._timer: threading.Timer | None = None
        self._last = ""
        self._time_left = TimeLeft()

    def __call__(self, text: str, fraction: float | None = None) -> None:
        """Show what is being done and how much of it is."""
        if text != self._last:
            self._last = text
            record(text, "DEBUG")
        if not self.is_drawn:
            return
        text = escaped(text)
        if self._bar is None:
            self._prepare(text)
        if self._bar is None or self._task is None:
            return
        share = None if fraction is None else min(max(fraction, 0.0), 1.0)
        self._time_left.reached(share)
        if share is None:
            self._bar.update(self._task, description=text, total=None, left="")
        else:
            left = self._time_left.in_words(share)
            self._bar.update(self._task, description=text, total=1.0, completed=share, left=left)

    @property
    def is_drawn(self) -> bool:
        """Whether there is a terminal for it."""
        return self._drawn and not is_verbose()

    def _prepare(self, text: str) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeElapsedColumn

        from stiffcal.cli.topped_progress import ToppedProgress

        columns = (
            TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn(),
            TextColumn("{task.fields[left]}", markup=False),
        )  # fmt: skip
        self._bar = ToppedProgress(*columns, console=Console(stderr=True), transient=True)
        self._bar.above = self.above
        self._task = self._bar.add_task(text, total=None, left="")
        self._timer = threading.Timer(BAR_AFTER_S, self._bar.start)
        self._timer.daemon = True
        self._timer.start()

    def stop(self) -> None:
        """Take the bar away."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer.join()
        if self._bar is not None:
            self._bar.stop()
        self._bar = self._task = self._timer = None
