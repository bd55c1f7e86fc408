"""`stiffcal view`: the page for a browser."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.next_step import after_pictures
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Output, StoreAt

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.workflow.command_results import ViewResult


def view(
    folder: Folder = HERE,
    output: Output = None,
    no_raw: Annotated[bool, typer.Option("--no-raw", help="Omit raw readings and log names, for customers.")] = False,
    open_page: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Write one HTML file for a browser (DIR/view.html).

    It shows the robot, residuals against any variable, every fit, the effects of the model, poses and readings; it
    needs no server and no network.

    Example: stiffcal view demo -o view.html
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.steps import RunContext
        from stiffcal.workflow.view import view_campaign

        context = RunContext(store=store, update=not no_update, progress=answer.progress, notify=answer.notify)
        result = view_campaign(folder, context, output=output, raw=not no_raw)
        if open_page:
            import webbrowser
            from pathlib import Path

            webbrowser.open(Path(result.file).resolve().as_uri())
        answer.give(result, show_view, after_pictures(folder, context, store, ("export", "-o", "model.json")))
    return OK


def show_view(console: Console, result: ViewResult) -> None:
    """Name the page."""
    if result.n_shown < result.n_states:
        console.print(
            f"{result.n_shown} of {result.n_states} load states are shown; errors are computed from all", soft_wrap=True
        )
    console.print(f"view: {result.file}", soft_wrap=True)
