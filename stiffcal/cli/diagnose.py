"""`stiffcal diagnose`: is the model good enough, and if not, which physical effect is missing."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from stiffcal.cli.answers import Document, answering, command_line
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, StoreAt
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import NOT_KNOWN, deviation, length, places, share, significant

if TYPE_CHECKING:
    from rich.console import Console

MOST_ROWS = 8


def diagnose(folder: Folder = HERE, as_json: AsJson = False, no_update: NoUpdate = False, store: StoreAt = None) -> int:
    """Learn which physical effect the model lacks.

    Tries every effect at every place beside everything else, in poses the fit has not seen; says how sure it is, what
    else could look the same, and when nothing is missing.

    Example: stiffcal diagnose demo
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.diagnose import diagnose_campaign
        from stiffcal.workflow.steps import RunContext

        context = RunContext(store=store, update=not no_update, progress=answer.progress, notify=answer.notify)
        document = diagnose_campaign(folder, context)
        answer.give(document, show_diagnosis, _next_step(folder, document, store))
    return OK


def _next_step(folder: Folder, document: Document, store: str | None) -> str:
    # What is missing comes first: with it, other effects may turn out to be needed, or not.
    for one in document["missing"]:
        return command_line("add", folder, one["effect"], *place_words(one["where"]), store=None)
    for one in document["superfluous"]:
        return command_line("remove", folder, one["effect"], *place_words(one["where"]), store=None)
    return command_line("report", folder, store=store)


def place_words(where: Document) -> list[str]:
    """Return the options that name a place.

    Examples
    --------
    >>> place_words({"joints": [4]})
    ['--joints', '4']
    """
    words = []
    for kind, items in where.items():
        names = ["-".join(str(part) for part in item) if isinstance(item, list) else str(item) for item in items]
        words += [f"--{kind}", ",".join(names)]
    return words


def show_diagnosis(console: Console, document: Document) -> None:
    """Draw the answer first, then the evidence, the ranking, and what was not tried."""
    console.print(document["summary"], soft_wrap=True)
    for one in document["missing"]:
        finding = _finding_of(document, one)
        console.print(f"\nmissing: {one['effect']} ({places(one['where'])})")
        if one["alternatives"]:
            names = ", ".join(f"{other['effect']} ({places(other['where'])})" for other in one["alternatives"])
            console.print(f"  cannot be told from: {names}", soft_wrap=True)
        if finding is not None and finding["evidence"]:
            for key in ("seen", "means", "alike", "check"):
                if finding["evidence"][key]:
                    console.print(textwrap.indent(textwrap.fill(finding["evidence"][key], 110), "  "), soft_wrap=True)
    if document.get("could_be"):
        console.print("\nlook alike in these poses and loads:")
        for one in document["could_be"]:
            console.print(f"  {one['effect']}: {places(one['where'])}", soft_wrap=True)
        console.print("  measure in more poses, or in these under loads along other axes")
    for one in document["superfluous"]:
        console.print(f"\nnot needed: {one['effect']} ({places(one['where'])}): without it the error is no larger")
    if document["structure"]:
        console.print("\nwhat is left follows:")
        for one in document["structure"]:
            console.print(f"  {one['follows']} ({share(one['share'])} of it): {one['seen']}", soft_wrap=True)
    _show_ranking(console, document)
    measure = document["next_measurement"]
    if measure:
        pose = ", ".join(significant(value) for value in measure["pose_deg"])
        load = ", ".join(significant(value) for value in measure["load"][:3])
        between = " and ".join(f"{one['effect']} ({places(one['where'])})" for one in measure["separates"])
        console.print(
            f"\nto tell {between} apart: pose ({pose})°, force ({load}) N in the sensor's axes; "
            f"there they differ by {length(measure['difference_m'])}",
            soft_wrap=True,
        )
    elif len(document["missing"]) == 1 and document["missing"][0]["alternatives"]:
        console.print("\nno single load in reach tells the foremost of these look-alikes apart by more than the noise")
    _show_pace(console, document["pace"])
    if document["not_tried"]:
        console.print("\nnot tried:")
        for one in document["not_tried"]:
            console.print(f"  {one['effect']}: needs {one['needs']}", soft_wrap=True)


def _show_pace(console: Console, pace: Document) -> None:
    if pace["candidates"] == 0:
        return
    console.print(
        f"\ntried {pace['candidates']} candidates ({pace['signatures']} with their shapes) beside "
        f"{pace['models']} model{'s' * (pace['models'] != 1)} in {significant(pace['seconds'])} s: "
        f"{pace['candidates_per_second']:.0f} candidates per second, the choice repeated in every fold"
    )


def _finding_of(document: Document, missing: Document) -> Document | None:
    for finding in document["findings"]:
        if finding["effect"] == missing["effect"] and finding["where"] == missing["where"]:
            return dict(finding)
    return None


def _show_ranking(console: Console, document: Document) -> None:
    """Show the ranking for the next single step."""
    if not document["findings"]:
        return
    table = plain_table("effect", "place", "verdict", "unseen, rms>", "explains>", "first in>", "at the tool>")
    table.add_row("present model", "", "", deviation(document["rms"]), "", "", "")
    for finding in document["findings"][:MOST_ROWS]:
        table.add_row(
            finding["effect"],
            places(finding["where"]),
            finding["verdict"],
            deviation(finding["heldout_rms_after"]),
            share(finding["explains"]),
            share(finding["confidence"]),
            length(finding["size_m"]),
        )
    table.add_row("noise", "", "", deviation(document["noise"]) if document["noise"] else NOT_KNOWN, "", "", "")
    console.print()
    console.print(table)
    more = len(document["findings"]) - MOST_ROWS
    if more > 0:
        console.print(f"  and {more} more, none better (all in --json)")
