"""`stiffcal demo`: the whole loop on a bundled example."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.improve import print_step
from stiffcal.cli.options import AsJson, Overwrite
from stiffcal.commands.next_step import following
from stiffcal.results.next_step import Step
from stiffcal.show.options import ShowOptions


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
        from stiffcal.stages.steps import RunContext

        context = RunContext(progress=answer.progress, notify=answer.notify, overwrite=overwrite)
        result = run_demo(folder, context, None if as_json else partial(print_step, answer))
        then = following(folder, None, Step.DIAGNOSE, done={Step.REPORT})
        answer.show(result, then, ShowOptions(folder=folder))
    return OK if result.passed else NOT_HELD
