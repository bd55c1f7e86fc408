"""Torque that swings with the joint's angle."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import Covariate, ParameterRole, ParameterSpec, Place, Values
from stiffcal.model.motion import Motion

_SOURCE = "a few per cent of a drive's Coulomb friction of 50 N·m: cogging of the motor, meshing of the gear"
# A wave needs this many samples, at the median distance of samples; finer ones are not tried.
SAMPLES_PER_WAVE = 4.0
# Beyond it, orders must be named in robot.toml: each order that is tried costs evidence.
MOST_INTEGERS = 200


class TorqueRipple(Motion):
    """The torque of a moving drive varies periodically with its angle, independent of the direction of motion.

    Law: τ_f += a cos mq + b sin mq, with q the joint's angle as the controller shows it, m the order: waves per turn
    of the joint (ripple of motor and gear, "position-dependent friction" in Armstrong-Hélouvry, Dupont and Canudas de
    Wit 1994). Orders that are tried: the gear orders in robot.toml, and the integers of which the travel holds one
    wave at least and the log four samples a wave.

    Assumes that the ripple depends neither on speed nor on load, which is nearly true for cogging and for the torque
    ripple of the motor current; friction that varies with the angle changes its sign with the direction and is not
    included.

    Limits: over a short travel neighbouring orders cannot be distinguished: the travel must contain several waves.
    Weight whose torque is not in the model has order 1 as well.
    """

    name = "torque-ripple"
    summary = "the drive torque varies periodically with the joint angle, the same in both directions"
    parameters = (
        ParameterSpec("a", "N·m", "cosine part of the ripple", -1e5, 1e5, 2.0, _SOURCE),
        ParameterSpec("b", "N·m", "sine part of the ripple", -1e5, 1e5, 2.0, _SOURCE),
        ParameterSpec(
            "order", "1", "waves per revolution of the joint", 1.0, 1e4, 12.0,
            "pole pairs, teeth and rollers per revolution of the joint: the gear orders in robot.toml, else integers",
            ParameterRole.NONLINEAR, discrete=True,
        ),
    )  # fmt: skip
    needs = ("friction runs: angles, and travel over one wave at least",)
    looks_like = ("friction-load",)
    fingerprint = (
        "torque over angle shows the same periodic pattern in every pass, at every speed and in both directions"
    )
    how_to_check = (
        "Move slowly over a long travel in both directions and plot torque over angle: the pattern stays "
        "at the same angles."
    )

    def lacking_motion(self, chain: Chain, motion: DriveMotion) -> str | None:
        """Travel that holds a wave."""
        orders = [order for of_joint in chain.gear_orders for order in of_joint]
        finest = max([*orders, MOST_INTEGERS])
        if not np.isfinite(motion.angle).any() or finest * _travel(motion) < 2.0 * np.pi:
            return "angles of the joint over more travel: the travel is shorter than one wave"
        return None

    def motion_columns(self, place: Place, chain: Chain, motion: DriveMotion, shape: Values) -> dict[str, Floats]:
        """Cos mq and sin mq."""
        phase = shape["order"] * motion.angle
        return {"a": np.cos(phase), "b": np.sin(phase)}

    def motion_grid(self, place: Place, chain: Chain, motion: DriveMotion) -> dict[str, Floats]:
        """Gear orders of the joint, and integers: those of which a whole wave lies within the travel."""
        travel = _travel(motion)
        if not travel > 0.0:
            return {"order": np.zeros(0)}
        integers = np.arange(1, min(MOST_INTEGERS, _finest(motion)) + 1)
        orders = np.union1d(integers, np.array(chain.gear_orders[place.joints[0] - 1], dtype=np.int64))
        return {"order": orders[orders * travel >= 2.0 * np.pi].astype(np.float64)}

    def motion_covariate(self, place: Place, chain: Chain, motion: DriveMotion) -> Covariate:
        """The joint's angle."""
        return Covariate("angle of the joint", "rad", np.nan_to_num(motion.angle))


def _travel(motion: DriveMotion) -> float:
    """Return the range of angles, rad."""
    known = motion.angle[np.isfinite(motion.angle)]
    return float(np.ptp(known)) if known.size else 0.0


def _finest(motion: DriveMotion) -> int:
    """Return the highest order of which half of the samples give enough a wave."""
    step = np.abs(np.diff(motion.angle))
    step = step[step > 0.0]
    return int(2.0 * np.pi / (SAMPLES_PER_WAVE * float(np.median(step)))) if step.size else 0
