"""What a manifest must say, and cannot have, where the robot has prismatic joints."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from stiffcal.campaign.found.experiment_kinds import reads
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.signals.signals import JointSignals
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault, InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode


def prismatic_faults(manifest: Manifest, joint_names: Sequence[str], prismatic: frozenset[str]) -> Iterator[Fault]:
    """Check units of joint columns against the kinds of the joints, and what prismatic joints rule out.

    Parameters
    ----------
    joint_names : of the robot, base to wrist. prismatic : those that move along their axis.
    """
    for source, name, signal in manifest.signals():
        if isinstance(signal, JointSignals):
            yield from _unit_faults(signal, f"sources.{source}.{name}", joint_names, prismatic)
            if prismatic:
                yield from _key_faults(signal, f"sources.{source}.{name}", prismatic)
    for number, run in enumerate(manifest.runs):
        if prismatic and reads(run.experiment, "moved_joint"):
            yield Fault(
                FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"runs[{number + 1}] ({run.id}).experiment",
                f"{run.experiment} runs measure torque over angle, and {', '.join(sorted(prismatic))} is prismatic",
                "describe the revolute joints of the bench alone in a campaign of its own",
            )  # fmt: skip


def _unit_faults(
    signal: JointSignals, place: str, joint_names: Sequence[str], prismatic: frozenset[str]
) -> Iterator[Fault]:
    count = len(joint_names)
    columns = signal.position or signal.command
    stated = signal.units.position
    if isinstance(stated, tuple) and len(stated) != count:
        reason, mend = f"{len(stated)} units for {count} joints", "write one, or one per joint"
        yield Fault(FaultCode.JOINT_COUNT, MANIFEST_FILE, f"{place}.units.position", reason, mend)
        return
    if columns is None or len(columns) != count:
        return
    units = signal.position_units(count)
    for joint, unit in zip(joint_names, units, strict=True):
        if (unit.quantity == "length") != (joint in prismatic):
            units_of_columns = {"position": ["mm" if name in prismatic else "deg" for name in joint_names]}
            kind = "prismatic" if joint in prismatic else "revolute"
            yield Fault(
                FaultCode.UNIT_CONFLICT, MANIFEST_FILE, f"{place}.units.position",
                f'{joint} is {kind}, and its column is read in "{unit.name}"',
                f"write the unit of each column: {toml_text.pair('units', units_of_columns)}",
            )  # fmt: skip
            return


def _key_faults(signal: JointSignals, place: str, prismatic: frozenset[str]) -> Iterator[Fault]:
    names = ", ".join(sorted(prismatic))
    if signal.motor:
        reason = f"{names} is prismatic, and motor-side logs are turns"
        mend = "log the joints' positions, and remove motor"
        yield Fault(FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"{place}.motor", reason, mend)
    if signal.torque_gain_sigma is not None:
        reason = f"{names} is prismatic: its motor holds a force, and these columns are torques"
        mend = "remove torque_gain_sigma"
        yield Fault(FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"{place}.torque_gain_sigma", reason, mend)


def refuse_prismatic(prismatic: Collection[str], reason: str, mend: str) -> None:
    """Raise where a robot has prismatic joints, for what is not made for them.

    Parameters
    ----------
    prismatic : names of the robot's prismatic joints. reason, mend : of the fault.

    Raises
    ------
    InputError : there is one.
    """
    if prismatic:
        place = f"joints ({', '.join(sorted(prismatic))}).type"
        raise InputError.at(FaultCode.VALUE_INVALID, "robot.toml", place, reason, mend)
