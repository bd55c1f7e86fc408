"""`stiffcal trust`: what a campaign folder wants to run, and what the user has allowed."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, answering
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.next_step import after_trust
from stiffcal.cli.options import HERE, AsJson
from stiffcal.cli.tables import plain_table
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.escapes.terminal import escaped
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.commands.trust import TrustOverview
    from stiffcal.results.trust_results import CampaignCode, CampaignQuery, TrustResult

NO_SANDBOX = (
    "This is no sandbox: code that you allow runs with your rights, whenever a command needs its effects. It can read"
    " and write your files and use the network."
)
QUERIES_RUN = "Queries run on your database with the rights of its user: they can read whatever that user may read."
KINDS = {"plugin": "code", "text": "query", "folder": "folder under development", "place": "place of stores"}


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
            answer.give(work.list_trust(), show_entries)
        elif revoke is not None:
            answer.give(work.revoke_trust(revoke), show_entries)
        elif place is not None:
            answer.give(work.allow_place(place), show_entries)
        elif edit:
            answer.give(work.allow_folder(folder or HERE), show_entries)
        elif only_hash:
            _give_hash(answer, work.read_campaign(folder or HERE))
        else:
            return _ask(answer, work.read_campaign(folder or HERE), yes)
    return OK


def _give_hash(answer: Answer, showing: TrustOverview) -> None:
    def show(console: Console, result: TrustResult) -> None:
        for digest in showing.hashes:
            console.print(digest, soft_wrap=True)

    if not showing.hashes:
        reason = "nothing in this campaign needs trust"
        raise InputError.at(FaultCode.OPTION_INVALID, str(showing.folder), "", reason, "leave STIFFCAL_TRUST out")
    answer.give(showing.result(), show)


def _ask(answer: Answer, showing: TrustOverview, yes: bool) -> int:
    """Show what a campaign wants to run, ask, and remember the answer; return the exit code."""
    from stiffcal.commands.trust import allow_shown

    document = showing.result()
    lines = code_lines(document)

    def show_code(console: Console, result: TrustResult) -> None:
        for line in lines:
            console.print(line, soft_wrap=True)
        show_allowed(console, result)

    if showing.allowed or yes:
        answer.give(document if showing.allowed else allow_shown(showing), show_code, after_trust(showing.folder, None))
        return OK
    if not answer.as_json:
        _show_paged(lines)
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
    answer.give(allow_shown(showing), show_allowed, after_trust(showing.folder, None))
    return OK


def _show_paged(lines: list[str]) -> None:
    """Show code through the user's pager where it is longer than the terminal."""
    if sys.stdout.isatty() and len(lines) >= shutil.get_terminal_size().lines - 2:
        import pydoc

        pydoc.pager("\n".join(lines) + "\n")
        lines = lines[-3:]
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()


def show_allowed(console: Console, result: TrustResult) -> None:
    """Print what was allowed."""
    for entry in result.entries:
        console.print(f"allowed: SHA-256 {entry.key}", soft_wrap=True)


def show_entries(console: Console, result: TrustResult) -> None:
    """Draw entries of the record."""
    verb = {"allowed": "trusted now", "revoked": "no longer trusted", "listed": "trusted"}[result.action]
    if result.entries:
        table = plain_table(verb, "", "allowed in", "since")
        for entry in result.entries:
            kind = KINDS.get(entry.kind, "generation of a store")
            table.add_row(kind, entry.key, entry.note, entry.since.replace("T", " ")[:16])
        console.print(table)
    elif result.is_list:
        console.print("nothing is trusted except installed packages")
    if result.is_list:
        for digest in result.environment or []:
            console.print(f"by STIFFCAL_TRUST: {digest}", soft_wrap=True)
        console.print(f"store generations written by your own runs: {result.generations}", soft_wrap=True)
        console.print(f"record: {result.record or 'none can be recorded'}", soft_wrap=True)


def code_lines(result: TrustResult) -> list[str]:
    """Return the code that a campaign wants to run, as lines that neither move the cursor nor turn the text round."""
    from stiffcal.commands.trust import lines_of

    plugins, queries, lines = result.plugins, result.queries or [], []
    for file in plugins.files if plugins is not None else ():
        effects = ", ".join(map(code_line, file.effects))
        lines.append(f"{code_line(file.name)}: {file.lines} lines, {file.bytes} bytes: {effects}")
        lines += [*_numbered(lines_of(file.text)), ""]
    for query in queries:
        lines.append(f"query to a database, {code_line(query.place)}:")
        lines += [*_numbered(lines_of(query.text)), f"query, SHA-256 {query.sha256}: {_state(query)}", ""]
    if plugins is not None:
        count = len(plugins.files)
        files = f"{count} file{'s' if count > 1 else ''}"
        lines += [f"code in {files}, SHA-256 {plugins.sha256}: {_state(plugins)}", NO_SANDBOX]
    if queries:
        lines.append(QUERIES_RUN)
    return lines or ["nothing in this campaign needs trust: it contains no code and no query"]


def _numbered(lines: Sequence[str]) -> list[str]:
    return [f"{number:6}  {code_line(line)}" for number, line in enumerate(lines, start=1)]


def _state(content: CampaignCode | CampaignQuery) -> str:
    return "trusted already" if content.trusted else "not trusted"


def code_line(text: str) -> str:
    r"""Return a line of code with every character that is not plainly visible written out.

    Examples
    --------
    >>> print(code_line("x = '\x1b[8m' # \u202e"))
    x = '\x1b[8m' # \u202e
    """
    text = text.expandtabs(4)
    if not text.isprintable():
        text = "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)
    return escaped(text)
