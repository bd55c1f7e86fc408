"""`stiffcal trust`: what a campaign folder wants to run, and what the user has allowed."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, answering
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import HERE, AsJson
from stiffcal.commands.next_step import after_trust
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from stiffcal.stages.campaign_code import TrustOverview


def trust(
    folder: Annotated[
        Path | None, typer.Argument(metavar="DIR", help="The campaign folder.", show_default=False)
    ] = None,
    edit: Annotated[bool, typer.Option("--edit", help="Trust any code in DIR, for development.")] = False,
    listed: Annotated[bool, typer.Option("--list", help="List everything that you trust.")] = False,
    revoke: Annotated[
        str | None,
        typer.Option("--revoke", metavar="DIR|HASH|URI", help="Revoke a permission.", show_default=False),
    ] = None,
    only_hash: Annotated[
        bool, typer.Option("--hash", help="Print the SHA-256 alone: STIFFCAL_TRUST takes it, in CI.")
    ] = False,
    place: Annotated[
        str | None,
        typer.Option("--store", metavar="URI", help="Trust stores at this location and below.", show_default=False),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Allow without asking.")] = False,
    as_json: AsJson = False,
) -> int:
    """List the code that a campaign folder would run, and allow it.

    A campaign from somebody else may bring code (plugins) and queries to a database. None of it runs until you have
    allowed it here. You allow this content, by its SHA-256, in any folder: a change has to be allowed again. There
    is no sandbox: allowed code runs with your rights.

    Example: stiffcal trust my-robot
    """
    with answering(as_json) as answer:
        from stiffcal.commands import trust as work
        from stiffcal.stages.campaign_code import read_campaign

        options = {"--edit": edit, "--list": listed, "--revoke": revoke is not None, "--hash": only_hash}
        chosen = [name for name, requested in {**options, "--store": place is not None}.items() if requested]
        if len(chosen) > 1:
            raise InputError.at(
                FaultCode.OPTION_CONFLICT,
                "command line",
                " ".join(chosen),
                "only one of these at a time",
                "leave the others out",
            )
        if folder is not None and (listed or revoke is not None or place is not None):
            raise InputError.at(
                FaultCode.OPTION_CONFLICT,
                "command line",
                chosen[0],
                f"takes no folder, found {folder}",
                "leave DIR out",
            )
        if listed:
            answer.show(work.list_trust())
        elif revoke is not None:
            answer.show(work.revoke_trust(revoke))
        elif place is not None:
            answer.show(work.allow_place(place))
        elif edit:
            answer.show(work.allow_folder(folder or HERE))
        elif only_hash:
            _give_hash(answer, read_campaign(folder or HERE))
        else:
            return _ask(answer, read_campaign(folder or HERE), yes)
    return OK


def _give_hash(answer: Answer, showing: TrustOverview) -> None:
    from stiffcal.show.answers.trust import page_of_hashes

    if not showing.hashes:
        reason = "nothing in this campaign needs trust"
        raise InputError.at(FaultCode.OPTION_INVALID, str(showing.folder), "", reason, "leave STIFFCAL_TRUST out")
    answer.show(showing.result(), page=page_of_hashes(showing.hashes))


def _ask(answer: Answer, showing: TrustOverview, yes: bool) -> int:
    """Show what a campaign wants to run, ask, and remember the answer; return the exit code."""
    from stiffcal.commands.trust import allow_shown
    from stiffcal.show.answers.trust import lines_of_campaign, page_of_campaign

    document = showing.result()
    if showing.allowed or yes:
        allowed = document if showing.allowed else allow_shown(showing)
        answer.show(allowed, after_trust(showing.folder, None), page=page_of_campaign(document, allowed))
        return OK
    if not answer.as_json:
        _show_paged(lines_of_campaign(document))
    if sys.stdin is None or not sys.stdin.isatty():
        mend = f"read it, then: {command_line('trust', showing.folder, '--yes')}; or STIFFCAL_TRUST={showing.hashes[0]}"
        raise InputError.at(
            FaultCode.PLUGIN_UNTRUSTED,
            str(showing.folder),
            "",
            "is not allowed, and there is no terminal to ask for confirmation",
            mend,
        )
    if not typer.confirm("Allow this to run with your rights?", default=False, err=True):
        answer.notify("nothing was allowed")
        return NOT_HELD
    allowed = allow_shown(showing)
    answer.show(allowed, after_trust(showing.folder, None), page=page_of_campaign(None, allowed))
    return OK


def _show_paged(lines: list[str]) -> None:
    """Show code through the user's pager where it is longer than the terminal."""
    if sys.stdout.isatty() and len(lines) >= shutil.get_terminal_size().lines - 2:
        import pydoc

        pydoc.pager("\n".join(lines) + "\n")
        lines = lines[-3:]
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()
