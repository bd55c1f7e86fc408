"""Paper 003's identification in dual quaternions: with the weight carried over it is the matrix form, to rounding."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.identification.answers.dual_form import TwoForms, identify_in_two_forms, two_forms_result
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_rpy, rotation_from_vector
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played

NOISE = Sigma(translation=15e-6, rotation=2e-5, force=0.5, moment=0.1)
ROUNDING = 1e-9


def fitted(chain: Chain, states: LoadStates) -> Fit:
    return identify_parameters(states, joint_springs(chain))


def noisy(chain: Chain, full_pose: bool = True, seed: int = 1) -> LoadStates:
    return played(
        joint_springs(chain, SIX_STIFFNESS), runs=4, noise=NOISE, full_pose=full_pose, seed=seed, load_scatter=0.02
    )


@cache
def ordinary(full_pose: bool = True) -> tuple[Fit, TwoForms]:
    """Return the fit of an ordinary campaign, and both forms."""
    chain = six_axes()
    fit = fitted(chain, noisy(chain, full_pose))
    return fit, identify_in_two_forms(fit)


def stretched_wrist() -> LoadStates:
    """Return states with joint 5 at zero in half of the poses: axes 4 and 6 in line, the wrist's singular pose."""
    chain = six_axes()
    states = noisy(chain)
    joints = states.joints.copy()
    joints[states.run % 2 == 0, 4] = 0.0
    robot = joint_springs(chain, SIX_STIFFNESS)
    balance = solve_balance(robot, chain.model_angles(joints), states.wrench, states.setup)
    rng = np.random.default_rng(3)
    position = balance.target_position + 15e-6 * rng.normal(size=balance.target_position.shape)
    turn = rotation_from_vector(2e-5 * rng.normal(size=(len(joints), 1, 3)))
    return replace(states, joints=joints, position=position, rotation=turn @ balance.target_rotation)


def pitched_up() -> tuple[Chain, LoadStates]:
    """Return a robot whose base is turned so that, in base axes, tools point along ±z: singular for roll–pitch–yaw."""
    chain = six_axes()
    turned = chain.fixed.copy()
    turned[0, :3, :3] = rotation_from_rpy(np.array([0.3, np.pi / 2, -0.4])) @ turned[0, :3, :3]
    chain = replace(chain, fixed=turned)
    return chain, noisy(chain)


@pytest.mark.parametrize("case", ["six joints", "position only", "stretched wrist", "pitch of 90 degrees"])
def test_the_two_forms_agree(case: str) -> None:
    if case in ("six joints", "position only"):
        fit, two = ordinary(full_pose=case != "position only")
    else:
        fit = fitted(*(pitched_up() if case == "pitch of 90 degrees" else (six_axes(), stretched_wrist())))
        two = identify_in_two_forms(fit)
    assert two.names == fit.free_names
    assert two.difference < ROUNDING
    # and the fit itself, whose derivatives go through the balance: the papers' columns are of first order
    for name, value in zip(two.names, two.dual, strict=True):
        found = fit.parameter(name)
        assert found.value is not None
        assert found.std is not None
        assert abs(found.value - value) < 5e-2 * found.std


def test_unweighted_is_another_estimate() -> None:
    _, two = ordinary(full_pose=True)
    away = np.abs(two.unweighted / two.dual - 1.0)
    # it changes with the unit of length, and neither choice is the weighted one
    assert away.max() > 1e-4
    assert np.abs(two.unweighted_mm / two.unweighted - 1.0).max() > 1e-4
    # but it estimates the same springs
    assert np.allclose(1.0 / two.unweighted, SIX_STIFFNESS, rtol=0.15)
    assert np.allclose(1.0 / two.unweighted_mm, SIX_STIFFNESS, rtol=0.15)
    assert [parameter.dual_quaternion for parameter in two_forms_result(two).parameters] == two.dual.tolist()


def test_unweighted_needs_orientation() -> None:
    _, two = ordinary(full_pose=False)
    assert np.isnan(two.unweighted).all()
    assert two_forms_result(two).parameters[0].unweighted_in_metres is None


def test_other_effects_are_refused() -> None:
    chain = six_axes()
    robot = joint_springs(chain)
    tilt = PlacedEffect(find_effects()["bearing-tilt"], Place("joints", (2,)))
    fit = identify_parameters(noisy(chain), replace(robot, placed=(*robot.placed, tilt)))
    with pytest.raises(InputError, match="bearing-tilt"):
        identify_in_two_forms(fit)
    with pytest.raises(InputError, match="first-order"):
        identify_in_two_forms(identify_parameters(noisy(chain), replace(robot, deformed=False)))
