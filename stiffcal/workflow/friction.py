"""Friction of the drives in the documents: fitted, judged at speeds that the fit has not seen, drawn."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.workflow.experiments import Judged, Part
from stiffcal.workflow.ingest import FREE_MOTION, FRICTION
from stiffcal.workflow.steps import Document, Ingested, moving_effects

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.experiments.friction import FrictionFit, FrictionParameter, JointFrictionFit
    from stiffcal.experiments.friction_rows import FrictionRows
    from stiffcal.measurements.friction_readings import FreeMotion, SteadyReadings
    from stiffcal.model.composite import PlacedEffect

Floats = NDArray[np.float64]

FRICTION_FIT = "friction_fit"
CURVE_POINTS = 120


def friction_part(data: Ingested) -> Part | None:
    """Fit the friction of every drive that the model gives friction and that friction runs have moved.

    Returns None where the campaign holds no friction run.

    Raises
    ------
    InputError
        The model holds no friction and nothing else could be fitted.
    """
    from stiffcal.experiments.friction import fit_friction

    readings = friction_readings(data)
    if readings == (None, None):
        return None
    placed = moving_effects(data.campaign)
    if not placed:
        return _without_effect(data)
    rows = friction_rows(data)
    usable = rows is not None and bool(np.isin(rows.joint, [one.place.joints[0] for one in placed]).any())
    if rows is None or not usable:
        return _nothing_told(data, placed)
    fixed = _fixed(data)
    fit = fit_friction(rows.select(~_held_out(data, rows)), placed, fixed)
    return _part(data, fit, placed)


def friction_readings(data: Ingested) -> tuple[SteadyReadings | None, FreeMotion | None]:
    """Return what the store holds of friction runs."""
    from stiffcal.measurements.friction_readings import motion_from_table, steady_from_table

    steady, motion = data.beside.get(FRICTION), data.beside.get(FREE_MOTION)
    try:
        return (
            None if steady is None else steady_from_table(steady),
            None if motion is None else motion_from_table(motion),
        )
    except ValueError as error:
        raise InputError.at(data.store.shown, FRICTION, str(error), "delete the store and run ingest again") from error


def friction_rows(data: Ingested) -> FrictionRows | None:
    """Return the equations of all friction runs, None where no reading is used."""
    from stiffcal.experiments.friction_rows import motion_rows, stacked_rows, steady_rows

    steady, motion = friction_readings(data)
    parts = []
    if steady is not None and steady.used.any():
        parts.append(steady_rows(steady))
    if motion is not None and motion.one_way.any():
        parts.append(motion_rows(motion, data.campaign.chain))
    return stacked_rows(parts) if parts else None


def friction_judged(data: Ingested) -> Judged | None:
    """Judge friction at speeds that the fit has not seen; None where the campaign tells no friction."""
    from stiffcal.validation.friction import unseen_friction

    rows, placed = friction_rows(data), moving_effects(data.campaign)
    if rows is None or not placed:
        return None
    rows = rows.select(np.isin(rows.joint, [one.place.joints[0] for one in placed]))
    if len(rows) == 0:
        return None
    from stiffcal.experiments.friction import fit_friction

    fixed, held_out = _fixed(data), _held_out(data, rows)
    unseen = unseen_friction(rows, placed, fixed, held_out)
    fit = fit_friction(rows.select(~held_out), placed, fixed)
    warnings = []
    residual = unseen.residual
    if unseen.scheme == "none":
        warnings.append("friction: fewer than three speeds, this is the error of the fit")
        residual = np.full(len(rows), np.nan)
        residual[~held_out] = fit.residual
    seen = np.isfinite(residual)
    size = np.full(len(rows), np.nan)
    size[~held_out] = fit.friction_measured
    names = data.joint_names
    by_joint = [
        _slice(names[joint - 1], residual[seen & (rows.joint == joint)]) for joint in np.unique(rows.joint[seen])
    ]
    by_run = [_slice(str(run), residual[seen & (rows.run == run)]) for run in dict.fromkeys(rows.run[seen].tolist())]
    rms = _rms(residual[seen])
    zero = _rms(size[np.isfinite(size)])
    return Judged(
        name="friction",
        scheme=unseen.scheme,
        rms={"torque": rms},
        largest={"torque": float(np.abs(residual[seen]).max())},
        noise=_noise(fit),
        relative={"torque": rms / zero if zero else None},
        zero_model={"torque": zero},
        by={"run": by_run, "joint": by_joint},
        section={"scheme": unseen.scheme, "n_readings": int(seen.sum())},
        n_readings=int(seen.sum()),
        warnings=warnings,
    )


def _fixed(data: Ingested) -> frozenset[str]:
    from stiffcal.model.assembly import fixed_parameters

    return fixed_parameters(data.campaign.model)


def _held_out(data: Ingested, rows: FrictionRows) -> NDArray[np.bool_]:
    runs = [run.id for run in data.campaign.manifest.runs if run.holdout]
    return np.isin(rows.run, runs)


def _without_effect(data: Ingested) -> Part | None:
    """Say that friction was measured and is not in the model; where nothing else is measured, refuse."""
    from stiffcal.model.catalogue import find_effects
    from stiffcal.workflow.steps import plugin_files

    names = [name for name, effect in find_effects(plugin_files(data.campaign)).items() if effect.in_motion]
    mend = f"stiffcal add {data.campaign.folder} {names[0] if names else 'EFFECT'} --all"
    if len(data.states) == 0:
        raise InputError.at(
            "model.toml", "effects", "the campaign holds friction runs, and the model no friction", mend
        )
    return Part(
        "friction", {"joints": []}, warnings=[f"friction runs are not used: the model holds no friction ({mend})"]
    )


def _nothing_told(data: Ingested, placed: tuple[PlacedEffect, ...]) -> Part:
    gaps = _gaps(data, placed, set())
    return Part(
        "friction",
        {"joints": []},
        parameters=[document for one in placed for document in _unknown(one)],
        not_identifiable=gaps,
        effects=_effects(placed),
        expected="no friction can be told from these runs",
    )


def _part(data: Ingested, fit: FrictionFit, placed: tuple[PlacedEffect, ...]) -> Part:
    """Return the part of a fit."""
    by_joint = {one.joint: one for one in fit.joints}
    parameters: list[Document] = []
    for one in placed:
        found = by_joint.get(one.place.joints[0])
        parameters += _unknown(one) if found is None else [_parameter(each) for each in found.parameters]
    section = {"joints": [_joint_document(data, fit, one, placed) for one in fit.joints]}
    gaps = _gaps(data, placed, set(by_joint)) + [_unseen_gap(one) for one in fit.joints if not all(one.seen.values())]
    return Part(
        name="friction",
        section=section,
        parameters=parameters,
        not_identifiable=gaps,
        effects=_effects(placed),
        rms={"torque": _rms(fit.residual)},
        noise=_noise(fit),
        noise_source="repeats" if any(one.noise is not None for one in fit.joints) else "none",
        n_runs=len(set(fit.rows.run.tolist())),
        n_readings=len(fit.rows),
        reduced_chi2=fit.reduced_chi2,
        condition=fit.condition,
        expected=_expected(fit),
        warnings=_warnings(data, fit),
        tables={FRICTION_FIT: fit_table(data, fit)},
    )


def _effects(placed: tuple[PlacedEffect, ...]) -> list[Document]:
    found: dict[str, Document] = {}
    for one in placed:
        entry = found.setdefault(one.effect.name, {"type": one.effect.name, "joints": []})
        entry["joints"].append(one.place.joints[0])
    return list(found.values())


def _parameter(one: FrictionParameter) -> Document:
    return {
        "name": one.name,
        "effect": one.effect,
        "where": {"joints": [one.joint]},
        "value": one.value,
        "std": one.std,
        "interval": None if one.interval is None else list(one.interval),
        "unit": one.spec.unit,
        "fixed": one.fixed,
        "identifiable": one.value is not None and (one.std is not None or not one.why),
        "at_bound": one.at_bound,
        "poorly_known": bool(one.std is not None and one.value and 1.96 * one.std > 0.6 * abs(one.value)),
        "remark": one.why,
    }


def _unknown(one: PlacedEffect) -> list[Document]:
    """Return a joint's parameters, none of them told."""
    return [
        {
            "name": one.parameter_name(spec.symbol),
            "effect": one.effect.name,
            "where": one.place.as_where(),
            "value": None,
            "std": None,
            "interval": None,
            "unit": spec.unit,
            "fixed": False,
            "identifiable": False,
            "at_bound": False,
            "poorly_known": False,
            "remark": "",
        }
        for spec in one.effect.parameters
    ]


def _gaps(data: Ingested, placed: tuple[PlacedEffect, ...], told: set[int]) -> list[Document]:
    """Name the joints of the model that these runs tell nothing of, and why."""
    steady, _ = friction_readings(data)
    gaps = []
    for one in placed:
        joint = one.place.joints[0]
        if joint in told:
            continue
        name = data.joint_names[joint - 1]
        own = np.zeros(0, dtype=np.str_) if steady is None else steady.set_aside[steady.joint == joint]
        reason = f"joint {name} never moved in a friction run"
        if own.size:
            reason = f"joint {name}: " + "; ".join(dict.fromkeys(own[own != ""].tolist()))
        names = [one.parameter_name(spec.symbol) for spec in one.effect.parameters]
        gaps.append({"parameters": names, "known": None, "value": None, "std": None, "reason": reason})
    return gaps


def _unseen_gap(one: JointFrictionFit) -> Document:
    names = [each.name for each in one.parameters if each.value is None]
    unseen = [symbol for symbol, seen in one.seen.items() if not seen]
    reason = f"{' and '.join(unseen)} friction is not seen: " + "; ".join(one.verdict[symbol] for symbol in unseen)
    return {"parameters": names, "known": None, "value": None, "std": None, "reason": reason}


def _joint_document(
    data: Ingested, fit: FrictionFit, one: JointFrictionFit, placed: tuple[PlacedEffect, ...]
) -> Document:
    from stiffcal.experiments.friction import friction_curve

    own = fit.rows.joint == one.joint
    effect = next(each for each in placed if each.place.joints == (one.joint,))
    low, high = one.lowest, one.highest
    # half on the slow part, which is drawn on its own
    speed = np.unique(
        np.concatenate([np.linspace(low, high, CURVE_POINTS // 2), np.geomspace(low, high, CURVE_POINTS)])
    )
    torque, std = friction_curve(one, effect, speed)
    steady = bool(fit.rows.steady[own].any())
    return {
        "joint": one.joint,
        "name": data.joint_names[one.joint - 1],
        "method": "steady velocities" if steady else "weight and inertia modelled",
        "n_readings": one.n_rows,
        "n_speeds": one.n_speeds if steady else None,
        "lowest_speed": low,
        "highest_speed": high,
        "rms": _rms(fit.residual[own]),
        "noise": one.noise,
        "optional": {symbol: {"seen": seen, "why": one.verdict.get(symbol, "")} for symbol, seen in one.seen.items()},
        "between_directions": _between_directions(data, fit, one.joint),
        "curve": {"velocity": speed.tolist(), "torque": torque.tolist(), "std": std.tolist()},
        "covariance": {"symbols": list(one.free), "matrix": one.covariance.tolist()},
    }


def _between_directions(data: Ingested, fit: FrictionFit, joint: int) -> Document | None:
    """Return what both directions share (weight, the torque's zero, friction that differs by direction), N·m."""
    own = (fit.rows.joint == joint) & fit.rows.steady
    if not own.any():
        return None
    shared = np.array([fit.beside[own & (fit.rows.piece == piece)].mean() for piece in np.unique(fit.rows.piece[own])])
    axis_is_plumb = joint == 1 and bool(
        np.linalg.norm(np.cross(data.campaign.chain.fixed[0, :3, 2], data.campaign.chain.gravity)) < 1e-6
    )
    return {
        "mean": float(shared.mean()),
        "low": float(shared.min()),
        "high": float(shared.max()),
        "weight_possible": not axis_is_plumb,
    }


def _warnings(data: Ingested, fit: FrictionFit) -> list[str]:
    words = []
    for one in fit.joints:
        name = data.joint_names[one.joint - 1]
        shared = _between_directions(data, fit, one.joint)
        own = fit.rows.joint == one.joint
        if shared is not None and not shared["weight_possible"]:
            level, noise = abs(shared["mean"]), _rms(fit.residual[own])
            if level > 4.0 * noise / math.sqrt(own.sum()) and level > 0.02 * _rms(fit.friction[own]):
                words.append(
                    f"joint {name} carries no weight, yet its drive needs {2.0 * level:.3g} N·m more in one direction "
                    "than in the other: friction differs by direction, or the torque's zero is off"
                )
        for each in one.parameters:
            if each.fixed and each.why:
                words.append(f"{each.name}: {each.why}")
            elif each.at_bound:
                words.append(f"{each.name} lies on the edge of what is possible")
        if all((one.values().get(symbol, 0.0) <= 0.0) for symbol in ("coulomb",) if symbol in one.values()):
            words.append(f"joint {name}: the drive pushes against its motion; check the sign of torque or gear_ratio")
    if fit.reduced_chi2 is not None and fit.reduced_chi2 > 1.5:
        words.append(
            f"friction: residuals are {math.sqrt(fit.reduced_chi2):.2g} times the scatter between repeats: the curve "
            "has a shape that the law lacks, and the stated uncertainties cover the scatter only"
        )
    if fit.scaled:
        words.append(
            "friction: too few repeats to know the noise; standard uncertainties come from the fit's residuals"
        )
    return words


def _expected(fit: FrictionFit) -> str:
    relative = _rms(fit.residual) / max(_rms(fit.friction), 1e-300)
    return (
        f"friction of a drive is told to {_rms(fit.residual):.3g} N·m rms over the measured speeds, "
        f"{100.0 * relative:.3g} % of it"
    )


def _noise(fit: FrictionFit) -> dict[str, float | None]:
    known = [(one.noise, one.n_rows) for one in fit.joints]
    if not known or any(noise is None for noise, _ in known):
        return {}
    squares = sum((noise or 0.0) ** 2 * n for noise, n in known)
    return {"torque": math.sqrt(squares / sum(n for _, n in known))}


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def _slice(label: str, residual: Floats) -> dict[str, Any]:
    nothing = {"translation": None, "rotation": None}
    return {
        "label": label,
        "low": None,
        "high": None,
        "n": int(residual.size),
        "rms": nothing | {"torque": _rms(residual)},
        "max": nothing | {"torque": float(np.abs(residual).max())},
    }


def fit_table(data: Ingested, fit: FrictionFit) -> pa.Table:
    """Return every row of the fit: velocity, friction as measured (weight, inertia, zeros taken off), fit, residual."""
    from stiffcal.store import table_of

    rows = fit.rows
    return table_of(
        {
            "run": rows.run.tolist(),
            "joint": [data.joint_names[joint - 1] for joint in rows.joint],
            "steady": rows.steady,
            "velocity_radps": rows.velocity,
            "friction_measured_Nm": fit.friction_measured,
            "friction_Nm": fit.friction,
            "beside_Nm": fit.beside,
            "residual_Nm": fit.residual,
        }
    )
