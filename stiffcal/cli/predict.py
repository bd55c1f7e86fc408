"""`stiffcal predict`: deflection and Cartesian stiffness under given loads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiffcal.cli.answers import Document, answering, command_line
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Output, StoreAt
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import NOT_KNOWN, significant

if TYPE_CHECKING:
    from rich.console import Console


def predict(
    folder: Folder = HERE,
    poses: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="CSV: a column per joint (degrees), Fx … Tz (N, N·m); one state a row.",
            show_default=False,
        ),
    ] = None,
    load_path: Annotated[
        str | None,
        typer.Option(
            "--load-path",
            metavar="F;F;…",
            help="Forces in N (base axes) that are passed through at --at; or a CSV file. The report shows the path.",
            show_default=False,
        ),
    ] = None,
    at: Annotated[
        str | None,
        typer.Option(
            "--at", metavar="A1,A2,…", help="The pose of the load path, joint angles in degrees.", show_default=False
        ),
    ] = None,
    points: Annotated[int, typer.Option(help="Points on each leg of the load path.")] = 20,
    note: Annotated[str, typer.Option(metavar="WORDS", help="What the report says beside the load path.")] = "",
    output: Output = None,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Predict deflection and stiffness under given loads.

    With uncertainty; loads from a table of poses, or along a path of forces at one pose.

    Example: stiffcal predict campaigns/irb4400 --load-path "-100,200,-300;0,0,0;100,-200,100" --at 0,10,20,0,30,0
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.predict import LoadPathWish, predict_campaign
        from stiffcal.workflow.steps import Means

        means = Means(store=store, update=not no_update, progress=answer.progress, say=answer.say)
        path = LoadPathWish(load_path, at, points, note) if load_path is not None else None
        document = predict_campaign(folder, means, poses=poses, load_path=path, output=output)
        answer.give(document, show_prediction, command_line("export", folder, "-o", "model.json", store=store))
    return OK


def show_prediction(console: Console, document: Document, most: int = 24) -> None:
    """Draw deflection ± 95 % and the stiffness along the axes, state by state."""
    table = plain_table("state>", "dx, dy, dz [mm], ± 95 %>", "rx, ry, rz [mrad]>", "stiffness along x, y, z [N/mm]>")
    for number, state in enumerate(document["states"][:most], start=1):
        table.add_row(str(number), _translations(state), _rotations(state), _stiffness(state["cartesian_stiffness"]))
    console.print(table)
    if len(document["states"]) > most:
        console.print(f"{len(document['states']) - most} more in --json or -o FILE")
    if document.get("file"):
        console.print(f"wrote {document['file']}", soft_wrap=True)


def _translations(state: Document) -> str:
    words = []
    for k in range(3):
        spread = 1.96e3 * state["covariance"][k][k] ** 0.5
        words.append(f"{significant(1e3 * state['deflection'][k])} ± {significant(spread, 2)}")
    return ", ".join(words)


def _rotations(state: Document) -> str:
    return ", ".join(significant(1e3 * value) for value in state["deflection"][3:])


def _stiffness(matrix: list[list[Any]] | None) -> str:
    return NOT_KNOWN if matrix is None else ", ".join(significant(1e-3 * matrix[k][k]) for k in range(3))
