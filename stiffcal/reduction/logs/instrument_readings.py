"""Readings of an instrument in SI and in its own axes, from columns of its log."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.signals.displacement_signals import WITHOUT_UNIT
from stiffcal.campaign.signals.signals import Deflection, Displacement, JointSignals, Pose, Wrench
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.rotations import rotation_from_rpy, rotation_from_vector
from stiffcal.quaternions import quaternion_from_rotation


def instrument_readings(
    source: Source, numbers: Mapping[str, Floats], name: str = "", metres_of_rods: Mapping[str, float] | None = None
) -> dict[str, Floats]:
    """Return the signals of a source in SI, channels first, from its columns by name.

    Parameters
    ----------
    source : what the manifest states. numbers : columns as logged. name : the source's.
    metres_of_rods : metres of a unit of each rod's reading; needed where the source logs rods.
    """
    readings: dict[str, Floats] = {}

    def block(columns: tuple[str, ...], factor: float = 1.0, offset: float = 0.0) -> Floats:
        values = np.stack([numbers[column] for column in columns])
        if factor != 1.0:
            values *= factor
        return values + offset if offset else values

    if source.joints is not None:
        readings |= _joint_readings(source.joints, block)
    if source.wrench is not None:
        readings["wrench"] = _wrench_readings(source.wrench, block)
    if source.dead_weight is not None:
        weight = source.dead_weight
        readings["mass"] = block((weight.mass_column,), weight.unit_of("mass").factor)
    for body, pose in source.body_poses().items():
        readings |= _pose_readings(body, pose, block)
    if source.deflection is not None:
        readings |= _deflection_readings(source.deflection, block)
    if source.displacement is not None:
        gauge: Displacement = source.displacement
        readings[f"displacement.{name}"] = block((gauge.column,), gauge.unit_of("length").factor)
    if source.lengths is not None:
        metres = metres_of_rods or {}
        readings |= {f"lengths.{rod}": block((rod,), metres[rod]) for rod in source.lengths.columns}
    if source.temperature is not None:
        kelvin = source.temperature.unit_of("temperature")
        readings["temperature"] = block(source.temperature.columns, kelvin.factor, kelvin.offset)
    if source.hold is not None:
        readings["hold"] = block((source.hold.column,), source.hold.unit_of("time").factor)
    return readings


Block = Callable[..., Floats]


def _joint_readings(joints: JointSignals, block: Block) -> dict[str, Floats]:
    keys = {"position": "joints", "command": "joints.command", "velocity": "joints.velocity", "torque": "joints.torque"}
    readings = {}
    for key, columns in joints.groups().items():
        name = keys.get(key, f"joints.{key}")
        if key in ("position", "command"):
            units = joints.position_units(len(columns))
            readings[name] = np.concatenate(
                [block((column,), u.factor) for column, u in zip(columns, units, strict=True)]
            )
        else:
            readings[name] = block(columns, 1.0 if key == "approach" else joints.unit_of(key).factor)
    if joints.torque_constant is not None and "joints.current" in readings and "joints.torque" not in readings:
        constant = np.array(joints.torque_constant)
        readings["joints.torque"] = readings["joints.current"] * constant[:, None]
    return readings


def _wrench_readings(wrench: Wrench, block: Block) -> Floats:
    """Return (6, n) as it acts on the robot; moments are zero where only a force is measured."""
    force = block(wrench.columns[: min(len(wrench.columns), 3)], wrench.unit_of("force").factor)
    if len(wrench.columns) == 1:
        direction = np.array(wrench.direction if wrench.direction is not None else (np.nan,) * 3)
        force = (direction / np.linalg.norm(direction))[:, None] * force
    moment = (
        block(wrench.columns[3:], wrench.unit_of("moment").factor) if wrench.moments_measured else np.zeros_like(force)
    )
    components = np.concatenate([force, moment])
    return -components if wrench.acts_on == "environment" else components


def _pose_readings(body: str, pose: Pose, block: Block) -> dict[str, Floats]:
    length = pose.unit_of("position").factor
    readings: dict[str, Floats] = {}
    if pose.position is not None:
        readings[f"position.{body}"] = block(pose.position, length)
    for name, marker in pose.markers.items():
        readings[f"marker.{body}.{name}"] = block(marker.columns, length)
    if pose.orientation is not None:
        kind, columns = pose.orientation
        values = block(columns, 1.0 if kind in WITHOUT_UNIT else pose.unit_of("rotation").factor)
        readings[f"quaternion.{body}"] = _quaternion(kind, values)
    turn = 1.0 if pose.orientation is None or pose.orientation[0] in WITHOUT_UNIT else pose.unit_of("rotation").factor
    factor_of = {"position": length, "rotation": turn}
    coverage = pose.sigma.coverage if pose.sigma is not None else 1.0
    for quantity, columns in pose.sigma_columns().items():
        readings[f"sigma.{quantity}.{body}"] = block(columns, factor_of[quantity] / coverage)
    if pose.sigma is not None and pose.sigma.per_metre is not None:
        name = f"sigma.position.{body}"
        near = pose.sigma.position if isinstance(pose.sigma.position, float) else 0.0
        distance = np.linalg.norm(readings[f"position.{body}"], axis=0, keepdims=True)
        readings[name] = readings.get(name, near * length) + pose.sigma.per_metre * length * distance
    return readings


_MATRIX_DIGITS = 0.02
"""Of elements written with two decimals the products are off by less."""


def _quaternion(kind: str, values: Floats) -> Floats:
    if kind == "quaternion_wxyz":
        return values
    if kind == "matrix":
        rotation = values.T.reshape(-1, 3, 3)
        off = np.abs(rotation @ rotation.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2), initial=0.0)
        if np.any(off > _MATRIX_DIGITS):
            row = int(np.nanargmax(off))
            reason = f"nine columns are no rotation matrix (first in row {row + 1} near here)"
            mend = "list its elements row by row, or leave the orientation out"
            raise InputError.at(FaultCode.READING_IMPLAUSIBLE, "campaign.toml", "pose.matrix", reason, mend)
    else:
        rotation = rotation_from_vector(values.T) if kind == "rotvec" else rotation_from_rpy(values.T)
    return np.ascontiguousarray(quaternion_from_rotation(rotation).T)


def _deflection_readings(deflection: Deflection, block: Block) -> dict[str, Floats]:
    readings = {"translation": block(deflection.translation, deflection.unit_of("translation").factor)}
    if deflection.rotation is not None:
        readings["rotation"] = block(deflection.rotation, deflection.unit_of("rotation").factor)
    coverage = deflection.sigma.coverage if deflection.sigma is not None else 1.0
    for quantity, columns in deflection.sigma_columns().items():
        name = "position" if quantity == "translation" else quantity
        readings[f"sigma.{name}.{deflection.body}"] = block(columns, deflection.unit_of(quantity).factor / coverage)
    return readings
