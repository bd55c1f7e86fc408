"""`stiffcal map`: deflection or stiffness over the workspace."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Output, Overwrite, StoreAt
from stiffcal.escapes.shell import command_line
from stiffcal.presentation.values import NextStep


def map(  # noqa: A001  (the command's name)
    folder: Folder = HERE,
    load: Annotated[
        str | None,
        typer.Option(metavar="F", help="Fx,Fy,Fz[,Tx,Ty,Tz] at the load point, base axes.", show_default=False),
    ] = None,
    mass: Annotated[
        float | None,
        typer.Option(metavar="KG", help="Mass at the load point, kg, instead of --load.", show_default=False),
    ] = None,
    stiffness: Annotated[
        str | None,
        typer.Option(metavar="x|y|z|X,Y,Z", help="Also map the stiffness along this direction.", show_default=False),
    ] = None,
    plane: Annotated[Literal["xy", "xz", "yz"], typer.Option(help="Plane of the map.")] = "xz",
    at: Annotated[
        float | None,
        typer.Option(
            metavar="M",
            help="Position of the plane on the third axis, m (default: middle of the reach).",
            show_default=False,
        ),
    ] = None,
    slices: Annotated[int, typer.Option(metavar="N", help="Number of parallel planes: a volume.")] = 1,
    points: Annotated[int, typer.Option(metavar="N", help="Points along the longer side of a plane.")] = 41,
    pose: Annotated[
        str | None,
        typer.Option(
            metavar="A1,A2,…",
            help="Keep the tool orientation of this pose (default: orientation free).",
            show_default=False,
        ),
    ] = None,
    target: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Frame that is mapped (default: the measured frame).", show_default=False),
    ] = None,
    output: Output = None,
    table: Annotated[
        Path | None, typer.Option(metavar="FILE", help="*.csv, *.xlsx, *.parquet: every point.", show_default=False)
    ] = None,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
    overwrite: Overwrite = False,
) -> int:
    """Map deflection or stiffness over the workspace.

    A plane or several, with reach and joint limits. The picture goes to DIR/map.svg, or to -o (*.svg, *.png, *.pdf).

    Example: stiffcal map demo --load 0,0,-500 --plane xz --at 0 --stiffness z -o map.svg --table map.csv
    """
    with answering(as_json) as answer:
        from stiffcal.commands.map import MapRequest, map_campaign
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store, update=not no_update, progress=answer.progress, notify=answer.notify, overwrite=overwrite
        )
        request = MapRequest(load, mass, stiffness, plane, at, slices, points, pose, target)
        result = map_campaign(folder, request, context, picture=output or folder / "map.svg", table=table)
        line = command_line("compensate", folder, "--path", "path.csv", store=store)
        answer.show(result, NextStep(line, once="a path with its forces is in path.csv"))
    return OK
