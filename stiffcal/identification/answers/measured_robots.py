"""Joint stiffnesses measured on robots, and whether a fit's are of their size: a hint at units of a whole campaign.

A campaign whose forces are all in kgf instead of N agrees with itself; only the size of its stiffnesses is off. What
a robot of given reach has varies by more than such a factor, so that this is a warning and never a fault: it is given
where two or more joints lie a factor of two or more outside what has been measured, all on the same side.

The torque on a joint grows with the payload times the reach, the stiffness that keeps the tool's deflection a given
share of the reach with that torque; payloads of one class of robots grow with the square of the reach. Stiffness is
therefore compared after division by the cube of the reach, and only with robots of a similar one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.fitting.fit import Fit
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import RZ
from stiffcal.wording import significant

KGF = 9.80665  # N, third General Conference on Weights and Measures (1901)
MM_PER_INCH = 25.4


@dataclass(frozen=True)
class MeasuredRobot:
    """A robot on which the stiffness of the drives was measured."""

    name: str
    """Maker and type."""
    reach_m: float
    """From joint 2 to the flange along the links, as `reach_of` gives it for the robot files bundled here."""
    stiffness: tuple[float | None, ...]
    """Of each joint's drive, base to wrist, N·m/rad; None where the source has no plausible number."""
    source: str
    """Where it was published."""


MEASURED = (
    MeasuredRobot(
        "ABB IRB 4400/60", 2.12, (731.82e3, 488.31e3, 428.61e3, 59.52e3, 56.87e3, 16.55e3),
        "Wang, Zhang and Fuhlbrigge, IROS 2009, section III.C",
    ),
    MeasuredRobot(
        "FANUC R-2000iC", 2.90, (8.6158e5, 2.8560e6, 1.8483e6, 2.7935e5, 4.1867e5, 2.7772e5),
        "published with the measurements of campaigns/fanuc-r2000ic, see its README",
    ),
    MeasuredRobot(
        # gear 6 is printed as 3.8e8, three hundred times its neighbours: campaigns/kr240/README.md
        "KUKA KR 240", 2.93, (5.4e6, 8.7e6, 5.2e6, 1.0e6, 1.2e6, None),
        "after Rösch: tensile tests with a scanning vibrometer",
    ),
)  # fmt: skip
# Robots of up to this ratio of reach are compared: those above, their neighbours up to 4.4 m, down to 1.4 m.
LIKE_REACH = 1.5
LEAST_ROBOTS = 2
OUTSIDE = 2.0
LEAST_JOINTS = 2
WELL_KNOWN = 0.3  # standard uncertainty over value

UNITS: tuple[tuple[float, str], ...] = (
    (KGF, "forces in kgf in a column of N"),
    (1.0 / KGF, "forces in N in a column of kgf"),
    (1.0 / MM_PER_INCH, "displacements in inches in a column of mm"),
    (MM_PER_INCH, "displacements in mm in a column of inches"),
)
"""What a stiffness is to be multiplied by where a campaign has this mistake throughout, and its words. All that fit are
named, as these factors differ by less than robots do. Pounds (4.4 N) are not among them: that much robots differ
themselves, and only a known weight shows them (`stiffcal.mistakes.known_weights`).
"""


def reach_of(chain: Chain) -> float:
    """Return the distances between successive joint frames from joint 1 to the flange, summed, m."""
    between = np.linalg.norm(chain.fixed[1:, :3, 3], axis=1).sum()
    return float(between + np.linalg.norm(chain.flange[:3, 3]))


def measured_ranges(reach: float) -> Floats:
    """Return (6, 2) the least and largest stiffness measured at each joint, scaled to a reach, N·m/rad.

    NaN where fewer than two of the robots are of a similar reach.
    """
    ranges = np.full((6, 2), np.nan)
    near = [robot for robot in MEASURED if max(robot.reach_m / reach, reach / robot.reach_m) <= LIKE_REACH]
    for joint in range(6):
        values = [
            stiffness * (reach / robot.reach_m) ** 3
            for robot in near
            if (stiffness := robot.stiffness[joint]) is not None
        ]
        if len(values) >= LEAST_ROBOTS:
            ranges[joint] = min(values), max(values)
    return ranges


@dataclass(frozen=True)
class UnusualStiffness:
    """Joints whose stiffness is not of the size that has been measured."""

    factors: Mapping[int, float]
    """By the joint's number from 1: how far outside, above 1 too stiff, below 1 too soft."""
    units: tuple[str, ...]
    """Mistakes of a whole campaign's units that would bring all known joints back into the ranges."""


def unusual_stiffness(reach: float, stiffness: Mapping[int, float]) -> UnusualStiffness | None:
    """Return what lies outside the measured ranges; None where fewer than two joints do, or not on the same side.

    Parameters
    ----------
    reach : as `reach_of` gives it, m. stiffness : N·m/rad by the number of the joint of a six-axis robot, from 1.
    """
    ranges = measured_ranges(reach)

    def outside(scale: float) -> dict[int, float]:
        found = {}
        for joint, value in stiffness.items():
            low, high = ranges[joint - 1]
            if scale * value < low / OUTSIDE:
                found[joint] = scale * value / low
            elif scale * value > high * OUTSIDE:
                found[joint] = scale * value / high
        return found

    factors = outside(1.0)
    same_side = all((first > 1.0) == (second > 1.0) for first, second in pairwise(factors.values()))
    if len(factors) < LEAST_JOINTS or not same_side:
        return None
    return UnusualStiffness(factors, tuple(words for scale, words in UNITS if not outside(scale)))


def unusual_stiffness_warnings(fit: Fit) -> list[str]:
    """Return a warning where the drives of a fitted six-axis robot are far from what such robots have; else nothing."""
    chain = fit.robot.chain
    if chain.n_joints != 6 or chain.prismatic_joints:
        return []
    known: dict[int, float] = {}
    for parameter in fit.parameters:
        drive = parameter.spec.compliance and parameter.spec.along == RZ and len(parameter.place.joints) == 1
        if drive and parameter.value and parameter.std and parameter.std < WELL_KNOWN * parameter.value:
            known[parameter.place.joints[0]] = 1.0 / parameter.value
    reach = reach_of(chain)
    unusual = unusual_stiffness(reach, known)
    return [] if unusual is None else [_sentence(unusual, chain.joint_names, reach)]


def _sentence(unusual: UnusualStiffness, names: Sequence[str], reach: float) -> str:
    ratios = [max(factor, 1.0 / factor) for factor in unusual.factors.values()]
    side = "above" if next(iter(unusual.factors.values())) > 1.0 else "below"
    joints = ", ".join(names[joint - 1] for joint in unusual.factors)
    units = f" (possible: {' or '.join(unusual.units)})" if unusual.units else ""
    return (
        f"the stiffness of {joints} is {significant(min(ratios), 2)} to {significant(max(ratios), 2)} "
        f"times {side} values measured on robots "
        f"of this reach ({significant(reach, 2)} m): check the units of force and displacement of the "
        f"whole campaign{units}; lbf "
        "cannot be detected in this way: use known masses and log them as dead_weight together with the force"
    )
