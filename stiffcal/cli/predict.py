"""`stiffcal predict`: deflection and Cartesian stiffness under given loads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import NextLine, answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Output, OverwriteAlone, StoreAt
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import NOT_KNOWN, significant
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.quantity import LENGTH, LINEAR_STIFFNESS, ShownUnit
from stiffcal.uncertainty import NORMAL_95

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.console import Console

    from stiffcal.compensation.predict_result import PredictedState, PredictResult
    from stiffcal.documents import Matrix, Vector


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
        from stiffcal.commands.predict import LoadPathRequest, OneLoad, predict_campaign
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
        then = NextLine(command_line("export", folder, "-o", "model.json", store=store))
        answer.give(result, show_prediction, then)
    return OK


def _both(option: str) -> InputError:
    """Return the fault of one pose next to a table of them."""
    reason, mend = f"--pose or --force and {option} are both given", f"give either of them; a load of {option} is in it"
    return InputError.at(FaultCode.OPTION_CONFLICT, "command line", option, reason, mend)


def _no_pose() -> InputError:
    """Return the fault of a force without a pose."""
    mend = "give the joint angles in degrees: --pose A1,A2,…"
    return InputError.at(FaultCode.OPTION_MISSING, "command line", "--pose", "--force is given without a pose", mend)


def show_prediction(console: Console, result: PredictResult, most: int = 24) -> None:
    """Draw deflection ± 95 % and the force it takes per millimetre, state by state."""
    console.print(f"deflection of {result.target}, base axes; values from {result.values_from}")
    numbered_states = list(enumerate(result.states[:most], start=1))
    shown = result.states[:most]
    unit = LENGTH.unit_for(float(value) for state in shown for value in state.deflection[:3])
    table = plain_table("state>", *(f"{unit.in_brackets(f'd{axis}')}>" for axis in "xyz"))
    for number, state in numbered_states:
        table.add_row(str(number), *(_translation(state, k, unit) for k in range(3)))
    console.print(table)
    compliances = [m for state in shown for m in (state.cartesian_compliance, state.linear_compliance)]
    hard = LINEAR_STIFFNESS.unit_for(1.0 / m[k, k] for m in compliances for k in range(3) if m[k, k] > 0.0)
    console.print(f"\n{hard.in_brackets('stiffness')}, with and without complementary stiffness")
    table = plain_table("state>", "x>", "y>", "z>", "x without>", "y without>", "z without>")
    for number, state in numbered_states:
        both = (state.cartesian_compliance, state.linear_compliance)
        table.add_row(str(number), *(cell for compliance in both for cell in _stiffness(compliance, hard)))
    console.print(table)
    _show_links(console, shown, unit)
    if len(result.states) > most:
        console.print(f"{len(result.states) - most} more in --json or -o FILE")
    if result.file is not None:
        console.print(f"wrote {result.file}", soft_wrap=True)


def _show_links(console: Console, states: Sequence[PredictedState], unit: ShownUnit) -> None:
    """Draw the deflection with and without each link's own part, side by side (000, Fig. 7)."""
    for number, link in enumerate(states[0].links if states else []):
        name, modelled, measured = link.link, link.at_target is not None, link.at_target_by_compliance is not None
        heads = [f"{unit.in_brackets('whole')}>"]
        heads += [f"{unit.in_brackets(one)}>" for one in (f"{name} rigid", f"part of {name}")] * modelled
        table = plain_table("state>", *heads, *[f"{unit.in_brackets(f'part of {name} by its 6×6')}>"] * measured)
        for place, state in enumerate(states, start=1):
            link_deflection = state.links[number]
            cells = [_vector(state.deflection, unit)]
            if link_deflection.at_target is not None:
                own = link_deflection.at_target
                cells += [_vector(state.deflection - own, unit), _vector(own, unit)]
            if link_deflection.at_target_by_compliance is not None:
                cells.append(_vector(link_deflection.at_target_by_compliance, unit))
            table.add_row(str(place), *cells)
        console.print(table)


def _vector(values: Vector, unit: ShownUnit) -> str:
    # what is smaller is the solver's rounding
    kept = (value if abs(value) > LENGTH.rounding else 0.0 for value in values[:3].tolist())
    return ", ".join(significant(unit.factor * value) for value in kept)


def _translation(state: PredictedState, axis: int, unit: ShownUnit) -> str:
    value = float(state.deflection[axis])
    if abs(value) < LENGTH.rounding:
        return "0"
    half = NORMAL_95 * float(state.covariance[axis, axis]) ** 0.5
    text = significant(unit.factor * value)
    return f"{text} ± {significant(unit.factor * half, 2)}" if half else text


def _stiffness(compliance: Matrix, unit: ShownUnit) -> list[str]:
    """Return force over deflection along each axis, the other directions free to give."""
    gives = [float(compliance[k, k]) for k in range(3)]
    return [significant(unit.factor / give) if give > 0.0 else NOT_KNOWN for give in gives]
