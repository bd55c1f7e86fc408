"""One picture of a campaign: load against deformation, the residual against what it may follow, or of the fit."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds import ExperimentKind, all_kinds
from stiffcal.quantity import FORCE, MOMENT, of_joint
from stiffcal.stages.experiments import runs_with_fits
from stiffcal.stages.fit import up_to_date_fit_at_hand
from stiffcal.stages.steps import Ingested, RunContext
from stiffcal.stages.validation import up_to_date_validation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stiffcal.arrays import Floats
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.report.content import ReportStates, ResidualCovariate
    from stiffcal.results.identify_result import IdentifyResult

AGAINST = "torque:4, angle:2, approach:2, force:x, load, time, hold, temperature, state, or velocity:2 (friction)"


def check_request(run: str | None, against: str | None, of: str | None) -> None:
    """Check what can be checked before anything is computed.

    Raises
    ------
    InputError : there is no such picture of a fit, or it is asked for of one run.
    """
    if of is None:
        return
    from stiffcal.report.gathering.plot_of_fit import check_picture

    check_picture(of)
    if run is not None or against is not None:
        mend = "leave --run and --against out"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--of", "it is of the whole fit", mend)


def draw_picture(
    data: Ingested, context: RunContext, run: str | None, against: str | None, of: str | None
) -> tuple[Figure, str]:
    """Return the picture, and what is in it in words; parameters as of `stiffcal.commands.plot.plot_campaign`.

    Raises
    ------
    InputError : there is no such run, or nothing to draw against.
    """
    if of is not None:
        from stiffcal.report.figures.panels import draw_panels
        from stiffcal.report.gathering.plot_of_fit import OF_FIT, picture_of_fit

        return draw_panels(picture_of_fit(of, data, context)), OF_FIT[of]
    names = [info.name for info in data.states.runs]
    if against is None:
        names += [name for name in _runs_by_themselves(data) if name not in names]
    if run is not None and run not in names:
        raise InputError.at(
            FaultCode.RUN_UNKNOWN, "command line", "--run", f"unknown run {run}", f"runs: {', '.join(names)}"
        )
    identified, fit = up_to_date_fit_at_hand(data, context)
    kind = _kind_to_draw(data, against, run)
    picture = None if kind is None else _kind_plot(kind, data, identified, run, against)
    if picture is not None:
        return picture
    if len(data.states) == 0:
        mend = "choose velocity, or velocity:2 for one joint"
        raise InputError.at(
            FaultCode.DATA_MISSING, "command line", "--against", "the campaign contains no load states", mend
        )
    validation = up_to_date_validation(data, identified, context, fit)
    from stiffcal.report.gathering.states import report_states_of

    states = report_states_of(data)
    if against is None:
        return _load_deformation(states, names, run, bool(data.states.absolute.all()))
    from stiffcal.report.figures.residual_against import draw_residual_against

    covariate = _covariate(against, data, identified, states)
    if run is not None:
        states, covariate = _only(states, covariate, names.index(run))
    if not np.isfinite(states.residual[states.used, :3]).any():
        mend = "leave --against out; stiffcal view DIR draws the residual of clamped runs"
        raise InputError.at(
            FaultCode.DATA_MISSING, "command line", "--against", "no displacement of a target was measured", mend
        )
    noise = None if validation.noise is None else validation.noise.translation
    figure = draw_residual_against(states, [covariate], noise)
    return figure, f"residual against {covariate.name}" + (f" in run {run}" if run else "")


def _runs_by_themselves(data: Ingested) -> dict[str, ExperimentKind]:
    """Return the runs that their kind of experiment draws one by one, by name."""
    kinds = {kind.name: kind for kind in all_kinds() if kind.plots_runs}
    return {run.id: kinds[run.experiment] for run in data.campaign.manifest.runs if run.experiment in kinds}


def _kind_to_draw(data: Ingested, against: str | None, run: str | None) -> ExperimentKind | None:
    """Return the kind of experiment whose picture is requested; None where it is one of loads at a tool."""
    axis = (against or "").partition(":")[0]
    requested = next((kind for kind in all_kinds() if axis and kind.plot_axis == axis), None)
    by_themselves = _runs_by_themselves(data)
    if requested is not None or against is not None:
        return requested
    if run is not None:
        return by_themselves.get(run)
    # Clamped runs have states too, and no displacement of a target over a force.
    if any(info.name not in by_themselves for info in data.states.runs):
        return None
    measured = {manifest_run.experiment for manifest_run in data.campaign.manifest.runs}
    return next((kind for kind in all_kinds() if kind.fit_tables and kind.name in measured), None)


def _kind_plot(
    kind: ExperimentKind, data: Ingested, identified: IdentifyResult, run: str | None, against: str | None
) -> tuple[Figure, str] | None:
    """Return a kind's picture and what it shows; ``against`` is "AXIS" or "AXIS:JOINT"."""
    from stiffcal.report.figures.panels import draw_panels

    _, _, selection = (against or "").partition(":")
    joint = data.joint_names[_joint(selection, data.joint_names)] if selection else None
    plot = kind.plot(runs_with_fits(data), identified, run, joint)
    return None if plot is None else (draw_panels(plot.picture), plot.drawn)


def _load_deformation(states: ReportStates, names: list[str], run: str | None, of_places: bool) -> tuple[Figure, str]:
    from stiffcal.report.figures import load_deformation as figures

    runs = sorted(set(states.run.tolist()))
    if states.along is not None:
        from stiffcal.report.figures.along_lines import draw_along_lines

        chosen = runs if run is None else [names.index(run)]
        figure = draw_along_lines(states, chosen, [names[k] for k in chosen])
        return figure, f"displacement along the force of {'every run' if run is None else f'run {run}'}"
    if run is not None:
        return figures.draw_load_deformation(states, names.index(run), run), f"load-deformation of run {run}"
    if all(np.count_nonzero(states.used & (states.run == number)) <= 1 for number in runs):
        return figures.draw_deflection_by_run(states, names, runs), (
            "distance from the nominal robot in all rows" if of_places else "deflection of all runs"
        )
    return figures.draw_load_deformation_sheet(states, runs, [names[k] for k in runs]), "load-deformation of all runs"


def _covariate(
    against: str, data: Ingested, identified: IdentifyResult, report_states: ReportStates
) -> ResidualCovariate:
    from stiffcal.report.content import ResidualCovariate
    from stiffcal.report.gathering.content import joint_torques

    quantity, _, selection = against.partition(":")
    states = data.states
    simple = {
        "load": ("load", "N", report_states.load),
        "time": ("time", "s", states.time),
        "hold": ("time under load", "s", states.hold),
        "state": ("state in the order measured", "1", np.arange(len(states), dtype=np.float64)),
    }
    if states.temperature.shape[1]:
        simple["temperature"] = ("temperature", "as logged", states.temperature[:, 0])
    if quantity in simple and not selection:
        name, unit, values = simple[quantity]
        if not np.isfinite(values).any():
            mend = f"choose {AGAINST}"
            raise InputError.at(
                FaultCode.DATA_MISSING, "command line", "--against", f"{quantity} is not logged in this campaign", mend
            )
        return ResidualCovariate(name, unit, np.asarray(values, dtype=np.float64))
    if quantity == "force" and selection in ("x", "y", "z"):
        return ResidualCovariate(f"force along {selection}", "N", report_states.force[:, "xyz".index(selection)])
    if quantity in ("torque", "angle", "approach"):
        joint = _joint(selection, data.joint_names)
        slides = bool(data.campaign.chain.prismatic[joint])
        if quantity == "approach":
            return ResidualCovariate(
                f"direction of the last motion of joint {joint + 1}", "1", _approach(states, joint)
            )
        if quantity == "angle":
            shown, what = of_joint(slides).usual, "position" if slides else "angle"
            return ResidualCovariate(f"{what} of joint {joint + 1}", shown.name, shown.factor * states.joints[:, joint])
        what, shown = ("force", FORCE.usual) if slides else ("torque", MOMENT.usual)
        return ResidualCovariate(f"{what} on joint {joint + 1}", shown.name, joint_torques(data, identified)[:, joint])
    raise InputError.at(
        FaultCode.OPTION_INVALID, "command line", "--against", f"unknown quantity {against}", f"choose {AGAINST}"
    )


def _approach(states: LoadStates, joint: int) -> Floats:
    """Return (n,) the direction of a drive's last motion, NaN where it is not known; ``joint`` from 0."""
    if states.approach.any() and not states.approach[states.used, joint].any():
        raise InputError.at(
            FaultCode.DATA_MISSING, "command line", "--against",
            f"joint {joint + 1} did not move before any row, so that there is no direction of its last motion",
            "choose a joint that moved",
        )  # fmt: skip
    if not states.approach.any():
        raise InputError.at(
            FaultCode.DATA_MISSING, "command line", "--against",
            "the direction of the joints' last motions is not known in this campaign",
            'name approach columns of the joints, or write approach = "direct" in [[runs]]',
        )  # fmt: skip
    return np.where(states.approach[:, joint] != 0.0, states.approach[:, joint], np.nan)


def _joint(which: str, names: tuple[str, ...]) -> int:
    if which in names:
        return names.index(which)
    if len(which) < 10 and which.isdecimal() and 1 <= int(which) <= len(names):
        return int(which) - 1
    mend = f"number 1 to {len(names)}, or one of {', '.join(names)}"
    raise InputError.at(
        FaultCode.JOINT_UNKNOWN, "command line", "--against", f"unknown joint {which or '(nothing)'}", mend
    )


def _only(states: ReportStates, covariate: ResidualCovariate, number: int) -> tuple[ReportStates, ResidualCovariate]:
    """Keep one run's states."""
    from dataclasses import fields

    keep = states.run == number
    selected: dict[str, Any] = {}
    for field in fields(states):
        values = getattr(states, field.name)
        selected[field.name] = None if values is None else values[keep]
    return replace(states, **selected), replace(covariate, values=covariate.values[keep])
