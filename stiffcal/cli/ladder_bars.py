"""The ladder of models as bars of characters: linear from zero, the noise marked in each."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from stiffcal.measurements.rms import Rms
from stiffcal.presentation.bars import drawn_bars
from stiffcal.show.ladder import ladder

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult

    from stiffcal.presentation.values import Bars
    from stiffcal.results.improve_results import ImproveStep

WIDEST, NARROWEST = 40, 12
"""Columns of a bar: more show no more, in fewer a tenth cannot be distinguished from zero."""
WIDEST_LADDER = 100
"""Columns of the whole where there is no terminal, or a wide one."""
GAP = "   "
"""Between columns, as in tables."""
COUNT_S = 0.8
"""How long a number takes to count down to the next, while the computer goes on with its work."""


def bar_lines(bars: Bars, width: int) -> list[str]:
    """Return bars as lines of at most `width` columns; without bars where they have no room.

    Examples
    --------
    >>> from stiffcal.presentation.values import Bar, Bars
    >>> sizes = {"no model": 1e-3, "present model": 1e-4, "add backlash (joint 4)": 2.5e-5, "noise": 2.5e-5}
    >>> bars = [Bar(name, size, f"{1e3 * size:.3f} mm", 5e-4 > size) for name, size in sizes.items()]
    >>> for line in bar_lines(Bars("step", "held-out data, rms", tuple(bars)), 64)[2:]:
    ...     print(line)
    no model                           1.000 mm   10.0 ×
    present model                      0.100 mm   ████│█████████████
    add backlash (joint 4)             0.025 mm   ████│
    noise                              0.025 mm   ░░░░│
    """
    names = max(len(bar.name) for bar in bars.bars)
    fits = names + len(GAP) + len(bars.amount) < width
    numbers = max(len(bars.amount) if fits else 0, *(len(bar.text) for bar in bars.bars))
    room = min(WIDEST, width - names - numbers - 2 * len(GAP))
    lines = [f"{bars.title:<{names}}{GAP}{bars.amount:>{numbers}}"]
    lines.append("─" * min(width, len(lines[0])))
    drawn = drawn_bars(bars, room) if room >= NARROWEST else [""] * len(bars.bars)
    for bar, text in zip(bars.bars, drawn, strict=True):
        lines.append(f"{bar.name:<{names}}{GAP}{bar.text:>{numbers}}{GAP}{text}".rstrip())
    return lines


@dataclass
class LiveLadder:
    """The ladder while it grows, for rich: the number of the last step counts down from that of the step before."""

    scheme: str | None = None
    """How data are held out."""
    steps: list[ImproveStep] = field(default_factory=list)
    """So far."""
    clock: Callable[[], float] = time.monotonic
    """Seconds."""
    reached_s: float = 0.0
    """When the last step came."""

    def reached(self, step: ImproveStep) -> None:
        """Take a step."""
        self.scheme = step.scheme
        self.steps = [*self.steps, step]  # the thread that draws reads the old list or the new one
        self.reached_s = self.clock()

    def lines(self, width: int) -> list[str]:
        """Return what the terminal shows now."""
        steps = self.steps
        if not steps:
            return []
        share, last = min((self.clock() - self.reached_s) / COUNT_S, 1.0), steps[-1]
        if len(steps) > 1 and share < 1.0:
            last = replace(last, heldout_rms=_between(steps[-2].heldout_rms, last.heldout_rms, share))
        return bar_lines(ladder([*steps[:-1], last], last.noise, self.scheme), width)

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Draw it."""
        from rich.text import Text

        for line in self.lines(options.max_width):
            yield Text(line, no_wrap=True, overflow="ellipsis")


def _between(before: Rms | None, after: Rms | None, share: float) -> Rms | None:
    """Return an error on its way from one to another."""
    if before is None or after is None:
        return after

    def course() -> Iterator[tuple[str, float | None]]:
        first = dict(before.items())
        for name, last in after.items():
            start = first.get(name)
            yield name, last if start is None or last is None else start + share * (last - start)

    return Rms.of(dict(course()))
