"""How soft a robot is before any reading: springs count, by themselves or in a curve that holds one."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.effects.cubic_stiffness import CubicStiffness
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.judgement.numbers import BEND, EXPECTED_EFFECTS, TYPICAL_COMPLIANCE, TYPICAL_TORQUE, UNLISTED
from stiffcal.judgement.priors import MemberKind, RobotScale, Share, log_odds
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import NodeLoads, Place
from stiffcal.model.forms import form_of
from tests.laboratory.effect_bench import robot_chain

CHAIN = robot_chain()
STIFF, SOFT = 4e5, 1.5e3
TORQUE = 20.0
CURVE = form_of(CubicStiffness(), {"p1", "p2", "p3"})


def scale_of(*placed: PlacedEffect) -> RobotScale:
    wrench = np.zeros((2 * CHAIN.n_joints + 2, 6, 3))
    wrench[:, 5] = TORQUE
    return RobotScale.of(CompliantRobot(CHAIN, placed), NodeLoads(wrench, np.zeros((CHAIN.n_joints, 3))))


def spring(joint: int, rigidity: float) -> PlacedEffect:
    return PlacedEffect(JointCompliance(), Place("joints", (joint,)), {"c": 1.0 / rigidity})


def curve(joint: int, rigidity: float) -> PlacedEffect:
    return PlacedEffect(CURVE, Place("joints", (joint,)), {"p1": rigidity, "p2": 0.0, "p3": 0.0})


def test_a_curve_that_holds_the_spring_counts_as_the_spring() -> None:
    springs, curves = (scale_of(one(1, STIFF), one(4, SOFT)) for one in (spring, curve))
    np.testing.assert_allclose(curves.of_joint, springs.of_joint)
    assert curves.compliance == pytest.approx(springs.compliance)
    assert springs.compliance == pytest.approx(1.0 / np.sqrt(STIFF * SOFT) / TYPICAL_COMPLIANCE)
    # what has no spring is as soft as all
    assert springs.of_joint[1] == pytest.approx(springs.compliance)


@pytest.mark.parametrize(("joint", "rigidity"), [(1, STIFF), (4, SOFT)])
def test_a_curve_bends_as_much_as_its_own_spring_gives(joint: int, rigidity: float) -> None:
    """At the largest torque its quadratic term is a share of the spring's, however soft other joints are."""
    scale = scale_of(curve(1, STIFF), curve(4, SOFT))
    place = Place("joints", (joint,))
    angle = TORQUE / rigidity
    torque = scale.torque[joint - 1] * TYPICAL_TORQUE
    assert torque == pytest.approx(TORQUE)
    assert scale.typical(CURVE, place, "p2") * angle**2 == pytest.approx(BEND * torque)
    assert scale.typical(CURVE, place, "p3") * angle**3 == pytest.approx(BEND * torque)


def test_a_form_or_a_family_more_moves_no_other_place() -> None:
    """Place first, family second, form third: what is added takes its share of the next larger one alone."""

    def expected(*families: str) -> tuple[dict[str, float], float]:
        """Return what is expected of each family at joint 1, and at joint 2."""
        effects = [Share("joint 1", family, MemberKind.EFFECT, True) for family in families]
        other = [Share("joint 2", "play", MemberKind.EFFECT, True)]
        laws = [Share(f"joint {joint}", "its angle", MemberKind.UNLISTED, True) for joint in (1, 2)]
        odds = np.exp(log_odds([*effects, *other, *laws]))
        p = odds / (1.0 + odds)
        assert p.sum() == pytest.approx(EXPECTED_EFFECTS)
        n = len(effects)
        assert p[-2] == pytest.approx(UNLISTED * (p[-2] + p[:n].sum()))
        return {family: sum(p[k] for k in range(n) if families[k] == family) for family in families}, p[n] + p[-1]

    plain, there = expected("play", "spring")
    more_forms, there_with_forms = expected("play", "play", "spring")
    more_families, there_with_families = expected("play", "spring", "bearing")
    assert more_forms == pytest.approx(plain)
    assert sum(more_families.values()) == pytest.approx(sum(plain.values()))
    assert there_with_forms == pytest.approx(there)
    assert there_with_families == pytest.approx(there)
