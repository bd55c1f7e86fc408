"""`stiffcal check`: what was understood of the campaign, and what is still missing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiffcal.cli.answers import Document, answering, command_line
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import HERE, AsJson, Folder, StoreAt

if TYPE_CHECKING:
    from rich.console import Console


def check(
    folder: Folder = HERE,
    quick: Annotated[bool, typer.Option("--quick", help="Read only the first lines of each file.")] = False,
    run: Annotated[str | None, typer.Option(metavar="ID", help="Only this run.", show_default=False)] = None,
    as_json: AsJson = False,
    store: StoreAt = None,
) -> int:
    """Say what was understood and what is still missing.

    Reads everything (streamed), names every fault with its place, and is usable while still measuring.
    Ends with exit code 1 where the campaign is not ready.

    Example: stiffcal check campaigns/irb4400 --quick
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.check import check_campaign

        document = check_campaign(folder, quick=quick, run=run, progress=answer.progress)
        ready = bool(document["ready"])
        answer.give(document, show_check, command_line("run" if ready else "check", folder, store=store))
    return OK if ready else NOT_HELD


def show_check(console: Console, document: Document) -> None:
    """Draw the check document, section by section as it comes."""
    for key, value in document.items():
        if key in {"schema", "warnings", "ready", "missing"}:
            continue
        _show(console, key.replace("_", " "), value, 0)
    missing = document.get("missing") or []
    if document["ready"]:
        console.print("ready")
    else:
        console.print("not ready:")
        for item in missing:
            _show(console, "", item, 1)


def _show(console: Console, title: str, value: Any, depth: int) -> None:
    indent = "  " * depth
    if isinstance(value, dict):
        console.print(f"{indent}{title}")
        for key, item in value.items():
            _show(console, str(key).replace("_", " "), item, depth + 1)
    elif isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        console.print(f"{indent}{title}")
        for item in value:
            if isinstance(item, dict):
                console.print(
                    f"{indent}  " + ", ".join(f"{k}: {_word(v)}" for k, v in item.items() if v not in (None, ""))
                )
            else:
                _show(console, "", item, depth + 1)
    else:
        label = f"{title}: " if title else ""
        console.print(f"{indent}{label}{_word(value)}", soft_wrap=True)


def _word(value: Any) -> str:
    from stiffcal.cli.wording import NOT_KNOWN, significant

    if value is None:
        return NOT_KNOWN
    if isinstance(value, float):
        return significant(value, 4)
    if isinstance(value, list):
        return ", ".join(_word(item) for item in value)
    if isinstance(value, dict):
        return ", ".join(f"{k} {_word(v)}" for k, v in value.items())
    return str(value)
