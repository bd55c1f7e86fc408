"""`stiffcal predict`: deflection and Cartesian stiffness under given loads."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Details, Folder, NoUpdate, Output, OverwriteAlone, StoreAt
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.presentation.values import NextStep
from stiffcal.show.options import ShowOptions


def predict(
    folder: Folder = HERE,
    pose: Annotated[
        str | None,
        typer.Option("--pose", metavar="A1,A2,…", help="One pose, joint angles in degrees.", show_default=False),
    ] = None,
    force: Annotated[
        str | None,
        typer.Option(
            "--force",
            metavar="Fx,Fy,Fz",
            help="The force at --pose in N, base axes, on the robot at the load point; with moments Fx, … Tz.",
            show_default=False,
        ),
    ] = None,
    poses: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="CSV, xlsx, …: a column per joint (degrees), Fx … Tz (N, N·m); one state a row.",
            show_default=False,
        ),
    ] = None,
    load_path: Annotated[
        str | None,
        typer.Option(
            "--load-path",
            metavar="F;F;…",
            help="Sequence of forces in N (base axes) at the pose --at, or a CSV file. The report shows the path.",
            show_default=False,
        ),
    ] = None,
    at: Annotated[
        str | None,
        typer.Option(
            "--at", metavar="A1,A2,…", help="Pose of the load path, joint angles in degrees.", show_default=False
        ),
    ] = None,
    points: Annotated[int, typer.Option(help="Points on each segment of the load path.")] = 20,
    note: Annotated[str, typer.Option(metavar="WORDS", help="Note for the report, printed with the load path.")] = "",
    output: Output = None,
    details: Details = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
    overwrite: OverwriteAlone = False,
) -> int:
    """Predict deflection and stiffness under given loads.

    With uncertainty; of one force at one pose, of a table of poses and loads, or along a path of forces at one pose.

    Example: stiffcal predict demo --pose 0,10,20,0,30,0 --force 0,0,-500
    """
    with answering(as_json) as answer:
        from stiffcal.commands.predict import predict_campaign
        from stiffcal.compensation.requested_loads import LoadPathRequest, OneLoad
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store, update=not no_update, progress=answer.progress, notify=answer.notify, overwrite=overwrite
        )
        path = LoadPathRequest(load_path, at, points, note) if load_path is not None else None
        if (pose is not None or force is not None) and poses is not None:
            raise _both("--poses")
        if pose is None and force is not None:
            raise _no_pose()
        one = None if pose is None else OneLoad(pose, OneLoad.force if force is None else force)
        result = predict_campaign(folder, context, poses=one or poses, load_path=path, output=output)
        then = NextStep(command_line("export", folder, "-o", "model.json", store=store))
        answer.show(result, then, ShowOptions(details, folder, store))
    return OK


def _both(option: str) -> InputError:
    """Return the fault of one pose next to a table of them."""
    reason, mend = f"--pose or --force and {option} are both given", f"give either of them; a load of {option} is in it"
    return InputError.at(FaultCode.OPTION_CONFLICT, "command line", option, reason, mend)


def _no_pose() -> InputError:
    """Return the fault of a force without a pose."""
    mend = "give the joint angles in degrees: --pose A1,A2,…"
    return InputError.at(FaultCode.OPTION_MISSING, "command line", "--pose", "--force is given without a pose", mend)
