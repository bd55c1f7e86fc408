"""One picture: load against deformation, or the residual against anything it might follow."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.workflow.command_results import PlotResult
from stiffcal.workflow.identify import fitted
from stiffcal.workflow.steps import Ingested, RunContext, ingested
from stiffcal.workflow.validate import validated

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stiffcal.report.content import ReportStates, ResidualCovariate
    from stiffcal.results.identify_result import IdentifyResult

PICTURES = (".svg", ".png", ".pdf")
AGAINST = "torque:4, angle:2, force:x, load, time, hold, temperature, state, or velocity:2 (friction)"


def plot_campaign(
    folder: Path,
    context: RunContext | None = None,
    output: Path | None = None,
    run: str | None = None,
    against: str | None = None,
) -> PlotResult:
    """Draw one picture of a campaign.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.
    output : ``*.svg``, ``*.png`` or ``*.pdf``; default plot.svg in the present folder.
    run : only this run.
    against : draw the residual in unseen poses against this: ``torque:4``, ``angle:2`` (joint by number or name),
        ``force:x``, ``load``, ``time``, ``hold``, ``temperature``, ``state``; ``velocity`` or ``velocity:2``: friction
        over speed; None: load against deformation, or friction where there are no load states.

    Returns
    -------
    PlotResult
        The picture's file, and what is in it.

    Raises
    ------
    InputError : there is no such run, or nothing to draw against.
    """
    context = context or RunContext()
    file = output or Path("plot.svg")
    if file.suffix.lower() not in PICTURES:
        raise InputError.at(
            FaultCode.FORMAT_UNKNOWN,
            str(file),
            "",
            "no picture format",
            f"end the name in one of {', '.join(PICTURES)}",
        )
    if not file.parent.is_dir():
        raise InputError.at(FaultCode.FILE_MISSING, str(file), "", "its folder does not exist", "make the folder first")
    data = ingested(folder, context)
    names = [info.name for info in data.states.runs]
    if len(data.states) == 0 and against is None:
        names += clamped_runs(data)
    if run is not None and run not in names:
        raise InputError.at(
            FaultCode.RUN_UNKNOWN, "command line", "--run", f"no run is called {run}", f"runs: {', '.join(names)}"
        )
    identified = fitted(data, context)
    from stiffcal.report.figures.canvas import save_figure

    if len(data.states) == 0 and against is None and clamped_runs(data):
        figure, drawn = _clamped(data, identified, run)
        save_figure(figure, file)
        return PlotResult(warnings=[], file=str(file), drawn=drawn)
    if (against or "").partition(":")[0] == "velocity" or (len(data.states) == 0 and against is None):
        figure, drawn = _friction(data, identified, against or "velocity")
        save_figure(figure, file)
        return PlotResult(warnings=[], file=str(file), drawn=drawn)
    if len(data.states) == 0:
        mend = "choose velocity, or velocity:2 for one joint"
        raise InputError.at(
            FaultCode.DATA_MISSING, "command line", "--against", "the campaign holds no load states", mend
        )
    validation = validated(data, identified, context)
    from stiffcal.workflow.report_content import report_states_of

    shown = report_states_of(data)
    if against is None:
        figure, drawn = _load_deformation(shown, names, run)
    else:
        from stiffcal.report.figures.residual_against import draw_residual_against

        covariate = _covariate(against, data, identified, shown)
        if run is not None:
            shown, covariate = _only(shown, covariate, names.index(run))
        noise = (validation["noise"] or {}).get("translation")
        figure = draw_residual_against(shown, [covariate], noise)
        drawn = f"residual against {covariate.name}" + (f" in run {run}" if run else "")
    save_figure(figure, file)
    return PlotResult(warnings=[], file=str(file), drawn=drawn)


def clamped_runs(data: Ingested) -> list[str]:
    """Return the names of the campaign's clamped runs."""
    return [run.id for run in data.campaign.manifest.runs if run.experiment == "clamped"]


def _clamped(data: Ingested, identified: IdentifyResult, run: str | None) -> tuple[Figure, str]:
    from stiffcal.report.figures.clamped import draw_branches
    from stiffcal.workflow.report_clamped import clamped_curves

    curves = clamped_curves(data, identified)
    if run is not None:
        chosen = (replace(one, poses=tuple(pose for pose in one.poses if pose.run == run)) for one in curves)
        curves = tuple(one for one in chosen if one.poses)
    drawn = tuple(one for one in curves if one.shown.angle.size)
    if not drawn:
        reason = "no whole sweep is left to draw" if run is None else f"no whole sweep is left of run {run}"
        raise InputError.at(
            FaultCode.DATA_MISSING, str(data.campaign.folder), "runs", reason, "stiffcal identify says why"
        )
    return draw_branches(drawn), "torque over angle of " + ", ".join(f"{one.joint} ({one.shown.run})" for one in drawn)


def _friction(data: Ingested, identified: IdentifyResult, against: str) -> tuple[Figure, str]:
    from stiffcal.report.figures.friction import draw_friction
    from stiffcal.workflow.report_friction import friction_curves

    curves = friction_curves(data, identified)
    if not curves:
        mend = "measure friction runs, or draw something else"
        raise InputError.at(
            FaultCode.DATA_MISSING, str(data.campaign.folder), "runs", "no friction was measured in this campaign", mend
        )
    _, _, which = against.partition(":")
    if which:
        name = data.joint_names[_joint(which, data.joint_names)]
        curves = tuple(curve for curve in curves if curve.joint == name)
        if not curves:
            raise InputError.at(
                FaultCode.DATA_MISSING,
                "command line",
                "--against",
                f"joint {name} has no friction runs",
                f"choose {AGAINST}",
            )
    return draw_friction(curves), "friction over speed of " + ", ".join(curve.joint for curve in curves)


def _load_deformation(shown: ReportStates, names: list[str], run: str | None) -> tuple[Figure, str]:
    from stiffcal.report.figures import load_deformation as figures

    runs = sorted(set(shown.run.tolist()))
    if shown.along is not None:
        from stiffcal.report.figures.along_lines import draw_along_lines

        chosen = runs if run is None else [names.index(run)]
        figure = draw_along_lines(shown, chosen, [names[k] for k in chosen])
        return figure, f"displacement along the force of {'every run' if run is None else f'run {run}'}"
    if run is not None:
        return figures.draw_load_deformation(shown, names.index(run), run), f"load-deformation of run {run}"
    if all(np.count_nonzero(shown.used & (shown.run == number)) <= 1 for number in runs):
        return figures.draw_deflection_by_run(shown, names, runs), "deflection of every run"
    return figures.draw_load_deformation_sheet(shown, runs, [names[k] for k in runs]), "load-deformation of every run"


def _covariate(against: str, data: Ingested, identified: IdentifyResult, shown: ReportStates) -> ResidualCovariate:
    from stiffcal.report.content import ResidualCovariate
    from stiffcal.workflow.report_content import joint_torques

    what, _, which = against.partition(":")
    states = data.states
    simple = {
        "load": ("load", "N", shown.load),
        "time": ("time", "s", states.time),
        "hold": ("time under load", "s", states.hold),
        "state": ("state in the order measured", "1", np.arange(len(states), dtype=np.float64)),
    }
    if states.temperature.shape[1]:
        simple["temperature"] = ("temperature", "as logged", states.temperature[:, 0])
    if what in simple and not which:
        name, unit, values = simple[what]
        if not np.isfinite(values).any():
            mend = f"choose {AGAINST}"
            raise InputError.at(
                FaultCode.DATA_MISSING, "command line", "--against", f"{what} is not logged in this campaign", mend
            )
        return ResidualCovariate(name, unit, np.asarray(values, dtype=np.float64))
    if what == "force" and which in ("x", "y", "z"):
        return ResidualCovariate(f"force along {which}", "N", shown.force[:, "xyz".index(which)])
    if what in ("torque", "angle"):
        joint = _joint(which, data.joint_names)
        if what == "angle":
            return ResidualCovariate(f"angle of joint {joint + 1}", "°", np.degrees(states.joints[:, joint]))
        return ResidualCovariate(f"torque on joint {joint + 1}", "N·m", joint_torques(data, identified)[:, joint])
    raise InputError.at(
        FaultCode.OPTION_INVALID, "command line", "--against", f"nothing is known of {against}", f"choose {AGAINST}"
    )


def _joint(which: str, names: tuple[str, ...]) -> int:
    if which in names:
        return names.index(which)
    if len(which) < 10 and which.isdecimal() and 1 <= int(which) <= len(names):
        return int(which) - 1
    mend = f"number 1 to {len(names)}, or one of {', '.join(names)}"
    raise InputError.at(
        FaultCode.JOINT_UNKNOWN, "command line", "--against", f"no joint is called {which or '(nothing)'}", mend
    )


def _only(shown: ReportStates, covariate: ResidualCovariate, number: int) -> tuple[ReportStates, ResidualCovariate]:
    """Keep one run's states."""
    from dataclasses import fields, replace

    keep = shown.run == number
    parts: dict[str, Any] = {}
    for one in fields(shown):
        values = getattr(shown, one.name)
        parts[one.name] = None if values is None else values[keep]
    return replace(shown, **parts), replace(covariate, values=covariate.values[keep])
