"""`stiffcal identify`: fit the model, show the stiffness table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Document, answering, command_line
from stiffcal.cli.bodies import show_cartesian, show_joints
from stiffcal.cli.endings import OK
from stiffcal.cli.experiments import overviews, show_overviews
from stiffcal.cli.links import show_coupling, show_links
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, StoreAt
from stiffcal.cli.suspects import show_suspects_of
from stiffcal.cli.tables import plain_table, show_parameters
from stiffcal.cli.wording import deviation, significant

if TYPE_CHECKING:
    from rich.console import Console


def identify(
    folder: Folder = HERE,
    loss: Annotated[str, typer.Option(help="linear (least squares) or huber (outliers count less).")] = "linear",
    dual_quaternions: Annotated[
        bool, typer.Option("--dual-quaternions", help="Joint springs in paper 003's form too, beside the matrix form.")
    ] = False,
    coupling: Annotated[
        bool, typer.Option("--coupling", help="With rods on a link: the same readings without them, side by side.")
    ] = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Fit the model: each stiffness with its uncertainty.

    Says too what the data cannot tell, and what error to expect in new poses.

    Example: stiffcal identify demo --loss huber
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.identify import identify_campaign
        from stiffcal.workflow.steps import RunContext

        context = RunContext(store=store, update=not no_update, progress=answer.progress, notify=answer.notify)
        document = identify_campaign(folder, context, loss, dual_quaternions, coupling)
        answer.give(document, show_fit, command_line("validate", folder, store=store))
    return OK


def show_fit(console: Console, document: Document) -> None:
    """Draw the identify document: the table, how well it fits, what cannot be told."""
    taken = (
        f"{document['n_readings']} readings" if document.get("n_readings") else f"{document['n_states']} load states"
    )
    console.print(f"{taken} in {document['n_runs']} runs")
    kinds = overviews(document)
    elsewhere = {name for overview in kinds for name in overview.parameters}
    show_parameters(console, [one for one in document["parameters"] if one["name"] not in elsewhere])
    show_overviews(console, kinds)
    noise = document.get("noise")
    against = f", noise {deviation(noise)} (from {document['noise_source']})" if noise else ", noise not known"
    console.print(f"fit {deviation(document['rms'])} rms{against}")
    console.print(
        f"reduced χ² {significant(document['reduced_chi2'])}, condition number {significant(document['condition'])}"
    )
    if document.get("joints_by_themselves"):
        show_joints(console, document["joints_by_themselves"])
    if document.get("cartesian_stiffness"):
        show_cartesian(console, document["cartesian_stiffness"])
    if document.get("links"):
        show_links(console, document["links"])
    if document.get("rejected"):
        console.print(f"{len(document['rejected'])} states set aside before the fit (bumped or excluded)")
    show_suspects_of(console, document)
    for ambiguity in document["not_identifiable"]:
        if elsewhere and set(ambiguity["parameters"]) <= elsewhere:
            continue
        console.print(f"cannot be told: {ambiguity_in_words(ambiguity)}")
    if document.get("expected_error"):
        console.print(document["expected_error"])
    if document.get("coupling"):
        show_coupling(console, document["coupling"])
    if document.get("dual_quaternions"):
        _show_dual_quaternions(console, document["dual_quaternions"])


def _show_dual_quaternions(console: Console, both: Document) -> None:
    """Draw the two forms side by side, and the paper's unweighted estimate apart."""

    def stiffness(compliance: float | None) -> str:
        return significant(1.0 / compliance) if compliance else "–"

    table = plain_table("stiffness, N·m/rad", "matrices>", "dual quaternions>", "unweighted, m>", "unweighted, mm>")
    for one in both["parameters"]:
        keys = ("matrix", "dual_quaternion", "unweighted_in_metres", "unweighted_in_millimetres")
        table.add_row(one["name"], *(stiffness(one[key]) for key in keys))
    console.print(table)
    console.print(
        f"both forms agree to {both['largest_relative_difference']:.1g} (relative); unweighted: 003, eq. 35 as "
        "printed, which counts lengths in m or mm and pure numbers alike"
    )


def ambiguity_in_words(ambiguity: Document) -> str:
    """Return what cannot be told apart, why, and what is known of it.

    Examples
    --------
    >>> ambiguity_in_words({"parameters": ["a", "b"], "reason": "they move the target alike", "known": "a + b"})
    'a, b: they move the target alike; known: a + b'
    """
    words = f"{', '.join(ambiguity['parameters'])}: {ambiguity['reason']}"
    return words + (f"; known: {ambiguity['known']}" if ambiguity.get("known") else "")
