"""`stiffcal demo`: the whole loop on a bundled example."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.improve import print_step
from stiffcal.cli.next_step import following
from stiffcal.cli.options import AsJson, Overwrite
from stiffcal.cli.pages import draw_blocks
from stiffcal.cli.run import show_run
from stiffcal.escapes.shell import command_line
from stiffcal.results.next_step import Step
from stiffcal.show.pages import page_of

if TYPE_CHECKING:
    from stiffcal.cli.console import AnswerConsole
    from stiffcal.commands.run_result import RunResult
    from stiffcal.results.history_results import HistoryResult


def demo(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Where the example is copied to.")] = Path("demo"),
    as_json: AsJson = False,
    overwrite: Overwrite = False,
) -> int:
    """Find a hidden effect in a bundled example.

    Copies the example to DIR, fits stiffness alone, diagnoses which effect the model lacks, adds it, and writes report
    and view. The hidden effect is in DIR/truth.json.

    Example: stiffcal demo
    """
    with answering(as_json) as answer:
        from stiffcal.commands.demo import run_demo
        from stiffcal.commands.history import read_history
        from stiffcal.stages.steps import RunContext

        context = RunContext(progress=answer.progress, notify=answer.notify, overwrite=overwrite)
        result = run_demo(folder, context, None if as_json else partial(print_step, answer))
        ladder = read_history(folder, context)
        show = partial(show_demo, ladder=ladder, page=command_line("view", folder))
        answer.give(result, show, following(folder, None, Step.DIAGNOSE, done={Step.REPORT}))
    return OK if result.passed else NOT_HELD


def show_demo(console: AnswerConsole, result: RunResult, ladder: HistoryResult, page: str) -> None:
    """Draw the ladder from the first model to the noise, then what `run` shows of the last."""
    show_run(console, result, page)
    console.print(f"\nhistory of fits (the hidden effect: {result.folder}/truth.json):", soft_wrap=True)
    draw_blocks(console, page_of(ladder).blocks)
