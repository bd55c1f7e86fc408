"""The ladder of models as bars of characters: linear from zero, the noise marked in each."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from stiffcal.cli.wording import NOT_KNOWN, deviation, places, significant
from stiffcal.measurements.rms import Rms
from stiffcal.validation.schemes import held_out

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult

    from stiffcal.results.improve_results import ImproveStep

WIDEST, NARROWEST = 40, 12
"""Columns of a bar: more show no more, in fewer a tenth cannot be distinguished from zero."""
WIDEST_LADDER = 100
"""Columns of the whole where there is no terminal, or a wide one."""
GAP = "   "
"""Between columns, as in tables."""
MARK, NOISE, EIGHTHS = "│", "░", " ▏▎▍▌▋▊▉"
MEASURES = ("translation", "torque", "motor_angle", "length", "rotation")
"""The first that is known of all models is drawn."""
COUNT_S = 0.8
"""How long a number takes to count down to the next, while the computer goes on with its work."""


@dataclass(frozen=True)
class LadderLine:
    """A line of the ladder."""

    name: str
    """Of the model, or "noise"."""
    rms: Rms | None
    """Its error; None where it is not known."""
    text: str = ""
    """In place of the number."""
    is_model: bool = False
    """Whether it counts for the scale: a model with effects."""


def rungs_of(steps: Sequence[ImproveStep], noise: Rms | None) -> list[LadderLine]:
    """Return the ladder from no model down to the noise.

    Parameters
    ----------
    steps : of `improve`, the model as it was first. noise : in the same measure; None where it is not known.
    """
    rungs = [LadderLine("no model", steps[0].zero_model, deviation(steps[0].zero_model))]
    for step in steps:
        text = deviation(step.heldout_rms) if step.heldout_rms else "not done"
        rungs.append(LadderLine(step_words(step), step.heldout_rms, text, is_model=True))
    return [*rungs, LadderLine("noise", noise, deviation(noise) if noise else NOT_KNOWN)]


def step_words(step: ImproveStep) -> str:
    """Return what a step did to the model."""
    return "present model" if step.action == "start" else f"{step.action} {step.effect} ({places(step.where)})"


def ladder_lines(rungs: Sequence[LadderLine], scheme: str | None, width: int) -> list[str]:
    """Return the ladder as lines of at most `width` columns; without bars where they have no room.

    Parameters
    ----------
    rungs : from no model down to the noise, which is last. scheme : how data were held out. width : columns.

    Examples
    --------
    >>> sizes = {"no model": 1e-3, "present model": 1e-4, "add backlash (joint 4)": 2.5e-5, "noise": 2.5e-5}
    >>> rungs = [LadderLine(name, Rms(size, None), f"{1e3 * size:.3f} mm", 5e-4 > size) for name, size in sizes.items()]
    >>> for line in ladder_lines(rungs, None, 64)[2:]:
    ...     print(line)
    no model                           1.000 mm   10.0 ×
    present model                      0.100 mm   ████│█████████████
    add backlash (joint 4)             0.025 mm   ████│
    noise                              0.025 mm   ░░░░│
    """
    title = f"{held_out(scheme)}, rms"
    names = max(len(rung.name) for rung in rungs)
    numbers = max(len(title) if names + len(GAP) + len(title) < width else 0, *(len(rung.text) for rung in rungs))
    room = min(WIDEST, width - names - numbers - 2 * len(GAP))
    lines = [f"{'step':<{names}}{GAP}{title:>{numbers}}"]
    lines.append("─" * min(width, len(lines[0])))
    bars = _bars(rungs, room) if room >= NARROWEST else [""] * len(rungs)
    for rung, drawn in zip(rungs, bars, strict=True):
        lines.append(f"{rung.name:<{names}}{GAP}{rung.text:>{numbers}}{GAP}{drawn}".rstrip())
    return lines


def _bars(rungs: Sequence[LadderLine], room: int) -> list[str]:
    """Return a bar for each rung, all on one scale from zero to the largest error of a model."""
    models = [rung.rms for rung in rungs if rung.is_model and rung.rms is not None]
    measure = drawn_measure(models)
    scale = 0.0 if measure is None else max(_size(rms, measure) or 0.0 for rms in models)
    if measure is None or not scale > 0.0:
        return [""] * len(rungs)
    noise = _size(rungs[-1].rms, measure)
    at = None if noise is None else room * noise / scale
    bars = []
    for rung in rungs:
        size = _size(rung.rms, measure)
        if size is None:
            bars.append("")
        elif size > scale * (1.0 + 0.5 / room):
            beyond = f"{significant(size / scale)} ×"
            bars.append(f"{beyond} the largest bar" if len(beyond) + 16 <= room else beyond)
        else:
            bars.append(bar(room * size / scale, at, room, NOISE if rung is rungs[-1] else ""))
    return bars


def drawn_measure(models: Sequence[Rms]) -> str | None:
    """Return the measure by which the errors of models are compared; None where none is known of all of them."""
    return next((name for name in MEASURES if models and all(_size(rms, name) is not None for rms in models)), None)


def _size(rms: Rms | None, measure: str) -> float | None:
    return None if rms is None else dict(rms.items()).get(measure)


def bar(length: float, mark: float | None, room: int, fill: str = "") -> str:
    """Return a bar of so many columns, with a mark at another.

    Examples
    --------
    >>> bar(2.5, None, 10)
    '██▌'
    """
    eighths = round(8.0 * length)
    text = (fill or "█") * (eighths // 8) + (EIGHTHS[eighths % 8].strip() if not fill else "")
    if mark is None or mark > room:
        return text
    cell = min(int(mark), room - 1)
    return text[:cell].ljust(cell) + MARK + text[cell + 1 :]


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
        rungs = rungs_of(steps, steps[-1].noise)
        share = min((self.clock() - self.reached_s) / COUNT_S, 1.0)
        if len(steps) > 1 and share < 1.0:
            between = _between(steps[-2].heldout_rms, steps[-1].heldout_rms, share)
            rungs[-2] = replace(rungs[-2], rms=between, text=deviation(between))
        return ladder_lines(rungs, self.scheme, width)

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
