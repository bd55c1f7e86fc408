"""What an effect that moves masses does: the torque of weight on a joint, over the joint's angle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.model.balance.deformed_chain import deformed_chain, node_wrenches
from stiffcal.model.effect import RZ, Effect, Inputs, joint_node
from stiffcal.model.laws.link_moments import LinkMoments
from stiffcal.report.content import EffectPicture

# Links of the example's lever, and gravity across its axes.
LINK_MASS = 60.0
GRAVITY = (0.0, -9.81, 0.0)
# The effect is drawn at this multiple of its usual size.
ENLARGED = 20.0


def weight_picture(effect: Effect, chain: Chain, setup: MeasurementSetup, caption: str) -> EffectPicture | None:
    """Return the torque of weight on joint 1 of the lever, in N·m over its angle in degrees.

    Parameters
    ----------
    effect : of the catalogue, or the user's own.
    chain : the lever without masses. setup : where force and target sit on it.
    caption : of the picture.

    Returns
    -------
    None for an effect that moves no masses, or has no place on the lever.
    """
    if not isinstance(effect, LinkMoments):
        return None
    centres = np.zeros((2, 3))
    centres[:, 0] = 0.4
    heavy = replace(chain, link_mass=np.full(2, LINK_MASS), link_com=centres, gravity=np.array(GRAVITY))
    places = effect.places(heavy)
    if not places:
        return None
    values = {spec.symbol: ENLARGED * spec.typical for spec in effect.parameters}
    angle = np.linspace(-np.pi, np.pi, 73)
    inputs = Inputs(np.stack([angle, np.full_like(angle, np.pi / 5.0)]), np.zeros((6, len(angle))), setup)
    without, with_it = (
        node_wrenches(robot, deformed_chain(robot, inputs.angles, None), inputs)[joint_node(1), RZ]
        for robot in (heavy, effect.adjusted_chain(places[0], heavy, values))
    )
    return EffectPicture(
        effect.name, "angle of joint 1 [°]", "torque of weight on joint 1 [N·m]", np.degrees(angle),
        without, with_it, np.zeros(len(angle), dtype=np.bool_), caption,
    )  # fmt: skip
