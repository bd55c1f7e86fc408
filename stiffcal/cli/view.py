"""`stiffcal view`: the page for a browser."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, answering
from stiffcal.cli.ended_in_order import ended_in_order
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Output, Overwrite, StoreAt
from stiffcal.commands.next_step import following
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.results.next_step import Step

if TYPE_CHECKING:
    from pathlib import Path

    from stiffcal.stages.steps import RunContext


def view(
    folder: Folder = HERE,
    output: Output = None,
    no_raw: Annotated[bool, typer.Option("--no-raw", help="Omit raw readings and log names, for customers.")] = False,
    open_page: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False,
    live: Annotated[
        bool,
        typer.Option("--live", help="Serve it on this machine: effects are ticked and refitted. Ctrl-C ends it."),
    ] = False,
    watch: Annotated[
        bool, typer.Option("--watch", help="As --live, while measuring: logs are followed, checked and fitted.")
    ] = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
    overwrite: Overwrite = False,
) -> int:
    """Write one HTML file for a browser (DIR/view.html).

    It shows the robot, residuals against any variable, every fit, the effects of the model, poses and readings; it
    needs no server and no network. With --live it is served on this machine alone, under an address that only this
    terminal shows: tick an effect, and the model is fitted again. With --watch it follows the logs while they are
    measured: runs appear as their logs come, with what `check` says of them.

    Example: stiffcal view demo -o view.html
    """
    if (live or watch) and output is not None:
        reason, mend = "a page that is served is no file", f"leave one of {'--watch' if watch else '--live'} and -o out"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", "-o", reason, mend)
    with answering(as_json) as answer:
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store, update=not no_update, progress=answer.progress, notify=answer.notify, overwrite=overwrite
        )
        if live or watch:
            _serve(answer, folder, context, open_page, raw=not no_raw, watch=watch)
            return OK
        from stiffcal.commands.view import view_campaign

        result = view_campaign(folder, context, output=output, raw=not no_raw)
        if open_page:
            import webbrowser
            from pathlib import Path

            webbrowser.open(Path(result.file).resolve().as_uri())
        answer.show(result, following(folder, store, Step.VIEW))
    return OK


def _serve(answer: Answer, folder: Path, context: RunContext, open_page: bool, *, raw: bool, watch: bool) -> None:
    """Serve the page until the user ends it."""
    from stiffcal.live.page import live_server
    from stiffcal.results.command_results import LiveResult

    server = live_server(folder, context, raw, watch)
    answer.show(LiveResult(warnings=[], address=server.address, follows_logs=watch))
    if open_page:
        import webbrowser

        webbrowser.open(server.address)
    with suppress(KeyboardInterrupt), ended_in_order():
        server.serve()
