"""A bending swing and a tilting bearing look alike at the tool; rods on the swing tell them apart (paper 000)."""

from __future__ import annotations

import pytest

from stiffcal.judgement.diagnosed import DiagnosedStates, diagnose_states
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from tests.laboratory.named_effects import named_with_alike
from tests.laboratory.robots import SIX_STIFFNESS
from tests.laboratory.rod_states import (
    bending_swing,
    five_rods,
    six_axes_with_beams,
    tilting_bearing,
    with_effect,
    with_rods,
)
from tests.laboratory.simulated_states import joint_springs, played

pytestmark = pytest.mark.long

SWING = ("link-beam swing", "link-springs swing")
TILT = "bearing-tilt j2"
HIDDEN = {
    "swing": bending_swing(EI2=4e6, EI3=6e6, GJ=3e6, EA=1.5e9),
    "bearing": tilting_bearing(x=1.2e-7, y=1.2e-7),
}


def diagnosed(states: LoadStates, model: CompliantRobot) -> DiagnosedStates:
    """Diagnose with what bends and tilts."""
    kinds = ("joint-compliance", "bearing-tilt", "link-beam", "link-springs")
    return diagnose_states(states, model, {name: find_effects()[name] for name in kinds})


@pytest.mark.parametrize("hidden", HIDDEN.values(), ids=HIDDEN)
def test_rods_distinguish_the_swing_from_the_bearing(hidden: PlacedEffect) -> None:
    chain = six_axes_with_beams()
    robot = with_effect(joint_springs(chain, SIX_STIFFNESS), hidden)
    tool_alone = played(robot, runs=6, noise=Sigma(translation=20e-6, rotation=30e-6), full_pose=False, seed=2)
    # from the tool alone: one of what looks alike is certain, whichever of the two it is
    undecided = diagnosed(tool_alone, joint_springs(chain))
    (names,) = named_with_alike(undecided)
    assert {SWING[0], TILT} <= names
    assert undecided.found[0].group.probability > 0.99
    assert not undecided.found[0].group.firm
    distinguished = diagnosed(with_rods(tool_alone, robot, five_rods(chain)), joint_springs(chain))
    assert not distinguished.unexplained
    (reported,) = named_with_alike(distinguished)
    if hidden is HIDDEN["swing"]:
        assert reported <= set(SWING)
    else:
        assert TILT in reported
        assert not reported & set(SWING)
