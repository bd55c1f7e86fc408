"""The form of a law that replaces others of its place: with which values its fit starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.derivatives.observation import rests
from stiffcal.identification.fitting.fit import Fit
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import NodeLoads, joint_node
from stiffcal.model.forms import same_joint, whole_form


def with_whole_form(states: LoadStates, fit: Fit, law: PlacedEffect) -> CompliantRobot | None:
    """Return a fitted model with the whole form of one of its laws in place of what that form includes.

    Parameters
    ----------
    states : that are searched.
    fit : of a model that holds the candidate.
    law : a law of this model, at a joint.

    Returns
    -------
    CompliantRobot
        None where the law has no such form in these states, or holds it already.
    """
    robot, place, effect = fit.robot, law.place, law.effect
    form = whole_form(effect, robot.chain, states)
    if form is None:
        return None
    whole = same_joint(effect, form)
    if whole.parameters == effect.parameters:
        return None
    names = (effect.name, *whole.includes)
    replaced = [placed for placed in robot.placed if placed.place == place and placed.effect.name in names]
    loaded, _ = rests(robot, fit.data)
    loads = NodeLoads(loaded.wrench, loaded.inputs.angles, fit.data.order, loaded.weight)
    covariate = law.covariate(robot.chain, loads)
    if covariate is None:
        return None
    turn = _turn(robot.chain, loads, replaced)
    values = form.start(covariate.value, turn)
    kept = tuple(placed for placed in robot.placed if placed not in replaced)
    return replace(robot, placed=(*kept, PlacedEffect(whole, place, values)))


def _turn(chain: Chain, loads: NodeLoads, placed_effects: list[PlacedEffect]) -> Floats:
    """Return (n,) by how much laws at one joint let it turn, rad."""
    turn = np.zeros(loads.wrench.shape[-1])
    for placed in placed_effects:
        joint = placed.place.joints[0]
        for term in placed.terms(chain, loads):
            if (term.node, term.component) == (joint_node(joint), chain.drive_components[joint - 1]):
                turn += placed.amplitude(term.symbol) * term.value
    return turn
