"""`stiffcal compensate`: corrected joint targets for a path with forces."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Output, OverwriteAlone, StoreAt
from stiffcal.escapes.shell import command_line
from stiffcal.presentation.values import NextStep

# Options of the path, its forces, and the goal.
PathFile = Annotated[
    Path,
    typer.Option(
        "--path",
        metavar="FILE",
        help="CSV, xlsx, …: a column per joint (degrees), or X, Y, Z (mm) with qw … qz or roll, pitch, yaw (degrees); "
        "optionally Fx … Tz (N, N·m), t (s), segment.",
        show_default=False,
    ),
]
Force = Annotated[
    str | None,
    typer.Option(
        "--force",
        metavar="F",
        help="Constant load along the path: Fx,Fy,Fz[,Tx,Ty,Tz] in N and N·m.",
        show_default=False,
    ),
]
Segments = Annotated[Path | None, typer.Option(metavar="FILE", help="CSV: segment, Fx … Tz.", show_default=False)]
Log = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="CSV: t, Fx … Tz, sensor log on the same clock as the path.", show_default=False),
]
ForceFrame = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Frame of the forces (default: base axes).", show_default=False),
]
ActsOn = Annotated[Literal["robot", "environment"], typer.Option(help="Body on which the stated forces act.")]
Filter = Annotated[
    float | None,
    typer.Option(
        "--filter", metavar="HZ", help="Cut-off of the low-pass filter for a noisy log, Hz.", show_default=False
    ),
]
Tool = Annotated[
    str | None,
    typer.Option(
        metavar="KG,X,Y,Z",
        help="Take the weight of the tool beyond the sensor out of a log: mass, centre in the flange frame (m).",
        show_default=False,
    ),
]
Zeroed = Annotated[
    bool, typer.Option("--zeroed/--never-zeroed", help="The sensor was zeroed in the first pose of the log.")
]
Target = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Frame that follows the path (default: the measured frame).", show_default=False),
]
Start = Annotated[
    str | None,
    typer.Option(metavar="A1,A2,…", help="Joint angles near the first pose of a Cartesian path.", show_default=False),
]
PositionOnly = Annotated[bool, typer.Option("--position-only", help="Correct the position only, not the orientation.")]
Sag = Annotated[
    bool | None,
    typer.Option(
        "--sag/--no-sag",
        help="Correct geometry errors and the sag under weight too: joint angles are those of the rigid robot.toml "
        "(default: yes for Cartesian paths and where the model contains the geometry, else no).",
        show_default=False,
    ),
]
Normal = Annotated[
    str | None,
    typer.Option(metavar="X,Y,Z|radial", help="Plot the error in this direction.", show_default=False),
]
Judge = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Campaign whose robot predicts the remaining error.", show_default=False),
]
PictureFile = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="*.svg, *.png, *.pdf: the error along the path.", show_default=False),
]


def compensate(
    path: PathFile,
    folder: Folder = HERE,
    force: Force = None,
    segments: Segments = None,
    log: Log = None,
    frame: ForceFrame = None,
    acts_on: ActsOn = "robot",
    filter_hz: Filter = None,
    tool: Tool = None,
    zeroed: Zeroed = True,
    target: Target = None,
    start: Start = None,
    position_only: PositionOnly = False,
    sag: Sag = None,
    normal: Normal = None,
    judge: Judge = None,
    output: Output = None,
    picture: PictureFile = None,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
    overwrite: OverwriteAlone = False,
) -> int:
    """Correct the joint targets of a path with known forces.

    The corrected targets place the loaded robot on the wanted path, within its joint limits; with the uncertainty of
    the remaining error.

    Example: stiffcal compensate demo --path path.csv --force 0,150,-300 -o corrected.csv --picture error.svg
    """
    with answering(as_json) as answer:
        from stiffcal.commands.compensate import compensate_campaign
        from stiffcal.compensation.corrected_path import CompensateRequest
        from stiffcal.compensation.path_forces import Forces
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store, update=not no_update, progress=answer.progress, notify=answer.notify, overwrite=overwrite
        )
        forces = Forces(force, segments, log, frame, acts_on, filter_hz, tool, zeroed)
        request = CompensateRequest(path, forces, target, start, not position_only, sag, normal, judge)
        result = compensate_campaign(folder, request, context, output=output, picture=picture)
        then = NextStep(command_line("export", folder, "-o", "model.json", store=store))
        answer.show(result, then)
    return OK
