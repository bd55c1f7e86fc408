"""What `trust` shows: the code that a campaign folder wants to run, and what the user has allowed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.escapes.terminal import escaped
from stiffcal.show.builder import PageBuilder
from stiffcal.trust.content import lines_of_code

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.trust_results import CampaignCode, CampaignQuery, TrustResult
    from stiffcal.show.options import ShowOptions

NO_SANDBOX = (
    "This is no sandbox: code that you allow runs with your rights, whenever a command needs its effects. It can read"
    " and write your files and use the network."
)
QUERIES_RUN = "Queries run on your database with the rights of its user: they can read whatever that user may read."
KINDS = {"plugin": "code", "text": "query", "folder": "folder under development", "place": "place of stores"}


def page(result: TrustResult, options: ShowOptions) -> Page:
    """Return the code of a campaign and what was allowed of it, or the entries of the record."""
    if result.is_of_campaign:
        return page_of_campaign(result, result)
    made = PageBuilder("What you trust")
    verb = {"allowed": "trusted now", "revoked": "no longer trusted", "listed": "trusted"}[result.action]
    if result.entries:
        rows = [
            (KINDS.get(one.kind, "generation of a store"), one.key, one.note, one.since.replace("T", " ")[:16])
            for one in result.entries
        ]
        made.table((verb, "", "allowed in", "since"), rows)
    elif result.is_list:
        made.say("nothing is trusted except installed packages", "nothing")
    if result.is_list:
        for digest in result.environment or []:
            made.say(f"by STIFFCAL_TRUST: {digest}", "environment")
        made.say(f"store generations written by your own runs: {result.generations}", "generations")
        made.say(f"record: {result.record or 'none can be recorded'}", "record")
    return made.page()


def page_of_campaign(shown: TrustResult | None, allowed: TrustResult) -> Page:
    """Return the code as it stood before it was allowed, then what was allowed.

    Parameters
    ----------
    shown : the campaign's code; None where it was shown before. allowed : with the entries that were made.
    """
    made = PageBuilder("Code of a campaign")
    for line in () if shown is None else lines_of_campaign(shown):
        made.say(line, "code")
    for entry in allowed.entries:
        made.say(f"allowed: SHA-256 {entry.key}", "allowed")
    return made.page()


def page_of_hashes(hashes: Sequence[str]) -> Page:
    """Return the SHA-256 of everything that needs to be allowed, and nothing else."""
    made = PageBuilder("SHA-256")
    for digest in hashes:
        made.say(digest, "sha256")
    return made.page()


def lines_of_campaign(result: TrustResult) -> list[str]:
    """Return the code that a campaign wants to run, as lines that neither move the cursor nor turn the text round."""
    plugins, queries, lines = result.plugins, result.queries or [], []
    for file in plugins.files if plugins is not None else ():
        effects = ", ".join(map(code_line, file.effects))
        lines.append(f"{code_line(file.name)}: {file.lines} lines, {file.bytes} bytes: {effects}")
        lines += [*_numbered(lines_of_code(file.text)), ""]
    for query in queries:
        lines.append(f"query to a database, {code_line(query.place)}:")
        lines += [*_numbered(lines_of_code(query.text)), f"query, SHA-256 {query.sha256}: {_state(query)}", ""]
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
