"""`stiffcal demo`: the whole loop on a bundled example."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from stiffcal.cli.answers import answering, command_line
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.next_step import after_diagnosis
from stiffcal.cli.options import AsJson
from stiffcal.cli.run import show_run


def demo(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Where the example is copied to.")] = Path("demo"),
    as_json: AsJson = False,
) -> int:
    """Run the whole loop on a bundled example.

    Copies it to DIR first, then goes from raw logs to the PDF.

    Example: stiffcal demo
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.demo import run_demo
        from stiffcal.workflow.steps import RunContext

        result = run_demo(folder, RunContext(progress=answer.progress, notify=answer.notify))
        show = partial(show_run, page=command_line("view", folder))
        answer.give(result, show, after_diagnosis(folder, result.diagnose, None, finished="view"))
    return OK if result.passed else NOT_HELD
