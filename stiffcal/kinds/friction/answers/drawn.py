"""Friction runs as rows that the page for a browser draws: torque of each bin or sample, and each effect's part."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.kinds.drawn_rows import DrawnPart, DrawnRows, DrawnVariable
from stiffcal.kinds.friction.answers.curves import FRICTION_FIT, FRICTION_HELDOUT
from stiffcal.kinds.friction.answers.parts import friction_readings, friction_rows, heldout_runs
from stiffcal.kinds.friction.fitting.row_columns import RowColumns
from stiffcal.kinds.measured import MeasuredRuns
from stiffcal.kinds.results import IdentifiedModel
from stiffcal.measurements.columns import values_of
from stiffcal.model.catalogue.campaign_effects import moving_effects
from stiffcal.model.motion import Motion

if TYPE_CHECKING:
    from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows
    from stiffcal.model.effect import Effect

DEGREES = 180.0 / np.pi
WAYS = ["backward", "forward"]


def drawn_friction(data: MeasuredRuns, identified: IdentifiedModel) -> DrawnRows | None:
    """Return the rows of all friction runs; None where no effect of the model shows in them.

    Parameters
    ----------
    data : the campaign with the tables of logs and of the fit.
    identified : the result of ``identify``.
    """
    rows, placed = friction_rows(data), moving_effects(data.campaign)
    if rows is None or FRICTION_FIT not in data.tables:
        return None
    judged: Booleans = np.isin(rows.joint, [effect.place.joints[0] for effect in placed])
    fitted = judged & ~heldout_runs(data, rows)
    if not fitted.any():
        return None
    table = data.tables[FRICTION_FIT]
    measured = np.full(len(rows), np.nan)
    # what friction is to explain: the torque without weight, inertia and zeros as fitted
    measured[fitted] = values_of(table.column("friction_measured_Nm"))
    other_torque = np.zeros(len(rows))
    parts = _parts(data, identified, rows)
    velocity_alone = values_of(table.column("friction_Nm"))
    other_torque[fitted] = sum((part.values for part in parts), np.zeros(len(rows)))[fitted] - velocity_alone
    return DrawnRows(
        run=rows.run, measured=measured + other_torque, fitted=fitted, judged=judged, fit_table=FRICTION_FIT,
        heldout_table=FRICTION_HELDOUT, residual="residual_Nm", direction="direction",
        variables=_variables(data, rows), parts=parts, readings=_readings(data, rows),
    )  # fmt: skip


def driver_of_rows(data: MeasuredRuns, effect: Effect, joint: int) -> DrawnVariable | None:
    """Return what an effect at a joint follows over the rows; None where it is none of moving joints."""
    from stiffcal.kinds.friction.answers.evidence import driver_of

    rows, chain = friction_rows(data), data.campaign.chain
    if rows is None or not isinstance(effect, Motion) or not (rows.joint == joint).any():
        return None
    place = next(place for place in effect.places(chain) if place.joints == (joint,))
    return driver_of(rows, chain, effect, place)


def _parts(data: MeasuredRuns, identified: IdentifiedModel, rows: FrictionRows) -> list[DrawnPart]:
    """Return the torque of each effect with the values of the fit."""
    values = {entry.name: entry.value for entry in identified.parameters if entry.value is not None}
    made, parts = RowColumns(rows, data.campaign.chain), []
    for effect in moving_effects(data.campaign):
        joint = effect.place.joints[0]
        if not (rows.joint == joint).any():
            continue
        shape = {symbol: values.get(effect.parameter_name(symbol), usual) for symbol, usual in effect.shape().items()}
        torque = np.zeros(len(rows))
        for symbol, column in made.of(effect.effect, effect.place, shape).items():
            torque += values.get(effect.parameter_name(symbol), 0.0) * column
        parts.append(DrawnPart(f"{effect.effect.name} {effect.place.label}", joint, torque))
    return parts


def _variables(data: MeasuredRuns, rows: FrictionRows) -> list[DrawnVariable]:
    """Return what a residual may follow, as far as it was logged and varies."""
    motion = rows.motion
    numbers = [
        DrawnVariable("velocity", "velocity of the drive, at the joint's side", "rad/s", rows.velocity),
        DrawnVariable("speed", "logarithm (base 10) of speed in rad/s", "", np.log10(np.abs(rows.velocity) + 1e-12)),
        DrawnVariable("torque", "measured torque", "N·m", rows.torque),
        DrawnVariable("angle", "angle of the joint", "°", DEGREES * rows.means(motion.angle)),
        DrawnVariable("load", "torque of the weight", "N·m", rows.means(motion.load)),
        DrawnVariable("temperature", "temperature above the first one", "K", rows.means(motion.temperature)),
        DrawnVariable("time", "time since the joint's first sample", "s", rows.means(motion.time)),
        DrawnVariable("travel", "travel since the last reversal", "°", DEGREES * rows.means(motion.travel)),
    ]
    variables = [
        entry
        for entry in numbers
        if np.isfinite(entry.values).any() and np.nanmax(entry.values) > np.nanmin(entry.values)
    ]
    forward = (rows.velocity > 0.0).astype(np.float64)
    variables.append(DrawnVariable("direction", "direction of motion", "", forward, WAYS))
    joints = np.unique(rows.joint)
    if len(joints) > 1:
        number = np.searchsorted(joints, rows.joint).astype(np.float64)
        names = [data.joint_names[joint - 1] for joint in joints.tolist()]
        variables.append(DrawnVariable("joint", "joint", "", number, names))
    return variables


def _readings(data: MeasuredRuns, rows: FrictionRows) -> dict[str, Floats]:
    """Return what each row was made of: the pass's stretch of the log's clock, and the means of its samples."""
    motion = rows.motion
    found = {
        "joint": rows.joint.astype(np.float64),
        "velocity_radps": rows.velocity,
        "torque_Nm": rows.torque,
        "torque_sigma_Nm": rows.sigma,
        "angle_rad": rows.means(motion.angle),
        "weight_Nm": rows.means(motion.load),
        "time_s": rows.means(motion.time),
        "samples": np.bincount(rows.row, minlength=len(rows)).astype(np.float64),
    }
    passes = friction_readings(data)[0]
    if passes is not None and rows.steady.all():
        found["pass_start_s"], found["pass_end_s"] = passes.start[rows.source], passes.end[rows.source]
    return found
