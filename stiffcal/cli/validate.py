"""`stiffcal validate`: the model against measurement in poses the fit has not seen."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiffcal.cli.answers import Document, answering, command_line
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, StoreAt, Thresholds
from stiffcal.cli.suspects import show_suspects_of
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import deviation, length, share

if TYPE_CHECKING:
    from rich.console import Console


def validate(
    folder: Folder = HERE,
    model: Annotated[
        Path | None,
        typer.Option("--model", metavar="OTHER_DIR", help="Hold another campaign's fitted model against these data."),
    ] = None,
    thresholds: Thresholds = None,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Hold the model against poses the fit has not seen.

    Says where it fails. Ends with exit code 1 where a threshold of campaign.toml, or of --thresholds, is not held.

    Example: stiffcal validate demo
    """
    with answering(as_json) as answer:
        from stiffcal.campaign.thresholds import load_thresholds
        from stiffcal.workflow.steps import RunContext
        from stiffcal.workflow.validate import validate_campaign

        file = load_thresholds(thresholds) if thresholds else None
        reach = (folder, *([model] if model else []), *(file.baselines() if file else []))
        context = RunContext(
            store=store, update=not no_update, progress=answer.progress, notify=answer.notify, reach=reach
        )
        document = validate_campaign(folder, context, model=model, thresholds=file)
        answer.give(document, show_validation, command_line("report", folder, store=store))
    return NOT_HELD if document["passed"] is False else OK


def show_validation(console: Console, document: Document) -> None:
    """Draw the validate document: the error in held-out poses next to the noise, then where it is largest."""
    console.print(f"unseen poses ({document['scheme']})")
    table = plain_table("", "rms>")
    table.add_row("model", deviation(document["rms"]))
    if document.get("max"):
        table.add_row("worst state", deviation(document["max"]))
    table.add_row("no model", deviation(document["zero_model"]))
    table.add_row("noise", deviation(document["noise"]) if document["noise"] else "not known")
    table.add_row("share of the deflection", _shares(document["relative"]))
    console.print(table)
    for title in ("body", "run", "direction", "load", "branch"):
        _show_bins(console, title, document.get(f"by_{title}") or [])
    if document.get("worst"):
        console.print(f"worst: {_worst(document['worst'])}")
    show_suspects_of(console, document)
    for line in document["failed"]:
        console.print(f"NOT held: {line}", soft_wrap=True)
    for line in document["not_judged"]:
        console.print(f"not judged: {line}", soft_wrap=True)
    if document["passed"]:
        limits = ", ".join(document.get("thresholds", {}))
        console.print(f"thresholds held: {limits}" if limits else "no thresholds are set")


def _show_bins(console: Console, title: str, bins: list[dict[str, Any]], most: int = 8) -> None:
    if len(bins) < 2:
        return
    of_deflection = ("share of its deflection>",) if "zero_model" in bins[0] else ()
    table = plain_table(title, "states>", "rms>", "max>", *of_deflection)
    ranked = sorted(bins, key=lambda item: -_translation(item["rms"]))
    for item in ranked[:most]:
        cells = [str(item["label"]), str(item["n"]), *(deviation(_as_pair(item[key])) for key in ("rms", "max"))]
        if of_deflection:
            whole = _translation(item["zero_model"])
            cells.append(share(_translation(item["rms"]) / whole) if whole else "–")
        table.add_row(*cells)
    console.print(table)
    if len(ranked) > most:
        console.print(f"  and {len(ranked) - most} more, each below these (all in --json)")


def _translation(rms: Any) -> float:
    value = rms.get("translation") if isinstance(rms, dict) else rms
    return float(value or 0.0)


def _as_pair(rms: Any) -> dict[str, float | None]:
    return rms if isinstance(rms, dict) else {"translation": rms}


def _shares(relative: Any) -> str:
    if isinstance(relative, dict):
        return ", ".join(f"{name} {share(value)}" for name, value in relative.items() if value is not None)
    return share(relative)


def _worst(worst: list[Document]) -> str:
    words = [f"run {item['run']}, row {item['row']}: {length(item['residual_m'])}" for item in worst[:3]]
    return "; ".join(words)
