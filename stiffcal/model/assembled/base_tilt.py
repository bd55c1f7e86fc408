"""The direction of gravity in the axes of the base, known before any measurement to the tolerance of assembly.

Where the tracker stands is found together with the robot, so that joint 1's own tilt is part of its frame by convention
(`stiffcal.identification.fitting.gauge`): base axes are then those in which joint 1's axis is where the robot file has
it, and how they are turned against gravity no place of an unloaded robot shows. What sags does: by the sine of the tilt
times the sag. Where a tracker is levelled, gravity is known in its axes, and joint 1's tilt is a number of its own.

Of a robot whose first axis is vertical the tilt is left out: it loads every joint with the sine and cosine of joint 1's
angle, weight itself does not, so that over poses all around it moves no compliance.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.assembled.measured_frames import FRAME
from stiffcal.model.effect import Geometry, Inputs, ParameterRole, ParameterSpec, Place, Values

TOLERANCE = 5e-3
"""rad, standard uncertainty of gravity's direction in base axes: what assembly leaves at most of an axis."""
_AXES = "xyz"
_SOURCE = "installation of industrial robots: some tenths of a milliradian"


def _spec(axis: str) -> ParameterSpec:
    return ParameterSpec(
        f"r{axis}",
        "rad",
        f"turn of the base about {axis} relative to the direction of gravity in the robot file",
        -0.1,
        0.1,
        5e-4,
        _SOURCE,
        ParameterRole.SETUP,
        prior=TOLERANCE,
    )


class BaseTilt(Geometry):
    """The base is not turned against gravity as the robot file states.

    Law: gravity in base axes is Exp(−r) g, with g the robot file's and r the turn of the base; weight and payloads pull
    along it. Of the three components of r the one about the base axis nearest to gravity changes nothing and is left
    out. Each of the others is normally distributed about 0 with the tolerance of assembly, 5 mrad.
    """

    name = FRAME
    place_kind = "frames"
    summary = "turn of the base against gravity"
    parameters = tuple(_spec(axis) for axis in _AXES)

    def adjusted_chain(self, place: Place, chain: Chain, values: Values) -> Chain:
        """Turn gravity."""
        turn = _turn(values)
        return chain if turn is None else replace(chain, gravity=turn @ chain.gravity)

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Turn a payload's weight; what a sensor reads is what it reads."""
        turn = _turn(values)
        if turn is None or not inputs.setup.load_is_weight:
            return inputs
        wrench = inputs.wrench.copy()
        wrench[:3] = turn @ wrench[:3]
        return replace(inputs, wrench=wrench)


class _AboutYZ(BaseTilt):
    """Of a base whose x axis is nearest to gravity."""

    parameters = BaseTilt.parameters[1:]


class _AboutXZ(BaseTilt):
    """Of a base whose y axis is nearest to gravity."""

    parameters = BaseTilt.parameters[::2]


class _AboutXY(BaseTilt):
    """Of a base that stands or hangs upright."""

    parameters = BaseTilt.parameters[:2]


def _turn(values: Values) -> Floats | None:
    """Return (3, 3) base axes as the robot file has them to those turned, of a vector fixed to the ground; None: 1."""
    small = np.array([values.get(f"r{axis}", 0.0) for axis in _AXES])
    return rotation_from_vector(-small) if small.any() else None


def first_axis_vertical(chain: Chain) -> bool:
    """Return whether gravity is along joint 1's axis, within the tolerance of assembly; also where there is none."""
    across = np.cross(chain.fixed[0][:3, 2], chain.gravity)
    return float(np.linalg.norm(across)) <= TOLERANCE * float(np.linalg.norm(chain.gravity))


def placed_base_tilt(chain: Chain) -> PlacedEffect:
    """Return the direction of gravity as part of a model: ``frame.base.rx`` and so on."""
    effect = (_AboutYZ, _AboutXZ, _AboutXY)[int(np.argmax(np.abs(chain.gravity)))]
    return PlacedEffect(effect(), Place("frames", frame="base"))
