"""Friction of the drives in words and documents: parameters, gaps, curves, what a reader must know."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.identification.answers.document import identified_parameter
from stiffcal.identification.answers.fit_results import IdentifiedParameter, UnidentifiedParameters
from stiffcal.kinds.friction.answers.results import (
    BearingFriction,
    BetweenDirections,
    FittedCurve,
    JointFrictionResult,
    SymbolCovariance,
)
from stiffcal.kinds.friction.fitting.identifiability import MotionLack
from stiffcal.kinds.friction.fitting.torque_rows import UnknownKind
from stiffcal.kinds.measured import MeasuredRuns
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import EffectInModel, Where
from stiffcal.validation.results import ErrorSlice
from stiffcal.wording import share, significant

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.estimation.parameters import Parameter
    from stiffcal.kinds.friction.fitting.joint_fits import FrictionFit, JointFrictionFit
    from stiffcal.kinds.friction.fitting.part_fit import PartFit
    from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows
    from stiffcal.kinds.friction.logs.readings import SteadyReadings
    from stiffcal.measurements.columns import Values
    from stiffcal.model.assembled.composite import PlacedEffect


CURVE_POINTS = 120


def effects_in_model(placed: tuple[PlacedEffect, ...]) -> list[EffectInModel]:
    """Return the effects of the model that friction runs identify, with their joints."""
    joints: dict[str, list[int]] = {}
    for effect in placed:
        joints.setdefault(effect.effect.name, []).append(effect.place.joints[0])
    return [EffectInModel(name, joints=numbers) for name, numbers in joints.items()]


def _identified(parameter: Parameter, lack: MotionLack | None) -> IdentifiedParameter:
    """Return one parameter as ``identify`` answers it, and why the motion does not determine it; None where it does."""
    return replace(
        identified_parameter(parameter),
        identifiable=parameter.identifiable and lack is None,
        remark="" if lack is None else lack.sentence,
    )


def identified_friction(joint_fit: JointFrictionFit) -> list[IdentifiedParameter]:
    """Return a joint's parameters as ``identify`` answers them."""
    return [_identified(parameter, joint_fit.lacking.get(parameter.name)) for parameter in joint_fit.parameters]


def unknown_parameters(placed: PlacedEffect) -> list[IdentifiedParameter]:
    """Return a joint's parameters, none of them identified."""
    return [
        IdentifiedParameter(
            name=placed.parameter_name(spec.symbol),
            effect=placed.effect.name,
            where=Where.of(placed.place),
            value=None,
            std=None,
            interval=None,
            unit=spec.unit,
            fixed=False,
            identifiable=False,
            remark="",
        )
        for spec in placed.effect.parameters
    ]


def gaps(
    data: MeasuredRuns, steady: SteadyReadings | None, placed: tuple[PlacedEffect, ...], fitted_joints: set[int]
) -> list[UnidentifiedParameters]:
    """Return the joints of the model that these runs leave open, and why.

    Parameters
    ----------
    fitted_joints : joints that were fitted.
    """
    missing = []
    for effect in placed:
        joint = effect.place.joints[0]
        if joint in fitted_joints:
            continue
        name = data.joint_names[joint - 1]
        reason = f"joint {name} never moved in a friction run"
        if steady is not None and (steady.joint == joint).any():
            reason = f"joint {name}: {_why_not_fitted(steady, joint)}"
        names = [effect.parameter_name(spec.symbol) for spec in effect.effect.parameters]
        missing.append(UnidentifiedParameters(parameters=names, known=None, reason=reason))
    return missing


def lacking_motion(data: MeasuredRuns, fit: FrictionFit) -> list[UnidentifiedParameters]:
    """Return the parameters that the motion of a fitted joint does not determine, and why."""
    groups = []
    for joint_fit in fit.joints:
        name = data.joint_names[joint_fit.joint - 1]
        # shapes have a value: the usual one
        for lack in sorted({*joint_fit.lacking.values()} - {MotionLack.SHAPE}):
            names = [one.name for one in joint_fit.parameters if joint_fit.lacking.get(one.name) is lack]
            reason = f"joint {name}: {lack.sentence}"
            groups.append(UnidentifiedParameters(parameters=names, known=None, reason=reason))
    return groups


def _why_not_fitted(steady: SteadyReadings, joint: int) -> str:
    """Return why the readings of a joint gave no fit."""
    of_joint = steady.joint == joint
    if steady.used[of_joint].any():
        return "its friction runs are held-out runs"
    _, first = np.unique(steady.set_aside_code[of_joint], return_index=True)
    return "; ".join(str(steady.set_aside[of_joint][k]) for k in sorted(first.tolist()))


def joint_friction(
    data: MeasuredRuns, fit: FrictionFit, joint_fit: JointFrictionFit, placed: tuple[PlacedEffect, ...]
) -> JointFrictionResult:
    """Return the result for one joint: how it was measured, what is left, its curve with standard uncertainty."""
    from stiffcal.kinds.friction.fitting.joint_fits import friction_curve

    of_joint = fit.rows.joint == joint_fit.joint
    effects = tuple(placed_effect for placed_effect in placed if placed_effect.place.joints == (joint_fit.joint,))
    low, high = joint_fit.lowest, joint_fit.highest
    # half on the slow part, which is drawn on its own
    speed = np.unique(
        np.concatenate([np.linspace(low, high, CURVE_POINTS // 2), np.geomspace(low, high, CURVE_POINTS)])
    )
    torque, std = friction_curve(joint_fit, effects, speed)
    steady = bool(fit.rows.steady[of_joint].any())
    return JointFrictionResult(
        joint=joint_fit.joint,
        name=data.joint_names[joint_fit.joint - 1],
        method="steady velocities" if steady else "weight and inertia modelled",
        n_readings=joint_fit.n_rows,
        n_speeds=joint_fit.n_speeds if steady else None,
        lowest_speed=low,
        highest_speed=high,
        rms=rms_of(fit.residual[of_joint]),
        noise=joint_fit.noise,
        reference_temperature=_known(fit.rows.first_temperature.get(joint_fit.joint)),
        between_directions=between_directions(data, fit, joint_fit.joint),
        curve=FittedCurve(velocity=speed, torque=torque, std=std),
        covariance=SymbolCovariance(symbols=list(joint_fit.free), matrix=joint_fit.covariance),
    )


def between_directions(data: MeasuredRuns, fit: FrictionFit, joint: int) -> BetweenDirections | None:
    """Return the torque common to both directions (weight, its zero, friction that differs by direction), N·m."""
    of_joint = (fit.rows.joint == joint) & fit.rows.steady
    if not of_joint.any():
        return None
    common = fit.nuisance + fit.residual
    shared = np.array(
        [_both_ways(fit, common, of_joint & (fit.rows.piece == piece)) for piece in np.unique(fit.rows.piece[of_joint])]
    )
    shared = shared[np.isfinite(shared)]
    if not shared.size:
        return None
    axis_is_plumb = not any(
        unknown.kind is UnknownKind.STRETCH and fit.rows.nuisance[of_joint, k].any()
        for k, unknown in enumerate(fit.rows.unknown)
    )
    return BetweenDirections(
        mean=float(shared.mean()),
        low=float(shared.min()),
        high=float(shared.max()),
        weight_possible=not axis_is_plumb,
    )


def _known(value: float | None) -> float | None:
    return None if value is None or math.isnan(value) else value


def _both_ways(fit: FrictionFit, common: Floats, chosen: Booleans) -> float:
    """Return the mean over both directions of a torque (k,) N·m in chosen rows; NaN where they moved one way only."""
    ways = [common[chosen & (fit.rows.velocity * way > 0.0)] for way in (1.0, -1.0)]
    return 0.5 * float(ways[0].mean() + ways[1].mean()) if all(way.size for way in ways) else math.nan


def bearing_frictions(fit: FrictionFit) -> list[BearingFriction]:
    """Return the friction of bearings that turn otherwise than a drive's shaft, as in a coupled wrist."""
    columns: dict[int, dict[UnknownKind, int]] = {}
    for k, unknown in enumerate(fit.rows.unknown):
        if unknown.kind in (UnknownKind.BEARING_COULOMB, UnknownKind.BEARING_VISCOUS):
            columns.setdefault(unknown.number, {})[unknown.kind] = k
    return [
        BearingFriction(
            joint=joint,
            coulomb=float(fit.unknowns[of[UnknownKind.BEARING_COULOMB]]),
            coulomb_std=float(fit.unknowns_std[of[UnknownKind.BEARING_COULOMB]]),
            viscous=float(fit.unknowns[of[UnknownKind.BEARING_VISCOUS]]),
            viscous_std=float(fit.unknowns_std[of[UnknownKind.BEARING_VISCOUS]]),
        )
        for joint, of in columns.items()
    ]


def friction_warnings(data: MeasuredRuns, fit: FrictionFit) -> list[str]:
    """Return the warnings on the numbers, as sentences."""
    texts = []
    for joint_fit in fit.joints:
        name = data.joint_names[joint_fit.joint - 1]
        shared = between_directions(data, fit, joint_fit.joint)
        of_joint = fit.rows.joint == joint_fit.joint
        if shared is not None and not shared.weight_possible:
            level, noise = abs(shared.mean), rms_of(fit.residual[of_joint])
            if level > 4.0 * noise / math.sqrt(of_joint.sum()) and level > 0.02 * rms_of(fit.friction[of_joint]):
                texts.append(
                    f"joint {name} carries no weight, but its drive needs {significant(2.0 * level)} N·m more in one "
                    "direction than in the other: friction depends on the direction, or the torque has a zero offset"
                )
        for parameter in joint_fit.parameters:
            if joint_fit.lacking.get(parameter.name) is MotionLack.SHAPE:
                texts.append(f"{parameter.name}: {MotionLack.SHAPE.sentence}")
            elif parameter.at_bound:
                texts.append(f"{parameter.name} is at the limit of its range")
        if any(p.value is not None and p.value <= 0.0 for p in joint_fit.parameters if p.spec.symbol == "coulomb"):
            texts.append(f"joint {name}: the torque opposes the motion; check the sign of torque or gear_ratio")
    if fit.reduced_chi2 is not None and fit.reduced_chi2 > 1.5:
        texts.append(
            f"friction: residuals are {significant(math.sqrt(fit.reduced_chi2), 2)} times the noise "
            f"of neighbouring samples: the "
            "model lacks an effect (stiffcal diagnose), and the uncertainties cover the noise only"
        )
    if fit.scaled:
        texts.append("friction: the noise is unknown; standard uncertainties are those of the residuals")
    return texts


def expected_words(fit: FrictionFit) -> str:
    """Return one sentence on how well friction is determined."""
    relative = rms_of(fit.residual) / max(rms_of(fit.friction), 1e-300)
    return (
        f"residual of the friction of a drive: {significant(rms_of(fit.residual))} N·m rms over the measured speeds, "
        f"{share(relative)} of it"
    )


def noise_of_fit(fit: FrictionFit) -> dict[str, float | None]:
    """Return the noise of the means of bins, N·m, over all joints; empty where that of a joint is not known."""
    noise_and_rows = [(joint_fit.noise, joint_fit.n_rows) for joint_fit in fit.joints]
    if not noise_and_rows or any(noise is None for noise, _ in noise_and_rows):
        return {}
    squares = sum((noise or 0.0) ** 2 * n for noise, n in noise_and_rows)
    return {"torque": math.sqrt(squares / sum(n for _, n in noise_and_rows))}


def rms_of(values: Floats) -> float:
    """Return the root of the mean square of (n,) values, 0 where there are none."""
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def error_slice(label: str, residual: Floats) -> ErrorSlice:
    """Return the error in a part of the readings, (n,) N·m."""
    return ErrorSlice(
        label=label,
        low=None,
        high=None,
        n=int(residual.size),
        rms=Rms(None, None, torque=rms_of(residual)),
        max=Rms(None, None, torque=float(np.abs(residual).max())),
    )


def fit_table(data: MeasuredRuns, fit: FrictionFit) -> pa.Table:
    """Return every row of the fit as a table."""
    from stiffcal.measurements.columns import table_of

    return table_of(friction_fit_columns(fit, data.joint_names))


def heldout_table(data: MeasuredRuns, rows: FrictionRows, residual: Floats) -> pa.Table:
    """Return a row for each equation, with the residual (k,) N·m of a fit without its speed."""
    from stiffcal.measurements.columns import table_of

    return table_of(heldout_columns(rows, residual, data.joint_names))


def heldout_columns(rows: FrictionRows, residual: Floats, joint_names: tuple[str, ...]) -> dict[str, Values]:
    """Return the columns of the table ``friction_heldout``."""
    return {
        "run": rows.run.tolist(),
        "joint": [joint_names[joint - 1] for joint in rows.joint],
        "velocity_radps": rows.velocity,
        "residual_Nm": residual,
    }


def part_of(rows: FrictionRows, part: PartFit) -> Floats:
    """Return (k,) N·m of the effects of a part that are no laws of velocity alone: ripple, temperature, load."""
    torque = np.zeros(len(rows))
    torque[np.isin(rows.joint, part.joints)] = part.other_than_velocity
    return torque


def friction_fit_columns(fit: FrictionFit, joint_names: tuple[str, ...]) -> dict[str, Values]:
    """Return columns: velocity, friction over velocity as measured (all else taken off) and as fitted, residual."""
    rows = fit.rows
    other = sum((part_of(rows, part) for part in fit.parts), np.zeros(len(rows)))
    return {
        "run": rows.run.tolist(),
        "joint": [joint_names[joint - 1] for joint in rows.joint],
        "steady": rows.steady,
        "velocity_radps": rows.velocity,
        "friction_measured_Nm": fit.friction_measured - other,
        "friction_Nm": fit.friction - other,
        "beside_Nm": fit.nuisance + other,
        "residual_Nm": fit.residual,
    }
